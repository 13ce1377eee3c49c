/// Downwash from flights of vehicles above one another: its scale, and the accuracy of the vertical
/// acceleration that it predicts.
#pragma once

#include <string>
#include <vector>

#include "sightline/analysis/identification/downwash_flight.hpp"

namespace sightline {

/// Half the width of the 95 % interval of a predicted vertical acceleration [m/s^2]. At the
/// acceleration d that the downwash causes it is
///
///   sqrt(calm^2 + gusty^2 sqrt(|d| / (1 m/s^2)))
///
/// The flow below rotors is turbulent and its edge moves: errors grow with d, but less than d.
struct DownwashBound {
  double calm = 0.0, gusty = 0.0;

  double at(double d) const;
};

/// Errors of predicted vertical accelerations.
struct DownwashError {
  double without = 0.0, with = 0.0;  ///< RMS of the models without and with downwash [m/s^2]
  double covered = 0.0;              ///< fraction of samples within the interval
  std::size_t samples = 0;

  double ratio() const { return with / without; }
};

/// Errors for a vehicle that was below others.
struct DownwashErrors {
  std::string robot{};
  int flight = 0;          ///< from 0, in the order given
  DownwashError all{};     ///< of the whole flight
  DownwashError inside{};  ///< where the downwash of momentum theory is above downwash_calm
};

/// Up to this acceleration by the downwash of momentum theory, a vehicle is outside of it [m/s^2].
inline constexpr double downwash_calm = 0.1;

struct DownwashIdentification {
  double scale = 0.0;     ///< `downwash` of [world]
  double interval = 0.0;  ///< half the width of its 95 % confidence interval
  double lag = 0.0;       ///< of the thrust behind the duty cycles [s]
  double seconds = 0.0;   ///< with a vehicle below another, outside and inside of its downwash
  DownwashBound bound{};
  std::string judged_on{};               ///< which samples judge, in words: "held-out flights"
  std::vector<DownwashErrors> errors{};  ///< by flight and vehicle

  double low() const { return scale - interval; }
  double high() const { return scale + interval; }
};

/// Fits the vertical acceleration without gravity of each vehicle below others,
///
///   a_z = c thrust(t) up_z - (d_z / m) (v_z + scale sum_j w_j),   lag thrust' = power - thrust,
///
/// by least squares, with w_j the downward speed of Jet below vehicle j, whose thrust is that of the
/// same model. c is a number of each vehicle and flight. The model without downwash has scale = 0 and
/// is otherwise the same; c is that of the samples outside of the downwash. Samples of vehicles with less
/// than 0.7 of their weight as thrust, at a lag of 0.1 s, are left out.
///
/// The interval of the scale is the wider of two, for independent residuals and for residuals that are
/// correlated within 1 s; both account for the uncertainty of the lag. The bound is that of
/// predictions by the numbers of other flights, of one flight by those of its other fifths.
///
/// @param held_out  flights that judge alone; none: each flight, or fifth of the only one, by the
///   numbers and the bound of the others
/// @throws std::invalid_argument for flights without a vehicle in the downwash of another, without 2 s
///   outside of it; if without one of the flights, or of the fifths of the only one, less than 0.5 s in
///   the downwash is left; and for a scale that is not above 0
DownwashIdentification identify_downwash(const std::vector<DownwashFlight>& flights,
                                         const std::vector<DownwashFlight>& held_out = {});

/// Table for the terminal, with the keys of a scenario at its end.
std::string to_string(const DownwashIdentification& found);

std::string to_json(const DownwashIdentification& found);

}  // namespace sightline
