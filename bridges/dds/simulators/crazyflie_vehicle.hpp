/// Simulator of a Crazyflie behind the Crazyswarm2 server: services, commanders, supervisor.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "bridges/dds/links/crazyswarm_link.hpp"
#include "bridges/dds/simulators/crazyflie_body.hpp"
#include "bridges/dds/simulators/faults.hpp"
#include "bridges/dds/simulators/simulated_imu.hpp"
#include "bridges/dds/simulators/simulated_radio.hpp"
#include "bridges/dds/simulators/vehicle_simulator.hpp"
#include "bridges/dds/topics/channel.hpp"

namespace sightline::dds {

/// Counters of the simulated Crazyflie. Any thread may read them.
struct CrazyflieCounts {
  std::int64_t setpoints = 0, setpoints_outside = 0;  ///< outside: received while not flying
  std::int64_t bad_setpoints = 0;                     ///< not finite, or more than 2 m from the vehicle
  std::int64_t arm_requests = 0, takeoff_requests = 0, go_to_requests = 0, land_requests = 0;
  std::int64_t locked_out = 0;    ///< take-offs and landings that a later set-point ended
  double dropped = 0.0;           ///< longest time in the air without thrust, until its plan began [s]
  double levelled_after = 0.0;    ///< time after the last set-point [s]; 0: never
  double motors_off_after = 0.0;  ///< time after the last set-point [s]; 0: never
  double radio_wait = 0.0;        ///< longest time that a set-point waits for the radio [s]
};

/// Behaviour of the services when called.
enum class Serving { well, without_answer, not_at_all };

/// Starts on the ground below its robot's start. Reproduces the firmware of August 2026 with its
/// Mellinger controller, and Crazyswarm2 of July 2026:
/// - Set-points override the planner of take-offs and landings until a request ends them, and each
///   stops it. A stopped planner stops the motors, also in the air.
/// - It may fly 60 ms after it was armed.
/// - The planner starts where it last knew the vehicle. It learns this each 10 ms while the vehicle
///   may fly; before, it is the origin. It ignores requests before the vehicle may fly, a take-off
///   unless it is stopped, and a landing during a landing. These two turn it to heading 0.
/// - Without set-points it levels out after 0.5 s and stops its motors for good after 2 s.
/// - It flies until 2 s after the motors last lifted, and stays armed for 3 s more.
/// - All but poses of others goes through its radio (SimulatedRadio).
class CrazyflieVehicle final : public VehicleSimulator {
 public:
  struct Setup {
    LinkOrigin origin{};
    Vec3<double> p{};  ///< position in G, on the ground [m]
    double heading = 0.0;
    Vehicle rotors = Vehicle::crazyflie();
    bool arms_itself = false;
    bool logs_pose = true;
    std::uint64_t seed = 1;  ///< of its IMU's errors
  };

  /// @param faults  of this vehicle; must outlive it
  CrazyflieVehicle(dds_entity_t participant, const Crazyswarm2Link& link, const Setup& setup, Faults& faults);
  ~CrazyflieVehicle() override;

  void step(std::int64_t number) override;
  bool is_steered() const override { return reported().setpoints > 0; }
  std::string counts() const override;

  CrazyflieCounts reported() const;
  Motion motion() const override;
  std::uint16_t supervisor() const;
  /// Injects a voltage [V], a radio, a service behaviour, or a tumble.
  void set_voltage(double voltage);
  /// @param latency  from a packet to the next [ms], at least 1
  /// @param share    of the packets that arrive, 0 to 1
  void set_radio(int latency, double share);
  void serve(Serving serving);
  void tumble();
  /// @param sag  by which it hovers too low, since its controller assumes a smaller mass [m]
  void set_sag(double sag);

 private:
  struct Ends;
  enum class Planner { stopped, flies, lands };
  /// From one place at rest to another, in its frame.
  struct Plan {
    TrajectoryPoint from{};
    Vec3<double> to{};
    double turn = 0.0, begun = 0.0, duration = 0.0;  // turn [rad]
  };

  std::uint8_t pm_state() const { return faults_.on(LinkFaultKind::battery_low) ? battery_low : on_battery; }
  bool has(std::uint16_t bit) const { return (supervisor_ & bit) != 0; }
  bool runs() const { return has(can_fly) && (setpoints_lead_ || planner_ != Planner::stopped); }
  TrajectoryPoint here() const;
  void on_state(const void* message);
  void take_setpoint(const TrajectoryPoint& setpoint, std::int64_t sent);
  bool on_arm(bool arm);
  void on_takeoff(double height, double duration);
  void on_go_to(const Vec3<double>& to, double yaw, double duration);
  void on_land(double height, double duration);
  void on_setpoints_end();
  void plan(Planner planner, const Vec3<double>& to, double yaw, double duration);
  TrajectoryPoint planned() const;
  void stop_motors(bool for_good);
  void disarm();
  void supervise();
  void follow(TrajectoryPoint to);
  void move();
  void send_imu();
  void send_pose();
  void send_status();

  Crazyswarm2Link link_;
  Setup setup_;
  Faults& faults_;
  mutable std::mutex lock_;  // guards all members below: reader threads and the stepping thread
  CrazyflieCounts reported_;
  CrazyflieBody body_;
  SimulatedImu imu_;
  Motion sensed_{};  // at the last log of its IMU, in G
  std::uint16_t supervisor_ = 0;
  double voltage_ = 4.1, sag_ = 0.0;  // [V], [m]
  SimulatedRadio radio_;
  std::int64_t sent_ = 0, received_ = 0;  // packets until the last status
  bool has_status_ = false;               // the server does not publish the first one
  Serving serving_ = Serving::well;
  bool setpoints_lead_ = false;
  Planner planner_ = Planner::stopped;
  Plan plan_{};
  TrajectoryPoint known_{};     // where the planner starts, in its frame
  TrajectoryPoint setpoint_{};  // in G
  std::int64_t armed_at_ = 0, setpoint_at_ = 0, lifted_at_ = 0, landed_at_ = 0;
  std::unique_ptr<Ends> ends_;
};

}  // namespace sightline::dds
