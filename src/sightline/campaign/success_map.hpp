/// A map of starts: how many of those of each range and bearing were recovered.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sightline {

/// Cells in polar coordinates, rings outwards, sectors to the left from straight behind round to straight behind.
struct SuccessMap {
  static constexpr int rings = 6, sectors = 24;
  struct Cell {
    std::int64_t runs = 0, recovered = 0;
  };

  double range_max = 1.0;  ///< outer edge of the last ring [m]
  std::vector<Cell> cells = std::vector<Cell>(rings * sectors);
  Cell behind{};  ///< starts of a bearing of exactly pi

  /// Counts runs of one range [m] and bearing [rad], any number of turns.
  void add(double range, double bearing, Cell runs);
};

/// The map as one <svg> element, the robot in the middle with its nose up; a cell's title tells its numbers.
std::string to_svg(const SuccessMap& map, const std::string& title);

}  // namespace sightline
