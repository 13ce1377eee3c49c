#include "bridges/dds/simulators/px4_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/base/now.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

constexpr std::int64_t checks_take = one_second;    // after its start
constexpr std::int64_t offboard_loss = one_second;  // COM_OF_LOSS_T
// Measured on PX4 1.16.1 (tests/dds/traces), from the request of a take-off on: its motors start,
// then their thrust rises (COM_SPOOLUP_TIME, MPC_TKO_RAMP_T).
constexpr std::int64_t spool_up = 17 * one_second / 10, thrust_up = 24 * one_second / 10;
constexpr std::int64_t land_detector = 3 * one_second;       // on the ground until it reports that it landed
constexpr std::int64_t idle_after_start = 11 * one_second;   // COM_DISARM_PRFLT
constexpr std::int64_t idle_after_landing = 2 * one_second;  // COM_DISARM_LAND
constexpr double takeoff_climb = 0.75, hold_climb = 0.25;    // below the altitude of a take-off [m/s]
constexpr double land_speed = 0.7, land_crawl = 0.3,
                 crawl_below = 1.0;      // MPC_LAND_SPEED, MPC_LAND_CRWL, MPC_LAND_ALT3
constexpr double altitude_radius = 0.8;  // NAV_MC_ALT_RAD [m]
constexpr double fastest = 10.0;         // limit of a set-point [m/s]
constexpr double mpc_xy_p = 0.95;        // MPC_XY_P of PX4 [1/s]
enum Ack : std::uint8_t { accepted = 0, temporarily_rejected = 1, unsupported = 3 };

}  // namespace

struct Px4Vehicle::Ends {
  explicit Ends(int release)
      : status_layout("VehicleStatus", release),
        position_layout("VehicleLocalPosition", release),
        ack_layout("VehicleCommandAck", release) {}

  Px4Layout status_layout, position_layout, ack_layout;
  std::unique_ptr<FaultyWriter> odometry, status, ack, landed, position, inertial;
  std::unique_ptr<RawReader> command, setpoint, heartbeat;
};

Px4Vehicle::Px4Vehicle(dds_entity_t participant, const Px4Link& link, const Setup& setup, Faults& faults)
    : release_(px4_first + static_cast<int>(link.release)),
      setup_(setup),
      booted_(monotonic_now()),
      synchronised_(realtime_now() - booted_),
      body_(setup.p, setup.heading, setup.rotors),
      imu_(Imu::bmi088(), setup.system),
      faults_(faults),
      aside_(participant, link, faults),
      ends_(std::make_unique<Ends>(release_)) {
  const auto topic = [&](Px4Side side, std::string_view message) {
    return px4_topic(link.name_space, side, message, release_);
  };
  const auto writer = [&](std::string_view message) {
    return std::make_unique<FaultyWriter>(participant, Px4Layout(message, release_).descriptor(),
                                          topic(Px4Side::out, message), of_px4_output, faults_);
  };
  const auto reader = [&](std::string_view message, int depth, const auto& taking) {
    const Px4Layout layout(message, release_);
    return std::make_unique<RawReader>(participant, layout.descriptor(), topic(Px4Side::in, message),
                                       Quality{.depth = depth}, layout.size(), Writers::all, taking(layout));
  };
  ends_->odometry = writer("VehicleOdometry");
  ends_->landed = writer("VehicleLandDetected");
  ends_->status = writer("VehicleStatus");
  ends_->ack = writer("VehicleCommandAck");
  ends_->position = writer("VehicleLocalPosition");
  ends_->inertial = writer("SensorCombined");
  send_status();  // readers from before its start learn at once that it is disarmed
  ends_->command = reader("VehicleCommand", 16, [this](const Px4Layout& in) {
    return [this, command = in.place("command"), param1 = in.place("param1"), param2 = in.place("param2"),
            param3 = in.place("param3"), target = in.place("target_system"),
            source = in.place("source_system")](const void* m, const Arrival&) {
      on_command(read_at<std::uint32_t>(m, command),
                 {read_at<float>(m, param1), read_at<float>(m, param2), read_at<float>(m, param3)},
                 read_at<std::uint8_t>(m, target), read_at<std::uint8_t>(m, source));
    };
  });
  ends_->setpoint = reader("TrajectorySetpoint", 2, [this](const Px4Layout&) {
    return [this](const void* m, const Arrival&) { on_setpoint(m); };
  });
  ends_->heartbeat = reader("OffboardControlMode", 2, [this](const Px4Layout& in) {
    return [this, position = in.place("position"), stamp = in.place("timestamp")](const void* m,
                                                                                  const Arrival&) {
      on_heartbeat(read_at<bool>(m, position), read_at<std::uint64_t>(m, stamp));
    };
  });
}

Px4Vehicle::~Px4Vehicle() = default;

void Px4Vehicle::set_nav(NavState nav) {
  nav_ = nav;
  if (nav != NavState::land && nav != NavState::takeoff) disarmed_nav_ = nav;
  send_status();
}

bool Px4Vehicle::hears_offboard() const { return monotonic_now() - heartbeat_at_ < offboard_loss; }

bool Px4Vehicle::may_arm() const {
  return checks_ && aside_.has_origin() && monotonic_now() - booted_ > checks_take &&
         (nav_ != NavState::offboard || hears_offboard());
}

void Px4Vehicle::on_command(std::uint32_t command, const std::array<float, 3>& params, std::uint8_t target,
                            std::uint8_t source) {
  const auto [param1, param2, param3] = params;
  const std::scoped_lock lock(lock_);
  if (target != 0 && target != setup_.system) return;  // for another system: no acknowledgement
  if (faults_.loses_request()) return;
  std::uint8_t result = unsupported;
  switch (static_cast<Px4Command>(command)) {
    case Px4Command::arm_disarm:
      if (param1 > 0.5F) {
        ++reported_.arm_requests;
        result = may_arm() ? accepted : temporarily_rejected;
        if (result == accepted && arming_ != px4_armed)
          arming_ = px4_armed, idle_until_ = monotonic_now() + idle_after_start;
      } else {
        const bool forced = param2 == px4_force;
        reported_.kills += forced ? 1 : 0;
        result = landed_ || forced ? accepted : temporarily_rejected;
        if (result == accepted) arming_ = px4_disarmed;
      }
      break;
    case Px4Command::takeoff:
      result = accepted;
      nav_ = NavState::takeoff;
      takeoff_to_ = body_.motion().p.z + setup_.altitude;
      break;
    case Px4Command::set_mode:
      if (param1 == px4_custom_mode && param2 == px4_mode_offboard) {
        ++reported_.offboard_requests;
        result = hears_offboard() || arming_ != px4_armed ? accepted : temporarily_rejected;
        if (result == accepted)
          set_nav(NavState::offboard), v_sp_ = a_sp_ = {}, r_sp_ = 0.0, has_p_sp_ = false;
      } else if (param1 == px4_custom_mode && param2 == px4_mode_auto && param3 == px4_auto_loiter) {
        result = accepted;
        takeoff_to_ = body_.motion().p.z;
        set_nav(NavState::hold);
      }
      break;
    case Px4Command::set_origin:
      result = accepted;
      aside_.lose_origin(false);
      break;
    case Px4Command::land:
      result = accepted;
      nav_ = NavState::land;
      break;
  }
  acknowledge(command, result, source);
  send_status();
}

void Px4Vehicle::on_setpoint(const void* message) {
  const auto& s = *static_cast<const px4_msgs_msg_dds__TrajectorySetpoint_*>(message);
  const std::scoped_lock lock(lock_);
  ++reported_.setpoints;
  if (nav_ != NavState::offboard) ++reported_.setpoints_outside;
  // A zero velocity (hold) answers no pose.
  const bool answers = s.velocity[0] != 0 || s.velocity[1] != 0 || s.velocity[2] != 0;
  if (answers && s.timestamp > 0 && s.timestamp < last_microsecond)
    answers_.add(1e-6 * (static_cast<double>(microseconds()) - static_cast<double>(s.timestamp)));
  for (const float v : s.velocity) {
    if (!std::isfinite(v) || std::abs(v) > fastest) {
      ++reported_.bad_setpoints;
      return;
    }
  }
  const auto given = [](const float* v) {
    const auto one = [](float x) { return std::isfinite(x) ? double{x} : 0.0; };
    return turned_over(Vec3<double>{one(v[0]), one(v[1]), one(v[2])});
  };
  const LinkOrigin turned = {{}, setup_.origin.heading};
  v_sp_ = in_G(turned, Motion{.p = given(s.velocity)}).p;
  a_sp_ = in_G(turned, Motion{.p = given(s.acceleration)}).p;
  r_sp_ = std::isfinite(s.yawspeed) ? -double{s.yawspeed} : 0.0;
  has_p_sp_ = std::isfinite(s.position[0] + s.position[1]);
  if (has_p_sp_) p_sp_ = in_G(setup_.origin, Motion{.p = given(s.position)}).p;
}

// As its client converts a stamp: never into the future.
void Px4Vehicle::on_heartbeat(bool position, std::uint64_t stamp) {
  const std::scoped_lock lock(lock_);
  ++reported_.heartbeats;
  const Nanoseconds now = monotonic_now(),
                    stamped = of_microseconds(std::min(stamp, last_microsecond)) - clock_offset();
  if (position) heartbeat_at_ = stamp == 0 ? now : std::min(now, stamped);
}

Nanoseconds Px4Vehicle::clock_offset() const {
  using K = LinkFaultKind;
  const double jump = faults_.on(K::clock_jump) ? faults_.size(K::clock_jump) : 0.0;
  return synchronised_ + to_nanoseconds(jump);
}

std::uint64_t Px4Vehicle::microseconds() const {
  return static_cast<std::uint64_t>((monotonic_now() + clock_offset()) / 1000);
}

void Px4Vehicle::move() {
  Vec3<double> v{}, a{};
  double r = 0.0;
  const double height = body_.motion().p.z;
  if (nav_ == NavState::offboard) {
    v = v_sp_, a = a_sp_, r = r_sp_;
    if (has_p_sp_) {
      const Vec3<double> way = p_sp_ - body_.motion().p - faults_.shift();
      v = v + mpc_xy_p * Vec3<double>{way.x, way.y, 0.0};
    }
  }
  const double climb = takeoff_speed(height, takeoff_to_);
  if (nav_ == NavState::takeoff) v.z = std::min(climb, takeoff_climb);
  if (nav_ == NavState::hold && !landed_) v.z = std::min(climb, hold_climb);
  if (nav_ == NavState::land) v.z = height > crawl_below ? -land_speed : -land_crawl;
  const std::int64_t now = monotonic_now();
  if (arming_ == px4_armed && (!body_.on_ground() || leaves_ground(v.z > 0, now)))
    body_.follow(v, a, r);
  else
    body_.rest();
  if (!body_.on_ground())
    landed_ = false, lifts_since_ = stands_since_ = 0;
  else if (arming_ != px4_armed)
    landed_ = true, lifts_since_ = stands_since_ = 0;
  else
    stand(v.z < 0, now);
  const bool reached = body_.motion().p.z > takeoff_to_ - altitude_radius;
  if (arming_ == px4_armed && nav_ == NavState::takeoff && reached && !body_.on_ground())
    set_nav(NavState::hold);
}

std::int64_t Px4Vehicle::shortened(std::int64_t duration) const {
  return std::llround(setup_.ground_time * static_cast<double>(duration));
}

bool Px4Vehicle::leaves_ground(bool climbs, std::int64_t now) {
  if (!climbs) {
    lifts_since_ = 0;
    return false;
  }
  if (lifts_since_ == 0) lifts_since_ = now;
  return now - lifts_since_ > shortened(spool_up + thrust_up);
}

void Px4Vehicle::stand(bool sinks, std::int64_t now) {
  if (lifts_since_ > 0) landed_ = landed_ && now - lifts_since_ < shortened(spool_up);
  if (!sinks) stands_since_ = 0;
  if (sinks && stands_since_ == 0) stands_since_ = now;
  if (!landed_ && sinks && now - stands_since_ > shortened(land_detector))
    landed_ = true, idle_until_ = now + shortened(idle_after_landing);
  if (!landed_ || lifts_since_ > 0 || now < idle_until_) return;
  arming_ = px4_disarmed;
  failsafe_ = false;
  nav_ = disarmed_nav_;
  send_slow();
  send_status();
}

void Px4Vehicle::step(std::int64_t number) {
  const std::scoped_lock lock(lock_);
  if (nav_ == NavState::offboard && arming_ == px4_armed && monotonic_now() - heartbeat_at_ > offboard_loss) {
    reported_.failsafe_after = to_seconds(monotonic_now() - heartbeat_at_);
    failsafe_ = true;
    set_nav(NavState::land);
  }
  suffer();
  send_odometry();  // the motion before this step, stamped now
  move();
  if (number % 20 == 0) send_status();
  if (number % 10 == 5) send_slow();
  aside_.lose_offboard(!hears_offboard());
  if (number % 100 == 50) aside_.send();
}

void Px4Vehicle::suffer() {
  using K = LinkFaultKind;
  const auto begins = [&](K kind) { return faults_.changed(kind) && faults_.on(kind); };
  if (begins(K::pilot)) set_nav(NavState::position);
  if (begins(K::disarm)) {
    arming_ = px4_disarmed;
    send_status();
  }
  if (faults_.changed(K::battery_low)) aside_.send();
  if (faults_.changed(K::estimator_invalid)) send_slow();
}

void Px4Vehicle::send_odometry() {
  const Motion local = in_local(setup_.origin, faults_.distorted(body_.motion()));
  px4_msgs_msg_dds__VehicleOdometry_ m{};
  m.timestamp = m.timestamp_sample = microseconds();
  send_inertial(m.timestamp_sample);
  m.pose_frame = m.velocity_frame = px4_frame_ned;
  const Vec3<double> p = turned_over(local.p), v = turned_over(local.v);
  const Quaternion q = turned_over(local.q);
  const std::array<double, 3> ps = {p.x, p.y, p.z}, vs = {v.x, v.y, v.z};
  const std::array<double, 4> qs = {q.w, q.x, q.y, q.z};
  for (std::size_t k = 0; k < 3; ++k)
    m.position[k] = static_cast<float>(ps[k]), m.velocity[k] = static_cast<float>(vs[k]),
    m.position_variance[k] = 1e-4F;
  for (std::size_t k = 0; k < 4; ++k) m.q[k] = static_cast<float>(qs[k]);
  m.angular_velocity[2] = static_cast<float>(-body_.motion().r);
  m.reset_counter = static_cast<std::uint8_t>(faults_.resets());
  ends_->odometry->write(&m);
}

// Two measurements before each odometry, as of PX4 with IMU_INTEG_RATE = 200.
void Px4Vehicle::send_inertial(std::uint64_t now) {
  const Motion before = std::exchange(sensed_, body_.motion());
  const std::uint64_t begin = std::exchange(sensed_at_, now);
  if (begin == 0 || now < begin + 2) return;
  const InertialSample exact = inertial_between(before, sensed_, 1e-6 * static_cast<double>(now - begin));
  const std::uint64_t middle = begin + (now - begin) / 2;
  for (const auto& [from, to] : {std::pair{begin, middle}, std::pair{middle, now}}) {
    const InertialSample measured = imu_.measure(exact, 1e-6 * static_cast<double>(to - from));
    const Vec3<double> w = body_turned_over(measured.gyro), f = body_turned_over(measured.force);
    const std::array<double, 3> rates = {w.x, w.y, w.z}, forces = {f.x, f.y, f.z};
    px4_msgs_msg_dds__SensorCombined_ m{};
    m.timestamp = to;
    m.gyro_integral_dt = m.accelerometer_integral_dt = static_cast<std::uint32_t>(to - from);
    for (std::size_t k = 0; k < 3; ++k)
      m.gyro_rad[k] = static_cast<float>(rates[k]), m.accelerometer_m_s2[k] = static_cast<float>(forces[k]);
    ends_->inertial->write(&m);
  }
}

void Px4Vehicle::send_status() {
  Px4Message m(ends_->status_layout);
  m.set("timestamp", microseconds());
  m.set("arming_state", arming_);
  for (const std::string_view nav : {"nav_state", "nav_state_user_intention"})
    m.set(nav, static_cast<std::uint8_t>(nav_));
  m.set("vehicle_type", std::uint8_t{1});
  m.set("system_type", std::uint8_t{2});
  m.set("system_id", setup_.system);
  m.set("component_id", std::uint8_t{1});
  m.set("failsafe", failsafe_);
  m.set("pre_flight_checks_pass", may_arm());
  ends_->status->write(m.data());
}

void Px4Vehicle::send_slow() {
  px4_msgs_msg_dds__VehicleLandDetected_ landed{};
  landed.timestamp = microseconds();
  landed.landed = landed.ground_contact = landed_;
  ends_->landed->write(&landed);
  Px4Message m(ends_->position_layout);
  for (const std::string_view stamp : {"timestamp", "timestamp_sample"}) m.set(stamp, microseconds());
  const bool valid =
      monotonic_now() - booted_ > checks_take / 2 && !faults_.on(LinkFaultKind::estimator_invalid);
  for (const std::string_view of : {"xy_valid", "z_valid", "v_xy_valid", "v_z_valid"}) m.set(of, valid);
  const Vec3<double> p = turned_over(in_local(setup_.origin, body_.motion()).p);
  m.set("x", static_cast<float>(p.x));
  m.set("y", static_cast<float>(p.y));
  m.set("z", static_cast<float>(p.z));
  m.set("heading_good_for_control", true);
  ends_->position->write(m.data());
}

void Px4Vehicle::acknowledge(std::uint32_t command, std::uint8_t result, std::uint8_t source) {
  Px4Message m(ends_->ack_layout);
  m.set("timestamp", microseconds());
  m.set("command", command);
  m.set("result", result);
  m.set("target_system", source);
  ends_->ack->write(m.data());
}

Px4VehicleCounts Px4Vehicle::reported() const {
  const std::scoped_lock lock(lock_);
  Px4VehicleCounts reported = reported_;
  reported.answer_median = answers_.within(0.5), reported.answer_p99 = answers_.within(0.99);
  return reported;
}
Motion Px4Vehicle::motion() const {
  const std::scoped_lock lock(lock_);
  return body_.motion();
}
bool Px4Vehicle::armed() const {
  const std::scoped_lock lock(lock_);
  return arming_ == px4_armed;
}
bool Px4Vehicle::is_steered() const {
  const std::scoped_lock lock(lock_);
  return arming_ == px4_armed && nav_ == NavState::offboard;
}
void Px4Vehicle::fail_checks(bool fails) {
  const std::scoped_lock lock(lock_);
  checks_ = !fails;
  send_status();
}
std::string Px4Vehicle::counts() const {
  const Px4VehicleCounts n = reported();
  const Motion m = motion();
  return fmt::format(
      "{} set-points ({} outside offboard, {} bad), {} heartbeats, {} requests to arm, {} for offboard, {}, "
      "at [{:.2f}, {:.2f}, "
      "{:.2f}] m, answers {:.3f} ms after the pose at the median, {:.3f} at 99 %{}",
      n.setpoints, n.setpoints_outside, n.bad_setpoints, n.heartbeats, n.arm_requests, n.offboard_requests,
      armed() ? "armed" : "disarmed", m.p.x, m.p.y, m.p.z, 1e3 * n.answer_median, 1e3 * n.answer_p99,
      n.failsafe_after > 0 ? fmt::format(", failsafe {:.3f} s after the last heartbeat", n.failsafe_after)
                           : "");
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::VehicleSimulator> sightline::Px4Link::simulator(
    const dds::SimulatorSetup& setup) const {
  return std::make_unique<dds::Px4Vehicle>(
      setup.participant, *this,
      dds::Px4Vehicle::Setup{.origin = setup.origin,
                             .p = setup.below,
                             .heading = setup.heading,
                             .altitude = setup.altitude,
                             .ground_time = setup.ground_time,
                             .system = static_cast<std::uint8_t>(
                                 target_system > 0 ? target_system : 1 + setup.robot.index % 255),
                             .rotors = setup.rotors},
      setup.faults);
}
