/// How far a robot was from its reference.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/model/state_roles.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// Whether the agent's Q asks for a place, or for a heading: only then a reference is one to be judged by.
bool tracks_position(const Agent& agent, const StateRoles& roles);
bool tracks_heading(const Agent& agent, const StateRoles& roles);

/// Position and heading of one robot against its reference, gathered sample by sample: the one judge of both errors. All are not a
/// number where no sample counted. Allocates nothing after its construction.
class TrackingError {
 public:
  /// @param model  of the robot
  /// @param from   nothing counts before [s]
  TrackingError(const Model& model, double from);

  /// @param agent  the robot while it is steered, as it is tuned at `time` [s]
  /// @param seen   what it truly shows then
  void add(const Agent& agent, double time, const Sight<double>& seen);

  double rms_position() const;  ///< root mean square of |p - p*| [m]
  double offset() const;        ///< the steady part of that error: the length of its mean in G [m]
  double rms_rest() const;      ///< root mean square of the rest [m]
  double rms_heading() const;   ///< root mean square of the angle between heading and reference heading [rad]

 private:
  StateRoles roles_;
  double from_;
  std::vector<double> x_ref_;
  Vec3<double> sum_{};  // [m]
  double squares_ = 0.0, heading_squares_ = 0.0;
  std::int64_t places_ = 0, headings_ = 0;  // that counted
};

}  // namespace sightline
