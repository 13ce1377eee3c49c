/// Stands in for a multirotor on plain topics of ROS 2.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/ros2_flyer_link.hpp"
#include "bridges/dds/ros2_odometry.hpp"
#include "bridges/dds/simulated_body.hpp"
#include "bridges/dds/vehicle_simulator.hpp"

namespace sightline::dds {

/// What a stand-in was told. Of any thread.
struct Ros2FlyerCounts {
  std::int64_t commands = 0, bad = 0;  ///< cmd_vel; those that are not finite, or faster than 10
  std::int64_t commands_outside = 0;   ///< other than zero, while it did not fly
  std::int64_t takeoffs = 0, landings = 0;
};

/// On the ground below where its robot starts. In flight it follows cmd_vel, and hovers 0.5 s after the last.
class Ros2Flyer final : public VehicleSimulator {
 public:
  struct Setup {
    LinkOrigin origin{};
    Vec3<double> p{};  ///< in G, on the ground [m]
    double heading = 0.0;
    double altitude = 1.0;  ///< of its take-off [m]
    std::optional<Vehicle>
        rotors{};  ///< none: the point of SimulatedBody, or an ar_drone where commands are normalised
  };

  /// @param faults  of this robot; outlives it
  Ros2Flyer(dds_entity_t participant, const Ros2Link& link, const Setup& setup, Faults& faults);

  void step(std::int64_t number) override;
  bool is_steered() const override { return reported().commands > 0; }
  std::string counts() const override;

  Ros2FlyerCounts reported() const;
  Motion motion() const override;
  Ros2State state() const;
  /// What can be wrong with it: it is landed by somebody, its services refuse or do not answer.
  void land_by_itself();
  void throw_invalid(bool refuses);

 private:
  void serve(dds_entity_t participant, const std::string& name, const std::function<bool()>& act);
  void on_twist(const void* twist);
  bool take_off();
  bool land();
  void follow(const Vec3<double>& v, double r);

  Ros2Link link_;
  Setup setup_;
  mutable std::mutex lock_;  // of all below
  Ros2FlyerCounts reported_;
  Vehicle rotors_;
  SimulatedBody body_;
  Ros2State state_ = Ros2State::landed;
  bool refuses_ = false;
  std::array<double, 4> wanted_{};  // as cmd_vel has it
  std::int64_t commanded_at_ = 0;
  Ros2Odometry odometry_;
  std::unique_ptr<FaultyWriter> state_writer_;
  std::vector<std::unique_ptr<ServiceServer>> services_;
  std::vector<std::unique_ptr<RawReader>> readers_;  // last: they end before what they fill
};

}  // namespace sightline::dds
