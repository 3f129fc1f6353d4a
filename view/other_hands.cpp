#include "view/other_hands.h"

#include <chrono>
#include <utility>

namespace tandem::view {

OtherHands::OtherHands(std::string server, std::string program_version)
    : server_(std::move(server)),
      version_(std::move(program_version)),
      thread_([this] { ask(); }) {}

OtherHands::~OtherHands() {
  stop_ = true;
  thread_.join();
}

void OtherHands::ask() {
  while (!stop_) {
    try {
      auto found = std::make_unique<Spectator>(server_, version_, 0.5);
      const std::lock_guard lock(mutex_);
      spectator_ = std::move(found);
      return;
    } catch (const std::exception&) {
      // No seat for spectators yet; the node itself says what is wrong with the server.
      for (int i = 0; i < 20 && !stop_; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

bool OtherHands::add_to(Snapshot& seen, int own) {
  const std::lock_guard lock(mutex_);
  if (spectator_ == nullptr) return false;
  (void)spectator_->take_messages();
  Snapshot there;
  if (!spectator_->at_now(there)) return false;
  for (int u = 0; u < core::kMaxUsers; ++u) {
    const auto i = static_cast<std::size_t>(u);
    if (u == own || !there.sites[i].has_hand) continue;
    seen.sites[i] = there.sites[i];
    seen.sites[i].has_objects = false;
    seen.sites[i].age += spectator_->buffer();
  }
  return true;
}

}  // namespace tandem::view
