#include "cli/demo_script.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "core/target_path.h"

namespace tandem::cli {
namespace {

constexpr double kShortest = 5.0;  // [s]

template <typename Change>
void for_each_intent(core::Scene& scene, Change&& change) {
  for (core::UserParameters& user : scene.users)
    for (core::FingerParameters& finger : user.fingers) change(finger.intent);
}

void speed_up(core::FingerIntent& intent, double factor) {
  for (core::Keyframe& k : intent.path) k.time /= factor;
  for (auto* sines : {&intent.path_sines, &intent.force_sines})
    for (core::SinePart& s : *sines) {
      s.start /= factor;
      s.end /= factor;
      s.omega *= factor;
    }
}

/// One round more, from `start` on. Its first keyframe is where the last round ended.
void append_round(core::FingerIntent& intent, const core::FingerIntent& round, double start) {
  for (std::size_t i = 1; i < round.path.size(); ++i) {
    core::Keyframe k = round.path[i];
    k.time += start;
    intent.path.push_back(k);
  }
  const auto append = [start](auto& sines, const auto& more) {
    for (core::SinePart s : more) {
      s.start += start;
      s.end += start;
      sines.push_back(s);
    }
  };
  append(intent.path_sines, round.path_sines);
  append(intent.force_sines, round.force_sines);
}

/// How many rounds of this a finger's path can hold.
int rounds_that_fit(const core::FingerIntent& intent) {
  int rounds = 1000;
  if (intent.path.size() > 1)
    rounds = (core::kMaxKeyframes - 1) / (static_cast<int>(intent.path.size()) - 1);
  for (const auto* sines : {&intent.path_sines, &intent.force_sines})
    if (!sines->empty())
      rounds = std::min(rounds, core::kMaxSines / static_cast<int>(sines->size()));
  return std::max(rounds, 1);
}

}  // namespace

ScriptTimes script_times(const core::Scene& scene) {
  ScriptTimes times;
  for (const core::UserParameters& user : scene.users)
    for (const core::FingerParameters& finger : user.fingers) {
      if (!finger.intent.path.empty())
        times.length = std::max(times.length, finger.intent.path.back().time);
      if (times.carries || finger.intent.path_sines.empty()) continue;
      const core::SinePart& carry = finger.intent.path_sines.front();
      times.carries = true;
      times.carry_start = carry.start;
      times.carry_end = carry.end;
      times.direction = glm::normalize(carry.direction);
    }
  return times;
}

int fit_script(core::Scene& scene, double seconds) {
  const double length = script_times(scene).length;
  if (length <= 0.0) return 1;
  if (seconds < kShortest)
    throw std::invalid_argument(
        fmt::format("--seconds {}: the hands need at least {} s to grasp, carry and let go",
                    seconds, kShortest));
  if (seconds < length) {
    for_each_intent(scene, [&](core::FingerIntent& i) { speed_up(i, length / seconds); });
    return 1;
  }
  int rounds = static_cast<int>(std::floor(seconds / length + 1e-9));
  for_each_intent(scene,
                  [&](core::FingerIntent& i) { rounds = std::min(rounds, rounds_that_fit(i)); });
  for_each_intent(scene, [&](core::FingerIntent& intent) {
    const core::FingerIntent round = intent;
    for (int r = 1; r < rounds; ++r) append_round(intent, round, r * length);
  });
  return rounds;
}

void leave_carry_to_recording(core::Scene& scene, double seconds) {
  const ScriptTimes times = script_times(scene);
  if (!times.carries)
    throw std::invalid_argument("scene " + scene.name +
                                ": no finger has a path_sine, so there is no carry that a recorded "
                                "hand could take over; give a scene like box_distributed");
  const double wait = seconds - times.length;
  for_each_intent(scene, [&](core::FingerIntent& intent) {
    intent.path_sines.clear();
    for (core::Keyframe& k : intent.path) {
      k.position -= times.direction * glm::dot(k.position, times.direction);
      if (k.time > times.carry_end) k.time += wait;
    }
  });
  if (wait < 0.0 && times.carry_end + wait < times.carry_start + 1.0)
    throw std::invalid_argument(
        fmt::format("--seconds {}: with recorded hands at least {} s are needed", seconds,
                    std::ceil(times.length - (times.carry_end - times.carry_start) + 1.0)));
}

}  // namespace tandem::cli
