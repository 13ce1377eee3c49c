/// Simulator of the robots' cameras with apriltag_ros.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/robot_state.hpp"
#include "bridges/dds/simulators/faults.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "sightline/scenario.hpp"
#include "sightline/worlds.hpp"

namespace sightline::dds {

/// Publishes the detections of each camera on /tf as apriltag_ros does: a transform from the
/// camera's optical frame to each tag, stamped with the exposure time.
/// The images are those of the simulation: detections with its noise, rate and latency. The
/// reported tags are those most visible to the camera.
class SimulatedCameras {
 public:
  /// @param faults  per link, of its robot; must outlive this. Message faults apply to images, too
  SimulatedCameras(dds_entity_t participant, const Scenario& scenario, const std::vector<Faults*>& faults);
  ~SimulatedCameras();

  /// Sends the messages due at this period number (VehicleSimulator::period).
  /// @param robots  in link order
  /// @param states  of the team; only those of other bodies are used
  void step(std::int64_t number, std::span<const Motion> robots, std::span<const double> states);
  /// Cameras and image counts, one line; empty: no cameras.
  std::string counts() const;

 private:
  struct Truth;
  struct Eye;

  void send(Eye& eye, std::span<const Detection> found);

  CameraOptions vision_;
  std::vector<RobotState> models_;
  std::vector<std::size_t> places_;  // state offsets of the robots
  std::vector<int> bodies_;          // body indices of the robots
  Truth* truth_ = nullptr;           // owned by cameras_
  std::unique_ptr<CameraWorld> cameras_;
  std::array<Nanoseconds, 256> times_{};  // time stamps of the last periods, ring buffer
  std::vector<std::unique_ptr<Eye>> eyes_;
};

}  // namespace sightline::dds
