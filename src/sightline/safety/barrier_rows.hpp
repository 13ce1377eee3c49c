/// The rows of a Barrier: what the next sampled state must keep of each plan and of each wall.
#pragma once

#include <array>

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

/// Inward normals of the world's bounds, in the order of bounds_of_world.
inline constexpr std::array<Vec2<double>, 4> inward = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
inline constexpr std::array<Wall, 4> bounds_of_world = {Wall::x_max, Wall::x_min, Wall::y_max, Wall::y_min};

enum class Heeded { all, members };
enum class Approach { slowing, at_once };  // of floor and ceiling

inline BarrierRow row_of_wall(const Vec3<double>& n, double E, double least, Wall wall) {
  return {n, E, {}, least, wall, -1, 0.0, 0.0, 0.0, 0.0, false};
}
void add_neighbours(const BarrierLaw& law, Heeded heeded, BarrierPeriod& now) noexcept;
void add_walls(const BarrierLaw& law, Approach approach, BarrierPeriod& now) noexcept;
/// Adds the rows of later or earlier times at which the command that leads to `there` has its least
/// gaps.
void add_cuts(const BarrierLaw& law, const NextState& there, BarrierPeriod& now) noexcept;

}  // namespace sightline
