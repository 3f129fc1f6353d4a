#include "harness/statement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

constexpr double kTie = 1.02;  ///< closer than 2 % is no win

const char* const kStyles[] = {"hold", "compensated", "extrapolate"};

using ByStyle = std::map<std::string, const PointResult*>;

struct Row {
  std::string label;
  ByStyle styles;
  [[nodiscard]] const PointResult* of(const std::string& style) const {
    const auto i = styles.find(style);
    return i == styles.end() ? nullptr : i->second;
  }
};

/// Mean over the sites of the force error [N]; infinite where not stable or not known.
double force_error(const PointResult& r) {
  if (!r.measures.stability.stable) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  int n = 0;
  for (const SiteMeasures& s : r.measures.sites)
    if (std::isfinite(s.force_error)) sum += s.force_error, ++n;
  return n > 0 ? sum / n : std::numeric_limits<double>::infinity();
}

std::string listed(const std::vector<std::string>& words) {
  return words.empty() ? "nowhere" : fmt::format("{}", fmt::join(words, "; "));
}

std::string age_of(const Row& row) {
  for (const char* style : kStyles)
    if (const PointResult* r = row.of(style); r != nullptr && std::isfinite(r->mean_age))
      return fmt::format("{} (mean age {:.1f} ms)", row.label, 1e3 * r->mean_age);
  return row.label;
}

std::string who_wins(const std::string& architecture, const std::vector<Row>& rows) {
  std::map<std::string, std::vector<std::string>> wins;
  for (const Row& row : rows) {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& [style, r] : row.styles) best = std::min(best, force_error(*r));
    if (!std::isfinite(best)) {
      wins["none"].push_back(row.label);
      continue;
    }
    std::vector<std::string> winners;
    for (const char* style : kStyles)
      if (const PointResult* r = row.of(style); r != nullptr && force_error(*r) <= kTie * best)
        winners.emplace_back(style);
    wins[winners.size() == 1 ? winners[0] : "tie"].push_back(
        winners.size() == 1 ? row.label
                            : fmt::format("{} ({})", row.label, fmt::join(winners, " = ")));
  }
  std::string text = architecture + ", least force error:";
  for (const char* style : kStyles) text += fmt::format(" {} at {}.", style, listed(wins[style]));
  if (!wins["tie"].empty()) text += " Within 2 %: " + listed(wins["tie"]) + ".";
  if (!wins["none"].empty()) text += " None is stable at " + listed(wins["none"]) + ".";
  return text;
}

/// What of hold's largest stable coupling another style has left.
std::string coupling_against_hold(const std::string& architecture, const std::string& style,
                                  const std::vector<Row>& rows) {
  std::vector<std::pair<double, std::string>> ratios;
  std::vector<std::string> lost, gained;
  for (const Row& row : rows) {
    const PointResult *hold = row.of("hold"), *other = row.of(style);
    if (hold == nullptr || other == nullptr) continue;
    if (hold->measures.stability.stable && !other->measures.stability.stable)
      lost.push_back(row.label);
    if (!hold->measures.stability.stable && other->measures.stability.stable)
      gained.push_back(row.label);
    const double a = other->largest_coupling, b = hold->largest_coupling;
    if (std::isfinite(a) && std::isfinite(b) && b > 0.0) ratios.emplace_back(a / b, row.label);
  }
  if (ratios.empty()) return {};
  std::sort(ratios.begin(), ratios.end());
  std::string text = fmt::format(
      "{}, {}: its largest stable coupling is {:.2f} ({}) to {:.2f} ({}) times that of hold, "
      "median "
      "{:.2f}.",
      architecture, style, ratios.front().first, ratios.front().second, ratios.back().first,
      ratios.back().second, ratios[ratios.size() / 2].first);
  if (!lost.empty()) text += " Not stable where hold is: " + listed(lost) + ".";
  if (!gained.empty()) text += " Stable where hold is not: " + listed(gained) + ".";
  return text;
}

/// Rows in the order of mean age: up to where one wins, from where it loses.
std::string extrapolation_by_age(const std::string& architecture, std::vector<Row> rows) {
  std::erase_if(
      rows, [](const Row& r) { return r.of("hold") == nullptr || r.of("extrapolate") == nullptr; });
  if (rows.empty()) return {};
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    return a.of("hold")->mean_age < b.of("hold")->mean_age;
  });
  const auto compare = [&](const char* what, auto&& wins, auto&& loses) {
    std::string last_win, first_loss;
    for (const Row& row : rows) {
      const PointResult &e = *row.of("extrapolate"), &h = *row.of("hold");
      if (wins(e, h)) last_win = age_of(row);
      if (loses(e, h) && first_loss.empty()) first_loss = age_of(row);
    }
    return fmt::format(" {}: {}{}.", what,
                       last_win.empty()
                           ? "it never wins"
                           : "the oldest samples with which it wins are at " + last_win,
                       first_loss.empty() ? ", it never loses"
                                          : ", the youngest with which it loses at " + first_loss);
  };
  return architecture + ", extrapolation against hold." +
         compare(
             "By force error",
             [](const PointResult& e, const PointResult& h) {
               return force_error(e) * kTie < force_error(h);
             },
             [](const PointResult& e, const PointResult& h) {
               return force_error(h) * kTie < force_error(e);
             }) +
         compare(
             "By largest stable coupling",
             [](const PointResult& e, const PointResult& h) {
               return e.largest_coupling > kTie * h.largest_coupling;
             },
             [](const PointResult& e, const PointResult& h) {
               return h.largest_coupling > kTie * e.largest_coupling;
             });
}

std::string drags(const std::string& architecture, const std::vector<Row>& rows) {
  std::string text = architecture + ", drag of one hand alone [N s/m]:";
  bool any = false;
  for (const char* style : kStyles) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    std::string at;
    for (const Row& row : rows)
      if (const PointResult* r = row.of(style);
          r != nullptr && r->measures.stability.stable && std::isfinite(r->measures.drag)) {
        low = std::min(low, r->measures.drag);
        if (r->measures.drag > high) high = r->measures.drag, at = row.label;
      }
    if (!(low <= high)) continue;
    any = true;
    const auto shown = [](double x) { return std::abs(x) < 5e-4 ? 0.0 : x; };  // no minus nothing
    text += fmt::format(" {} {:.3f} to {:.3f} ({});", style, shown(low), shown(high), at);
  }
  if (!any) return {};
  text.back() = '.';
  return text;
}

std::string failures(const std::string& architecture, const std::vector<Row>& rows) {
  std::string text;
  for (const char* style : kStyles) {
    std::vector<std::string> labels;
    for (const Row& row : rows)
      if (const PointResult* r = row.of(style); r != nullptr && !r->measures.stability.stable)
        labels.push_back(row.label);
    if (!labels.empty()) text += fmt::format(" {}: {}.", style, listed(labels));
  }
  return text.empty() ? architecture + ": stable everywhere."
                      : architecture + ", not stable as the scene is:" + text;
}

}  // namespace

std::vector<std::string> statement(const std::vector<PointResult>& results) {
  std::vector<std::string> architectures;
  std::map<std::string, std::vector<Row>> tables;
  for (const PointResult& r : results) {
    if (r.failed || r.point.style.empty()) continue;
    auto& rows = tables[r.point.architecture];
    if (rows.empty()) architectures.push_back(r.point.architecture);
    auto row = std::find_if(rows.begin(), rows.end(),
                            [&](const Row& x) { return x.label == r.point.label; });
    if (row == rows.end()) row = rows.insert(rows.end(), Row{r.point.label, {}});
    row->styles[r.point.style] = &r;
  }
  std::vector<std::string> out;
  for (const std::string& architecture : architectures) {
    const std::vector<Row>& rows = tables[architecture];
    for (std::string sentence :
         {who_wins(architecture, rows), failures(architecture, rows), drags(architecture, rows),
          coupling_against_hold(architecture, "compensated", rows),
          coupling_against_hold(architecture, "extrapolate", rows),
          extrapolation_by_age(architecture, rows)})
      if (!sentence.empty()) out.push_back(std::move(sentence));
  }
  return out;
}

}  // namespace tandem::harness
