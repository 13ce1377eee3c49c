/// Receive-only examination of a fleet before a flight.
#pragma once

#include <memory>
#include <vector>

#include "bridges/dds/dds_world.hpp"

namespace sightline::dds {

/// Creates one writer per PX4 vehicle, to request its message layouts; everything else only reads.
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
