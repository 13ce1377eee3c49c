/// Colours of all figures: of pages and of other views of a flight.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace sightline {

inline constexpr std::size_t palette_robots = 6;  ///< used in turn, cyclically
inline constexpr std::array<std::string_view, palette_robots + 2> palette = {
    "#3b82d6", "#e07b1a", "#2a9d5c", "#a05cd0", "#d64a8b", "#1aa3b5", "#d8322f", "#8a8f98"};
inline constexpr std::string_view palette_green = palette[2], palette_red = palette[palette_robots],
                                  palette_grey = palette[palette_robots + 1];

}  // namespace sightline
