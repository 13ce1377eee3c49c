/// Simulator of a PX4 vehicle: arming, modes, acknowledgements, and messages in the layout of its
/// release.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "bridges/dds/links/px4_link.hpp"
#include "bridges/dds/simulators/faults.hpp"
#include "bridges/dds/simulators/px4_vehicle_diagnostics.hpp"
#include "bridges/dds/simulators/simulated_body.hpp"
#include "bridges/dds/simulators/simulated_imu.hpp"
#include "bridges/dds/simulators/vehicle_simulator.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/delay_histogram.hpp"

namespace sightline::dds {

/// Counters of the simulated vehicle. Any thread may read them.
struct Px4VehicleCounts {
  std::int64_t setpoints = 0, setpoints_outside = 0;  ///< outside: received in another mode than offboard
  std::int64_t bad_setpoints = 0;                     ///< not finite, or faster than 10 m/s
  std::int64_t heartbeats = 0, arm_requests = 0, offboard_requests = 0;
  std::int64_t kills = 0;  ///< requests to disarm in the air
  double answer_median = 0.0,
         answer_p99 = 0.0;      ///< from the stamp of a pose to the set-point that answers it [s]
  double failsafe_after = 0.0;  ///< from the last heartbeat to its failsafe [s]; 0: none occurred
};

/// A vehicle that starts on the ground below its robot's start.
class Px4Vehicle final : public VehicleSimulator {
 public:
  struct Setup {
    LinkOrigin origin{};
    Vec3<double> p{};  ///< position in G, on the ground [m]
    double heading = 0.0;
    double altitude = 1.0;     ///< of its take-off [m], MIS_TAKEOFF_ALT
    double ground_time = 1.0;  ///< factor of the times that it stands armed before and after a flight
    std::uint8_t system = 1;
    std::optional<Vehicle> rotors{};  ///< none: point mass with velocity lag
  };

  /// @param faults  of this vehicle; must outlive it
  Px4Vehicle(dds_entity_t participant, const Px4Link& link, const Setup& setup, Faults& faults);
  ~Px4Vehicle() override;

  void step(std::int64_t number) override;
  bool is_steered() const override;
  std::string counts() const override;

  Px4VehicleCounts reported() const;
  Motion motion() const override;  ///< in G
  bool armed() const;
  /// Makes its preflight checks fail.
  void fail_checks(bool fails);
  /// Battery, failsafe flags, layout responses.
  Px4VehicleDiagnostics& aside() { return aside_; }

 private:
  struct Ends;

  void set_nav(NavState nav);
  void on_command(std::uint32_t command, const std::array<float, 3>& params, std::uint8_t target,
                  std::uint8_t source);
  bool hears_offboard() const;
  bool may_arm() const;
  void on_setpoint(const void* message);
  /// @param stamp  by its clock [us]; 0: now
  void on_heartbeat(bool position, std::uint64_t stamp);
  /// Its clock less the monotonic clock. It follows the agent's clock at its start, not later steps of it.
  Nanoseconds clock_offset() const;
  std::uint64_t microseconds() const;  ///< of its clock
  void move();
  std::int64_t shortened(std::int64_t duration) const;
  bool leaves_ground(bool climbs, std::int64_t now);
  void stand(bool sinks, std::int64_t now);
  void send_odometry();
  void send_inertial(std::uint64_t now);
  void send_status();
  void send_slow();
  void suffer();
  void acknowledge(std::uint32_t command, std::uint8_t result, std::uint8_t source);

  int release_;
  Setup setup_;
  mutable std::recursive_mutex lock_;  // guards all members below: reader threads and the stepping thread
  Px4VehicleCounts reported_;
  DelayHistogram answers_;
  std::uint8_t arming_ = px4_disarmed;
  // The mode, and that after it disarms: the last that allows arming.
  NavState nav_ = NavState::hold, disarmed_nav_ = NavState::hold;
  bool failsafe_ = false, checks_ = true, landed_ = true;
  std::int64_t booted_, heartbeat_at_ = 0;
  Nanoseconds synchronised_;  // clock_offset() without a jump
  // Since when it is to leave the ground, and since when it stands on it but is to sink; 0: it does not.
  // Until when it stays armed on the ground.
  std::int64_t lifts_since_ = 0, stands_since_ = 0, idle_until_ = 0;
  double takeoff_to_ = 0.0;  // height to which it climbs and then holds [m]
  SimulatedBody body_;
  SimulatedImu imu_;
  Motion sensed_{};                        // at the last inertial measurement, in G
  std::uint64_t sensed_at_ = 0;            // by its clock [us]; 0: none yet
  Vec3<double> p_sp_{}, v_sp_{}, a_sp_{};  // in G; the height of p_sp_ is unused
  double r_sp_ = 0.0;
  bool has_p_sp_ = false;
  Faults& faults_;
  Px4VehicleDiagnostics aside_;
  std::unique_ptr<Ends> ends_;
};

}  // namespace sightline::dds
