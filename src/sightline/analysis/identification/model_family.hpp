/// The models that are fitted to a multirotor's flight: (24) or its form under velocity commands, each with parts that
/// may be there.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/world/flight_controller.hpp"

namespace sightline {

/// What a model has besides (24), or besides the lags of LaggedMultirotor.
struct ModelStructure {
  Commands commands = Commands::tilt;
  bool delay = false;     ///< commands act later
  bool coriolis = false;  ///< the velocity stays in G while the vehicle yaws
  bool lags = false;  ///< of tilt, climb and yaw rate; under velocity commands always, of climb and yaw rate

  bool operator==(const ModelStructure&) const = default;
  /// "(24) + delay + Coriolis + lags"
  std::string name() const;
};

/// All of a kind of commands, the plain one first.
std::vector<ModelStructure> model_structures(Commands commands);

/// The numbers of all of them; a structure has some.
///
///   v_f' = a_f v_f + push_f + r v_s,   v_s' = a_s v_s + push_s - r v_f     (the last terms with Coriolis)
///
/// with push = (b_f u_f, -b_s u_s) behind tau, climb b_z u_z behind tau_z and r = b_psi u_psi behind tau_psi, all of
/// commands that were given `delay` ago. With lags the push is (1 + v_z' / g) times that, as in LaggingHoverMultirotor.
/// Under velocity commands a_f = -1 / tau_f, b_f = 1 / tau_f, a_s = -1 / tau_s, b_s = -1 / tau_s, b_z = b_psi = 1.
struct ModelNumbers {
  double b_z = 1.0, b_psi = 1.6, a_f = -0.3, b_f = 1.7, a_s = -0.3, b_s = 1.7;
  double tau_f = 0.5, tau_s = 0.5;
  double delay = 0.0;
  double tau = 0.1, tau_z = 0.25, tau_psi = 0.18;
  double w_x = 0.0, w_y = 0.0;  ///< steady acceleration in G: wind, or a vehicle that is trimmed badly
};

/// A number that is fitted, and the inputs that must move for it to be known.
struct FittedNumber {
  std::string_view key, unit;
  double ModelNumbers::*value;
  double low, high;   ///< between which it is looked for
  std::size_t input;  ///< 0 u_f, 1 u_s, 2 u_z, 3 u_psi; 4: u_f or u_s
  std::string_view meaning;
  bool of_flight = false;  ///< and not of the vehicle
};

inline constexpr std::array<std::string_view, 4> command_names = {"u_f", "u_s", "u_z", "u_psi"};

/// Those of a structure, in the order of the robot's parameters; then the delay, and what is of the flight.
std::vector<FittedNumber> fitted_numbers(const ModelStructure& structure);

}  // namespace sightline
