/// Weights that change smoothly over time.
#pragma once

namespace sightline {

/// Factor of a weight: from one value to another with a continuous slope, constant before and
/// after,
///
///   from + (to - from) s^2 (3 - 2 s),   s = (t - begin) / duration in [0, 1].
///
/// A solver uses the factor at the update's time for the whole horizon. Therefore a weight that
/// starts at 0 changes nothing at first, and one that has reached 0 can be removed.
struct Ramp {
  double begin = 0.0, duration = 0.0;  ///< [s], duration >= 0
  double from = 1.0, to = 1.0;         ///< >= 0

  bool operator==(const Ramp&) const = default;
  /// Factor at time t [s].
  double at(double t) const noexcept {
    if (t >= begin + duration) return to;
    if (t <= begin) return from;
    const double s = (t - begin) / duration;
    return from + (to - from) * (s * s * (3.0 - 2.0 * s));
  }

  /// Whether the final weight is > 0.
  bool lasts() const noexcept { return to > 0; }
  /// Whether the weight is constant from t on.
  bool has_settled(double t) const noexcept { return from == to || t >= begin + duration; }
  /// Whether the weight has reached 0 for good.
  bool is_over(double t) const noexcept { return !lasts() && t >= begin + duration; }
};

}  // namespace sightline
