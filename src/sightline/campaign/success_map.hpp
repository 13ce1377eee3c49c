/// Map of starts: recovered runs by range and bearing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sightline {

/// Cells in polar coordinates: rings outwards; sectors counterclockwise, from straight behind.
struct SuccessMap {
  static constexpr int rings = 6, sectors = 24;
  struct Cell {
    std::int64_t runs = 0, recovered = 0;
  };

  double range_max = 1.0;  ///< outer edge of the last ring [m]
  std::vector<Cell> cells = std::vector<Cell>(rings * sectors);
  Cell behind{};  ///< starts with a bearing of exactly pi

  /// Adds runs at one range [m] and bearing [rad]; the bearing may include whole turns.
  void add(double range, double bearing, Cell runs);
};

/// The map as one <svg> element, with the robot in the centre, heading up. Each cell's title has
/// its numbers.
std::string to_svg(const SuccessMap& map, const std::string& title);

}  // namespace sightline
