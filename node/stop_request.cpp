#include "node/stop_request.h"

#include <array>
#include <stdexcept>
#include <unistd.h>

#include "core/scene.h"

namespace tandem::node {
namespace {

constexpr std::size_t kMaxDevices = core::kMaxUsers * core::kMaxFingers;

// What the handlers see. Written before they are installed and after they are removed only.
StopRequest* active_request = nullptr;
std::array<devices::HapticDevice*, kMaxDevices> active_devices{};
std::size_t active_device_count = 0;

void stop_devices() noexcept {
  for (std::size_t i = 0; i < active_device_count; ++i) active_devices[i]->stop();
}

extern "C" void on_end(int signal) {
  if (active_request == nullptr) return;
  if (active_request->requested() && active_request->signal() != 0) {
    stop_devices();
    _exit(128 + signal);
  }
  active_request->request(signal);
}

extern "C" void on_crash(int signal) {
  stop_devices();
  // SA_RESETHAND has put the default action back: this time the process dies of it.
  raise(signal);
}

}  // namespace

SignalGuard::SignalGuard(StopRequest& request, std::span<devices::HapticDevice* const> devices) {
  if (active_request != nullptr) throw std::logic_error("two nodes in one process");
  if (devices.size() > kMaxDevices) throw std::logic_error("more devices than a session has");
  active_request = &request;
  active_device_count = devices.size();
  for (std::size_t i = 0; i < devices.size(); ++i) active_devices[i] = devices[i];

  for (std::size_t i = 0; i < kCount; ++i) {
    const int signal = kSignals[i];
    const bool ends = signal == SIGINT || signal == SIGTERM;
    struct sigaction action {};
    action.sa_handler = ends ? on_end : on_crash;
    action.sa_flags = ends ? SA_RESTART : static_cast<int>(SA_RESETHAND | SA_NODEFER);
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, &before_[i]);
  }
}

SignalGuard::~SignalGuard() {
  for (std::size_t i = 0; i < kCount; ++i) sigaction(kSignals[i], &before_[i], nullptr);
  active_request = nullptr;
  active_device_count = 0;
}

}  // namespace tandem::node
