#include "cli/stability_guard.h"

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cli/analyze.h"
#include "cli/commands.h"
#include "scene/shared_hash.h"

namespace tandem::cli {

namespace {

AnalyzedScene analyzed(const core::Scene& scene) {
  analysis::LinearScene linear = analysis::linear_scene(scene);
  return {std::move(linear.scene), {}, std::move(linear.assumptions)};
}

/// What is found by differences of a running loop is known to this; a drift that nothing brakes is
/// one, and no instability.
constexpr double kGrows = 1.0 + 1e-6;

double growth(AnalyzedScene s, int ticks) {
  const double N = s.scene.ticks_per_packet();
  s.network.set_round_trip(ticks / N, N);
  return analysis::judge(s.lift()).radius;
}

/// One number of a coupler, and its path for --set.
struct Number {
  std::size_t coupler;
  core::Gain core::CouplerParameters::*gain;
  double core::Gain::*value;
  std::string path;
  bool by_root = false;  ///< lowered by the root of what the others are

  [[nodiscard]] double& in(core::Scene& scene) const {
    return scene.couplers[coupler].*gain.*value;
  }
};

/// Couplers that do the same with the same gains: what is turned down together.
struct Group {
  std::vector<std::size_t> couplers;
};

int kind_of(const core::CouplerParameters& c) {
  return c.user.empty() ? 0 : c.copy.empty() || c.user == c.copy ? 1 : 2;
}

std::vector<Group> groups_of(const core::Scene& scene) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < scene.couplers.size(); ++i) {
    const core::CouplerParameters& c = scene.couplers[i];
    bool placed = false;
    for (Group& g : groups) {
      const core::CouplerParameters& other = scene.couplers[g.couplers.front()];
      if (kind_of(c) != kind_of(other) || c.gain.stiffness != other.gain.stiffness ||
          c.gain.damping != other.gain.damping)
        continue;
      g.couplers.push_back(i);
      placed = true;
      break;
    }
    if (!placed) groups.push_back({{i}});
  }
  return groups;
}

/// How some couplers may be lowered.
enum class How {
  kStiffness,        ///< of the axis, normal, or linear gain
  kDamping,          ///< of the same
  kAllStiffnesses,   ///< tangential and rotation too
  kStiffnessFaster,  ///< all stiffnesses, dampings by the root: the damping ratio stays
  kAll
};

std::vector<Number> numbers_of(const core::Scene& scene, const std::vector<std::size_t>& couplers,
                               How how) {
  std::vector<Number> out;
  const bool axis = scene.space == core::Space::kAxis;
  for (const std::size_t i : couplers) {
    const core::CouplerParameters& c = scene.couplers[i];
    const auto add = [&](core::Gain core::CouplerParameters::*gain, const std::string& part) {
      const std::string path = "coupler." + c.name + (part.empty() ? "" : "." + part);
      if (how != How::kDamping && (c.*gain).stiffness > 0.0)
        out.push_back({i, gain, &core::Gain::stiffness, path + ".stiffness"});
      if (how != How::kStiffness && how != How::kAllStiffnesses && (c.*gain).damping > 0.0)
        out.push_back(
            {i, gain, &core::Gain::damping, path + ".damping", how == How::kStiffnessFaster});
    };
    add(&core::CouplerParameters::gain, axis ? "" : c.user.empty() ? "linear" : "normal");
    if (axis || how == How::kStiffness || how == How::kDamping) continue;
    if (c.user.empty())
      add(&core::CouplerParameters::rotation, "rotation");
    else
      add(&core::CouplerParameters::tangential, "tangential");
  }
  return out;
}

/// Two digits, downwards: what is advised can be typed.
double round_down(double value) {
  if (!(value > 0.0)) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1.0);
  return std::floor(value / unit + 1e-9) * unit;
}

}  // namespace

std::string advice(const core::Scene& scene, int ticks) {
  const AnalyzedScene base = analyzed(scene);
  // One kind of coupler, then those over the network, then all.
  std::vector<std::vector<std::size_t>> sets_of_couplers;
  std::vector<std::size_t> remote, all;
  for (const Group& g : groups_of(base.scene)) {
    sets_of_couplers.push_back(g.couplers);
    all.insert(all.end(), g.couplers.begin(), g.couplers.end());
    if (kind_of(base.scene.couplers[g.couplers.front()]) != 1)
      remote.insert(remote.end(), g.couplers.begin(), g.couplers.end());
  }
  sets_of_couplers.push_back(remote);
  sets_of_couplers.push_back(all);
  std::vector<std::vector<Number>> changes;
  for (const auto& couplers : sets_of_couplers)
    for (const How how :
         {How::kStiffness, How::kDamping, How::kAllStiffnesses, How::kStiffnessFaster, How::kAll})
      changes.push_back(numbers_of(base.scene, couplers, how));
  for (const double factor : {0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05})
    for (const std::vector<Number>& numbers : changes) {
      if (numbers.empty()) continue;
      AnalyzedScene edited = base;
      std::string lower, sets;
      for (const Number& n : numbers) {
        double& value = n.in(edited.scene);
        const double before = value;
        value = round_down((n.by_root ? std::sqrt(factor) : factor) * value);
        lower += fmt::format("{}{} from {:.6g} to {:.6g}", lower.empty() ? "" : ", ", n.path,
                             before, value);
        sets += fmt::format(" --set {}={:.6g}", n.path, value);
      }
      if (growth(edited, ticks) < kGrows && growth(edited, ticks + 1) < kGrows)
        return "lower " + lower + ", in every node:" + sets;
    }
  return "no gain of its couplers lowered to a twentieth makes it stable; shorten the delay, or "
         "give "
         "hands and objects more mass";
}

node::StabilityPrediction predict_stability(const core::Scene& scene) {
  node::StabilityPrediction out;
  try {
    const AnalyzedScene s = analyzed(scene);
    const double without = growth(s, 0);
    const int N = static_cast<int>(std::ceil(s.scene.ticks_per_packet()));
    const bool network = s.scene.architecture != core::Architecture::kSingle;
    const int look = !network ? 0 : s.scene.space == core::Space::kAxis ? 8 * N : 4 * N;
    int ticks = 0;
    if (without < kGrows) {
      while (ticks < look && growth(s, ticks + 1) < kGrows) ++ticks;
      out.largest_stable_ticks = ticks;
      out.looked_no_further = ticks == look;
    }
    out.known = true;
    out.grows_from = kGrows;
    out.text = fmt::format("predicted: growth {:.6f} a packet period without delay", without);
    if (network && without < kGrows)
      out.text += fmt::format(
          "; a round trip of {} ticks ({:.1f} ms) is borne, {}", ticks,
          1e3 * ticks * s.scene.tick(),
          out.looked_no_further ? "more was not looked at" : fmt::format("{} are not", ticks + 1));
    if (!s.assumptions.empty())
      out.text += fmt::format("\n  assumed: {}", fmt::join(s.assumptions, "; "));
    out.growth = [s](int at) { return growth(s, at); };
    out.advice = [scene](int at) { return advice(scene, at); };
  } catch (const std::exception& e) {
    out.text = std::string("no prediction of its stability: ") + e.what();
  }
  return out;
}

node::GuardMaker guard_maker(bool refuses, const core::Scene* scene) {
  struct Known {
    std::uint64_t hash = 0;
    node::StabilityPrediction prediction;
  };
  auto known = std::make_shared<Known>();
  if (scene != nullptr) {
    *known = {scene::shared_hash(*scene), predict_stability(*scene)};
    if (refuses && known->prediction.known && known->prediction.largest_stable_ticks < 0)
      throw Failed(
          known->prediction.text + "\nrefused: the scene is unstable whatever the network " +
          "does (--on-unstable warn runs it all the same); " + known->prediction.advice(0));
  }
  return [known, refuses](const core::Scene& of) {
    const bool same = known->hash != 0 && known->hash == scene::shared_hash(of);
    return std::make_unique<node::StabilityGuard>(same ? known->prediction : predict_stability(of),
                                                  refuses, of.tick());
  };
}

}  // namespace tandem::cli
