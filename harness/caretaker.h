#pragma once

#include <string>
#include <sys/types.h>

namespace tandem::harness {

/// Removes what this process has made should it end without doing so itself, SIGKILL included: a
/// child process that waits for our end at a pipe. Also turns SIGINT and SIGTERM into a flag.
///
/// Make the first call of `instance` early, before there are threads. It goes with the process.
class Caretaker {
 public:
  [[nodiscard]] static Caretaker& instance();

  /// Whether SIGINT or SIGTERM has come since the start.
  [[nodiscard]] static bool interrupted();

  /// Sets the signal handlers again, for callers who had others in between. SIGPIPE is ignored.
  void listen();

  void kill_group_at_end(pid_t leader);
  void remove_folder_at_end(const std::string& folder);
  void remove_namespace_at_end(const std::string& name);
  /// Done by others since, and its number or name may soon be somebody else's.
  void group_has_ended(pid_t leader);
  void folder_is_removed(const std::string& folder);
  void namespace_is_removed(const std::string& name);
  /// All is done: nothing of what was told is needed any more.
  void forget();

 private:
  Caretaker();
  ~Caretaker();
  void tell(const std::string& line);

  int pipe_ = -1;
  pid_t pid_ = -1;
};

}  // namespace tandem::harness
