/// Suggestions for a name that is unknown.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// Edit distance: letters added, omitted or replaced, and neighbouring letters swapped, from one
/// name to the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name of `known` with the smallest edit distance, if that is at most a third of the longer of
/// the two names; else none. Leading key parts that both names share, "agent.uav0.", do not reduce
/// the distance.
std::optional<std::string_view> nearest(std::string_view name, std::span<const std::string_view> known);

/// The text after "expected a known key" in a message: `, the nearest is "d_min"`. If no name is
/// near: the known names, `: d_min, d_max`, at most `hint_names` of them.
std::string hint(std::string_view name, std::span<const std::string_view> known);
inline constexpr std::size_t hint_names = 12;

}  // namespace sightline
