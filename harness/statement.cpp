#include "harness/statement.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

namespace tandem::harness {

namespace {

using Labels = std::vector<std::string>;

std::string joined(const std::vector<std::string>& words, const char* last = " and ") {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i)
    out += (i == 0 ? "" : i + 1 == words.size() ? last : ", ") + words[i];
  return out;
}

std::string spoken(const std::vector<int>& who) {
  std::vector<std::string> names;
  for (const int i : who) names.emplace_back(kSpokenNames[static_cast<std::size_t>(i)]);
  return joined(names) + (who.size() > 1 ? " alike" : "");
}

/// "n = 0 to n = 2, n = 4" or "every value": those of `all` for which `is` holds.
std::string where(const std::vector<Contest>& all, const std::function<bool(const Contest&)>& is) {
  std::vector<std::string> parts;
  std::size_t count = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!is(all[i])) continue;
    std::size_t end = i;
    while (end + 1 < all.size() && is(all[end + 1])) ++end;
    count += end - i + 1;
    parts.push_back(end == i       ? all[i].label
                    : end == i + 1 ? all[i].label + ", " + all[end].label
                                   : all[i].label + " to " + all[end].label);
    i = end;
  }
  if (count == all.size() && count > 1)
    return fmt::format("every value ({} to {})", all.front().label, all.back().label);
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// "extrapolated at n = 0 to n = 2; hold at n = 3", of one of a contest's two judgements.
std::string winners(const std::vector<Contest>& all, std::vector<int> Contest::*best,
                    int Contest::*known, const std::string& nobody) {
  std::vector<std::string> parts;
  std::vector<std::vector<int>> said;
  for (const Contest& contest : all) {
    const std::vector<int>& who = contest.*best;
    if (who.empty() || std::find(said.begin(), said.end(), who) != said.end()) continue;
    said.push_back(who);
    parts.push_back(spoken(who) + " at " +
                    where(all, [&](const Contest& c) { return c.*best == who; }));
  }
  const std::string none =
      where(all, [&](const Contest& c) { return (c.*best).empty() && c.*known >= 2; });
  if (!none.empty()) parts.push_back(nobody + " at " + none);
  const std::string unknown = where(all, [&](const Contest& c) { return c.*known < 2; });
  if (!unknown.empty()) parts.push_back("not compared (too few are known) at " + unknown);
  return fmt::format("{}", fmt::join(parts, "; "));
}

/// Where the least error is another's in newton, which weighs small forces as it does large ones.
std::string in_newton(const Contests& c) {
  std::vector<std::string> parts;
  for (const Contest& x : c.at)
    if (x.least_newton != x.least_error && !x.least_newton.empty())
      parts.push_back(fmt::format("{} at {}", spoken(x.least_newton), x.label));
  return parts.empty() ? "" : fmt::format(" (In newton {}.)", fmt::join(parts, "; "));
}

std::string wins(const Contests& c) {
  return fmt::format(
      "{}. Least force error: {}.{} Largest stable {}: {}.", c.architecture,
      winners(c.at, &Contest::least_error, &Contest::error_known, "none (no session is stable)"),
      in_newton(c), c.coupling,
      winners(c.at, &Contest::largest_coupling, &Contest::coupling_known,
              "none (not stable with any that was tried)"));
}

/// Least and largest of a number, where both reconstructions have it.
std::string range_of(const Contests& c, Reconstruction who, double Contender::*what) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Contest& contest : c.at) {
    const double x = contest.by[who].*what;
    if (!std::isfinite(contest.by[kHeld].*what) || !std::isfinite(contest.by[kCompensation].*what))
      continue;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  const auto shown = [](double x) { return std::abs(x) < 5e-4 ? 0.0 : x; };  // no minus nothing
  if (!(low <= high)) return {};
  const std::string a = fmt::format("{:.3g}", shown(low)), b = fmt::format("{:.3g}", shown(high));
  return a == b ? a : a + " to " + b;
}

std::string compensation(const Contests& c) {
  std::string text = c.architecture + ". Compensation: ";
  const Margin& m = c.margin;
  if (!m.known) {
    text += fmt::format("at no value is the largest stable {} known both with it and for hold",
                        c.coupling);
  } else {
    text += m.least_at == m.most_at
                ? fmt::format("of the {} that hold bears it leaves {:.2f} ({})", c.coupling,
                              m.least, m.least_at)
                : fmt::format(
                      "of the {} that hold bears it leaves {:.2f} ({}) to {:.2f} ({}), "
                      "{:.2f} in the median",
                      c.coupling, m.least, m.least_at, m.most, m.most_at, m.median);
    const auto lost = [](double left) { return std::lround(100.0 * (1.0 - left)); };
    const long most = lost(m.least), least = lost(m.most);
    text += most <= 0       ? ": no margin is lost"
            : least == most ? fmt::format(": {} % of the margin is lost", most)
            : least < 0     ? fmt::format(": from {} % gained to {} % lost", -least, most)
                            : fmt::format(": {} to {} % of the margin is lost", least, most);
  }
  if (!m.nothing_at.empty())
    text += fmt::format("; at {} no {} at all is stable with it, though some is for hold",
                        joined(m.nothing_at), c.coupling);
  const std::string with = range_of(c, kCompensation, &Contender::drag);
  if (!with.empty())
    text += fmt::format(". Drag of one hand alone: {} N s/m with it, {} without", with,
                        range_of(c, kHeld, &Contender::drag));
  return text + ".";
}

/// What the ratio of a standing is of.
enum class Of { kError, kCoupling };

std::string ratio(const Standing& s, Of of) {
  if (of == Of::kError && s.ratio == 0.0) return "it is not stable";
  if (of == Of::kError && std::isinf(s.ratio)) return "the others are not stable";
  return std::isinf(s.ratio) ? "beyond measure" : fmt::format("{:.2f}", s.ratio);
}

std::string ms(double seconds) { return fmt::format("{:.1f} ms", 1e3 * seconds); }

std::string at_age(const Standing& s, Of of) {
  return fmt::format("{} ({}: {})", ms(s.age), s.label, ratio(s, of));
}

/// "wins up to 11.2 ms (n = 2: 1.23) and loses from 15.1 ms (n = 3: 0.97), even at about 14.6 ms".
std::string by_age(const ByAge& found, Of of) {
  const auto at_age = [of](const Standing& s) { return harness::at_age(s, of); };
  std::vector<const Standing*> decided;
  Labels even;
  for (const Standing& s : found.standings)
    if (s.wins() || s.loses())
      decided.push_back(&s);
    else
      even.push_back(s.label);
  std::string text;
  if (found.standings.empty()) {
    text = "has nothing to be compared with";
  } else if (decided.empty()) {
    text = "is even at every age seen";
  } else if (found.crossings.empty()) {
    const Standing &young = *decided.front(), &old = *decided.back();
    text = fmt::format("{} at every age seen, ", young.wins() ? "wins" : "loses") +
           (&young == &old ? at_age(young) : at_age(young) + " to " + at_age(old));
  } else {
    const auto verb = [](const Standing& s) { return s.wins() ? "wins" : "loses"; };
    for (std::size_t i = 0; i < found.crossings.size(); ++i) {
      const Crossing& c = found.crossings[i];
      const bool alone = decided.front()->label == c.from.label;  // nobody younger did the same
      if (i == 0)
        text += fmt::format("{} {} {}", verb(c.from), alone ? "at" : "up to", at_age(c.from));
      const bool last = i + 1 == found.crossings.size();
      const Standing& until = last ? *decided.back() : found.crossings[i + 1].from;
      const bool one = until.label == c.to.label;
      text += fmt::format("{} {} {} {}", last ? " and" : ",", verb(c.to), one ? "at" : "from",
                          at_age(c.to));
      if (!one) text += " to " + at_age(until);
    }
    std::vector<std::string> at;
    for (const Crossing& c : found.crossings)
      at.push_back(std::isfinite(c.at)
                       ? "at about " + ms(c.at)
                       : fmt::format("somewhere from {} to {}", ms(c.from.age), ms(c.to.age)));
    text += "; it changes " + joined(at);
    if (found.crossings.size() > 2) text += "; more than the age decides here";
  }
  if (!even.empty() && !decided.empty()) text += "; is even at " + joined(even);
  if (!found.none_stable.empty()) text += "; none is stable at " + joined(found.none_stable);
  return text;
}

/// "wins at 2 users (2.15); loses at 3 users (0.85)": of ages that are much alike.
std::string by_value(const ByAge& found, Of of) {
  std::vector<std::string> won, lost, even;
  for (const Standing& s : found.standings)
    (s.wins()    ? won
     : s.loses() ? lost
                 : even)
        .push_back(fmt::format("{} ({})", s.label, ratio(s, of)));
  std::vector<std::string> parts;
  if (!won.empty()) parts.push_back("wins at " + joined(won));
  if (!lost.empty()) parts.push_back("loses at " + joined(lost));
  if (!even.empty()) parts.push_back("is even at " + joined(even));
  if (!found.none_stable.empty()) parts.push_back("none is stable at " + joined(found.none_stable));
  if (parts.empty()) return "has nothing to be compared with";
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::string extrapolation(const Contests& c) {
  const bool one_age = c.by_error.one_age() || c.by_coupling.one_age();
  const auto said = [&](const ByAge& found, Of of) {
    return one_age ? by_value(found, of) : by_age(found, of);
  };
  return fmt::format(
      "{}. Extrapolation against the better of the others, by {}. By force error (theirs over its "
      "own) it {}. By largest stable {} (its own over theirs) it {}.",
      c.architecture,
      one_age ? c.knob + " (the samples are of much the same age)" : "mean age of the samples",
      said(c.by_error, Of::kError), c.coupling, said(c.by_coupling, Of::kCoupling));
}

/// "hold at n = 3; compensated at every value", of those contenders for which `is` holds.
std::string who_where(const Contests& c, const std::function<bool(const Contender&)>& is) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < kReconstructions; ++i) {
    const std::string at = where(c.at, [&](const Contest& x) { return is(x.by[i]); });
    if (!at.empty()) parts.push_back(fmt::format("{} at {}", kSpokenNames[i], at));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::string failures(const Contests& c) {
  const std::string unstable =
      who_where(c, [](const Contender& x) { return x.judged && !x.stable; });
  const std::string near = who_where(c, [](const Contender& x) { return x.near_boundary; });
  const std::string failed = who_where(c, [](const Contender& x) { return x.failed; });
  const std::string missed = who_where(c, [](const Contender& x) { return x.missed_ticks; });
  std::string text = c.architecture + ". Failures: ";
  text += unstable.empty() ? "none, every session is stable as the scene is"
                           : "not stable as the scene is: " + unstable;
  text += near.empty() ? ". Within 10 % of the boundary: none."
                       : ". Within 10 % of the boundary: " + near + ".";
  if (!failed.empty()) text += " Did not run: " + failed + ".";
  if (!missed.empty())
    text += fmt::format(" Not judged, over {:g} % of the ticks were missed: {}.", 1e2 * kMostMissed,
                        missed);
  return text;
}

std::string unconfirmed(const Contests& c) {
  std::vector<std::string> parts;
  for (const Contest& contest : c.at)
    for (std::size_t i = 0; i < kReconstructions; ++i)
      if (!contest.by[i].unconfirmed.empty())
        parts.push_back(fmt::format("{} at {} ({})", kSpokenNames[i], contest.label,
                                    contest.by[i].unconfirmed));
  if (parts.empty()) return c.architecture + ". On sockets every largest coupling was confirmed.";
  return fmt::format("{}. Largest {} not confirmed on sockets, so not counted above: {}.",
                     c.architecture, c.coupling, fmt::join(parts, "; "));
}

/// "below 14.6 ms", "from 6.5 ms to 13.1 ms", of the ages at which extrapolation wins.
std::string ages_won(const ByAge& found) {
  const auto decided = std::find_if(found.standings.begin(), found.standings.end(),
                                    [](const Standing& s) { return s.wins() || s.loses(); });
  if (decided == found.standings.end()) return "nowhere";
  if (found.one_age()) {
    Labels won;
    for (const Standing& s : found.standings)
      if (s.wins()) won.push_back(s.label);
    return won.empty() ? "nowhere" : "at " + joined(won);
  }
  if (found.crossings.empty()) return decided->wins() ? "at every age seen" : "nowhere";
  const auto age = [](const Crossing& c) {
    return std::isfinite(c.at) ? ms(c.at)
                               : fmt::format("{:.1f}...{}", 1e3 * c.from.age, ms(c.to.age));
  };
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < found.crossings.size(); ++i) {
    const Crossing& c = found.crossings[i];
    if (i == 0 && c.from.wins()) parts.push_back("below " + age(c));
    if (c.from.wins()) continue;
    parts.push_back(i + 1 < found.crossings.size()
                        ? fmt::format("from {} to {}", age(c), age(found.crossings[i + 1]))
                        : "above " + age(c));
  }
  return joined(parts);
}

std::string margin_lost(const Margin& m) {
  const auto lost = [](double left) { return std::max(0L, std::lround(100.0 * (1.0 - left))); };
  std::string text;
  if (m.known)
    text = lost(m.least) == lost(m.most) ? fmt::format("{} %", lost(m.least))
                                         : fmt::format("{} to {} %", lost(m.most), lost(m.least));
  if (!m.nothing_at.empty())
    text += (m.known ? " and all of it at " : "all of it at ") + joined(m.nothing_at);
  return text;
}

/// All architectures together; empty where nothing could be compared.
std::string in_short(const std::vector<Contests>& all) {
  std::vector<std::string> margins, couplings, errors;
  for (const Contests& c : all) {
    if (const std::string lost = margin_lost(c.margin); !lost.empty())
      margins.push_back(c.architecture + " " + lost);
    if (!c.by_error.standings.empty())
      errors.push_back(c.architecture + " " + ages_won(c.by_error));
    if (!c.by_coupling.standings.empty())
      couplings.push_back(c.architecture + " " + ages_won(c.by_coupling));
  }
  std::string text;
  if (!margins.empty())
    text += fmt::format(" Of the largest stable coupling of hold, compensation loses: {}.",
                        fmt::join(margins, "; "));
  if (!errors.empty())
    text += fmt::format(" Extrapolation has the least force error: {}.", fmt::join(errors, "; "));
  if (!couplings.empty())
    text += fmt::format(" Extrapolation has the largest stable coupling: {}.",
                        fmt::join(couplings, "; "));
  return text.empty() ? text : "In short, by mean age of the samples in use." + text;
}

std::string introduction(bool real) {
  std::string text =
      "Hold uses the last sample until the next comes; compensated is hold with negative damping "
      "that leaves 5 % of its drag; extrapolated carries the last sample on by its age and "
      "velocity. Force error: RMS against the same hands on an ideal network, in parts of the "
      "force (Weber), mean of the hands; who is not stable loses. Within 2 % is alike. Age: of the "
      "samples in use, delay and wait for the next packet together.";
  if (real)
    text +=
        " Largest couplings are not searched for on sockets: counted is the one that the analysis "
        "predicts from the measured delays, where sessions on sockets at 0.9 times it were stable "
        "and at 1.1 times not (0: where the session as it is was not stable).";
  return text;
}

std::string shown(double x) {
  if (x >= 1000.0 && std::isfinite(x)) {  // three digits are known, all that stand before the point
    const double unit = std::pow(10.0, std::floor(std::log10(x)) - 2.0);
    return fmt::format("{:.0f}", unit * std::round(x / unit));
  }
  return std::isnan(x) ? "-" : std::isinf(x) ? "inf" : fmt::format("{:.3g}", x);
}

bool has(const std::vector<int>& who, std::size_t i) {
  return std::find(who.begin(), who.end(), static_cast<int>(i)) != who.end();
}

}  // namespace

std::vector<std::string> statement(const std::vector<Contests>& all) {
  std::vector<std::string> out;
  if (all.empty()) return out;
  out.push_back(introduction(all.front().real));
  if (std::string text = in_short(all); !text.empty()) out.push_back(std::move(text));
  for (const Contests& c : all) {
    const bool compared = std::any_of(c.at.begin(), c.at.end(), [](const Contest& x) {
      return x.error_known > 1 || x.coupling_known > 1;
    });
    if (compared) {
      out.push_back(wins(c));
      out.push_back(compensation(c));
      out.push_back(extrapolation(c));
    } else {
      out.push_back(c.architecture +
                    ". No two reconstructions are known at the same value: none can win here.");
    }
    out.push_back(failures(c));
    if (c.real) out.push_back(unconfirmed(c));
  }
  return out;
}

std::string contest_table(const std::vector<Contests>& all) {
  std::string text;
  for (const Contests& c : all) {
    text += fmt::format("  {:20} {:>8}   {:^39}   {:>29}\n", c.architecture, "mean age",
                        "force error [Weber]", fmt::format("largest stable {} [N/m]", c.coupling));
    text += fmt::format("  {:20} {:>8}", c.knob, "[ms]");
    for (int twice = 0; twice < 2; ++twice)
      text +=
          fmt::format("   {:>12} {:>12} {:>13}", kSpokenNames[0], kSpokenNames[1], kSpokenNames[2]);
    text += "\n";
    for (const Contest& contest : c.at) {
      std::string errors, couplings;
      for (std::size_t i = 0; i < kReconstructions; ++i) {
        const Contender& x = contest.by[i];
        const std::string error = x.judged && !x.stable ? "not stable" : shown(x.error());
        errors += fmt::format(
            " {:>{}}",
            (has(contest.least_error, i) ? "*" : "") + error + (x.near_boundary ? "~" : " "),
            i == 2 ? 13 : 12);
        couplings += fmt::format(" {:>{}}",
                                 (has(contest.largest_coupling, i) ? "*" : "") + shown(x.coupling),
                                 i == 2 ? 13 : 12);
      }
      text += fmt::format("  {:20} {:>8.1f}  {}  {}\n", contest.label, 1e3 * contest.age, errors,
                          couplings);
    }
  }
  return text;
}

}  // namespace tandem::harness
