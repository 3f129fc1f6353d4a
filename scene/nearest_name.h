#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tandem::scene {

/// Number of letters to insert, delete or replace to make one word of the other (Levenshtein),
/// upper and lower case alike.
[[nodiscard]] int edit_distance(std::string_view a, std::string_view b);

/// "; did you mean 'mass'? known: mass, name, size" - without the question when nothing is near,
/// without the list when it is empty.
[[nodiscard]] std::string suggestion(std::string_view wrong, const std::vector<std::string>& known);

}  // namespace tandem::scene
