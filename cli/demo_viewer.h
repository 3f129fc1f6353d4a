#pragma once

#include <string>
#include <sys/types.h>

namespace tandem::cli {

/// What the demo shows of a session while it runs: a window that looks on as a spectator where
/// there is a display, else one picture in a file. A process of its own, with less right to the
/// processors than anything else; gone when this object is.
class DemoViewer {
 public:
  /// @param address  of a running server or replica
  /// @param picture  where to put the picture without a display
  /// @param seconds  until that is taken
  DemoViewer(const std::string& address, const std::string& picture, double seconds);
  ~DemoViewer();
  DemoViewer(const DemoViewer&) = delete;
  DemoViewer& operator=(const DemoViewer&) = delete;

 private:
  pid_t pid_ = -1;
};

}  // namespace tandem::cli
