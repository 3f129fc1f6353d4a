#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/bounds.h"
#include "analysis/coupler_limits.h"
#include "analysis/stability.h"
#include "cli/analyze.h"
#include "cli/commands.h"

namespace tandem::cli {

namespace {

using nlohmann::ordered_json;

struct BoundsOptions {
  AnalyzeOptions common;
  std::string csv;
  double device_damping = -1.0, device_friction = -1.0, encoder_step = -1.0;
};

/// One line of one coupler, and how the scene's field is called.
struct Line {
  std::string user, finger, field;
  bool remote = false;  ///< its force crosses the network
  bool wall = false;    ///< a wall that the finger touches, instead of a coupler to an object
  analysis::LocalCoupler coupler;
};

/// One bound beside its exact answer.
struct Row {
  std::string name, source, asks;  ///< what it promises
  std::string inputs{};
  double value = 0.0;  ///< [N/m], or [N s/m] for what is needed
  bool applies = true;
  std::string why_not{};
  double exact = 0.0;
  std::string exactly{};  ///< what the exact answer is of
};

/// What the finger's device and the rates add, or the options in their place.
void of_device(analysis::LocalCoupler& k, const core::Scene& given,
               const core::FingerParameters& finger, const BoundsOptions& o) {
  k.device_damping = finger.damping;
  const int d = core::index_of(given.devices, finger.device);
  if (d >= 0) {
    k.device_friction = given.devices[d].friction;
    k.encoder_step = given.devices[d].encoder_step;
  }
  if (o.device_damping >= 0.0) k.device_damping = o.device_damping;
  if (o.device_friction >= 0.0) k.device_friction = o.device_friction;
  if (o.encoder_step >= 0.0) k.encoder_step = o.encoder_step;
  k.T = given.tick();
  k.latency_ticks = given.rates.latency_ticks;
  k.integrator = given.integrator;
}

std::vector<Line> lines_of(const core::Scene& given, const AnalyzedScene& s,
                           const BoundsOptions& o) {
  std::vector<Line> out;
  const bool plane = s.scene.space == core::Space::kPlane;
  for (const core::CouplerParameters& c : s.scene.couplers) {
    const int u = core::index_of(s.scene.users, c.user);
    const int object = core::index_of(s.scene.objects, c.object);
    if (c.user.empty() || u < 0 || object < 0) continue;
    const core::UserParameters& user = given.users[u];
    for (std::size_t f = 0; f < user.fingers.size(); ++f)
      for (const auto& [gain, kind] :
           {std::pair{&c.gain, plane ? "normal." : ""}, {&c.tangential, "tangential."}}) {
        if (!plane && gain == &c.tangential) continue;
        if (gain->stiffness <= 0.0 && gain->damping <= 0.0) continue;
        Line line;
        line.user = user.name;
        line.finger = user.fingers[f].name;
        line.field = "coupler." + c.name + "." + kind + "stiffness";
        line.remote = s.scene.architecture == core::Architecture::kCentral ? !user.local
                      : !c.copy.empty()                                    ? c.copy != user.name
                                                                           : false;
        analysis::LocalCoupler& k = line.coupler;
        k.stiffness = gain->stiffness;
        k.damping = gain->damping;
        k.hand_mass = user.mass;
        k.object_mass = s.scene.objects[object].mass;
        if (s.scene.architecture == core::Architecture::kDistributedSplit)
          k.object_mass /= static_cast<double>(s.scene.users.size());
        of_device(k, given, user.fingers[f], o);
        out.push_back(line);
      }
  }
  for (const core::WallParameters& w : s.scene.walls)
    for (const core::UserParameters& user : given.users)
      for (const core::FingerParameters& finger : user.fingers) {
        if (plane || !w.touches_fingers || w.gain.stiffness <= 0.0) continue;
        Line line;
        line.user = user.name;
        line.finger = finger.name;
        line.field = "wall." + w.name + ".stiffness";
        line.wall = true;
        line.coupler.stiffness = w.gain.stiffness;
        line.coupler.damping = w.gain.damping;
        line.coupler.hand_mass = user.mass;
        of_device(line.coupler, given, finger, o);
        out.push_back(line);
      }
  return out;
}

std::vector<Row> rows_of(const Line& line) {
  const analysis::LocalCoupler& c = line.coupler;
  const std::string b_text = fmt::format("b {:g}", c.device_damping);
  const auto no_damping = [&](Row& row) {
    row.applies = c.device_damping > 0.0;
    if (row.applies) return;
    row.why_not = "the device has no damping of its own (finger.damping, --device-damping)";
  };
  std::vector<Row> rows;
  const analysis::WorstHand wall = analysis::worst_wall_stiffness(c);
  const auto hand_text = [](const analysis::WorstHand& w) {
    return fmt::format("of a hand of {:g} kg, {:g} N/m, {:g} N s/m", w.hand.mass, w.hand.stiffness,
                       w.hand.damping);
  };

  Row needed{"Colgate-Schenkel, damping", "Colgate and Schenkel 1997", "b for a passive wall K + B",
             fmt::format("K {:g}, B {:g}, {} ticks late", c.stiffness, c.damping, c.latency_ticks),
             analysis::colgate_schenkel_damping(c.stiffness, c.damping, c.T, c.latency_ticks)};
  needed.exact = c.device_damping;
  needed.exactly = "the device's b";
  rows.push_back(needed);

  Row passive{
      "Colgate-Schenkel, stiffness", "Colgate and Schenkel 1997", "passive wall, any hand",
      fmt::format("{}, B {:g}, {} ticks late", b_text, c.damping, c.latency_ticks),
      analysis::colgate_schenkel_stiffness(c.device_damping, c.damping, c.T, c.latency_ticks)};
  no_damping(passive);
  if (passive.applies && passive.value == 0.0) {
    passive.applies = false;
    passive.why_not =
        fmt::format("the virtual damper alone needs {:g} N s/m of the device",
                    analysis::colgate_schenkel_damping(0.0, c.damping, c.T, c.latency_ticks));
  }
  passive.exact = wall.stiffness;
  passive.exactly = "wall, worst sampled passive hand: " + hand_text(wall);
  rows.push_back(passive);

  analysis::LocalCoupler spring = c;
  spring.damping = 0.0;
  spring.latency_ticks = 0;
  const analysis::WorstHand bare =
      c.damping == 0.0 && c.latency_ticks == 0 ? wall : analysis::worst_wall_stiffness(spring);
  Row abbott{
      "Abbott-Okamura", "Abbott and Okamura 2005", "passive spring wall, encoder and friction",
      fmt::format("{}, friction {:g} N, encoder {:g} m", b_text, c.device_friction, c.encoder_step),
      analysis::abbott_okamura_stiffness(c.device_damping, c.device_friction, c.encoder_step, c.T)};
  no_damping(abbott);
  if (abbott.applies && c.encoder_step > 0.0 && c.device_friction == 0.0) {
    abbott.applies = false;
    abbott.why_not = "an encoder step without friction is never passive (device.friction)";
  }
  abbott.exact = bare.stiffness;
  abbott.exactly = "spring wall without encoder and friction: " + hand_text(bare);
  rows.push_back(abbott);

  Row diolaiti{"Diolaiti", "Diolaiti et al. 2006", "spring wall loses energy, no chatter",
               fmt::format("{}, friction {:g} N, encoder {:g} m, {} ticks late", b_text,
                           c.device_friction, c.encoder_step, c.latency_ticks),
               analysis::diolaiti_stiffness(c.device_damping, c.device_friction, c.encoder_step,
                                            c.T, c.latency_ticks * c.T)};
  no_damping(diolaiti);
  if (diolaiti.applies && diolaiti.value == 0.0) {
    diolaiti.applies = false;
    diolaiti.why_not = "an encoder step without friction chatters at any stiffness";
  }
  spring.latency_ticks = c.latency_ticks;
  const analysis::WorstHand late =
      c.latency_ticks == 0 ? bare : analysis::worst_wall_stiffness(spring);
  diolaiti.exact = late.stiffness;
  diolaiti.exactly = "delayed spring wall without encoder and friction: " + hand_text(late);
  rows.push_back(diolaiti);

  if (line.wall) {  // (3.18) with an object that nothing moves; the hand is stepped exactly
    constexpr double kFast = 1e300;  // [kg]
    Row free{"2 B / T", "thesis 3.18, an object held fast", "stable, hand free",
             fmt::format("B {:g}, mass {:g} kg", c.damping, c.hand_mass),
             analysis::coupled_masses_stiffness(c.damping, c.hand_mass, kFast, c.T)};
    free.exact = analysis::stable_wall_stiffness(c, {c.hand_mass, 0.0, 0.0});
    free.exactly =
        "this hand, free" + std::string(c.device_damping > 0.0 ? ", device damping too" : "");
    free.applies = c.latency_ticks == 0;
    if (!free.applies) free.why_not = "it knows no computation delay";
    rows.push_back(free);
    return rows;
  }

  // The closed forms know no device damping and no delay; the exact pair beside them has both.
  const bool exact_object = c.integrator == core::Integrator::kZeroOrderHold;
  const double step = exact_object                                           ? 0.5
                      : c.integrator == core::Integrator::kSemiImplicitEuler ? 1.0
                                                                             : 0.0;
  const double pair = analysis::stable_coupler_stiffness(c, {c.hand_mass, 0.0, 0.0});
  const std::string of_pair = "this free hand and object" +
                              std::string(c.latency_ticks > 0 ? ", computation delay too" : "") +
                              (c.device_damping > 0.0 ? ", device damping too" : "");
  const auto masses = [&](const char* name, const char* source, double value) {
    Row row{name, source, "stable, hand and object free",
            fmt::format("B {:g}, masses {:g} and {:g} kg", c.damping, c.hand_mass, c.object_mass),
            value};
    row.exact = pair;
    row.exactly = of_pair;
    if (c.latency_ticks > 0) {
      row.applies = false;
      row.why_not = "it knows no computation delay";
    }
    return row;
  };
  Row zoh = masses("2 B / T", "thesis 3.18, exact zero-order hold",
                   analysis::coupled_masses_stiffness(c.damping, c.hand_mass, c.object_mass, c.T));
  if (zoh.applies && !exact_object) {
    zoh.applies = false;
    zoh.why_not = "the object is stepped by another integrator";
  }
  rows.push_back(zoh);
  Row euler = masses("B / T", "explicit Euler on both masses", c.damping / c.T);
  if (euler.applies && step != 0.0) {
    euler.applies = false;
    euler.why_not = "hand and object are stepped otherwise here";
  } else if (euler.applies) {
    euler.why_not = "the hand is exact here: the next line is of this pair";
  }
  rows.push_back(euler);
  rows.push_back(
      masses("trace and determinant", "Jury's test, exact hand, this integrator",
             analysis::coupled_masses_stiffness(c.damping, c.hand_mass, c.object_mass, step, c.T)));

  Row llewellyn{"Llewellyn, coupling", "Adams and Hannaford 1999",
                "any passive hand and environment", fmt::format("{}, B {:g}", b_text, c.damping),
                analysis::llewellyn_stiffness(c.damping, c.device_damping, c.T)};
  no_damping(llewellyn);
  if (llewellyn.applies && c.latency_ticks > 0) {
    llewellyn.applies = false;
    llewellyn.why_not = "its two-port knows no computation delay";
  }
  if (llewellyn.applies && llewellyn.value == 0.0) {
    llewellyn.applies = false;
    llewellyn.why_not =
        fmt::format("the damper alone needs {:g} N s/m of the device, B / 8", c.damping / 8.0);
  }
  const analysis::WorstHand any = analysis::worst_coupler_stiffness(c);
  llewellyn.exact = any.stiffness;
  llewellyn.exactly = "worst sampled passive hand on a wall or free objects: " + hand_text(any);
  rows.push_back(llewellyn);
  return rows;
}

ordered_json value_of(double x) { return std::isinf(x) ? ordered_json("over 1e8") : number(x); }

void run(const BoundsOptions& o) {
  const core::Scene given = o.common.scene.load();
  const AnalyzedScene s = o.common.load();
  std::string text = fmt::format(
      "{}, round trip {:.6g} packets: bounds from the literature beside exact answers [N/m]\n"
      "  A bound that asks for passivity holds for any passive hand; the exact one beside it is "
      "the least\n  of sampled hands, so an upper limit of what any bound may allow.\n{}{}",
      s.scene.name, o.common.delay_packets, s.assumed(), s.grasp());
  ordered_json json;
  json["scene"] = s.scene.name;
  json["delay_packets"] = o.common.delay_packets;
  json["assumptions"] = s.assumptions;
  json["couplers"] = ordered_json::array();
  std::string csv = "field,user,finger,bound,applies,value,exact\n";
  analysis::StabilityJudge judge(s.scene, s.network);
  std::vector<std::string> seen;
  for (const Line& line : lines_of(given, s, o)) {
    // Fingers of one user with equal devices have equal bounds.
    const analysis::LocalCoupler& c = line.coupler;
    const std::string same =
        fmt::format("{} {} {} {}", line.field, c.device_damping, c.device_friction, c.encoder_step);
    if (std::find(seen.begin(), seen.end(), same) != seen.end()) continue;
    seen.push_back(same);
    ordered_json entry{{"field", line.field},
                       {"user", line.user},
                       {"finger", line.finger},
                       {"stiffness", c.stiffness},
                       {"across_network", line.remote}};
    text += fmt::format("  {} = {:g}, user {}\n", line.field, c.stiffness, line.user);
    const analysis::Knob knob(s.scene, line.field);
    analysis::IntervalOptions options;
    options.samples = 80;
    options.tolerance = 1e-9;
    const double top = std::max(30.0 * c.damping / c.T, 100.0 * c.stiffness);
    const auto stable = analysis::stable_intervals(judge, s.scene, knob, 1e-6 * top, top, options);
    std::string listed;
    entry["stable_in_this_scene"] = ordered_json::array();
    for (const auto& i : stable) {
      entry["stable_in_this_scene"].push_back({number(i.low), number(i.high)});
      listed += fmt::format("{}{:.6g} .. {:.6g}", listed.empty() ? "" : "; ",
                            i.low <= 1e-6 * top ? 0.0 : i.low, i.high);
    }
    text += fmt::format("    exact, in this whole scene: stable at {}\n",
                        listed.empty() ? "none" : listed);
    if (line.remote) {
      text +=
          "    bounds: none applies, its force crosses the network (held for a packet, "
          "delayed)\n";
      entry["why_not"] = "its force crosses the network";
      json["couplers"].push_back(entry);
      continue;
    }
    entry["bounds"] = ordered_json::array();
    for (const Row& row : rows_of(line)) {
      const bool needs = row.exactly == "the device's b";
      text += fmt::format(
          "    {:27} {:>12}  exact {:>12}  {}\n", row.name,
          row.applies ? fmt::format("{:.6g}{}", row.value, needs ? " N s/m" : "") : "no",
          std::isinf(row.exact) ? "over 1e8" : fmt::format("{:.6g}", row.exact), row.asks);
      text += fmt::format("        {}; {}; exact: {}\n", row.source, row.inputs, row.exactly);
      if (!row.why_not.empty())
        text += fmt::format("        {}{}\n", row.applies ? "" : "does not apply: ", row.why_not);
      entry["bounds"].push_back({{"bound", row.name},
                                 {"source", row.source},
                                 {"promises", row.asks},
                                 {"inputs", row.inputs},
                                 {"applies", row.applies},
                                 {"why_not", row.applies ? "" : row.why_not},
                                 {"value", value_of(row.value)},
                                 {"exact", value_of(row.exact)},
                                 {"exact_of", row.exactly}});
      csv += fmt::format("{},{},{},{},{},{},{}\n", line.field, line.user, line.finger, row.name,
                         row.applies ? 1 : 0, row.value, row.exact);
    }
    json["couplers"].push_back(entry);
  }
  if (json["couplers"].empty())
    throw Failed(s.scene.name +
                 " has no coupler between hand and object, and no wall that fingers touch");
  o.common.tell(o.csv, csv, text, json);
}

}  // namespace

void add_analyze_bounds(CLI::App& analyze) {
  CLI::App* command = analyze.add_subcommand(
      "bounds",
      "passivity and stability bounds of the literature for every hand's coupler, each "
      "beside the exact answer");
  auto o = std::make_shared<BoundsOptions>();
  o->common.add(*command);
  command
      ->add_option("--device-damping", o->device_damping,
                   "of the mechanism [N s/m]; default: the scene's finger.damping")
      ->check(between(0.0, 1e6));
  command
      ->add_option("--device-friction", o->device_friction,
                   "Coulomb [N]; default: the scene's device.friction")
      ->check(between(0.0, 1e6));
  command
      ->add_option("--encoder-step", o->encoder_step,
                   "[m]; default: the scene's device.encoder_step")
      ->check(between(0.0, 1.0));
  add_csv(*command, o->csv, "write the bounds to this file");
  on_call(*command, o, run);
}

}  // namespace tandem::cli
