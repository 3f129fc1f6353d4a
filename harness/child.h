#pragma once

#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace tandem::harness {

/// A program's main: what it does with its words, and its exit status.
using Main = int (*)(int, char**);

struct ChildOptions {
  std::string network;                   ///< name of the network namespace it runs in; empty: ours
  std::vector<std::string> environment;  ///< NAME=VALUE beside what we have
  bool takes_input = false;              ///< `write` reaches its standard input; else it has none
  /// Given: called in the fork with the words, instead of starting the program anew. In user-mode
  /// Linux that costs a program of 50 libraries 0.8 s, and a fork next to nothing.
  Main main = nullptr;
};

/// A program that runs beside us, its standard output and error in one text. It is in a process
/// group of its own, so that Ctrl-C reaches us alone; it gets SIGTERM when we die, whatever the
/// cause, and SIGKILL when this goes out of scope. For one thread, which must not end before it.
class Child {
 public:
  /// `words`: the program, by path or as found in PATH and the system folders, and its arguments.
  /// Throws HarnessError when it cannot be started; a program that is missing ends with 127.
  explicit Child(std::vector<std::string> words, const ChildOptions& options = {});
  Child(Child&& other) noexcept;
  Child& operator=(Child&& other) noexcept;
  ~Child();

  void signal(int number);
  /// False when it takes no more.
  bool write(const std::string& text);
  void end_input();
  /// Takes what it has said; waits for that at most so long. False once it has ended.
  bool listen(int milliseconds);
  /// Waits for its end: exit status, or 128 + signal. Nothing after so many seconds; it goes on.
  [[nodiscard]] std::optional<int> wait(double seconds);

  [[nodiscard]] bool running() const { return pid_ > 0 && !status_; }
  [[nodiscard]] std::optional<int> status() const { return status_; }
  [[nodiscard]] const std::string& said() const { return said_; }
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// The end to poll for something said; -1: nothing will come.
  [[nodiscard]] int output() const { return output_; }

 private:
  void reap(bool wait);

  pid_t pid_ = -1;
  int output_ = -1, input_ = -1;
  std::string said_;
  std::optional<int> status_;
};

struct Ended {
  int status = 0;
  std::string said;
};

/// Runs a program to its end, at most half a minute; then it is killed and `status` is 137.
/// `network`: the network namespace it runs in; empty: ours.
[[nodiscard]] Ended run_program(const std::vector<std::string>& words,
                                const std::string& network = "", const std::string& input = "");

/// The same for what must work: throws HarnessError with the command and what it said.
void must_run(const std::vector<std::string>& words, const std::string& network = "",
              const std::string& input = "");

/// Path of a program in PATH or the system folders; empty: there is none.
[[nodiscard]] std::string find_program(const std::string& name);

}  // namespace tandem::harness
