#include "bridges/dds/simulators/crazyflie_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bridges/dds/topics/ros_message.hpp"
#include "bridges/dds/topics/service.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "crazyflie.h"
}

namespace sightline::dds {
namespace {

constexpr std::int64_t level_out_after = 500'000'000,
                       motors_off_after = 2'000'000'000;  // as in the firmware [ns]
constexpr std::int64_t arming_lasts = 60'000'000;         // until it may fly [ns]
constexpr std::int64_t flying_lasts = 2'000'000'000;      // after the motors last lifted [ns]
constexpr std::int64_t armed_lasts = 3'000'000'000;       // after it flies no more [ns]
constexpr std::int64_t packet_interval = 4'000'000;       // [ns]
constexpr double status_period = 0.1;                     // [s]
constexpr double gyro_most = 2000, acc_most = 24;         // [deg/s], [g]
constexpr double furthest = 2.0;                          // distance of a set-point from the vehicle [m]

double seconds_of(const builtin_interfaces_msg_dds__Duration_& d) { return d.sec + 1e-9 * d.nanosec; }
double seconds_now() { return to_seconds(monotonic_now()); }

/// Polynomial from 0 to 1 whose derivatives up to the third vanish at both ends, and two of them.
std::array<double, 3> smooth_step(double s) {
  const double t = 1 - s;
  return {s * s * s * s * (35 - s * (84 - s * (70 - 20 * s))), 140 * s * s * s * t * t * t,
          420 * s * s * t * t * (1 - 2 * s)};
}

double angle(const Vec2<double>& d) { return std::atan2(d.y, d.x); }

}  // namespace

struct CrazyflieVehicle::Ends {
  std::unique_ptr<FaultyWriter> pose, status, imu;
  std::vector<std::unique_ptr<ServiceServer>> services;
  std::unique_ptr<RawReader> full_state;
};

CrazyflieVehicle::CrazyflieVehicle(dds_entity_t participant, const Crazyswarm2Link& link, const Setup& setup,
                                   Faults& faults)
    : link_(link),
      setup_(setup),
      faults_(faults),
      body_(setup.p, setup.heading, setup.rotors),
      imu_(Imu::bmi088(), setup.seed),
      sensed_(body_.motion()),
      supervisor_(setup.arms_itself ? arms_itself | is_armed | can_fly : can_be_armed),
      radio_(monotonic_now(), packet_interval),
      ends_(std::make_unique<Ends>()) {
  const std::string& name = link.name_space;
  constexpr Quality of_rclcpp = {true, false, 10};
  ends_->pose = std::make_unique<FaultyWriter>(participant, geometry_msgs_msg_dds__PoseStamped__desc,
                                               name + "/pose", of_rclcpp, faults);
  ends_->status = std::make_unique<FaultyWriter>(participant, crazyflie_interfaces_msg_dds__Status__desc,
                                                 name + "/status", of_rclcpp, faults);
  if (!link.imu.empty())
    ends_->imu = std::make_unique<FaultyWriter>(
        participant, crazyflie_interfaces_msg_dds__LogDataGeneric__desc, link.imu, of_rclcpp, faults);
  const auto serve = [&](const ServiceType& type, const char* service, RadioPort port,
                         std::function<std::function<void()>(const void*)> packet) {
    ends_->services.push_back(
        std::make_unique<ServiceServer>(participant, type, name + service,
                                        [this, port, packet = std::move(packet)](const void* request, void*) {
                                          const std::scoped_lock lock(lock_);
                                          if (serving_ != Serving::not_at_all)
                                            radio_.send(port, packet(request));
                                          return serving_ == Serving::well;
                                        }));
  };
  serve(arm_service, "/arm", RadioPort::arming, [this](const void* request) {
    return [this, arm = static_cast<const crazyflie_interfaces_srv_dds__Arm_Request_*>(request)->arm] {
      on_arm(arm);
    };
  });
  serve(takeoff_service, "/takeoff", RadioPort::commander, [this](const void* request) {
    const auto& up = *static_cast<const crazyflie_interfaces_srv_dds__Takeoff_Request_*>(request);
    return [this, height = up.height, time = seconds_of(up.duration)] { on_takeoff(height, time); };
  });
  serve(go_to_service, "/go_to", RadioPort::commander, [this](const void* request) {
    const auto& there = *static_cast<const crazyflie_interfaces_srv_dds__GoTo_Request_*>(request);
    return [this, to = Vec3<double>{there.goal.x, there.goal.y, there.goal.z}, yaw = there.yaw,
            time = seconds_of(there.duration)] { on_go_to(to, yaw, time); };
  });
  serve(land_service, "/land", RadioPort::commander, [this](const void* request) {
    const auto& down = *static_cast<const crazyflie_interfaces_srv_dds__Land_Request_*>(request);
    return [this, height = down.height, time = seconds_of(down.duration)] { on_land(height, time); };
  });
  serve(setpoints_stop_service, "/notify_setpoints_stop", RadioPort::setpoints,
        [this](const void*) { return [this] { on_setpoints_end(); }; });
  serve(empty_service, "/emergency", RadioPort::emergency,
        [this](const void*) { return [this] { stop_motors(true); }; });
  ends_->full_state = std::make_unique<RawReader>(
      participant, crazyflie_interfaces_msg_dds__FullState__desc, name + "/cmd_full_state", of_ros_commands,
      std::nullopt, Writers::all, [this](const void* m, const Arrival&) { on_state(m); });
}

CrazyflieVehicle::~CrazyflieVehicle() = default;

TrajectoryPoint CrazyflieVehicle::here() const {
  const Motion local = in_local(setup_.origin, body_.motion());
  return {.p = local.p, .d = heading(rotation(local.q))};
}

void CrazyflieVehicle::on_state(const void* message) {
  const auto& m = *static_cast<const crazyflie_interfaces_msg_dds__FullState_*>(message);
  const std::scoped_lock lock(lock_);
  ++reported_.setpoints;
  const auto& p = m.pose.position;
  const auto& q = m.pose.orientation;
  const auto& v = m.twist.linear;
  const Motion wanted = in_G(
      setup_.origin, {{p.x, p.y, p.z}, normalised({q.w, q.x, q.y, q.z}), {v.x, v.y, v.z}, m.twist.angular.z});
  const Vec3<double> a = in_G({{}, setup_.origin.heading}, {.p = {m.acc.x, m.acc.y, m.acc.z}}).p;
  if (!is_finite(wanted) || !std::isfinite(norm(a)) || norm(wanted.p - body_.motion().p) > furthest) {
    ++reported_.bad_setpoints;
    return;
  }
  const TrajectoryPoint setpoint = {wanted.p, wanted.v, a, {}, heading(rotation(wanted.q)), wanted.r};
  radio_.send(RadioPort::setpoints,
              [this, setpoint, sent = monotonic_now()] { take_setpoint(setpoint, sent); });
}

void CrazyflieVehicle::take_setpoint(const TrajectoryPoint& setpoint, std::int64_t sent) {
  const std::int64_t now = monotonic_now();
  reported_.radio_wait = std::max(reported_.radio_wait, to_seconds(now - sent));
  if (!has(is_flying)) ++reported_.setpoints_outside;
  if (setpoints_lead_ && planner_ != Planner::stopped) ++reported_.locked_out;
  planner_ = Planner::stopped;
  setpoints_lead_ = true;
  setpoint_ = setpoint;
  setpoint_at_ = now;
}

bool CrazyflieVehicle::on_arm(bool arm) {
  reported_.arm_requests += arm ? 1 : 0;
  if (arm == has(is_armed)) return true;
  if (arm && !has(can_be_armed)) return false;
  if (arm)
    supervisor_ = is_armed, armed_at_ = monotonic_now();
  else
    disarm();
  return true;
}

void CrazyflieVehicle::disarm() {
  supervisor_ = setup_.arms_itself ? arms_itself | is_armed | can_fly : can_be_armed;
  planner_ = Planner::stopped;
  landed_at_ = 0;
}

void CrazyflieVehicle::plan(Planner planner, const Vec3<double>& to, double yaw, double duration) {
  planner_ = planner;
  plan_ = {known_, to, wrap(yaw - angle(known_.d)), seconds_now(), std::max(0.1, duration)};
}

TrajectoryPoint CrazyflieVehicle::planned() const {
  const double s = std::min(1.0, (seconds_now() - plan_.begun) / plan_.duration);
  const auto [way, rate, acceleration] = smooth_step(s);
  const Vec3<double> path = plan_.to - plan_.from.p;
  const double turned = angle(plan_.from.d) + way * plan_.turn;
  TrajectoryPoint at = plan_.from;
  at.p = at.p + way * path;
  at.v = (rate / plan_.duration) * path;
  at.a = (acceleration / square(plan_.duration)) * path;
  at.d = {std::cos(turned), std::sin(turned)};
  at.r = rate / plan_.duration * plan_.turn;
  return at;
}

void CrazyflieVehicle::on_takeoff(double height, double duration) {
  ++reported_.takeoff_requests;
  if (has(can_fly) && planner_ == Planner::stopped)
    plan(Planner::flies, {known_.p.x, known_.p.y, height}, 0.0, duration);
}

void CrazyflieVehicle::on_go_to(const Vec3<double>& to, double yaw, double duration) {
  ++reported_.go_to_requests;
  if (has(can_fly)) plan(Planner::flies, to, yaw, duration);
}

void CrazyflieVehicle::on_land(double height, double duration) {
  ++reported_.land_requests;
  if (has(can_fly) && planner_ != Planner::lands)
    plan(Planner::lands, {known_.p.x, known_.p.y, height}, 0.0, duration);
}

void CrazyflieVehicle::on_setpoints_end() {
  setpoints_lead_ = false;
  known_ = here();
}

void CrazyflieVehicle::stop_motors(bool for_good) {
  setpoints_lead_ = false;
  planner_ = Planner::stopped;
  if (for_good) supervisor_ = is_locked;
}

void CrazyflieVehicle::supervise() {
  const std::int64_t now = monotonic_now();
  if (has(is_armed) && !has(can_fly) && now - armed_at_ > arming_lasts) supervisor_ |= can_fly;
  if (runs()) {
    supervisor_ |= is_flying;
    lifted_at_ = now;
    landed_at_ = 0;
  } else if (has(is_flying) && !body_.on_ground()) {
    reported_.dropped = std::max(reported_.dropped, to_seconds(now - lifted_at_));
  }
  if (has(is_flying) && now - lifted_at_ > flying_lasts) {
    supervisor_ = static_cast<std::uint16_t>(supervisor_ & ~is_flying);
    landed_at_ = now;
  }
  if (landed_at_ > 0 && now - landed_at_ > armed_lasts) disarm();
  if (!has(is_flying) || !setpoints_lead_) return;
  const double age = to_seconds(now - setpoint_at_);
  if (now - setpoint_at_ > level_out_after && reported_.levelled_after == 0) reported_.levelled_after = age;
  if (now - setpoint_at_ > motors_off_after) {
    reported_.motors_off_after = age;
    stop_motors(true);
  }
}

void CrazyflieVehicle::follow(TrajectoryPoint to) {
  to.p.z -= sag_;
  body_.follow(to);
}

void CrazyflieVehicle::move() {
  if (!runs()) {
    body_.rest();
  } else if (!setpoints_lead_) {
    const TrajectoryPoint at = planned();
    const Motion in = in_G(setup_.origin, {at.p, upright(at.d), at.v, at.r});
    follow({in.p, in.v, at.a, {}, heading(rotation(in.q)), at.r});
  } else if (monotonic_now() - setpoint_at_ > level_out_after) {
    body_.level_out(setpoint_.p.z - sag_);
  } else {
    follow(setpoint_);
  }
  if (planner_ == Planner::stopped && has(can_fly)) known_ = here();
  if (planner_ == Planner::stopped) return;
  known_ = planned();
  if (planner_ == Planner::lands && seconds_now() - plan_.begun >= plan_.duration)
    planner_ = Planner::stopped;
}

void CrazyflieVehicle::step(std::int64_t number) {
  const std::scoped_lock lock(lock_);
  supervise();
  if (ends_->imu) send_imu();
  if (setup_.logs_pose) send_pose();  // the pose before this step
  if (number % std::llround(status_period / period) == 0) send_status();
  radio_.run(monotonic_now());
  move();
}

void CrazyflieVehicle::send_imu() {
  const Motion before = std::exchange(sensed_, body_.motion());
  const InertialSample m = imu_.measure(inertial_between(before, sensed_, period), period);
  const auto logged = [](double value, double unit, double most) {
    return static_cast<float>(std::clamp(value / unit, -most, most));
  };
  const auto turn = [&](double w) { return logged(w, crazyflie_gyro_unit, gyro_most); };
  const auto push = [&](double f) { return logged(f, gravity, acc_most); };
  const std::array<float, crazyflie_imu.size()> all = {turn(m.gyro.x),  turn(m.gyro.y),  turn(m.gyro.z),
                                                       push(m.force.x), push(m.force.y), push(m.force.z)};
  const auto values = std::make_shared<std::vector<float>>();
  for (const std::string& name : link_.imu_vars) {
    const auto* const at = std::find(crazyflie_imu.begin(), crazyflie_imu.end(), name);
    values->push_back(
        at == crazyflie_imu.end() ? 0.0F : all.at(static_cast<std::size_t>(at - crazyflie_imu.begin())));
  }
  const auto ticks = static_cast<std::uint32_t>(monotonic_now() / 1'000'000 % (1 << 24));
  radio_.log([this, values, ticks] {
    static std::array<char, 6> world = {"world"};
    crazyflie_interfaces_msg_dds__LogDataGeneric_ log{};
    log.header.stamp = stamp_of(realtime_now());
    log.header.frame_id = world.data();
    log.timestamp = ticks;
    set_sequence(log.values, *values);
    ends_->imu->write(&log, values);
  });
}

void CrazyflieVehicle::send_pose() {
  const Motion local = in_local(setup_.origin, faults_.distorted(body_.motion()));
  geometry_msgs_msg_dds__PoseStamped_ m{};
  m.pose.position = {local.p.x, local.p.y, local.p.z};
  m.pose.orientation = {local.q.x, local.q.y, local.q.z, local.q.w};
  radio_.log([this, m]() mutable {
    static std::array<char, 6> world = {"world"};
    const RosTime now = to_ros(realtime_now());  // the server stamps it
    m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
    m.header.frame_id = world.data();
    ends_->pose->write(&m);
  });
}

void CrazyflieVehicle::send_status() {
  crazyflie_interfaces_msg_dds__Status_ m{};
  const bool ended = planner_ == Planner::stopped || seconds_now() - plan_.begun >= plan_.duration;
  m.supervisor_info = static_cast<std::uint16_t>(
      supervisor_ | (planner_ == Planner::stopped ? 0 : planner_flies) | (ended ? planner_is_done : 0));
  m.battery_voltage = static_cast<float>(voltage_);
  m.pm_state = pm_state();
  radio_.log([this, m]() mutable {
    static std::array<char, 6> world = {"world"};
    const RosTime now = to_ros(realtime_now());
    m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
    m.header.frame_id = world.data();
    m.num_tx_unicast = static_cast<std::uint32_t>(radio_.sent() - std::exchange(sent_, radio_.sent()));
    m.num_rx_unicast =
        static_cast<std::uint32_t>(radio_.received() - std::exchange(received_, radio_.received()));
    m.latency_unicast = static_cast<std::uint16_t>(radio_.latency());
    if (std::exchange(has_status_, true)) ends_->status->write(&m);
  });
}

CrazyflieCounts CrazyflieVehicle::reported() const {
  const std::scoped_lock lock(lock_);
  return reported_;
}
Motion CrazyflieVehicle::motion() const {
  const std::scoped_lock lock(lock_);
  return body_.motion();
}
std::uint16_t CrazyflieVehicle::supervisor() const {
  const std::scoped_lock lock(lock_);
  return supervisor_;
}
void CrazyflieVehicle::set_voltage(double voltage) {
  const std::scoped_lock lock(lock_);
  voltage_ = voltage;
}
void CrazyflieVehicle::set_radio(int latency, double share) {
  const std::scoped_lock lock(lock_);
  radio_.set(std::int64_t{1'000'000} * latency, share);
}
void CrazyflieVehicle::serve(Serving serving) {
  const std::scoped_lock lock(lock_);
  serving_ = serving;
}
void CrazyflieVehicle::set_sag(double sag) {
  const std::scoped_lock lock(lock_);
  sag_ = sag;
}
void CrazyflieVehicle::tumble() {
  const std::scoped_lock lock(lock_);
  stop_motors(false);
  supervisor_ = is_tumbled | is_crashed;
}

std::string CrazyflieVehicle::counts() const {
  const CrazyflieCounts n = reported();
  const Motion m = motion();
  const std::uint16_t info = supervisor();
  std::string ends;
  if (n.levelled_after > 0)
    ends += fmt::format(", levelled out {:.3f} s after the last set-point", n.levelled_after);
  if (n.motors_off_after > 0) ends += fmt::format(", motors off {:.3f} s after it", n.motors_off_after);
  return fmt::format(
      "{} set-points ({} while it did not fly, {} bad), {} requests to arm, {} to take off, {} to land ({} "
      "locked "
      "out), {}, at [{:.2f}, {:.2f}, {:.2f}] m{}",
      n.setpoints, n.setpoints_outside, n.bad_setpoints, n.arm_requests, n.takeoff_requests, n.land_requests,
      n.locked_out,
      (info & is_locked) != 0   ? "locked"
      : (info & is_flying) != 0 ? "flying"
                                : "landed",
      m.p.x, m.p.y, m.p.z, ends);
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::VehicleSimulator> sightline::Crazyswarm2Link::simulator(
    const dds::SimulatorSetup& setup) const {
  return std::make_unique<dds::CrazyflieVehicle>(
      setup.participant, *this,
      dds::CrazyflieVehicle::Setup{.origin = setup.origin,
                                   .p = setup.below,
                                   .heading = setup.heading,
                                   .rotors = setup.rotors.value_or(Vehicle::crazyflie()),
                                   .logs_pose = setup.sends_poses,
                                   .seed = static_cast<std::uint64_t>(setup.robot.index) + 1},
      setup.faults);
}
