/// Errors of a robot against its reference.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/model/state_roles.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// True if the agent's Q weighs a position, or a heading; only then is its reference a criterion.
bool tracks_position(const Agent& agent, const StateRoles& roles);
bool tracks_heading(const Agent& agent, const StateRoles& roles);

/// Collects position and heading errors of one robot, sample by sample; the only judge of both
/// errors. Every result is NaN if no sample counted. Allocates nothing after construction.
class TrackingError {
 public:
  /// @param model  of the robot
  /// @param from   samples before this time do not count [s]
  TrackingError(const Model& model, double from);

  /// @param agent  the steered robot with its tuning at `time` [s]
  /// @param seen   its true pose at that time
  void add(const Agent& agent, double time, const Sight<double>& seen);

  double rms_position() const;  ///< root mean square of |p - p*| [m]
  double offset() const;        ///< steady part of that error: length of its mean in G [m]
  double rms_rest() const;      ///< root mean square of the remaining error [m]
  double rms_heading() const;   ///< root mean square of the angle between heading and reference heading [rad]

 private:
  StateRoles roles_;
  double from_;
  std::vector<double> x_ref_;
  Vec3<double> sum_{};  // [m]
  double squares_ = 0.0, heading_squares_ = 0.0;
  std::int64_t places_ = 0, headings_ = 0;  // number of samples that counted
};

}  // namespace sightline
