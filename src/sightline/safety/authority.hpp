/// What the commands of a robot can do to its horizontal velocity, found from its model:
///
///   v' = -c v + a     for every a of a disc |a| <= b, and at every corner a = sum of +-g_k, at every speed the
///                     robot reaches by its own commands
///
/// c is the drag fitted over all directions; where drag differs between them, the thrust that makes up for it is
/// taken off b and g_k. Of the multirotor, (16): c = -a_f, b = b_f, since along an axis one command alone
/// accelerates it, and g_k = (b_f, 0), (0, b_s) in V.
#pragma once

#include <array>
#include <span>

#include "sightline/model/model.hpp"

namespace sightline {

inline constexpr int most_states = 32;  ///< of a robot with an Authority

struct Authority {
  double drag = 0.0;                      ///< c [1/s], >= 0
  double acceleration = 0.0;              ///< b [m/s^2], > 0
  std::array<Vec2<double>, 4> thrusts{};  ///< g_k [m/s^2]
  int thrust_count = 0;
  bool turns = false;   ///< g_k are of V and turn with the heading; else of G
  bool climbs = false;  ///< commands change the height
  /// tau of a vertical speed that follows late, v_z' = (b u - v_z) / tau; 0: at once [s]
  double climb_lag = 0.0;
  double climb = 0.0;             ///< vertical speed that can be had both up and down [m/s]
  std::array<double, 4> reach{};  ///< what each input can do either way; 0: it neither pushes nor climbs
  double push = 0.0;              ///< greatest |v' + c v|, whatever is commanded [m/s^2]
  double rise = 0.0;              ///< greatest vertical speed of one that follows at once, either way [m/s]
  double free = 1.0;              ///< part of what the inputs push that makes up for nothing else, in (0, 1]

  /// Part of b, g_k and climb that is left under narrower limits of the inputs, in [0.05, 1].
  double part(std::span<const double> u_min, std::span<const double> u_max) const noexcept;
};

/// Whether robots of two abilities move alike, and differ at most in how much they can do: only then can each count on
/// what the other does by the same law.
bool moves_alike(const Authority& a, const Authority& b) noexcept;

/// @param u_min, u_max  limits of the inputs, finite
/// @throws std::invalid_argument for a model of more than 4 inputs or 32 states, and for one whose commands do
///         not accelerate it in every horizontal direction at once and in axes of its heading or of G, or whose
///         height does not follow the command at once
Authority authority_of(const Model& model, std::span<const double> u_min, std::span<const double> u_max);

}  // namespace sightline
