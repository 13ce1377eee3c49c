/// The rows of a Barrier: what the next sampled state must keep of each plan and of each wall.
#pragma once

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

enum class Approach { slowing, at_once };  // of bounds of the height

inline BarrierRow row_of_wall(const Vec3<double>& n, double E, double least, Wall wall) {
  return {n, E, {}, least, wall, -1, 0.0, 0.0, 0.0, 0.0, false};
}
/// Finds the heights and planes that bound the robot: floor, ceiling, world, and a face of each of
/// the forbidden pieces that leave least after 1 s at the present velocity.
///
/// The reserve of a face is the distance that braking straight away from it leaves, or the room of
/// an upper or lower face. Of a piece, the face of the greatest reserve counts. Its plan keeps that
/// reserve, so the greatest of the next period is no less: no hysteresis is needed.
void find_bounds(const BarrierLaw& law, BarrierPeriod& now) noexcept;
void add_neighbours(const BarrierLaw& law, BarrierPeriod& now) noexcept;
void add_walls(const BarrierLaw& law, Approach approach, BarrierPeriod& now) noexcept;
/// Adds the rows of later or earlier times at which the command that leads to `there` has its least
/// gaps.
void add_cuts(const BarrierLaw& law, const NextState& there, BarrierPeriod& now) noexcept;

}  // namespace sightline
