#include "harness/sweep.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "harness/compensation.h"
#include "harness/many_users.h"
#include "harness/recorded_series.h"
#include "harness/sweep.pb.h"
#include "harness/sweep_file.h"
#include "scene/load_scene.h"
#include "scene/validate_scene.h"

namespace tandem::harness {

namespace {

/// Recordings are read once, however many steps use them.
class Recordings {
 public:
  explicit Recordings(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::shared_ptr<const RecordedSeries> load(const wire::Condition::Recorded& r) {
    const int given = int{r.has_one_way()} + int{r.has_round_trips()} + int{r.has_sent()};
    if (given != 1 || r.has_sent() != r.has_received())
      throw SweepError(
          "recorded: give exactly one of one_way, round_trips, or sent together with received");
    auto& series = known_[r.SerializeAsString()];
    if (series == nullptr)
      series = std::make_shared<const RecordedSeries>(
          r.has_one_way()       ? read_one_way(path(r.one_way()))
          : r.has_round_trips() ? read_round_trips(path(r.round_trips()))
                                : read_stamps(path(r.sent()), path(r.received())));
    return series;
  }

 private:
  /// Relative to the sweep's file.
  [[nodiscard]] std::string path(const std::string& file) const {
    const std::filesystem::path p(file);
    return (p.is_absolute() ? p : folder_ / p).string();
  }
  std::filesystem::path folder_;
  std::map<std::string, std::shared_ptr<const RecordedSeries>> known_;
};

Condition plain(const wire::Condition& w, Recordings& recordings) {
  Condition c;
  c.delay = w.delay();
  c.jitter = w.jitter();
  switch (w.distribution()) {
    case wire::Condition::UNIFORM:
      c.distribution = Distribution::kUniform;
      break;
    case wire::Condition::PARETO:
      c.distribution = Distribution::kPareto;
      break;
    case wire::Condition::PARETO_NORMAL:
      c.distribution = Distribution::kParetoNormal;
      break;
    default:
      c.distribution = Distribution::kNormal;
  }
  c.correlation = w.correlation();
  c.loss = w.loss();
  if (w.has_bursts())
    c.bursts = Bursts{w.bursts().enter(), w.bursts().leave(),
                      w.bursts().has_loss_inside() ? w.bursts().loss_inside() : 1.0,
                      w.bursts().loss_outside()};
  c.duplicate = w.duplicate();
  c.reorder = w.reorder();
  c.rate_bit_per_s = w.rate_bit_per_s();
  if (w.has_outage())
    c.outage = Outage{w.outage().start(), w.outage().length(), w.outage().period()};
  if (w.has_recorded()) c.recorded = recordings.load(w.recorded());
  return c;
}

/// The sweep's network with the step's over it, field by field.
LinkConditions merged(const wire::Network& base, const wire::Network& step, Recordings& recordings,
                      const std::string& where) {
  const auto direction = [&](const wire::Condition& own_base, const wire::Condition& own_step,
                             const char* name) {
    wire::Condition c = base.both();
    c.MergeFrom(own_base);
    c.MergeFrom(step.both());
    c.MergeFrom(own_step);
    const Condition out = plain(c, recordings);
    if (const std::string why = problem_with(out); !why.empty())
      throw SweepError(fmt::format("{}: {}: {}", where, name, why));
    return out;
  };
  return {direction(base.there(), step.there(), "there"),
          direction(base.back(), step.back(), "back")};
}

std::string short_name(const core::Scene& scene, const std::string& given) {
  if (given == "axis_central") return "central";
  if (given == "axis_distributed") return "distributed";
  if (given == "axis_distributed_split") return "split";
  return scene.name.empty() ? given : scene.name;
}

const char* style_name(wire::Style style) {
  switch (style) {
    case wire::HOLD:
      return "hold";
    case wire::COMPENSATED:
      return "compensated";
    case wire::EXTRAPOLATE:
      return "extrapolate";
    default:
      return "";
  }
}

void apply_style(wire::Style style, const LinkConditions& network, core::Scene& scene,
                 std::vector<std::string>& edits) {
  if (style == wire::AS_SCENE) return;
  for (auto& object : scene.objects) object.compensation = object.compensation_rotation = 0.0;
  scene.reconstruction.kind = style == wire::EXTRAPOLATE ? core::ReconstructionKind::kExtrapolate
                                                         : core::ReconstructionKind::kHold;
  if (style == wire::EXTRAPOLATE) edits.emplace_back("reconstruction.kind=EXTRAPOLATE");
  if (style != wire::COMPENSATED) return;
  const double compensation = tuned_compensation(scene, network);
  for (auto& object : scene.objects) {
    object.compensation = compensation;
    edits.push_back(fmt::format("object.{}.compensation={:.6g}", object.name, compensation));
  }
}

bool same(const Condition& a, const Condition& b) {
  return netem_arguments(a) == netem_arguments(b) && to_text(a) == to_text(b);
}

void check(const SweepPoint& point, const std::string& where) {
  if (point.scene.architecture == core::Architecture::kSingle)
    throw SweepError(where + ": scene '" + point.scene_name +
                     "' has one user and no network; a sweep needs two users or more");
  if (point.scene.users.size() > 2 && !same(point.network.there, point.network.back))
    throw SweepError(fmt::format(
        "{}: with {} users both directions must be alike (netem stands at a workstation's way "
        "out); use network {{ both {{ ... }} }}",
        where, point.scene.users.size()));
  const auto room = [&](const Condition& c) {
    constexpr double kRoom = 60.0;  // of core::LinkModel's 64
    const double in_flight = (c.delay + 2.0 * c.jitter) * point.scene.rates.packet_hz;
    if (in_flight > kRoom)
      throw SweepError(fmt::format(
          "{}: delay {:g} s and twice the jitter {:g} s keep {:.0f} packets in flight at {:g} "
          "packets a second; a modelled link holds {:.0f}: less of it, or a lower rates.packet_hz",
          where, c.delay, c.jitter, in_flight, point.scene.rates.packet_hz, kRoom));
  };
  room(point.network.there);
  room(point.network.back);
  const auto problems = scene::validate_scene(point.scene);
  if (!problems.empty()) throw scene::SceneError(problems);
}

bool bad_seconds(double s) { return !(s >= 2.0 && s <= 3600.0); }

Sweep sweep_of(const std::string& text, const std::string& file, const SweepOptions& options) {
  wire::Sweep wire;
  parse_sweep(text, file, wire);
  const auto fail = [&](const std::string& why) { throw SweepError(file + ": " + why); };
  if (wire.scene().empty()) fail("no scene: name at least one, scene: \"axis_distributed\"");
  if (wire.step().empty()) fail("no step: a sweep needs at least one step { ... }");
  if (wire.has_seconds() && bad_seconds(wire.seconds()))
    fail(fmt::format("seconds {:g} must be within 2 and 3600", wire.seconds()));

  Sweep sweep;
  sweep.name = std::filesystem::path(file).stem().string();
  sweep.title = wire.title().empty() ? sweep.name : wire.title();
  sweep.knob = wire.knob().empty() ? "step" : wire.knob();
  sweep.unit = wire.unit();
  Recordings recordings(std::filesystem::path(file).parent_path());
  std::vector<wire::Style> styles;
  for (const int s : wire.style()) styles.push_back(static_cast<wire::Style>(s));
  if (styles.empty()) styles.push_back(wire::AS_SCENE);
  bool any_quick = false;
  for (const auto& step : wire.step()) any_quick = any_quick || step.quick();

  std::set<std::string> names;
  for (const std::string& scene_name : wire.scene())
    for (const wire::Style style : styles)
      for (int i = 0; i < wire.step_size(); ++i) {
        const wire::Step& step = wire.step(i);
        if (options.quick && (any_quick ? !step.quick() : i != 0)) continue;
        const std::string label =
            step.label().empty() ? fmt::format("{:g} {}", step.value(), sweep.unit) : step.label();
        const std::string where = fmt::format("{}: step {} ({})", file, i + 1, label);
        if (!std::isfinite(step.value())) throw SweepError(where + ": value must be a number");
        SweepPoint point;
        point.scene_name = scene_name;
        point.edits.assign(wire.set().begin(), wire.set().end());
        point.edits.insert(point.edits.end(), step.set().begin(), step.set().end());
        point.scene = scene::load_scene(scene_name, point.edits);
        point.network = merged(wire.network(), step.network(), recordings, where);
        if (step.has_users()) {
          point.scene = with_users(point.scene, step.users());
          point.edits.push_back(fmt::format("users={}", step.users()));
        }
        point.architecture = short_name(point.scene, scene_name);
        point.style = style_name(style);
        point.knob = sweep.knob;
        point.value = step.value();
        point.label = label;
        point.seconds = options.seconds > 0.0  ? options.seconds
                        : wire.seconds() > 0.0 ? wire.seconds()
                                               : 5.0;
        check(point, where);
        apply_style(style, point.network, point.scene, point.edits);
        point.name = point.architecture + (point.style.empty() ? "/" : "/" + point.style + "/") +
                     sweep.knob + "=" + label;
        if (!names.insert(point.name).second)
          throw SweepError(where + ": there is a point '" + point.name +
                           "' already; give steps different labels");
        sweep.points.push_back(std::move(point));
      }
  return sweep;
}

}  // namespace

const std::vector<std::string>& built_in_sweeps() {
  static const std::vector<std::string> names{"thesis", "rate",  "delay",     "jitter",
                                              "loss",   "users", "conditions"};
  return names;
}

Sweep load_sweep(const std::string& name_or_file, const SweepOptions& options) {
  std::string file;
  const std::string text = read_sweep_file(name_or_file, file);
  return sweep_of(text, file, options);
}

Sweep recorded_sweep(const std::string& recorded, const SweepOptions& options) {
  return sweep_of(
      "title: \"A recorded network, both ways\" knob: \"network\" "
      "scene: \"axis_central\" scene: \"axis_distributed\" "
      "scene: \"axis_distributed_split\" "
      "style: HOLD style: COMPENSATED style: EXTRAPOLATE "
      "step { label: \"recorded\" network { both { recorded { " +
          recorded + " } } } }",
      "recorded", options);
}

std::string scene_text(const SweepPoint& point) { return scene::to_text(point.scene); }

}  // namespace tandem::harness
