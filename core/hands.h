#pragma once

#include <array>

#include "core/finger_output.h"
#include "core/simulated_hand.h"

namespace tandem::core {

/// The simulated hands of all users, as a loop closes them.
template <typename V>
class Hands {
 public:
  explicit Hands(const Scene& scene) noexcept {
    user_count_ = static_cast<int>(scene.users.size());
    for (int u = 0; u < user_count_; ++u) {
      const UserParameters& user = scene.users[u];
      counts_[u] = static_cast<int>(user.fingers.size());
      for (int f = 0; f < counts_[u]; ++f) {
        const int d = index_of(scene.devices, user.fingers[f].device);
        hands_[u][f] = SimulatedHand<V>(scene.tick(), user.mass, user.fingers[f],
                                        d < 0 ? nullptr : &scene.devices[d]);
      }
    }
  }

  void sample(int user, HandSample<V>& out) const noexcept {
    for (int f = 0; f < counts_[user]; ++f) out[f] = hands_[user][f].sample();
  }
  void step(int user, const FingerOutput<V>& output, std::int64_t slot) noexcept {
    for (int f = 0; f < counts_[user]; ++f) hands_[user][f].step(output.forces[f], slot);
  }
  [[nodiscard]] SimulatedHand<V>& finger(int user, int f) noexcept { return hands_[user][f]; }
  [[nodiscard]] const SimulatedHand<V>& finger(int user, int f) const noexcept {
    return hands_[user][f];
  }
  [[nodiscard]] int count(int user) const noexcept { return counts_[user]; }
  [[nodiscard]] int user_count() const noexcept { return user_count_; }

  template <typename Visitor>
  void visit_state(Visitor&& visitor) {
    for (int u = 0; u < user_count_; ++u)
      for (int f = 0; f < counts_[u]; ++f) hands_[u][f].visit_state(visitor);
  }

 private:
  int user_count_ = 0;
  std::array<int, kMaxUsers> counts_{};
  std::array<std::array<SimulatedHand<V>, kMaxFingers>, kMaxUsers> hands_{};
};

}  // namespace tandem::core
