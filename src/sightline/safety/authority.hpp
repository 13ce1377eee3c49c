/// The accelerations and vertical speeds that a robot's commands can produce, found from its model.
///
/// The horizontal velocity v follows
///
///   v' = -c v + a     for every a of a disc |a| <= b, and for every corner a = sum of +-g_k,
///                     at every speed that the robot reaches by its own commands
///
/// c is the drag fitted over all directions. Where drag differs between directions, the thrust that
/// compensates the difference is subtracted from b and g_k. For the multirotor, (16):
/// c = -a_f, b = b_f, since along an axis one command alone accelerates it, and g_k = (b_f, 0),
/// (0, b_s) in V.
///
/// If the horizontal acceleration itself is a state of the robot, shown by its tilt, a follows its
/// command, and the yaw rate r and the vertical speed theirs:
///
///   tau a' = a_command - a + tau r J a,    v' = -c v + (1 + lift v_z') a
///
/// A robot that drives along its heading d, such as the unicycle, has v = v_f d instead, and one
/// input that accelerates it, v_f' = -c v_f + a for every |a| <= b. Its heading turns by command
/// alone.
#pragma once

#include <array>
#include <span>

#include "sightline/base.hpp"
#include "sightline/model.hpp"

namespace sightline {

inline constexpr int most_states = 32;  ///< of a robot with an Authority

struct Authority {
  /// Whether the robot drives along its heading only.
  bool drives() const noexcept { return drive >= 0; }

  double drag = 0.0;                      ///< c [1/s], >= 0
  double acceleration = 0.0;              ///< b [m/s^2], > 0
  std::array<Vec2<double>, 4> thrusts{};  ///< g_k [m/s^2]
  int thrust_count = 0;
  bool turns = false;   ///< g_k are in V and turn with the heading; else in G
  bool climbs = false;  ///< commands change the height
  /// tau of a vertical speed with a lag, v_z' = (b u - v_z) / tau; 0: no lag [s]
  double climb_lag = 0.0;
  double climb = 0.0;             ///< vertical speed attainable both up and down [m/s]
  std::array<double, 4> reach{};  ///< half range of each input; 0: it neither pushes nor climbs
  double push = 0.0;              ///< greatest |v' + c v| under any command [m/s^2]
  double rise = 0.0;              ///< greatest vertical speed of a robot without a lag, up or down [m/s]
  double thrust_lag = 0.0;   ///< tau of a; 0: a follows its command at once, and the rest does not hold [s]
  double thrust_most = 0.0;  ///< greatest |a| under any command [m/s^2]
  double turn_lag = 0.0;     ///< of the yaw rate; 0: no lag [s]
  double turn = 0.0;         ///< greatest |r'|, if the yaw rate lags [rad/s^2]
  int rate_state = -1;       ///< index of the yaw rate in the state, if it lags
  double lift = 0.0;         ///< share of a that a vertical acceleration adds [s^2/m]
  double misfit = 0.0;       ///< greatest |v'| beyond this law at the sampled states [m/s^2]
  int drive = -1;     ///< input that accelerates a robot which drives along its heading; -1: any other robot
  double free = 1.0;  ///< part of the inputs' push that compensates nothing else, in (0, 1]

  /// Part of b, g_k and climb that remains under narrower input limits, in [0.05, 1].
  double part(std::span<const double> u_min, std::span<const double> u_max) const noexcept;
};

/// Whether two robots have like motion and differ only in the size of their abilities. Only then
/// can each rely on the other's use of the same law.
bool moves_alike(const Authority& a, const Authority& b) noexcept;

/// @param u_min, u_max  limits of the inputs, finite
/// @throws std::invalid_argument for a model of more than 4 inputs or 32 states. Also for a model
///         whose commands neither accelerate it in every horizontal direction at once, along axes of
///         its heading or of G, nor drive it along its heading with one input and turn it with at
///         most one other. Also for a model whose height follows its command neither at
///         once nor with one lag
Authority authority_of(const Model& model, std::span<const double> u_min, std::span<const double> u_max);

}  // namespace sightline
