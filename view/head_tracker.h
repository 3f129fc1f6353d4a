#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "net/udp_socket.h"
#include "view/room.h"

namespace tandem::view {

/// A head's place in the tracker's frame from one line of text: "X Y Z" [m], or "X Y Z QW QX QY QZ"
/// with the turn of the head; commas or spaces between. Throws std::invalid_argument with what is
/// wrong: not numbers, more than 100 m away, a quaternion that is far from length 1.
[[nodiscard]] Rigid parse_head(std::string_view line);

/// Head poses as any tracker's own program can send them: UDP datagrams of text, one pose each
/// (docs/viewer.md). The newest counts. One thread.
class HeadTracker {
 public:
  /// `bind`: "PORT" (this computer only) or "ADDRESS:PORT". Throws as net::UdpLink does.
  explicit HeadTracker(const std::string& bind);

  /// Takes what has come until `now` [s]; true: `head` was set. Never waits.
  bool update(double now, Rigid& head);
  /// "ADDRESS:PORT" where it listens.
  [[nodiscard]] std::string address() const;
  [[nodiscard]] std::uint64_t accepted() const noexcept { return accepted_; }
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }
  /// Why the last one was refused; empty: none was.
  [[nodiscard]] const std::string& last_refusal() const noexcept { return refusal_; }
  /// The tracker has said nothing for a second, or never anything: the head is where it was last.
  [[nodiscard]] bool silent(double now) const noexcept {
    return accepted_ == 0 || now - last_ > 1.0;
  }

 private:
  net::UdpLink link_;
  std::uint64_t accepted_ = 0, refused_ = 0;
  std::string refusal_;
  double last_ = 0.0;
};

}  // namespace tandem::view
