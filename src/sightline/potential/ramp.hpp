/// Weights that are blended over time.
#pragma once

namespace sightline {

/// The factor of a weight: from one value to another with a continuous slope, constant before and after,
///
///   from + (to - from) s^2 (3 - 2 s),   s = (t - begin) / duration in [0, 1].
///
/// A solver uses the factor of the update's time for the whole horizon: a weight that begins at 0 changes nothing at
/// first, and one that has reached 0 can be left out.
struct Ramp {
  double begin = 0.0, duration = 0.0;  ///< [s], duration >= 0
  double from = 1.0, to = 1.0;         ///< >= 0

  bool operator==(const Ramp&) const = default;
  /// At time t [s].
  double at(double t) const noexcept {
    if (t >= begin + duration) return to;
    if (t <= begin) return from;
    const double s = (t - begin) / duration;
    return from + (to - from) * (s * s * (3.0 - 2.0 * s));
  }

  /// Whether the weight is there in the end.
  bool lasts() const noexcept { return to > 0; }
  /// Whether the weight moves no more.
  bool has_settled(double t) const noexcept { return from == to || t >= begin + duration; }
  /// Whether the weight has faded away.
  bool is_over(double t) const noexcept { return !lasts() && t >= begin + duration; }
};

}  // namespace sightline
