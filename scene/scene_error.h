#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace tandem::scene {

/// One thing that is wrong with a scene, said to a person.
struct Problem {
  std::string path;   ///< field, as --set addresses it: coupler.k11.stiffness; may be empty
  std::string text;   ///< field, value, what is allowed, what to do
  std::string where;  ///< FILE:LINE, or the --set that did it; filled by the loader
};

/// Everything that is wrong with a scene; what() has one line for each problem.
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(std::vector<Problem> problems);
  [[nodiscard]] const std::vector<Problem>& problems() const noexcept { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// Shortest decimal text that reads back to the same double; no exponent from 1e-4 to 1e7.
[[nodiscard]] std::string number_text(double value);

}  // namespace tandem::scene
