/// What events change around a team: which bodies are present, and of a simulated world the
/// positions of targets and obstacles, the wind and measurement faults.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/potential/ramp.hpp"

namespace sightline {

enum class Presence : std::uint8_t {
  absent,   ///< not in the world
  steered,  ///< a robot of the team
  hold,     ///< present, not controlled: a robot that brakes and stays, a target or an obstacle
  land,     ///< a robot that brakes and descends
};

/// Changes of a simulated world; others ignore them.
struct Surroundings {
  /// A target or an obstacle that moves to a place and stays there, whatever its motion was before.
  struct Move {
    BodyId body{};
    Vec3<double> to{};                   ///< in G [m]
    double begin = 0.0, duration = 0.0;  ///< [s]; lasts longer if the body would exceed its top speed
  };
  /// Steady acceleration of all robots in G.
  struct Wind {
    Vec3<double> acceleration{};         ///< [m/s^2]
    double begin = 0.0, duration = 0.0;  ///< duration of the change from the previous wind [s]
  };
  enum class FaultKind { dropout, freeze, jump };
  /// A fault in the measurements of a body, during from <= t < until.
  struct Fault {
    FaultKind kind = FaultKind::dropout;
    BodyId body{};
    Vec3<double> offset{};           ///< of a jump, in G [m]
    double from = 0.0, until = 0.0;  ///< [s]
  };
  /// Greatest number of faults in force at one time.
  static constexpr std::size_t faults_max = 32;

  std::vector<Move> moves{};  ///< the latest of each body
  std::optional<Wind> wind{};
  std::vector<Fault> faults{};
};

/// Progress at t of a change that begins at `begin` and takes `duration`: 0 to 1, with zero slope
/// at both ends.
inline double blended(double t, double begin, double duration) {
  return Ramp{.begin = begin, .duration = duration, .from = 0.0, .to = 1.0}.at(t);
}

}  // namespace sightline
