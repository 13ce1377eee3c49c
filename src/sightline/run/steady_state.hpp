/// The state of a robot after its lags have settled, with pose and velocity held.
#pragma once

#include <span>
#include <vector>

#include "sightline/model.hpp"

namespace sightline {

struct SteadyState {
  std::vector<double> x;      ///< state, with settled inner states
  Vec3<double> velocity;      ///< [m/s], in G
  Vec3<double> acceleration;  ///< [m/s^2], in G
  double turn = 0.0;          ///< turn rate of the heading, anticlockwise [rad/s]
  Vec2<double> lean;          ///< Sight::lean
};

/// Whether each state is part of position, heading or velocity. The others, such as a lagging tilt,
/// follow from commands.
std::vector<char> shown_states(const Model& model);
/// The state at rest at (0, 0, 1) [m], heading along x.
std::vector<double> state_at_rest(const Model& model);
/// Settles from the state x (nx) under a constant input u (nu): pose and velocity stay, the other
/// states settle for 5 s. For set-up only.
SteadyState settle(const Model& model, std::vector<double> x, std::span<const double> u);
/// Greatest speed [m/s] from rest under constant inputs at these bounds (nu each), without turning.
/// Infinity if the speed still grows after 30 s, or for more than 8 inputs. For set-up only.
double top_speed(const Model& model, std::span<const double> u_min, std::span<const double> u_max);

}  // namespace sightline
