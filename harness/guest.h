#pragma once

#include <chrono>
#include <ios>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace tandem::harness {

/// User-mode Linux: a kernel that is an ordinary program, with netem as a module, booted on this
/// machine's own files in about 3 s (Debian's package user-mode-linux). What runs in it sees the
/// same paths and programs as root, writes land on the real disk, and its network is its own.
struct GuestKernel {
  std::string program;  ///< linux.uml; empty: not installed
  std::string modules;  ///< folder of its kernel modules
  std::string why_not;  ///< what is missing and how to get it
  [[nodiscard]] bool ready() const { return why_not.empty(); }
};
/// Looks for linux.uml in PATH, and for modules beside it.
[[nodiscard]] GuestKernel find_guest_kernel();

/// What a guest's clock is.
enum class GuestClock {
  kHost,  ///< the host's: a processor that the host takes away makes force loops miss ticks
  kOwn    ///< harness/guest_time.h: without host stalls, without idle time
};

/// Whether this process runs inside a guest that Guest booted.
[[nodiscard]] bool inside_guest();

/// The kernel round the guest and what it granted, for reports.
[[nodiscard]] std::string guest_host();

/// Mounts, modules and loopback, once, at the beginning of what runs inside. Throws HarnessError.
void settle_inside_guest();

/// Processors that guests may be pinned to, the one to take first in front: the first ones of the
/// machine take most of its interrupts.
[[nodiscard]] std::vector<int> processors_for_guests();

/// A guest that runs one command line as root in the current folder, pinned to one processor. With
/// the host's clock it asks for SCHED_FIFO 50, for punctual timers; with a clock of its own nothing
/// that runs in it can tell how long it took. The death of this process ends it.
class Guest {
 public:
  /// Makes its folder and nothing else yet. Throws HarnessError.
  Guest(GuestKernel kernel, GuestClock clock, int processor);
  /// Ends it, whatever it is doing, and removes its folder.
  ~Guest();
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;

  /// The same inside and outside; what the command leaves here is there once it has ended.
  [[nodiscard]] const std::string& folder() const { return folder_; }

  /// Boots it. Throws HarnessError.
  void start(const std::vector<std::string>& words);

  /// Takes the lines that the command has written since the last look. False once it has ended.
  /// Throws HarnessError with the end of the guest's console when it does not come up or breaks
  /// down.
  struct Said {
    std::vector<std::string> out, err;
  };
  bool look(Said& said);
  /// Exit status of the command; nothing before its end.
  [[nodiscard]] std::optional<int> status() const { return status_; }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  /// Complete lines of a file that grows.
  class Tail {
   public:
    void take(const std::string& file, std::vector<std::string>& lines, bool ended);

   private:
    std::streamoff done_ = 0;
    std::string begun_;
  };
  void end();

  GuestKernel kernel_;
  GuestClock clock_;
  int processor_;
  std::string folder_;
  pid_t pid_ = -1;
  std::chrono::steady_clock::time_point started_;
  Tail out_, err_;
  std::optional<int> status_;
};

/// Folders of guests whose process is gone, left by runs that were killed together with the process
/// that cleans up after them.
[[nodiscard]] std::vector<std::string> left_guests();

/// Ends these guests if they still run, and removes the folders.
void remove_guests(const std::vector<std::string>& folders);

}  // namespace tandem::harness
