/// What was probably meant by a name that is none.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// Letters that are added, left out or replaced, and neighbours that are swapped, from one name to the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name of `known` with the least edit distance, where that is at most a third of the longer of the two; none where no name is so
/// near. Parts of a key that both begin with, "agent.uav0.", make nothing nearer.
std::optional<std::string_view> nearest(std::string_view name, std::span<const std::string_view> known);

/// What stands behind "expected a known key" in a sentence: `, the nearest is "d_min"`; where none is near, the names that there are,
/// `: d_min, d_max`, at most `hint_names` of them.
std::string hint(std::string_view name, std::span<const std::string_view> known);
inline constexpr std::size_t hint_names = 12;

}  // namespace sightline
