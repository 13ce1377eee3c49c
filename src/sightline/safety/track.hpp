/// State estimate of one body: accepts or refuses its measurements, and predicts its state to the
/// present.
///
/// A measurement x of time s is refused with the fault
///
///   not_finite    if one of its numbers is NaN or infinite
///   heading       if | |d| - 1 | > 0.05: it is not of unit length
///   world         if |p_x|, |p_y| or |p_z| > world
///   speed         if |v| > v_max
///   jump          if |p - p'| > v_max (s - s') + 3 sqrt(6) sigma, or the heading turned by more than
///                 turn_max (s - s') + 3 sqrt(2) sigma_heading, (p', s') being the previous one
///   frozen        if it was the same, bit for bit, for frozen_after, while the model under the given
///                 inputs has moved
///   time          if s is more than 50 ms ahead of now, or older than `oldest`
///
/// (sqrt(6) sigma is the root mean square of the difference of two positions.) After a refusal, a
/// measurement is accepted again after `accept_after` good ones in a row, each consistent with the
/// previous one. The age of frozen measurements counts from the first of the equal ones.
///
/// Between measurements the model predicts the state under the given inputs, so a late measurement
/// is predicted to the present. A measurement of the present time is taken unchanged, bit for bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/model/model.hpp"
#include "sightline/safety/input_history.hpp"

namespace sightline {

/// Reason why a measurement is refused.
enum class MeasurementFault : std::uint8_t { none, not_finite, heading, world, speed, jump, frozen, time };
inline constexpr int measurement_fault_count = 8;
std::string_view to_string(MeasurementFault fault);

/// Bounds of plausible measurements of a body.
struct TrackLimits {
  double world = 100.0;         ///< of a position, each axis [m], > 0
  double v_max = 5.0;           ///< greatest speed of a body [m/s], > 0
  double turn_max = 4.0;        ///< greatest turn rate of a body [rad/s], > 0
  double position_sigma = 0.0;  ///< of a measurement, each axis [m], >= 0
  double heading_sigma = 0.0;   ///< [rad], >= 0
  double frozen_after = 0.3;    ///< equal measurements are a fault after this time [s], > 0
  double oldest = 2.5;          ///< greatest age of a measurement that is predicted to the present [s], > 0
  int accept_after = 3;         ///< good measurements in a row that clear a fault, >= 1
  double command_delay = 0.0;   ///< from a command to its effect [s], >= 0
};

class Track {
 public:
  /// @param input_at  offset of the body's input in the history's rows
  Track(const Model& model, std::size_t input_at, const TrackLimits& limits);

  /// Takes a measurement x (nx) of time `stamp` that arrives at `now` [s]. Ignores one that is not
  /// newer than the last.
  /// @param sigma  standard deviation of an estimated position [m]; 0: measured. An estimate may
  ///               jump, since a new measurement corrects it
  /// @return why it is refused; `none` also for one that is ignored
  MeasurementFault take(std::span<const double> x, double stamp, double now, const InputHistory& history,
                        double sigma = 0.0) noexcept;
  /// Restarts the track for a body that joins at `now` [s] in the state x (nx). Earlier
  /// measurements are discarded.
  void begin(std::span<const double> x, double now) noexcept;
  /// Predicts the state to `now` [s], which must not decrease.
  void predict(double now, const InputHistory& history) noexcept;

  /// Whether a measurement was ever accepted; before, the state is at rest at the origin.
  bool known() const noexcept { return time_ > never; }
  /// Whether the last measurement was accepted.
  bool trusted() const noexcept { return trusted_; }
  /// The state estimate (nx) at the time of the last predict().
  std::span<const double> state() const noexcept { return x_; }
  /// Time of the measurement on which the state is based [s]; minus infinity before the first.
  double stamp() const noexcept { return stamp_; }

 private:
  static constexpr double never = -std::numeric_limits<double>::infinity();

  MeasurementFault implausible(std::span<const double> x) noexcept;
  bool consistent(const Sight<double>& sight, double stamp) const noexcept;
  bool frozen(std::span<const double> x, double stamp, const InputHistory& history) noexcept;
  void accept_measurement(std::span<const double> x, double stamp, double now) noexcept;
  void carry(std::vector<double>& x, double from, double to, const InputHistory& history) noexcept;

  Model model_;
  std::size_t input_at_;
  TrackLimits limits_;
  std::vector<double> x_, last_, drift_;  // estimate; last plausible measurement; prediction if frozen
  std::vector<double> scratch_, no_input_;
  double time_ = never, stamp_ = never;  // of x_; of the measurement on which it is based
  double last_stamp_ = never;            // youngest measurement so far
  double reference_stamp_ = never;       // of last_
  double equal_since_ = never, drift_time_ = never;
  Sight<double> sight_{}, reference_{};  // of the current measurement; of last_
  int streak_ = 0;                       // good measurements in a row since the last fault
  bool trusted_ = true, is_frozen_ = false;
};

}  // namespace sightline
