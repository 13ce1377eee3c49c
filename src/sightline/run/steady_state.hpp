/// What a robot comes to once its lags are over, while pose and velocity are held.
#pragma once

#include <span>
#include <vector>

#include "sightline/model/model.hpp"

namespace sightline {

struct SteadyState {
  std::vector<double> x;      ///< its state, inner states settled
  Vec3<double> velocity;      ///< [m/s], in G
  Vec3<double> acceleration;  ///< [m/s^2], in G
  double turn = 0.0;          ///< of the heading, anticlockwise [rad/s]
  Vec2<double> lean;          ///< Sight::lean
};

/// Whether each state is a place, a heading or a velocity; the others, such as a tilt that lags, follow from commands.
std::vector<char> shown_states(const Model& model);
/// At rest at the origin, heading along x.
std::vector<double> state_at_rest(const Model& model);
/// From the state x (nx) under a constant input u (nu): states that are shown stay, the others settle for 5 s. Set-up.
SteadyState settle(const Model& model, std::vector<double> x, std::span<const double> u);
/// Greatest speed [m/s] that a robot comes to from rest under any constant inputs within these bounds (nu each), without
/// turning; infinity where it still grows after 30 s, and for a robot of more than 8 inputs. Set-up.
double top_speed(const Model& model, std::span<const double> u_min, std::span<const double> u_max);

}  // namespace sightline
