#pragma once

#include <stdexcept>

namespace tandem::harness {

/// A network could not be made or a session not be run; the text is for people.
class HarnessError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Somebody wanted it to end: Ctrl-C or SIGTERM.
class Interrupted : public HarnessError {
 public:
  Interrupted() : HarnessError("stopped before its end") {}
};

}  // namespace tandem::harness
