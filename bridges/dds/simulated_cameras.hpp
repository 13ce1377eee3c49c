/// Stands in for the cameras of a fleet's robots, and for apriltag_ros behind them.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/conversion.hpp"
#include "bridges/dds/faults.hpp"
#include "bridges/dds/robot_state.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/world/camera_world.hpp"

namespace sightline::dds {

/// What each camera finds in its pictures goes out on /tf as apriltag_ros says it: a transform to each tag from the camera's optical
/// frame, at the time of the exposure. Pictures are those of the simulation: detections with their noise, rate and latency; the tags are
/// those that the camera sees best.
class SimulatedCameras {
 public:
  /// @param faults  of the robot of each link, which outlive this: what they do to messages they do to pictures too
  SimulatedCameras(dds_entity_t participant, const Scenario& scenario, const std::vector<Faults*>& faults);
  ~SimulatedCameras();

  /// Sends what is due at that number of periods (VehicleSimulator::period).
  /// @param robots  in the order of the links
  /// @param states  of the team; those of other bodies count
  void step(std::int64_t number, std::span<const Motion> robots, std::span<const double> states);
  /// Those that it sees with, a line; empty: none.
  std::string counts() const;

 private:
  struct Truth;
  struct Eye;

  void send(Eye& eye, std::span<const Detection> found);

  CameraOptions vision_;
  std::vector<RobotState> models_;
  std::vector<std::size_t> places_;  // of the robots' states
  std::vector<int> bodies_;          // and of the robots in the team
  Truth* truth_ = nullptr;           // within cameras_
  std::unique_ptr<CameraWorld> cameras_;
  std::array<Nanoseconds, 256> times_{};  // of the last periods, a ring
  std::vector<std::unique_ptr<Eye>> eyes_;
};

}  // namespace sightline::dds
