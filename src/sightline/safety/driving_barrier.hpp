/// The barrier of a robot that drives along its heading, such as a unicycle.
///
/// Its only plan is to brake with the heading held, with the share `authority` of its acceleration,
/// and to stand then. The plan stops it at a sample, after the time T, and its path is the segment
/// S. In the last period it brakes less than before. So the rest of the plan is the plan of the
/// next sample, and its path is part of S. The reserve h [m] is
///
///   at rest        h = dist(S, p_O) - rho
///   uncooperative  h = dist(S, p_O) - rho - W T     and stands: nothing is required
///   cooperative    h = dist(S, S_O) - rho           S_O: of the same plan of the other robot
///   wall, zone     h = dist(S, half-space)
///
/// with rho = d_hard + margin + 3 sigma + W age. The plan keeps all of them at once, for any number
/// of bodies: docs/safety.md, 3. Among the commands that do, the one nearest to the solver's is
/// searched for, along lines from the plan's own command.
#pragma once

#include <span>

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

/// The reserve against one neighbour [m].
double driving_reserve(const BarrierLaw& law, const BarrierPeriod& now, const Neighbour& neighbour) noexcept;

/// Replaces u, which is within the limits, by a command that keeps all reserves. If one of them is
/// negative, the result is a conflict, and the robot does not come nearer by its own motion.
BarrierResult keep_driving_distances(const BarrierLaw& law, BarrierPeriod& now, std::span<double> u) noexcept;

}  // namespace sightline
