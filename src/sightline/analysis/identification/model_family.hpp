/// Family of the models that are fitted to a multirotor's flight: (24) or its form under velocity
/// commands, each with optional parts.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/world/flight_controller.hpp"

namespace sightline {

/// Parts of a model besides (24), or besides the lags of LaggedMultirotor.
struct ModelStructure {
  Commands commands = Commands::tilt;
  bool delay = false;     ///< commands act `delay` later
  bool coriolis = false;  ///< the velocity stays in G while the vehicle yaws
  bool lags = false;      ///< of tilt, climb and yaw rate; of climb and yaw rate, always present, under
                          ///< velocity commands

  bool operator==(const ModelStructure&) const = default;
  /// "(24) + delay + Coriolis + lags"
  std::string name() const;
};

/// All structures of a kind of commands, the plain one first.
std::vector<ModelStructure> model_structures(Commands commands);

/// Numbers of all structures; a structure uses some of them.
///
///   v_f' = a_f v_f + push_f + r v_s,   v_s' = a_s v_s + push_s - r v_f   (last terms: Coriolis)
///
/// push = (b_f u_f, -b_s u_s) follows with lag tau, climb b_z u_z with lag tau_z, and r = b_psi
/// u_psi with lag tau_psi, all from the commands of `delay` ago. With lags the push is multiplied
/// by (1 + v_z' / g), as in LaggingHoverMultirotor. Under velocity commands a_f = -1 / tau_f, b_f =
/// 1 / tau_f, a_s = -1 / tau_s, b_s = -1 / tau_s, b_z = b_psi = 1.
struct ModelNumbers {
  double b_z = 1.0, b_psi = 1.6, a_f = -0.3, b_f = 1.7, a_s = -0.3, b_s = 1.7;
  double tau_f = 0.5, tau_s = 0.5;
  double delay = 0.0;
  double tau = 0.1, tau_z = 0.25, tau_psi = 0.18;
  double w_x = 0.0, w_y = 0.0;  ///< steady acceleration in G [m/s^2]: wind or a trim error
};

/// A number of the fit, and the inputs that must move to identify it.
struct FittedNumber {
  std::string_view key, unit;
  double ModelNumbers::*value;
  double low, high;   ///< bounds of the fit
  std::size_t input;  ///< 0 u_f, 1 u_s, 2 u_z, 3 u_psi; 4: u_f or u_s
  std::string_view meaning;
  bool of_flight = false;  ///< belongs to the flight, not to the vehicle
};

inline constexpr std::array<std::string_view, 4> command_names = {"u_f", "u_s", "u_z", "u_psi"};

/// The numbers of a structure, in the order of the robot's parameters; then the delay, and those of
/// the flight.
std::vector<FittedNumber> fitted_numbers(const ModelStructure& structure);

}  // namespace sightline
