/// Simulator of a Crazyflie behind the Crazyswarm2 server: services, commanders, supervisor.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "bridges/dds/links/crazyswarm_link.hpp"
#include "bridges/dds/simulators/crazyflie_body.hpp"
#include "bridges/dds/simulators/faults.hpp"
#include "bridges/dds/simulators/vehicle_simulator.hpp"
#include "bridges/dds/topics/channel.hpp"

namespace sightline::dds {

/// Counters of the simulated Crazyflie. Any thread may read them.
struct CrazyflieCounts {
  std::int64_t setpoints = 0, setpoints_outside = 0;  ///< outside: received while not flying
  std::int64_t bad_setpoints = 0;                     ///< not finite, or more than 2 m from the vehicle
  std::int64_t arm_requests = 0, takeoff_requests = 0, land_requests = 0;
  std::int64_t locked_out = 0;    ///< take-off and landing requests rejected during set-points
  double levelled_after = 0.0;    ///< time after the last set-point [s]; 0: never
  double motors_off_after = 0.0;  ///< time after the last set-point [s]; 0: never
  double radio_wait = 0.0;        ///< longest time that a set-point waits for the radio [s]
};

/// Behaviour of the services when called.
enum class Serving { well, without_answer, not_at_all };

/// Starts on the ground below its robot's start. Reproduces the firmware:
/// - Set-points override the take-off and landing commander until a request ends them.
/// - Without set-points it levels out after 0.5 s and stops its motors for good after 2 s.
/// - Its radio sends one packet at a time. Set-points wait for it, which the status has as latency.
/// - It arms if its supervisor allows it, and takes off if it is armed and the battery is good.
class CrazyflieVehicle final : public VehicleSimulator {
 public:
  struct Setup {
    LinkOrigin origin{};
    Vec3<double> p{};  ///< position in G, on the ground [m]
    double heading = 0.0;
    Vehicle rotors = Vehicle::crazyflie();
    bool arms_itself = false;
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
  /// @param latency  of a unicast packet that does not wait [ms], at least 1
  /// @param share    of the packets that arrive, 0 to 1
  void set_radio(int latency, double share);
  void serve(Serving serving);
  void tumble();

 private:
  struct Ends;
  /// Source of the set-points.
  enum class Commander {
    stopped,  ///< none: motors off
    ended,    ///< set-points have ended: the last one stays in force
    plan,     ///< take-off and landing
    others,
  };
  /// Smooth height profile of take-off and landing.
  struct Plan {
    double from = 0.0, to = 0.0, begun = 0.0, duration = 0.0;
    Vec2<double> p{};
  };

  std::uint8_t pm_state() const { return faults_.on(LinkFaultKind::battery_low) ? battery_low : on_battery; }
  bool has(std::uint16_t bit) const { return (supervisor_ & bit) != 0; }
  void on_state(const void* message);
  bool on_arm(bool arm);
  void on_takeoff(double height, double duration);
  void on_land(double height, double duration);
  void on_setpoints_end();
  void plan(double height, double duration);
  void stop_motors(bool for_good);
  void supervise();
  void move();
  void send_pose();
  void send_status();

  Crazyswarm2Link link_;
  Setup setup_;
  Faults& faults_;
  mutable std::mutex lock_;  // guards all members below: reader threads and the stepping thread
  CrazyflieCounts reported_;
  CrazyflieBody body_;
  std::uint16_t supervisor_ = 0;
  double voltage_ = 4.1;
  int latency_ = 4;              // of a unicast packet [ms]
  double share_ = 1.0;           // of the packets that arrive
  std::int64_t radio_free_ = 0;  // when it has sent all set-points [ns]
  Serving serving_ = Serving::well;
  bool lands_ = false;
  Commander commander_ = Commander::stopped;
  Plan plan_{};
  TrajectoryPoint setpoint_{};  // in G
  std::int64_t setpoint_at_ = 0, lifted_at_ = 0;
  std::unique_ptr<Ends> ends_;
};

}  // namespace sightline::dds
