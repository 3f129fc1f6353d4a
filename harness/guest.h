#pragma once

#include <string>
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

/// Whether this process runs inside a guest that run_in_guest booted.
[[nodiscard]] bool inside_guest();

/// The kernel round the guest and what it granted, for reports.
[[nodiscard]] std::string guest_host();

/// Mounts, modules and loopback, once, at the beginning of what runs inside. Throws HarnessError.
void settle_inside_guest();

/// Whether people watch: standard error is a terminal, here or at the host.
[[nodiscard]] bool on_terminal();

/// Boots the guest, runs one command line in it as root in the current folder, and ends it. What
/// the command says appears on our standard output and error as it comes. The guest is pinned to
/// one processor and asks for SCHED_FIFO 50, for punctual timers; with a clock of its own nothing
/// that runs in it can tell how long it took.
/// Ctrl-C, SIGTERM and the death of this process end the guest. Returns the exit status of the
/// command. Throws HarnessError with the end of the guest's console when it does not come up or
/// breaks down.
[[nodiscard]] int run_in_guest(const GuestKernel& kernel, const std::vector<std::string>& words,
                               GuestClock clock);

/// Folders of guests whose process is gone, left by runs that were killed together with the process
/// that cleans up after them.
[[nodiscard]] std::vector<std::string> left_guests();

/// Ends these guests if they still run, and removes the folders.
void remove_guests(const std::vector<std::string>& folders);

}  // namespace tandem::harness
