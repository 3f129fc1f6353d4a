#pragma once

#include <stdexcept>

namespace tandem::harness {

/// A network could not be made or a session not be run; the text is for people.
class HarnessError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tandem::harness
