#include "cli/sweep_axis.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

#include "scene/load_scene.h"

namespace tandem::cli {

namespace {

constexpr int kMostValues = 1000000;

std::vector<double> values_of(const std::string& text,
                              const std::function<void(const std::string&)>& bad) {
  std::vector<double> values;
  if (text.find(':') == std::string::npos) {
    std::stringstream list(text);
    for (std::string one; std::getline(list, one, ',');) {
      double value = 0.0;
      if (!CLI::detail::lexical_cast(one, value) || !std::isfinite(value))
        bad("\"" + one + "\" is no number");
      values.push_back(value);
    }
    if (values.empty()) bad("no values");
    return values;
  }
  double from = 0.0, to = 0.0;
  int count = 0, read = 0;
  if (std::sscanf(text.c_str(), "%lf:%lf:%d%n", &from, &to, &count, &read) != 3)
    bad("the range is FROM:TO:COUNT, or FROM:TO:COUNTlog for even ratios");
  const std::string spacing = text.substr(static_cast<std::size_t>(read));
  if (!spacing.empty() && spacing != "log" && spacing != "lin")
    bad("\"" + spacing + "\" after the count is neither log nor lin");
  if (!std::isfinite(from) || !std::isfinite(to)) bad("the range has to be finite");
  if (count < 1 || count > kMostValues) bad(fmt::format("1 to {} values", kMostValues));
  if (count == 1 ? from > to : !(from < to)) bad("the range must go up");
  if (spacing == "log" && !(from > 0.0)) bad("even ratios need a range above 0");
  for (int i = 0; i < count; ++i) {
    const double part = count == 1 ? 0.0 : static_cast<double>(i) / (count - 1);
    values.push_back(i + 1 == count && count > 1 ? to
                     : spacing == "log"          ? from * std::pow(to / from, part)
                                                 : from + (to - from) * part);
  }
  return values;
}

}  // namespace

std::vector<std::string> SweepAxis::sets(double value) const {
  std::vector<std::string> out;
  std::stringstream fields(name);
  for (std::string field; std::getline(fields, field, ',');)
    out.push_back(fmt::format("{}={}", field, value));
  return out;
}

SweepAxis parse_axis(const core::Scene& scene, const std::string& text) {
  const auto bad = [&](const std::string& why) {
    throw CLI::ValidationError("--axis", text + ": " + why);
  };
  const std::size_t equal = text.find('=');
  if (equal == std::string::npos || equal == 0)
    bad("write FIELD[,FIELD...]=FROM:TO:COUNT[log] or FIELD=VALUE,VALUE,...");
  SweepAxis axis;
  axis.name = text.substr(0, equal);
  axis.values = values_of(text.substr(equal + 1), bad);
  axis.is_delay = axis.name == "delay_packets";
  if (axis.is_delay) {
    for (const double d : axis.values)
      if (d < 0.0 || d > 60.0) bad(fmt::format("{} is not within 0 to 60 packet periods", d));
    return axis;
  }
  // The scene's own rules: every value of a list, the ends of a range.
  const std::string whole = scene::to_text(scene);
  const bool range = text.find(':', equal) != std::string::npos;
  for (std::size_t i = 0; i < axis.values.size(); ++i)
    if (!range || i == 0 || i + 1 == axis.values.size())
      (void)scene::load_scene_text(whole, "the scene with " + text, axis.sets(axis.values[i]));
  try {
    axis.knob.emplace(scene, axis.name);
  } catch (const std::invalid_argument&) {  // a field that is set by its path, and more slowly
  }
  return axis;
}

SweepGrid::SweepGrid(const core::Scene& scene, std::vector<SweepAxis> axes, double delay_packets)
    : scene_(scene),
      text_(scene::to_text(scene)),
      axes_(std::move(axes)),
      delay_packets_(delay_packets) {
  for (const SweepAxis& axis : axes_) by_text_ = by_text_ || (!axis.knob && !axis.is_delay);
}

double SweepGrid::count() const {
  double n = 1.0;
  for (const SweepAxis& axis : axes_) n *= static_cast<double>(axis.values.size());
  return n;
}

std::vector<double> SweepGrid::values(std::int64_t point) const {
  std::vector<double> out(axes_.size());
  for (std::size_t a = axes_.size(); a-- > 0;) {
    const auto size = static_cast<std::int64_t>(axes_[a].values.size());
    out[a] = axes_[a].values[static_cast<std::size_t>(point % size)];
    point /= size;
  }
  return out;
}

void SweepGrid::place(std::int64_t point, AnalyzedScene& last, double& delay_packets) const {
  const std::vector<double> at = values(point);
  if (by_text_ || last.scene.objects.empty()) {
    std::vector<std::string> sets;
    for (std::size_t a = 0; a < axes_.size(); ++a)
      if (!axes_[a].knob && !axes_[a].is_delay)
        for (std::string& set : axes_[a].sets(at[a])) sets.push_back(std::move(set));
    analysis::LinearScene linear = analysis::linear_scene(
        sets.empty() ? scene_ : scene::load_scene_text(text_, "this point of the sweep", sets));
    last.scene = std::move(linear.scene);
    last.assumptions = std::move(linear.assumptions);
  }
  delay_packets = delay_packets_;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (axes_[a].is_delay) delay_packets = at[a];
    if (axes_[a].knob) axes_[a].knob->set(last.scene, at[a]);
  }
  last.network.set_round_trip(delay_packets, last.scene.ticks_per_packet());
}

}  // namespace tandem::cli
