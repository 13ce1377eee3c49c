/// What events change of the world around a team, which is simulated: where a body is that nobody controls, the wind, faults of
/// measurements. A world that is not simulated is as it is.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/potential/ramp.hpp"

namespace sightline {

struct Surroundings {
  /// A target or an obstacle that goes to a place and rests there, whatever moved it before.
  struct Move {
    BodyId body{};
    Vec3<double> to{};                   ///< [m]
    double begin = 0.0, duration = 0.0;  ///< [s]; slower where it would be faster than it may
  };
  /// Steady acceleration of all robots in G.
  struct Wind {
    Vec3<double> acceleration{};         ///< [m/s^2]
    double begin = 0.0, duration = 0.0;  ///< over which it comes up from what it was [s]
  };
  enum class FaultKind { dropout, freeze, jump };
  /// A fault in the measurements of a body, in from <= t < until.
  struct Fault {
    FaultKind kind = FaultKind::dropout;
    BodyId body{};
    Vec3<double> offset{};           ///< of a jump [m]
    double from = 0.0, until = 0.0;  ///< [s]
  };
  /// Most that are in force at one time.
  static constexpr std::size_t faults_max = 32;

  std::vector<Move> moves{};  ///< the last of each body
  std::optional<Wind> wind{};
  std::vector<Fault> faults{};
};

/// Where a change that began at `begin` and takes `duration` is at t: 0 to 1, at rest at both ends.
inline double blended(double t, double begin, double duration) {
  return Ramp{.begin = begin, .duration = duration, .from = 0.0, .to = 1.0}.at(t);
}

}  // namespace sightline
