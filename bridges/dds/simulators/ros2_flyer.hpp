/// Simulator of a multirotor on plain ROS 2 topics.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/links/ros2_flyer_link.hpp"
#include "bridges/dds/simulators/ros2_odometry.hpp"
#include "bridges/dds/simulators/simulated_body.hpp"
#include "bridges/dds/simulators/vehicle_simulator.hpp"

namespace sightline::dds {

/// Counters of the simulated multirotor. Any thread may read them.
struct Ros2FlyerCounts {
  std::int64_t commands = 0, bad = 0;  ///< cmd_vel messages; bad: not finite, or a component sum >= 10
  std::int64_t commands_outside = 0;   ///< nonzero, while not flying
  std::int64_t takeoffs = 0, landings = 0;
};

/// Starts on the ground below its robot's start. In flight it follows cmd_vel, and hovers 0.5 s
/// after the last one.
class Ros2Flyer final : public VehicleSimulator {
 public:
  struct Setup {
    LinkOrigin origin{};
    Vec3<double> p{};  ///< position in G, on the ground [m]
    double heading = 0.0;
    double altitude = 1.0;  ///< of its take-off [m]
    std::optional<Vehicle>
        rotors{};  ///< none: SimulatedBody's point mass; ar_drone if commands are normalised
  };

  /// @param faults  of this robot; must outlive it
  Ros2Flyer(dds_entity_t participant, const Ros2Link& link, const Setup& setup, Faults& faults);

  void step(std::int64_t number) override;
  bool is_steered() const override { return reported().commands > 0; }
  std::string counts() const override;

  Ros2FlyerCounts reported() const;
  Motion motion() const override;
  Ros2State state() const;
  /// Injects a landing by another operator, or rejected service calls.
  void land_by_itself();
  void refuse_requests(bool refuses);

 private:
  void serve(dds_entity_t participant, const std::string& name, const std::function<bool()>& act);
  void on_twist(const void* twist);
  bool take_off();
  bool land();
  void follow(const Vec3<double>& v, double r);

  Ros2Link link_;
  Setup setup_;
  mutable std::mutex lock_;  // guards all members below
  Ros2FlyerCounts reported_;
  Vehicle rotors_;
  SimulatedBody body_;
  Ros2State state_ = Ros2State::landed;
  bool refuses_ = false;
  std::array<double, 4> wanted_{};  // as in cmd_vel
  std::int64_t commanded_at_ = 0;
  Ros2Odometry odometry_;
  std::unique_ptr<FaultyWriter> state_writer_;
  std::vector<std::unique_ptr<ServiceServer>> services_;
  std::vector<std::unique_ptr<RawReader>> readers_;  // last member: destroyed before the members they fill
};

}  // namespace sightline::dds
