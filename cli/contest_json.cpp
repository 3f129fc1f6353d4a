#include "cli/contest_json.h"

#include <cmath>

#include "cli/options.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

ordered_json names(const std::vector<int>& who) {
  ordered_json out = ordered_json::array();
  for (const int i : who) out.push_back(harness::kStyleNames[static_cast<std::size_t>(i)]);
  return out;
}

ordered_json contest_json(const harness::Contest& contest) {
  ordered_json out{{"label", contest.label},
                   {"mean_age_s", number(contest.age)},
                   {"least_force_error", names(contest.least_error)},
                   {"least_force_error_n", names(contest.least_newton)},
                   {"largest_coupling", names(contest.largest_coupling)}};
  for (std::size_t i = 0; i < harness::kReconstructions; ++i) {
    const harness::Contender& x = contest.by[i];
    if (!x.there) continue;
    ordered_json one{{"failed", x.failed},
                     {"judged", x.judged},
                     {"stable", x.stable},
                     {"near_boundary", x.near_boundary},
                     {"force_error_rms_weber", number(x.weber)},
                     {"force_error_rms_n", number(x.newton)},
                     {"drag_n_s_per_m", number(x.drag)},
                     {"largest_coupling_n_per_m", number_or_word(x.coupling)}};
    if (!x.unconfirmed.empty()) one["not_confirmed"] = x.unconfirmed;
    out["by"][harness::kStyleNames[i]] = std::move(one);
  }
  return out;
}

ordered_json standing_json(const harness::Standing& s) {
  return {{"label", s.label}, {"mean_age_s", number(s.age)}, {"ratio", number_or_word(s.ratio)}};
}

ordered_json ages_json(const harness::ByAge& by_age) {
  ordered_json out{{"standings", ordered_json::array()},
                   {"crossings", ordered_json::array()},
                   {"none_stable", by_age.none_stable}};
  for (const harness::Standing& s : by_age.standings) out["standings"].push_back(standing_json(s));
  for (const harness::Crossing& c : by_age.crossings)
    out["crossings"].push_back({{"wins_before", c.from.wins()},
                                {"from", standing_json(c.from)},
                                {"to", standing_json(c.to)},
                                {"at_s", number(c.at)}});
  return out;
}

}  // namespace

ordered_json number_or_word(double x) {
  if (std::isinf(x)) return x > 0 ? "infinite" : "-infinite";
  return number(x);
}

ordered_json to_json(const std::vector<harness::Contests>& contests) {
  ordered_json out = ordered_json::array();
  for (const harness::Contests& c : contests) {
    ordered_json one{{"architecture", c.architecture}, {"coupling", c.coupling}};
    one["at"] = ordered_json::array();
    for (const harness::Contest& contest : c.at) one["at"].push_back(contest_json(contest));
    if (c.margin.known)
      one["compensation_leaves_of_holds_coupling"] = {
          {"least", c.margin.least},   {"least_at", c.margin.least_at},
          {"most", c.margin.most},     {"most_at", c.margin.most_at},
          {"median", c.margin.median}, {"nothing_at", c.margin.nothing_at}};
    one["extrapolation"] = {{"by_force_error", ages_json(c.by_error)},
                            {"by_largest_coupling", ages_json(c.by_coupling)}};
    out.push_back(std::move(one));
  }
  return out;
}

}  // namespace tandem::cli
