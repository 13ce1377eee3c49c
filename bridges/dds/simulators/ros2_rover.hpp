/// Simulator of a ground robot that is driven by cmd_vel.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "bridges/dds/simulators/ros2_odometry.hpp"
#include "bridges/dds/simulators/vehicle_simulator.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// Follows velocities with a lag of 0.1 s, and stops 0.5 s after the last one.
class Ros2Rover final : public VehicleSimulator {
 public:
  struct Setup {
    LinkOrigin origin{};
    Motion start{};         ///< in G
    bool sideward = false;  ///< also drives sideways
  };

  /// @param faults  of this robot; must outlive it
  Ros2Rover(dds_entity_t participant, const Ros2Link& link, const Setup& setup, Faults& faults);

  void step(std::int64_t number) override;
  bool is_steered() const override { return commands() > 0; }
  std::string counts() const override;

  Motion motion() const override;  ///< in G
  std::int64_t commands() const;
  bool stopped_itself() const;

 private:
  void on_twist(const void* twist);

  Ros2Link link_;
  Setup setup_;
  mutable std::mutex lock_;  // guards all members below
  Motion motion_;
  Vec2<double> v_{}, v_wanted_{};  // forward, left [m/s]
  double r_wanted_ = 0.0;
  std::int64_t commanded_at_ = 0, commands_ = 0, bad_ = 0;
  bool stopped_itself_ = false;
  Ros2Odometry odometry_;
  std::unique_ptr<RawReader> cmd_vel_;
};

}  // namespace sightline::dds
