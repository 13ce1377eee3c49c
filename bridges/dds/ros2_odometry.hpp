/// The odometry that stand-ins on ROS 2 send.
#pragma once

#include <memory>
#include <string>

#include "bridges/dds/faults.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

class Ros2Odometry {
 public:
  /// In the frames that the link wants, "odom" and "base_link" where it wants none.
  Ros2Odometry(dds_entity_t participant, const Ros2Link& link, const LinkOrigin& origin, Faults& faults);
  /// @param motion  in G
  void send(const Motion& motion);

 private:
  LinkOrigin origin_;
  Faults& faults_;
  std::string frame_, body_frame_;
  std::unique_ptr<FaultyWriter> writer_;  // none where others see it
};

}  // namespace sightline::dds
