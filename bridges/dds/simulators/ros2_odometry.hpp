/// Odometry messages of the ROS 2 simulators.
#pragma once

#include <memory>
#include <string>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/simulators/faults.hpp"

namespace sightline::dds {

class Ros2Odometry {
 public:
  /// Uses the frames of the link; "odom" and "base_link" if the link names none.
  Ros2Odometry(dds_entity_t participant, const Ros2Link& link, const LinkOrigin& origin, Faults& faults);
  /// @param motion  in G
  void send(const Motion& motion);

 private:
  LinkOrigin origin_;
  Faults& faults_;
  std::string frame_, body_frame_;
  std::unique_ptr<FaultyWriter> writer_;  // null if the poses come from others
};

}  // namespace sightline::dds
