#pragma once

#include <string>
#include <sys/types.h>
#include <vector>

#include <nlohmann/json.hpp>

namespace tandem::test {

/// The program `tandem` as a child process, its output in one string. Killed when it goes out of
/// scope.
class Program {
 public:
  /// @param file_limit  RLIMIT_FSIZE of the child [bytes]; 0: none. A full disk, nearly.
  explicit Program(std::vector<std::string> arguments, long file_limit = 0);
  Program(Program&& other) noexcept;
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program();

  void signal(int number);
  /// Waits for its end, at most so many seconds (then it is killed and -1 comes back): exit status,
  /// or 128 + signal.
  int wait(double seconds = 20.0);
  /// Waits until its output has `text`; false after so many seconds.
  bool says(const std::string& text, double seconds = 10.0);
  [[nodiscard]] const std::string& output() const { return output_; }

 private:
  void read_some(int timeout_ms);

  pid_t pid_ = -1;
  int pipe_ = -1;
  std::string output_;
};

/// A file in a folder of this test program's own, gone at its end.
[[nodiscard]] std::string scratch(const std::string& name);
/// "127.0.0.1:PORT" that nobody uses now.
[[nodiscard]] std::string free_address();
[[nodiscard]] nlohmann::json json_in(const std::string& file);
void sleep_seconds(double seconds);
/// Arguments that keep a node from asking for real time, so that a crowded test machine stays
/// usable.
[[nodiscard]] std::vector<std::string> node(std::vector<std::string> arguments);

}  // namespace tandem::test
