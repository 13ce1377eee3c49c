/// The seam between a control loop and what it flies: simulated, recorded or real.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "sightline/estimate/broadcast_track.hpp"
#include "sightline/estimate/measurement.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/world/command.hpp"
#include "sightline/world/detection.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline {

/// How a robot moved, as its autopilot tells it.
struct RobotMotion {
  BodyId robot{};
  MotionSample motion{};
};

/// A pose that a body tells of itself by radio.
struct BodyBroadcast {
  BodyId body{};
  BroadcastPose pose{};
};

/// What is known at the beginning of a period. It holds until the next measure(), the truth until the next apply().
struct Measured {
  std::span<const double> measured;  ///< states of all bodies, in the order of the team (nx)
  std::span<const double> stamps;    ///< of each body, when it was so [s]; minus infinity: never seen
  std::span<const double> truth;     ///< true states (nx); empty where nobody knows them
  std::span<const Detection>
      detections{};  ///< that arrived since the last measure(), in the order of arrival
  std::span<const Quaternion>
      attitudes{};  ///< true ones of all bodies, no_attitude of one without; empty: nobody knows
  std::span<const RobotMotion> motions{};       ///< told since the last measure(), of each robot in order
  std::span<const BodyBroadcast> broadcasts{};  ///< that arrived since the last measure()
};

/// Most of each kind in one period.
struct MeasuredMost {
  std::size_t detections = 0, motions = 0, broadcasts = 0;
};

/// What a Loop flies. After construction nothing here allocates, locks, throws or prints; one thread.
///
/// Period k of the loop, at t = k period: set_presence() where it changes, measure(t), apply(t, ...). Time passes as the
/// loop's Clock says; a period that was missed is told by apply() before the next measure().
class World {
 public:
  virtual ~World() = default;

  /// All bodies that there will ever be; outlives the world's users.
  virtual const Team& team() const noexcept = 0;
  /// States in which the bodies begin, and in which one that joins in flight does (nx).
  virtual std::span<const double> start() const noexcept = 0;
  virtual MeasuredMost measured_max() const noexcept { return {}; }
  /// Who is there from now on, one for each body; before the first call, all are.
  virtual void set_presence(std::span<const Presence> presence) noexcept = 0;
  /// What events changed around the team, from now on. A world that is not simulated is as it is.
  virtual void surround(const Surroundings& /*around*/) noexcept {}
  /// What is known at t [s], which rises.
  virtual Measured measure(double t) noexcept = 0;
  /// The inputs u (nu) are in force from t [s] on, for `periods` periods of `period` [s]. Of missed periods, the inputs
  /// that went on. `believed` are the states that u was decided on (nx).
  /// @return false where the world cannot go on, which ends the loop
  virtual bool apply(double t, std::span<const double> estimated, const Command& u, double period,
                     std::int64_t periods) noexcept = 0;
  /// True states after the last apply() (nx), without any sensor; empty where nobody knows them. Changes nothing that
  /// measure() will give.
  virtual std::span<const double> truth() const noexcept { return {}; }
  /// After apply() gave false: why, a sentence; empty where a state is no longer finite. Allocates: for after the flight.
  virtual std::string ended() const { return {}; }
};

}  // namespace sightline
