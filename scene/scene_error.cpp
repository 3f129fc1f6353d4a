#include "scene/scene_error.h"

#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

namespace tandem::scene {
namespace {

std::string all_lines(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) {
    if (!text.empty()) text += '\n';
    if (!problem.where.empty()) text += problem.where + ": ";
    text += problem.text;
  }
  return text;
}

}  // namespace

SceneError::SceneError(std::vector<Problem> problems)
    : std::runtime_error(all_lines(problems)), problems_(std::move(problems)) {}

std::string number_text(double value) {
  char buffer[32];
  const double size = std::abs(value);
  const bool short_enough = size == 0.0 || (size >= 1e-4 && size < 1e7);
  const auto [end, error] =
      short_enough ? std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed)
                   : std::to_chars(buffer, buffer + sizeof buffer, value);
  return error == std::errc{} ? std::string(buffer, end) : "?";
}

}  // namespace tandem::scene
