#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>

#include "core/records.h"
#include "core/scene.h"
#include "core/view_tap.h"
#include "view/snapshot.h"

namespace tandem::view {

/// Puts together what one node saw, from its ticks and the packets it used: the same for a running
/// node (core::ViewTap) and for its recording.
///
/// A replica knows the hands and copies of the others, a server their hands, a client only its own
/// hand and the server's objects (its window asks for the rest, view/other_hands.h).
class Assembler {
 public:
  /// `user`: whose node it is; "server". Throws std::invalid_argument if the scene has no such
  /// user.
  Assembler(const core::Scene& scene, const std::string& user);

  void take(const core::TickRecord& tick);
  void take(const core::TappedTick& tapped);
  /// `count`: packets of this peer used so far, for its loss; 0: not counted.
  void take(const core::PacketRecord& packet, std::int64_t count = 0);
  /// Loss and faults start anew (a recording is played from elsewhere).
  void forget();

  [[nodiscard]] const Snapshot& snapshot() const noexcept { return now_; }

 private:
  struct Count {
    std::int64_t used = 0;
    std::uint64_t sequence = 0;
  };
  [[nodiscard]] double loss_of(int site, std::int64_t used, std::uint64_t sequence);

  core::Scene scene_;
  int hand_ = -1;  ///< whose hand the ticks carry; -1: nobody's
  bool is_client_ = false;
  Snapshot now_;
  std::array<std::deque<Count>, kSites> counts_;
};

/// Reads everything that is new in a tap into an assembler; false: nothing was.
[[nodiscard]] bool take_all(core::ViewTap& tap, Assembler& assembler);

}  // namespace tandem::view
