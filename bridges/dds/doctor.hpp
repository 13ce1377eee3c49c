/// Listens to a fleet before a flight: the ends of its links, silent.
#pragma once

#include <memory>
#include <vector>

#include "bridges/dds/dds_world.hpp"

namespace sightline::dds {

/// Beside readers it has one writer for each vehicle of PX4, by which it asks for layouts of messages.
class DdsDoctor final : public FleetDoctor {
 public:
  /// @throws as DdsWorld
  DdsDoctor(const Scenario& scenario, std::shared_ptr<Domain> domain)
      : world_(scenario, std::move(domain), {}, PublishMode::off) {}

  std::vector<Finding> findings() override { return world_.examine(); }
  std::vector<RobotPose> poses() override { return world_.poses(); }

 private:
  DdsWorld world_;
};

}  // namespace sightline::dds
