/// Faults of measurements and controllers that a scenario injects.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

#include "sightline/ocp/team.hpp"

namespace sightline {

enum class FaultKind : std::uint8_t {
  dropout,  ///< no measurement arrives; the last one stays, with its stamp
  delay,    ///< the measurement arrives later
  freeze,   ///< the same values repeat, with a fresh stamp
  nan,      ///< one number is NaN
  jump,     ///< the position has an added offset
};
std::string_view to_string(FaultKind kind);

/// A fault in the measurements of a body, for arrival times from <= t < until.
struct Fault {
  FaultKind kind = FaultKind::dropout;
  BodyId body{};  ///< index -1: every body
  double from = 0.0;
  double until = std::numeric_limits<double>::infinity();
  double probability = 1.0;  ///< for each measurement, in [0, 1]; dropout, nan, jump
  double delay = 0.1;        ///< of FaultKind::delay, added to the sensor's own [s], in [0, 10]
  Vec3<double> offset{};     ///< of FaultKind::jump [m]
  int number = -1;           ///< of FaultKind::nan: index in the body's state; -1: drawn each time

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
  bool strikes(BodyId at, double t) const noexcept;
};

inline constexpr double longest_fault_delay = 10.0;  // [s]

}  // namespace sightline
