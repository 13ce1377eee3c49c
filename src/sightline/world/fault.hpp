/// Faults of measurements and controllers that a scenario injects.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "sightline/ocp/team.hpp"

namespace sightline {

enum class FaultKind : std::uint8_t {
  dropout,  ///< no measurement arrives; the last one stays, with its time
  delay,    ///< it comes later than it would
  freeze,   ///< the same values come again, with a fresh time
  nan,      ///< one of its numbers is NaN
  jump,     ///< the position is wrong by an offset
};
std::string_view to_string(FaultKind kind);

/// A fault in the measurements of a body, in from <= t < until. Times are of the arrival.
struct Fault {
  FaultKind kind = FaultKind::dropout;
  BodyId body{};  ///< index -1: each of all bodies
  double from = 0.0;
  double until = std::numeric_limits<double>::infinity();
  double probability = 1.0;  ///< of each measurement, in [0, 1]; dropout, nan, jump
  double delay = 0.1;        ///< of a delay, besides the sensor's own [s], in [0, 10]
  Vec3<double> offset{};     ///< of a jump [m]
  int number = -1;           ///< that becomes none: place in the body's state; -1: drawn each time

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
  bool strikes(BodyId at, double t) const noexcept;
};

/// Updates that begin in from <= t < until take `delay` to end: until then the last plan is used, and the
/// next update begins only then.
struct LatePlan {
  double from = 0.0;
  double until = std::numeric_limits<double>::infinity();
  double delay = 0.1;  ///< [s], in [0, 10]

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
  /// Whether an update that begins at t is late.
  bool strikes(double t) const noexcept;
};

inline constexpr double longest_fault_delay = 10.0;  // [s]

}  // namespace sightline
