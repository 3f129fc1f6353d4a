#include "net/session.h"

namespace tandem::net {

std::optional<SessionDatagram> SessionOutput::next_datagram() {
  if (datagrams_.empty()) return std::nullopt;
  auto out = std::move(datagrams_.front());
  datagrams_.pop_front();
  return out;
}

std::optional<SessionEvent> SessionOutput::next_event() {
  if (events_.empty()) return std::nullopt;
  auto out = std::move(events_.front());
  events_.pop_front();
  return out;
}

void SessionOutput::send(const Endpoint& to, const ControlMessage& message) {
  datagrams_.push_back({to, encode_control(message)});
}

}  // namespace tandem::net
