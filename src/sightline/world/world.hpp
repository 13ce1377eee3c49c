/// Interface between a control loop and the world that it controls: simulated, recorded or real.
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

/// Motion of a robot, as its autopilot reports it.
struct RobotMotion {
  BodyId robot{};
  MotionSample motion{};
};

/// A pose that a body broadcasts by radio.
struct BodyBroadcast {
  BodyId body{};
  BroadcastPose pose{};
};

/// Measurements at the beginning of a period. Valid until the next measure(); `truth`, until the
/// next apply().
struct Measured {
  std::span<const double> measured;         ///< states of all bodies, in the order of the team (nx)
  std::span<const double> stamps;           ///< time of each body's measured state [s]; minus infinity: none
  std::span<const double> truth;            ///< true states (nx); empty if unknown
  std::span<const Detection> detections{};  ///< arrived since the last measure(), in the order of arrival
  std::span<const Quaternion>
      attitudes{};  ///< true attitudes of all bodies, no_attitude for a body without; empty: unknown
  std::span<const RobotMotion> motions{};       ///< since the last measure(), of each robot in order
  std::span<const BodyBroadcast> broadcasts{};  ///< arrived since the last measure()
};

/// Maximum number of each kind in one period.
struct MeasuredMost {
  std::size_t detections = 0, motions = 0, broadcasts = 0;
};

/// The world that a Loop controls. After construction nothing here allocates, locks, throws or
/// prints; one thread.
///
/// Period k of the loop, at t = k period: set_presence() if it changes, measure(t), apply(t, ...).
/// The loop's Clock determines how time passes. apply() reports missed periods before the next
/// measure().
class World {
 public:
  virtual ~World() = default;

  /// All bodies that can ever be present; outlives the world's users.
  virtual const Team& team() const noexcept = 0;
  /// States in which the bodies start, and to which one that joins in flight is set (nx).
  virtual std::span<const double> start() const noexcept = 0;
  virtual MeasuredMost measured_max() const noexcept { return {}; }
  /// Sets which bodies are present from now on, one entry per body; before the first call, all are.
  virtual void set_presence(std::span<const Presence> presence) noexcept = 0;
  /// Applies changes that events make around the team, from now on. A world that is not simulated
  /// ignores them.
  virtual void surround(const Surroundings& /*around*/) noexcept {}
  /// Measurements at t [s], which must increase.
  virtual Measured measure(double t) noexcept = 0;
  /// Applies the inputs u (nu) from t [s] on, for `periods` periods of `period` [s]. For missed
  /// periods, u are the inputs that stayed in force.
  /// @param estimated  states from which u was computed (nx)
  /// @return false if the world cannot continue, which ends the loop
  virtual bool apply(double t, std::span<const double> estimated, const Command& u, double period,
                     std::int64_t periods) noexcept = 0;
  /// True states after the last apply() (nx), without any sensor; empty if unknown. Does not affect
  /// later measure() calls.
  virtual std::span<const double> truth() const noexcept { return {}; }
  /// Reason why apply() returned false, one sentence; empty if a state is no longer finite.
  /// Allocates: call only after the flight.
  virtual std::string ended() const { return {}; }
};

}  // namespace sightline
