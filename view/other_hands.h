#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "view/spectator.h"

namespace tandem::view {

/// The hands of the others for the window of a client: the server tells a client only of its
/// objects, so the window asks the server as a spectator does, in a session of its own, and goes on
/// asking until it is let in. The force loop knows nothing of it.
class OtherHands {
 public:
  OtherHands(std::string server, std::string program_version);
  ~OtherHands();
  OtherHands(const OtherHands&) = delete;
  OtherHands& operator=(const OtherHands&) = delete;

  /// Puts in what is known of all users but `own`: 2.5 packet periods old, and so it says. False:
  /// nothing is known.
  bool add_to(Snapshot& seen, int own);

 private:
  void ask();

  std::string server_, version_;
  std::mutex mutex_;  ///< spectator_
  std::unique_ptr<Spectator> spectator_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tandem::view
