#include "bridges/dds/simulators/crazyflie_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bridges/dds/topics/service.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "crazyflie.h"
}

namespace sightline::dds {
namespace {

constexpr std::int64_t level_out_after = 500'000'000,
                       motors_off_after = 2'000'000'000;  // as in the firmware [ns]
constexpr std::int64_t flying_lasts = 2'000'000'000;      // after the motors last lifted [ns]
constexpr double status_period = 0.1;                     // [s]
constexpr double furthest = 2.0;                          // distance of a set-point from the vehicle [m]
constexpr double up_to_ground = 0.1;                      // height below which a landing ends [m]

double seconds_of(const builtin_interfaces_msg_dds__Duration_& d) { return d.sec + 1e-9 * d.nanosec; }
double seconds_now() { return 1e-9 * static_cast<double>(monotonic_now()); }

}  // namespace

struct CrazyflieVehicle::Ends {
  std::unique_ptr<FaultyWriter> pose, status;
  std::vector<std::unique_ptr<ServiceServer>> services;
  std::unique_ptr<RawReader> full_state;
};

CrazyflieVehicle::CrazyflieVehicle(dds_entity_t participant, const Crazyswarm2Link& link, const Setup& setup,
                                   Faults& faults)
    : link_(link),
      setup_(setup),
      faults_(faults),
      body_(setup.p, setup.heading, setup.rotors),
      supervisor_(setup.arms_itself ? arms_itself | is_armed | can_fly : can_be_armed),
      ends_(std::make_unique<Ends>()) {
  const std::string& name = link.name_space;
  constexpr Quality of_rclcpp = {true, false, 10};
  ends_->pose = std::make_unique<FaultyWriter>(participant, geometry_msgs_msg_dds__PoseStamped__desc,
                                               name + "/pose", of_rclcpp, faults);
  ends_->status = std::make_unique<FaultyWriter>(participant, crazyflie_interfaces_msg_dds__Status__desc,
                                                 name + "/status", of_rclcpp, faults);
  const auto serve = [&](const ServiceType& type, const char* service, std::function<void(const void*)> act) {
    ends_->services.push_back(std::make_unique<ServiceServer>(
        participant, type, name + service, [this, act = std::move(act)](const void* request, void*) {
          const std::scoped_lock lock(lock_);
          if (serving_ != Serving::not_at_all) act(request);
          return serving_ == Serving::well;
        }));
  };
  serve(arm_service, "/arm", [this](const void* request) {
    on_arm(static_cast<const crazyflie_interfaces_srv_dds__Arm_Request_*>(request)->arm);
  });
  serve(takeoff_service, "/takeoff", [this](const void* request) {
    const auto& up = *static_cast<const crazyflie_interfaces_srv_dds__Takeoff_Request_*>(request);
    on_takeoff(up.height, seconds_of(up.duration));
  });
  serve(land_service, "/land", [this](const void* request) {
    const auto& down = *static_cast<const crazyflie_interfaces_srv_dds__Land_Request_*>(request);
    on_land(down.height, seconds_of(down.duration));
  });
  serve(setpoints_stop_service, "/notify_setpoints_stop", [this](const void*) { on_setpoints_end(); });
  serve(empty_service, "/emergency", [this](const void*) { stop_motors(true); });
  ends_->full_state = std::make_unique<RawReader>(
      participant, crazyflie_interfaces_msg_dds__FullState__desc, name + "/cmd_full_state", of_ros_commands,
      std::nullopt, Writers::all, [this](const void* m, const Arrival&) { on_state(m); });
}

CrazyflieVehicle::~CrazyflieVehicle() = default;

void CrazyflieVehicle::on_state(const void* message) {
  const auto& m = *static_cast<const crazyflie_interfaces_msg_dds__FullState_*>(message);
  const std::scoped_lock lock(lock_);
  ++reported_.setpoints;
  if (!has(is_flying)) ++reported_.setpoints_outside;
  const std::int64_t now = monotonic_now(), sent_from = std::max(radio_free_, now);
  reported_.radio_wait = std::max(reported_.radio_wait, 1e-9 * static_cast<double>(sent_from - now));
  radio_free_ = sent_from + std::int64_t{1'000'000} * latency_;
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
  setpoint_ = {wanted.p, wanted.v, a, {}, heading(rotation(wanted.q)), wanted.r};
  setpoint_at_ = monotonic_now();
  commander_ = Commander::others;
}

bool CrazyflieVehicle::on_arm(bool arm) {
  reported_.arm_requests += arm ? 1 : 0;
  if (arm ? has(can_be_armed) : !has(is_flying)) {
    supervisor_ = static_cast<std::uint16_t>(arm ? is_armed | can_fly : can_be_armed);
    return true;
  }
  return false;
}

void CrazyflieVehicle::plan(double height, double duration) {
  const Vec3<double>& p = body_.motion().p;
  plan_ = {p.z, height + setup_.origin.p.z, seconds_now(), std::max(0.1, duration), {p.x, p.y}};
  commander_ = Commander::plan;
  setpoint_at_ = monotonic_now();
}

void CrazyflieVehicle::on_takeoff(double height, double duration) {
  ++reported_.takeoff_requests;
  if (commander_ == Commander::others) ++reported_.locked_out;
  if (commander_ == Commander::others || !has(can_fly) || pm_state() != on_battery) return;
  lands_ = false;
  plan(height, duration);
}

void CrazyflieVehicle::on_land(double height, double duration) {
  ++reported_.land_requests;
  if (commander_ == Commander::others) ++reported_.locked_out;
  if (commander_ == Commander::others || !has(is_flying)) return;
  lands_ = true;
  plan(height, duration);
}

void CrazyflieVehicle::on_setpoints_end() {
  if (commander_ == Commander::others) commander_ = Commander::ended;
}

void CrazyflieVehicle::stop_motors(bool for_good) {
  commander_ = Commander::stopped;
  lands_ = false;
  if (for_good) supervisor_ = is_locked;
}

void CrazyflieVehicle::supervise() {
  const std::int64_t now = monotonic_now();
  if (commander_ != Commander::stopped && has(can_fly)) {
    supervisor_ |= is_flying;
    lifted_at_ = now;
  }
  // As in the firmware: the motors stop at the end of a landing; is_flying clears and it disarms
  // only later.
  if (has(is_flying) && commander_ == Commander::stopped && body_.on_ground() &&
      now - lifted_at_ > flying_lasts)
    supervisor_ = setup_.arms_itself ? arms_itself | is_armed | can_fly : can_be_armed;
  if (!has(is_flying) || commander_ == Commander::plan || body_.on_ground()) return;
  const double age = 1e-9 * static_cast<double>(now - setpoint_at_);
  if (now - setpoint_at_ > level_out_after && reported_.levelled_after == 0) reported_.levelled_after = age;
  if (now - setpoint_at_ > motors_off_after) {
    reported_.motors_off_after = age;
    stop_motors(true);
  }
}

void CrazyflieVehicle::move() {
  const Motion& m = body_.motion();
  if (!has(can_fly) || commander_ == Commander::stopped) {
    body_.rest();
    return;
  }
  if (commander_ == Commander::plan) {
    const double s = std::min(1.0, (seconds_now() - plan_.begun) / plan_.duration);
    const double way = s * s * s * (10 + s * (-15 + 6 * s)),
                 rate = 30 * s * s * (1 - s) * (1 - s) / plan_.duration;
    const double z = plan_.from + way * (plan_.to - plan_.from), v_z = rate * (plan_.to - plan_.from);
    setpoint_at_ = monotonic_now();
    if (lands_ && s >= 1 && m.p.z < plan_.to + up_to_ground) {
      stop_motors(false);
      lifted_at_ = monotonic_now();
    }
    body_.follow({{plan_.p.x, plan_.p.y, z}, {0, 0, v_z}, {}, {}, heading(rotation(m.q)), 0.0});
    return;
  }
  if (monotonic_now() - setpoint_at_ > level_out_after) {
    body_.level_out(setpoint_.p.z);
    return;
  }
  body_.follow(setpoint_);
}

void CrazyflieVehicle::step(std::int64_t number) {
  const std::scoped_lock lock(lock_);
  supervise();
  send_pose();  // the pose before this step, stamped now
  move();
  if (number % std::llround(status_period / period) == 0) send_status();
}

void CrazyflieVehicle::send_pose() {
  const Motion local = in_local(setup_.origin, faults_.distorted(body_.motion()));
  static std::array<char, 6> world = {"world"};
  const RosTime now = to_ros(realtime_now());
  geometry_msgs_msg_dds__PoseStamped_ m{};
  m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
  m.header.frame_id = world.data();
  m.pose.position = {local.p.x, local.p.y, local.p.z};
  m.pose.orientation = {local.q.x, local.q.y, local.q.z, local.q.w};
  ends_->pose->write(&m);
}

void CrazyflieVehicle::send_status() {
  static std::array<char, 6> world = {"world"};
  const RosTime now = to_ros(realtime_now());
  crazyflie_interfaces_msg_dds__Status_ m{};
  m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
  m.header.frame_id = world.data();
  m.supervisor_info = supervisor_;
  m.battery_voltage = static_cast<float>(voltage_);
  m.pm_state = pm_state();
  const std::int64_t waits = std::max<std::int64_t>(radio_free_ - monotonic_now(), 0) / 1'000'000;
  m.latency_unicast = static_cast<std::uint16_t>(std::min<std::int64_t>(latency_ + waits, 10'000));
  m.num_tx_unicast = static_cast<std::uint32_t>(1e3 * status_period / latency_);
  m.num_rx_unicast = static_cast<std::uint32_t>(share_ * m.num_tx_unicast);
  ends_->status->write(&m);
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
  latency_ = latency, share_ = share;
}
void CrazyflieVehicle::serve(Serving serving) {
  const std::scoped_lock lock(lock_);
  serving_ = serving;
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
                                   .rotors = setup.rotors.value_or(Vehicle::crazyflie())},
      setup.faults);
}
