/// Weights that move.
#pragma once

namespace sightline {

/// The part of a weight that is in force: on a line from one part to another, held before and after.
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
    return t <= begin ? from : from + (to - from) * ((t - begin) / duration);
  }
};

}  // namespace sightline
