/// Weights that move.
#pragma once

namespace sightline {

/// The part of a weight that is in force: from one part to another without a kink, held before and after,
///
///   from + (to - from) s^2 (3 - 2 s),   s = (t - begin) / duration in [0, 1].
///
/// A solver takes the part of the time it is asked at for its whole horizon: what begins at 0 changes nothing at
/// first, and what ends at 0 can be left out without a trace.
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
};

}  // namespace sightline
