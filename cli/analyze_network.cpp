#include <algorithm>
#include <cmath>
#include <csignal>
#include <span>
#include <stdexcept>
#include <unistd.h>

#include <fmt/format.h>

#include "analysis/packet_fates.h"
#include "analysis/random_network.h"
#include "cli/analyze.h"
#include "cli/commands.h"
#include "cli/link_options.h"
#include "cli/network_trace.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct NetworkOptions {
  AnalyzeOptions common;
  LinkOptions link;
  std::string trace, received;
  bool one_way = false;
  analysis::LyapunovOptions sampling;
};

volatile std::sig_atomic_t network_interrupted = 0;

NetworkTrace read_trace(const NetworkOptions& o) {
  if (o.trace.empty()) return {};
  try {
    return o.received.empty() ? read_delays(o.trace, !o.one_way)
                              : read_captures(o.trace, o.received);
  } catch (const std::runtime_error& e) {
    throw Failed(std::string("--trace: ") + e.what());
  }
}

constexpr double kRoom = 60.0;  // packets in flight; a modelled link holds 64

/// A packet that newer ones overtake is never used, so one that is later than a modelled link has
/// room for counts as lost if any of the next has come by then. How many those are.
int take_out_overtaken(std::vector<double>& recorded, double delay_ticks, double ticks_per_packet) {
  const std::vector<double> as_recorded = recorded;
  int count = 0;
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    if (delay_ticks + recorded[i] <= kRoom * ticks_per_packet) continue;
    for (std::size_t k = 1; k <= static_cast<std::size_t>(kRoom) && recorded[i] >= 0.0; ++k) {
      const double later = as_recorded[(i + k) % as_recorded.size()];
      if (later >= 0.0 && static_cast<double>(k) * ticks_per_packet + later <= as_recorded[i])
        recorded[i] = -1.0;
    }
    count += recorded[i] < 0.0 ? 1 : 0;
  }
  return count;
}

void add_fates(const NetworkOptions& o, std::span<const double> recorded, AnalyzedScene& s) {
  const double local_hz = s.scene.rates.local_hz;
  core::LinkModelParameters link = o.link.model(local_hz);
  const double own_delay = link.delay_ticks;
  link.recorded = recorded;
  link.recorded_from_seed = true;
  double fixed = 0.0;
  for (auto& row : s.network.link)
    for (core::LinkModelParameters& one : row) {
      link.delay_ticks = one.delay_ticks + own_delay;
      fixed = std::max(fixed, link.delay_ticks);
      one = link;
    }
  double longest = fixed + 2.0 * link.jitter_ticks;
  for (const double d : recorded) longest = std::max(longest, fixed + d);
  const double in_flight = longest / s.scene.ticks_per_packet();
  if (in_flight <= kRoom) return;
  throw CLI::ValidationError(
      o.trace.empty() ? "--link-delay-ms" : "--trace",
      fmt::format("the longest delay, {:.4g} ms, keeps {:.0f} packets in flight; a modelled link "
                  "holds {:.0f}: at most {:.4g} ms at rates.packet_hz = {:g}",
                  1e3 * longest / local_hz, in_flight, kRoom, 1e3 * kRoom / s.scene.rates.packet_hz,
                  s.scene.rates.packet_hz));
}

/// One line on what packets of every link meet.
std::string said(const NetworkOptions& o, const NetworkTrace& trace) {
  std::string text;
  if (!trace.about.empty()) text += "; delays of " + trace.about;
  if (o.link.delay_ms > 0.0) text += fmt::format("; {:g} ms one way", o.link.delay_ms);
  if (o.link.jitter_ms > 0.0)
    text += fmt::format("; {} jitter {:g} ms", o.link.jitter_kind, o.link.jitter_ms);
  if (o.link.loss > 0.0) text += fmt::format("; {:g} of the packets lost", o.link.loss);
  if (o.link.burst_enter > 0.0)
    text += fmt::format("; bursts of loss: into one {:g}, out of it {:g} a packet",
                        o.link.burst_enter, o.link.burst_leave);
  return text.empty() ? "; every packet arrives in time" : text;
}

void run(const NetworkOptions& o) {
  AnalyzedScene s = o.common.load();
  if (s.scene.architecture == core::Architecture::kSingle)
    throw CLI::ValidationError(
        "--scene", s.scene.name +
                       " is architecture: SINGLE, no packets travel in it; CENTRAL and DISTRIBUTED "
                       "scenes have a network (`tandem scene list`); `tandem analyze point` judges "
                       "this one");
  const NetworkTrace trace = read_trace(o);
  std::vector<double> recorded = trace.in_ticks(s.scene.rates.local_hz);
  const int overtaken =
      o.link.fifo ? 0
                  : take_out_overtaken(recorded,
                                       s.network.link[0][1].delay_ticks +
                                           o.link.delay_ms * 1e-3 * s.scene.rates.local_hz,
                                       s.scene.ticks_per_packet());
  add_fates(o, recorded, s);

  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.common.delay_packets;
  json["assumptions"] = s.assumptions;
  if (!recorded.empty()) json["recorded_overtaken"] = overtaken;
  std::string text = fmt::format("{}, round trip {:.6g} packets{}\n{}", s.scene.name,
                                 o.common.delay_packets, said(o, trace), s.assumed());
  if (overtaken > 0)
    text += fmt::format(
        "  {} of the recorded delays are above {:.4g} ms: newer packets overtake those, they count "
        "as lost\n",
        overtaken, 1e3 * kRoom / s.scene.rates.packet_hz);

  const auto session = analysis::random_session(s.scene, s.network);
  ordered_json& square = json["mean_square"];
  bool unstable_square = false;
  if (session.why_not.empty()) {
    const auto moment = analysis::second_moment(session.system);
    unstable_square = !(moment.radius < 1.0);
    const char* how = moment.dense ? "exact: eigenvalues of the half-vectorised Kronecker matrix"
                                   : "exact: the same matrix, applied until its growth is steady";
    square = {{"stable", moment.converged ? ordered_json(!unstable_square) : nullptr},
              {"radius_per_packet", number(moment.radius)},
              {"method", how},
              {"modes", session.system.states.size()},
              {"maps", session.system.maps.size()},
              {"size", moment.size},
              {"converged", moment.converged},
              {"independent_draws", recorded.empty() ? "as given" : "from the recorded histogram"}};
    text += fmt::format(
        "  mean square: {} grows {:.10g} times a packet period ({}{})\n    {}, {} modes, {} maps "
        "measured on the running loop, {} numbers\n",
        "E|x|^2", moment.radius, unstable_square ? "NOT stable" : "stable",
        moment.converged ? "" : ", not converged: take it as near", how,
        session.system.states.size(), session.system.maps.size(), moment.size);
    if (!recorded.empty())
      text += "    recorded delays taken as independent draws; what follows takes them in order\n";
  } else {
    square = {{"stable", nullptr}, {"why_not", session.why_not}};
    text +=
        fmt::format("  mean square: not lifted exactly, {}; sampled instead:\n", session.why_not);
  }

  analysis::LyapunovOptions sampling = o.sampling;
  const bool progress = isatty(STDERR_FILENO) != 0;
  sampling.progress = [&](int done, int all) {
    if (progress) fmt::print(stderr, "\r{} of {} runs{}", done, all, done == all ? "\n" : "");
    return network_interrupted == 0;
  };
  const auto before = std::signal(SIGINT, [](int) { network_interrupted = 1; });
  analysis::Lyapunov typical;
  try {
    typical = analysis::sampled_exponent(s.scene, s.network, sampling);
  } catch (const std::runtime_error& e) {
    std::signal(SIGINT, before);
    throw Failed(e.what());
  }
  std::signal(SIGINT, before);
  const char* verdict = typical.surely_stable()     ? "stable"
                        : typical.surely_unstable() ? "NOT stable"
                                                    : "not decided: take more --runs or --packets";
  json["typical_run"] = {{"exponent_per_packet", number(typical.exponent)},
                         {"half_width_95_percent", number(typical.half_width)},
                         {"growth_per_packet", number(std::exp(typical.exponent))},
                         {"verdict", verdict},
                         {"method", "sampled Lyapunov exponent of the running loop"},
                         {"runs", typical.runs},
                         {"packets", typical.packets},
                         {"seed", sampling.seed}};
  text += fmt::format(
      "  typical run: Lyapunov exponent {:.3e} +- {:.1e} a packet period (95 %), that is {:.8f} "
      "times: {}\n    sampled on the running loop, {} runs of {} packets\n",
      typical.exponent, typical.half_width, std::exp(typical.exponent), verdict, typical.runs,
      typical.packets);
  if (unstable_square && typical.surely_stable())
    text +=
        "  Runs die out in the end, but their mean square grows: now and then losses follow each\n"
        "  other for long enough to make a deviation large. Do not put a hand on it.\n";
  if (!o.common.json.to_stdout()) fmt::print("{}", text);
  o.common.json.write(json);
}

}  // namespace

void add_analyze_network(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "network",
      "stability under random loss and jitter: mean square exactly, typical run sampled");
  auto o = std::make_shared<NetworkOptions>();
  o->common.add(*command);
  o->link.add(*command);
  command->get_option("--burst-leave")->needs(command->get_option("--burst-enter"));
  CLI::Option* trace = command->add_option(
      "--trace", o->trace, "recorded round trips, one a line [ms]; nan: lost. Half counts one way");
  trace->excludes(command->get_option("--jitter-ms"));
  CLI::Option* one_way = command->add_flag("--one-way", o->one_way, "they are one-way delays");
  one_way->needs(trace);
  command
      ->add_option("--received", o->received,
                   "--trace is a capture of packets as sent, this one as received: lines "
                   "TIME_NS,PACKET; what is missing was lost")
      ->needs(trace)
      ->excludes(one_way);
  command->add_option("--runs", o->sampling.runs, "sampled runs")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command->add_option("--packets", o->sampling.packets, "packet periods of each")
      ->check(CLI::Range(10, 100000000))
      ->capture_default_str();
  command->add_option("--seed", o->sampling.seed, "of the fates")->check(seed_number, "", "seed");
  on_call(*command, o, run);
}

}  // namespace tandem::cli
