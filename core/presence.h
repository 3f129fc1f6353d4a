#pragma once

#include <cstdint>
#include <optional>

#include "core/scene.h"

namespace tandem::core {

/// Whether a peer is there, as a gain on every force it causes: 1 while its packets come, down to 0
/// after `timeout` of silence within `fade`, up again within `rejoin` from zero stretch. Smooth
/// (3 s^2 - 2 s^3) and continuous whatever order packets and silences come in.
/// Without silence parameters the peer is there from the first tick and held for ever.
/// Before the first packet of a peer its gain is 0.
class Presence {
 public:
  Presence() noexcept = default;
  Presence(const std::optional<SilenceParameters>& silence, double T) noexcept {
    if (!silence) return;
    declared_ = true;
    ramp_ = 0.0;
    timeout_slots_ = static_cast<std::int64_t>(silence->timeout / T + 0.5);
    fade_step_ = silence->fade > 0.0 ? T / silence->fade : 1.0;
    rejoin_step_ = silence->rejoin > 0.0 ? T / silence->rejoin : 1.0;
  }

  /// One tick; `fresh`: a packet of the peer was accepted for it. Returns true when the peer has
  /// just come (back) from nothing: the caller seats its couplers at zero stretch.
  bool update(bool fresh, std::int64_t slot) noexcept {
    if (!declared_) return false;
    bool seated = false;
    if (fresh) {
      seated = ramp_ <= 0.0;
      joining_ = joining_ || seated;
      last_fresh_ = slot;
      seen_ = true;
    }
    const bool silent = !seen_ || slot - last_fresh_ > timeout_slots_;
    stale_ = seen_ && silent;
    ramp_ += silent ? -fade_step_ : rejoin_step_;
    if (ramp_ < 0.0) ramp_ = 0.0;
    if (ramp_ >= 1.0) {
      ramp_ = 1.0;
      joining_ = false;
    }
    return seated;
  }

  [[nodiscard]] double gain() const noexcept { return ramp_ * ramp_ * (3.0 - 2.0 * ramp_); }
  /// Part of the stretch found at the join that is still to be taken off: from 1 to 0 while the
  /// gain rises from nothing, 0 ever after. A fade must not bring that stretch back.
  [[nodiscard]] double seat_part() const noexcept { return joining_ ? 1.0 - gain() : 0.0; }
  /// It was there, and has not been heard for longer than `timeout`.
  [[nodiscard]] bool stale() const noexcept { return stale_; }
  [[nodiscard]] bool silent() const noexcept { return declared_ && ramp_ <= 0.0; }
  [[nodiscard]] bool declared() const noexcept { return declared_; }

 private:
  bool declared_ = false;
  bool seen_ = false, stale_ = false;
  bool joining_ = false;  ///< rising from nothing, not yet at 1
  double ramp_ = 1.0;
  std::int64_t last_fresh_ = 0;
  std::int64_t timeout_slots_ = 0;
  double fade_step_ = 0.0, rejoin_step_ = 0.0;
};

}  // namespace tandem::core
