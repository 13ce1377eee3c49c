/// What is believed of one body: which of its measurements are good, and where it is now.
///
/// A measurement x of time s is refused where
///
///   not_finite    a number of it is none
///   heading       | |d| - 1 | > 0.05: it was not on the circle
///   world         |p_x|, |p_y| or |p_z| > world
///   speed         |v| > v_max
///   jump          |p - p'| > v_max (s - s') + 3 sqrt(6) sigma, or the heading turned by more than
///                 turn_max (s - s') + 3 sqrt(2) sigma_heading, (p', s') being the one before
///   frozen        it has been the same, bit for bit, for frozen_after, while the model under the inputs
///                 given since has moved
///   time          s is more than 50 ms ahead of now, or older than `oldest`
///
/// (sqrt(6) sigma is the root mean square of the difference of two positions.) After a refusal `accept_after`
/// good ones in a row, each consistent with the one before, are asked for until one is believed again. A frozen
/// body's measurements count from the first of the equal ones.
///
/// Between measurements the state is predicted by the model under the inputs that were given: a measurement
/// that is late is carried to the present. One of this very moment is believed bit for bit.
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

/// Why a measurement is not believed.
enum class Doubt : std::uint8_t { none, not_finite, heading, world, speed, jump, frozen, time };
inline constexpr int doubt_count = 8;
std::string_view to_string(Doubt doubt);

/// What can be true of a body.
struct TrackLimits {
  double world = 100.0;         ///< of a position, each axis [m], > 0
  double v_max = 5.0;           ///< no body is faster [m/s], > 0
  double turn_max = 4.0;        ///< no body turns faster [rad/s], > 0
  double position_sigma = 0.0;  ///< of a measurement, each axis [m], >= 0
  double heading_sigma = 0.0;   ///< [rad], >= 0
  double frozen_after = 0.3;    ///< equal measurements are suspicious for so long [s], > 0
  double oldest = 2.5;          ///< age of a measurement that can still be carried to the present [s], > 0
  int accept_after = 3;         ///< good measurements in a row that end a doubt, >= 1
};

class Track {
 public:
  /// @param input_at  where the body's input stands in the history's rows
  Track(const Model& model, std::size_t input_at, const TrackLimits& limits);

  /// Takes a measurement x (nx) of time `stamp` that is there at `now` [s]. One that is not younger than the
  /// last is nothing new.
  /// @return why it is not believed; none also for nothing new
  Doubt take(std::span<const double> x, double stamp, double now, const InputHistory& history) noexcept;
  /// Forgets all that was: the body comes to be there at `now`, in the state x (nx); what was measured before is not
  /// of it.
  void begin(std::span<const double> x, double now) noexcept;
  /// Carries the state to `now`, which must not fall.
  void predict(double now, const InputHistory& history) noexcept;

  /// Whether anything was ever believed; before, the state is that of rest in the origin.
  bool known() const noexcept { return time_ > never; }
  /// Whether the last measurement was believed.
  bool trusted() const noexcept { return trusted_; }
  /// The believed state (nx) at the time of the last predict().
  std::span<const double> state() const noexcept { return x_; }
  /// Time of the measurement that the state comes from [s]; minus infinity before there was one.
  double stamp() const noexcept { return stamp_; }

 private:
  static constexpr double never = -std::numeric_limits<double>::infinity();

  Doubt implausible(std::span<const double> x) noexcept;
  bool consistent(const Sight<double>& sight, double stamp) const noexcept;
  bool frozen(std::span<const double> x, double stamp, const InputHistory& history) noexcept;
  void believe(std::span<const double> x, double stamp, double now) noexcept;
  void carry(std::vector<double>& x, double from, double to, const InputHistory& history) noexcept;

  Model model_;
  std::size_t input_at_;
  TrackLimits limits_;
  std::vector<double> x_, last_, drift_;  // believed; last plausible measurement; from the first equal one on
  std::vector<double> scratch_, no_input_;
  double time_ = never, stamp_ = never;  // of x_; of the measurement it comes from
  double last_stamp_ = never;            // youngest measurement so far
  double reference_stamp_ = never;       // of last_
  double equal_since_ = never, drift_time_ = never;
  Sight<double> sight_{}, reference_{};  // of the measurement at hand; of last_
  int streak_ = 0;                       // good ones in a row since the last doubt
  bool trusted_ = true, is_frozen_ = false;
};

}  // namespace sightline
