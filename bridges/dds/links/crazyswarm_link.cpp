#include "bridges/dds/links/crazyswarm_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bridges/dds/links/flatness.hpp"
#include "bridges/dds/topics/seen_poses.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "crazyflie.h"
}

namespace sightline::dds {
namespace {

constexpr Nanoseconds pose_old = one_second / 2, supervisor_old = 5 * one_second / 2;
constexpr Nanoseconds landing_step_most = 50'000'000;  // timeout of an answer, beside the latency
constexpr int latency_waited_most = 50;                // [ms]
constexpr Nanoseconds planned_within = 300'000'000;    // from the last request to the status with its effect
constexpr double landed_height = 0.15;                 // up to which it is not requested to land again [m]
constexpr Nanoseconds planner_learns = 60'000'000;     // where the vehicle is, once it may fly
constexpr int looks_least = 5;                         // discovery checks required, at 5 Hz
constexpr Nanoseconds takeoff_patience = 2 * one_second;
constexpr std::uint32_t remain_valid = 100;         // [ms]; new firmware ignores it
constexpr double setpoints_apart_most = 0.1;        // [s]
constexpr double setpoints_most = 0.9;              // share of the packets that the radio carries
constexpr double draining = 0.7;                    // of the radio, while packets wait for it
constexpr double rate_mean = 0.3;                   // [s]
constexpr int late_after = 300;                     // latency of poses [ms]
constexpr double packets_least = 20, lately = 1.0;  // for the comparison of logs, [s]
constexpr double logs_most = 0.95;                  // share of the packets
constexpr double stray_most = 0.5;                  // beside its start, before the task [m]
constexpr double arriving_least = 0.9;              // share of the unicast packets
constexpr double landing_pace = 0.3;                // [m/s]
constexpr double landing_time_least = 1.0;          // [s]
constexpr double touchdown_height = 0.02;           // above the ground, where the motors stop [m]
constexpr double descended = 0.1, at_height = 0.1;  // [m]
constexpr double sagging_least = 0.5;               // share of the height, once its take-off has ended
constexpr double turned_most = 0.1;                 // after its take-off [rad]
constexpr double turning_pace = 0.8;                // mean [rad/s]
constexpr double turning_time_least = 0.5;          // [s]
constexpr int turns_most = 2;                       // requests to turn back
constexpr std::array<const char*, 4> other_setpoints = {"/cmd_hover", "/cmd_velocity_world", "/cmd_position",
                                                        "/cmd_vel_legacy"};

builtin_interfaces_msg_dds__Duration_ ros_duration(double seconds) {
  const RosTime time = to_ros(to_nanoseconds(seconds));
  return {time.sec, time.nanosec};
}

geometry_msgs_msg_dds__Vector3_ vector3(const Vec3<double>& a) { return {a.x, a.y, a.z}; }

}  // namespace

int periods_of_setpoint(int latency, double rate, double period) noexcept {
  const double most = std::max(1.0, setpoints_apart_most / period),
               apart = rate > 0 ? 1 / (setpoints_most * rate) : 1e-3 * latency;
  return static_cast<int>(std::clamp(std::ceil(apart / period), 1.0, most));
}

int periods_of_setpoint_in_flight(int each, double rate, double period) noexcept {
  if (rate <= 0 || setpoints_most * rate * period * each >= 1) return each;
  return std::max(each, periods_of_setpoint(0, draining * rate, period));
}

bool poses_are_late(int latency, double packets, double logs) noexcept {
  return latency > late_after || (packets >= packets_least && logs > logs_most * packets);
}

CrazyswarmLinkEnd::CrazyswarmLinkEnd(Port participant, const Link& link, double period, Inertial inertial)
    : crazyflie_(std::get<Crazyswarm2Link>(link.kind)),
      from_(link.poses),
      origin_(link.origin),
      period_(period),
      full_state_(std::make_unique<RawWriter>(participant, crazyflie_interfaces_msg_dds__FullState__desc,
                                              crazyflie_.name_space + "/cmd_full_state", of_ros_commands)),
      takeoff_(participant, takeoff_service, crazyflie_.name_space + "/takeoff"),
      land_(participant, land_service, crazyflie_.name_space + "/land"),
      go_to_(participant, go_to_service, crazyflie_.name_space + "/go_to"),
      arm_(participant, arm_service, crazyflie_.name_space + "/arm"),
      setpoints_stop_(participant, setpoints_stop_service, crazyflie_.name_space + "/notify_setpoints_stop"),
      emergency_(participant, empty_service, crazyflie_.name_space + "/emergency"),
      poses_(link.origin),
      inertial_(inertial == Inertial::read ? std::make_unique<InertialSamples>(InertialSamples::longest)
                                           : nullptr) {
  if (inertial_) read_inertial(participant);
  if (from_.estimated()) poses_.keep_each(kept_motions);
  if (from_.by_others())
    read_seen_poses(poses_, participant, from_, Attitude::needed);
  else
    read_pose_stamped(poses_, participant, crazyflie_.name_space + "/pose", "", Attitude::needed);
  status_reader_ = std::make_unique<RawReader>(
      participant, crazyflie_interfaces_msg_dds__Status__desc, crazyflie_.name_space + "/status", of_sensors,
      std::nullopt, Writers::all,
      [this](const void* message, const Arrival& arrival) { on_status(message, arrival.monotonic); });
}

/// The server stamps logs as they arrive, poses and measurements in any order: a measurement holds
/// until the next one.
void CrazyswarmLinkEnd::read_inertial(Port participant) {
  std::array<std::size_t, crazyflie_imu.size()> places{};
  const std::vector<std::string>& vars = crazyflie_.imu_vars;
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] =
        static_cast<std::size_t>(std::find(vars.begin(), vars.end(), crazyflie_imu[i]) - vars.begin());
  const auto take = [this, places, count = vars.size()](const void* message, const Arrival& arrival) {
    const auto& m = *static_cast<const crazyflie_interfaces_msg_dds__LogDataGeneric_*>(message);
    if (m.values._length != count) {
      ++other_logs_;
      return;
    }
    const auto axes = [&](std::size_t first) {
      const auto value = [&](std::size_t i) { return double{m.values._buffer[places[first + i]]}; };
      return Vec3<double>{value(0), value(1), value(2)};
    };
    const auto& stamp = m.header.stamp;
    inertial_->put({of_ros(stamp.sec, stamp.nanosec), crazyflie_gyro_unit * axes(0), gravity * axes(3)},
                   arrival.monotonic);
  };
  inertial_reader_ =
      std::make_unique<RawReader>(participant, crazyflie_interfaces_msg_dds__LogDataGeneric__desc,
                                  crazyflie_.imu, Quality{.depth = 8}, std::nullopt, Writers::first, take);
}

// The server counts packets from one status to the next.
void CrazyswarmLinkEnd::on_status(const void* message, Nanoseconds arrived) {
  const auto& m = *static_cast<const crazyflie_interfaces_msg_dds__Status_*>(message);
  Status& s = taken_;
  const std::int64_t others = (from_.by_others() ? 0 : poses_.reader().counts().received.load()) +
                              (inertial_reader_ ? inertial_reader_->counts().received.load() : 0);
  if (s.first == 0) {
    s.first = arrived;
  } else {
    s.sent += m.num_tx_unicast, s.received += m.num_rx_unicast;
    const double seconds = to_seconds(arrived - s.arrived),
                 packets =
                     m.num_rx_unicast > 0 ? std::min(m.num_tx_unicast, m.num_rx_unicast) : m.num_tx_unicast,
                 part = s.rate > 0 ? std::min(1.0, seconds / rate_mean) : 1.0,
                 kept = std::exp(-seconds / lately);
    if (seconds > 0) s.rate += part * (packets / seconds - s.rate);
    s.packets_lately = kept * s.packets_lately + packets;
    s.logs_lately = kept * s.logs_lately + 1 + static_cast<double>(others - s.others);
  }
  s.others = others;
  s.arrived = arrived, s.supervisor = m.supervisor_info, s.pm_state = m.pm_state;
  s.voltage = m.battery_voltage, s.latency = m.latency_unicast;
  status_.put(s);
}

bool CrazyswarmLinkEnd::are_poses_late() const noexcept {
  const Status& s = last_status_;
  if (from_.by_others()) return phase_ == Phase::ground && s.latency > late_after;  // its status is late
  return poses_are_late(s.latency, s.packets_lately, s.logs_lately);
}

/// A set-point that waited for the radio may end the landing, which the planner's bit shows: then
/// it must be requested again, before the firmware stops the motors.
bool CrazyswarmLinkEnd::lands() noexcept {
  if (landing_ != Landing::requested) return false;
  if (!has(is_flying)) return true;
  const bool known = land_.answer() == Answer::accepted || height() < land_from_ - descended;
  return known && (!tells_planner_ || has(planner_flies) || height() < landed_height ||
                   last_status_.arrived < landing_since_ + planned_within);
}

/// One that is heavier than its controller assumes hovers below the height of its take-off.
bool CrazyswarmLinkEnd::is_up() noexcept {
  const bool ended = has(planner_flies) && has(planner_is_done);
  return height() >
         (ended ? sagging_least * crazyflie_.takeoff_height : crazyflie_.takeoff_height - at_height);
}

/// Angle from the heading before its take-off [rad].
double CrazyswarmLinkEnd::turned() noexcept {
  const Vec2<double> was = heading(rotation(left_.q)), is = heading(rotation(poses_.newest().motion.q)),
                     by = rotate<double>({was.x, -was.y}, is);
  return std::abs(std::atan2(by.y, by.x));
}

LinkReason CrazyswarmLinkEnd::unfit() noexcept {
  // In flight the firmware's low-battery state decides, because the voltage sags with each thrust
  // peak.
  if (last_status_.pm_state >= battery_low) return LinkReason::battery_low;
  if (are_poses_late()) return LinkReason::late;
  const Vec3<double>& p = poses_.newest().motion.p;
  const bool strayed = phase_ == Phase::takeoff && norm(p.x - left_.p.x, p.y - left_.p.y) > stray_most;
  return strayed ? LinkReason::strayed : LinkReason::as_requested;
}

LinkFacts CrazyswarmLinkEnd::facts(Nanoseconds now) noexcept {
  (void)status_.look(last_status_);
  each_ = phase_ < Phase::setpoints ? periods_of_setpoint(last_status_.latency, last_status_.rate, period_)
                                    : periods_of_setpoint_in_flight(each_, last_status_.rate, period_);
  if (!has(can_fly))
    may_fly_since_ = 0;
  else if (may_fly_since_ == 0)
    may_fly_since_ = now;
  const bool flies = has(is_flying);
  down_ = down_ || (landing_ == Landing::requested && !flies);
  LinkFacts facts;
  facts.there = poses_.is_fresh(now, pose_old) && now - last_status_.arrived < supervisor_old;
  // A self-arming firmware is armed on the ground, too; it counts as armed only from our request to
  // its landing.
  facts.armed = has(is_armed) && (!has(arms_itself) || (phase_ != Phase::ground && !down_));
  // Its planner takes off from where it last knew the vehicle, and learns it only while it may fly.
  if (phase_ == Phase::arming && (may_fly_since_ == 0 || now - may_fly_since_ < planner_learns))
    facts.armed = false;
  facts.landed = !flies;
  const bool may_arm = has(arms_itself) ? has(can_fly) : has(can_be_armed);
  facts.checked = received_ && may_arm && !flies && battery_is_good() && !poses_.of_second_writer() &&
                  !poses_.in_other_frames() && (arm_.there() || has(arms_itself)) && !are_poses_late();
  facts.contested = rivals_ > 0;
  facts.restarted = speakers_ >= 0 && status_reader_->writers_came() > speakers_;
  facts.failsafe = has(is_tumbled) || has(is_locked) || has(is_crashed);
  facts.unfit = unfit();
  const double seconds = to_seconds(now - requested_at_);
  const bool hovers = flies && phase_ >= Phase::takeoff && is_up() &&
                      (phase_ != Phase::takeoff || seconds > crazyflie_.takeoff_time);
  turns_back_ = hovers && phase_ == Phase::takeoff && turned() > turned_most &&
                (turns_ < turns_most || now < turned_at_);
  facts.airborne = hovers && !turns_back_;
  facts.refused =
      phase_ == Phase::takeoff && !flies && seconds > crazyflie_.takeoff_time + to_seconds(takeoff_patience);
  tells_planner_ = tells_planner_ || (phase_ == Phase::takeoff && has(planner_flies));
  facts.mode = phase_ == Phase::takeoff  ? AutopilotMode::takeoff
               : lands()                 ? AutopilotMode::land
               : phase_ > Phase::takeoff ? AutopilotMode::offboard
                                         : AutopilotMode::other;
  return facts;
}

void CrazyswarmLinkEnd::request(Request request, Nanoseconds now) noexcept {
  if (request != Request::none) requested_at_ = now;
  switch (request) {
    case Request::none:
    case Request::hold:
    case Request::origin:
      break;
    case Request::arm: {
      speakers_ = status_reader_->writers_came();
      phase_ = Phase::arming;
      left_ = poses_.newest().motion;
      turns_ = 0;
      const crazyflie_interfaces_srv_dds__Arm_Request_ arm{true};
      if (!has(arms_itself)) (void)arm_.call(&arm);
      break;
    }
    case Request::take_off: {
      phase_ = Phase::takeoff;
      const crazyflie_interfaces_srv_dds__Takeoff_Request_ up{
          0, static_cast<float>(crazyflie_.takeoff_height), ros_duration(crazyflie_.takeoff_time)};
      (void)takeoff_.call(&up);
      break;
    }
    case Request::offboard:
      phase_ = Phase::setpoints;
      break;
    case Request::emergency: {
      landing_ = Landing::none;
      const std_srvs_srv_dds__Empty_Request_ stop{};
      (void)emergency_.call(&stop);
      break;
    }
    case Request::land: {
      if (landing_ == Landing::none) land_from_ = height();
      phase_ = Phase::landing;
      landing_ = Landing::last_setpoint;
      landing_since_ = now;
      break;
    }
  }
}

void CrazyswarmLinkEnd::land() noexcept {
  const double time = std::max(landing_time_least, height() / landing_pace);
  const crazyflie_interfaces_srv_dds__Land_Request_ down{0, static_cast<float>(touchdown_height),
                                                         ros_duration(time)};
  (void)land_.call(&down);
}

/// A take-off of the server ends at heading 0 of its frame. From there it turns to the heading
/// before, at one place.
void CrazyswarmLinkEnd::turn_back(Nanoseconds now) noexcept {
  if (!turns_back_ || phase_ != Phase::takeoff || now < turned_at_) return;
  ++turns_;
  const double time = std::max(turning_time_least, turned() / turning_pace);
  turned_at_ = now + to_nanoseconds(time) + landing_step_most;
  const Motion to = in_local(origin_, left_);
  const Vec2<double> d = heading(rotation(to.q));
  const crazyflie_interfaces_srv_dds__GoTo_Request_ back{0,
                                                         false,
                                                         {to.p.x, to.p.y, crazyflie_.takeoff_height},
                                                         static_cast<float>(std::atan2(d.y, d.x)),
                                                         ros_duration(time)};
  (void)go_to_.call(&back);
}

/// The server may execute requests out of order, and its radio sends the end of set-points before a
/// landing. So each request waits for the answer to the one before, and for the radio. A vehicle
/// that never flew is disarmed.
void CrazyswarmLinkEnd::go_on_landing(Nanoseconds now) noexcept {
  const bool answered = last_status_.arrived > requested_at_;
  if (landing_ == Landing::requested && answered && !has(is_flying) && has(is_armed) && !has(arms_itself) &&
      !std::exchange(disarms_, true)) {
    const crazyflie_interfaces_srv_dds__Arm_Request_ disarm{false};
    (void)arm_.call(&disarm);
  }
  const Nanoseconds waited = now - landing_since_,
                    radio = Nanoseconds{1'000'000} * std::min(last_status_.latency, latency_waited_most);
  const auto done = [&](const ServiceCaller& caller) {
    return waited >= landing_step_most + radio || (caller.answer() != Answer::none && waited >= radio);
  };
  const auto next = [&](Landing step) { landing_ = step, landing_since_ = now; };
  switch (landing_) {
    case Landing::none:
    case Landing::requested:
      break;
    case Landing::last_setpoint:
      if (waited < radio) break;
      next(Landing::planned);
      land();
      break;
    case Landing::planned: {
      if (!done(land_)) break;
      next(Landing::setpoints_end);
      const crazyflie_interfaces_srv_dds__NotifySetpointsStop_Request_ end{0, remain_valid};
      (void)setpoints_stop_.call(&end);
      break;
    }
    case Landing::setpoints_end:
      if (!done(setpoints_stop_)) break;
      next(Landing::requested);
      land();
      break;
  }
}

void CrazyswarmLinkEnd::send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept {
  request(output.request, now);
  if (landing_ != Landing::requested && !output.heartbeat)
    landing_ = Landing::none;  // it has left our control
  turn_back(now);
  go_on_landing(now);
  // A set-point after the land request would end the landing.
  if (output.setpoint == Setpoint::none || phase_ != Phase::setpoints || --wait_ > 0) return;
  wait_ = each_;
  if (output.setpoint == Setpoint::task) {
    holds_ = false;
    send_state(command.lead);
    return;
  }
  if (!std::exchange(holds_, true)) {
    const Motion& m = poses_.newest().motion;
    hold_ = {.p = m.p, .d = heading(rotation(m.q))};
  }
  send_state(hold_);
}

void CrazyswarmLinkEnd::send_state(const TrajectoryPoint& point) noexcept {
  const FlatAttitude flat = flat_attitude(point.a, point.j, point.d, point.r);
  const Motion local = in_local(origin_, {point.p, flat.q, point.v, 0.0});
  const Vec3<double> a = in_local({{}, origin_.heading}, Motion{.p = point.a}).p;
  static std::array<char, 6> world = {"world"};
  crazyflie_interfaces_msg_dds__FullState_ m{};
  const RosTime now = to_ros(realtime_now());
  m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
  m.header.frame_id = world.data();
  m.pose.position = {local.p.x, local.p.y, local.p.z};
  m.pose.orientation = {local.q.x, local.q.y, local.q.z, local.q.w};
  m.twist.linear = vector3(local.v);
  m.twist.angular = vector3(flat.w);
  m.acc = vector3(a);
  (void)full_state_->write(&m);
}

void CrazyswarmLinkEnd::watch(std::span<const SeenWriter> writers) {
  for (ServiceCaller* caller : {&takeoff_, &land_, &go_to_, &arm_, &setpoints_stop_, &emergency_})
    caller->watch(writers);
  // By then, discovery has found the other writers.
  const bool here = full_state_->matched() > 0 && takeoff_.there() && land_.there() && go_to_.there() &&
                    setpoints_stop_.there();
  looks_ = here ? looks_ + 1 : 0;
  received_ = looks_ > looks_least;
  int others = full_state_->rivals(writers);
  for (const char* topic : other_setpoints) {
    const std::string name = wire_topic(crazyflie_.name_space + topic);
    others += static_cast<int>(
        std::count_if(writers.begin(), writers.end(), [&](const SeenWriter& w) { return w.topic == name; }));
  }
  rivals_ = others;
}

void CrazyswarmLinkEnd::examine_battery(FindingList& to) const {
  const Status& s = last_status_;
  if (s.pm_state != on_battery)
    to.add(Aspect::battery, Light::red, "its power is in state {}, expected 0: {}", s.pm_state,
           s.pm_state == battery_low ? "the battery is low" : "off the charger");
  if (s.voltage < crazyflie_.battery_min)
    to.add(Aspect::battery, Light::red, "its battery has {:.2f} V, expected {} V", s.voltage,
           crazyflie_.battery_min);
  to.add_green(Aspect::battery, "{:.2f} V", s.voltage);
}

void CrazyswarmLinkEnd::examine_radio(FindingList& to) const {
  const Status& s = last_status_;
  if (s.latency == 0 || s.sent == 0) {
    to.add(Aspect::radio, Light::unknown, "its status counts no unicast packets, or has no latency of them");
    return;
  }
  const double rate = static_cast<double>(s.sent) / to_seconds(s.arrived - s.first),
               share = static_cast<double>(s.received) / static_cast<double>(s.sent);
  const bool lossy = s.received > 0 && share < arriving_least;
  const std::string figures =
      fmt::format("{:.0f} unicast packets a second{}, latency {} ms", rate,
                  s.received > 0 ? fmt::format(", of which {:.0f} % arrive", 100 * share) : "", s.latency);
  if (each_ > 1)
    to.add(Aspect::radio, Light::red,
           "{}, expected {:.0f} packets at least: it receives a set-point each {} periods; set "
           "horizon.period = {:g} s, or have fewer Crazyflies on a radio",
           figures, std::ceil(1 / (setpoints_most * period_)), each_.load(), each_ * period_);
  else if (lossy)
    to.add(Aspect::radio, Light::red,
           "{}, expected {:.0f} % at least: set a greater horizon.period or another channel", figures,
           100 * arriving_least);
  else
    to.add_green(Aspect::radio, "{}", figures);
}

void CrazyswarmLinkEnd::examine(const Surroundings& around, FindingList& to) {
  const Nanoseconds now = monotonic_now();
  const LinkFacts f = facts(now);
  const auto examine_reader = [&](const RawReader& reader, bool is_young) {
    if (reader.counts().received == 0)
      to.add(Aspect::topics, Light::red, "{}: no message, {}: is this log of the Crazyflie switched on?",
             reader.topic(), why_nothing_comes(reader, around));
    else if (!is_young)
      to.add(Aspect::topics, Light::red, "{}: its messages ceased", reader.topic());
  };
  examine_reader(poses_.reader(), poses_.is_fresh(now, pose_old));
  examine_reader(*status_reader_, now - last_status_.arrived < supervisor_old);
  if (inertial_) {
    const std::int64_t other = other_logs_;
    examine_inertial(*inertial_, *inertial_reader_,
                     other > 0 ? fmt::format("{} logs have not {} values, as imu_vars has", other,
                                             crazyflie_.imu_vars.size())
                               : "they ceased",
                     around, to);
  }
  if (!full_state_->received(around.readers))
    to.add(Aspect::topics, Light::red, "{}: {}", full_state_->topic(), why_stale(*full_state_, around));
  const bool known = status_.count() > 0;
  for (const ServiceCaller* caller : {&takeoff_, &land_, &go_to_, &setpoints_stop_, &arm_})
    if (!caller->there() && (caller != &arm_ || (known && !has(arms_itself))))
      to.add(Aspect::topics, Light::red, "{}: no server", caller->service());
  if (known && are_poses_late())
    to.add(Aspect::topics, Light::red,
           "its logs are late: {:.0f} of {:.0f} packets of its radio have one, latency {} ms: lower the "
           "frequency of the pose in crazyflies.yaml, have fewer Crazyflies on a radio, or take poses of "
           "motion capture without this log",
           last_status_.logs_lately, last_status_.packets_lately, last_status_.latency);
  to.add_green(Aspect::topics, "pose and status arrive, it receives set-points, its services are there");
  poses_.examine("the frame that is G", "other frames", to);
  for (const SeenWriter& writer : around.writers)
    if (writer.topic.starts_with(wire_topic(crazyflie_.name_space + "/cmd_")) &&
        (writer.topic != full_state_->topic() || full_state_->rivals(std::span(&writer, 1)) > 0))
      to.add(Aspect::writers, Light::red, "{}: another program writes set-points", writer.topic);
  to.add_green(Aspect::writers, "no other program publishes in its place or steers it");
  if (!known) return;
  examine_battery(to);
  examine_radio(to);
  const bool may_arm = has(arms_itself) ? has(can_fly) : has(can_be_armed);
  if (f.failsafe)
    to.add(Aspect::checks, Light::red, "it has {}",
           has(is_tumbled)   ? "tumbled"
           : has(is_crashed) ? "crashed"
                             : "locked itself: start it anew");
  else if (!may_arm && !f.armed)
    to.add(Aspect::checks, Light::red, "its own checks before a flight do not pass");
  to.add_green(Aspect::checks, "its own checks before a flight pass");
  if (f.armed) to.add(Aspect::state, Light::red, "it is armed already");
  if (has(is_flying)) to.add(Aspect::state, Light::red, "it flies already");
  to.add_green(Aspect::state, "on the ground");
}

std::string CrazyswarmLinkEnd::counts() const {
  std::string words = fmt::format("{}, {} of its status, a set-point each {} periods", poses_.counts(),
                                  status_reader_->counts().received.load(), each_.load());
  if (inertial_)
    words +=
        fmt::format(", {} measurements of its IMU, {} not finite, {} with another number of values",
                    inertial_reader_->counts().received.load(), inertial_->not_finite(), other_logs_.load());
  return words;
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::LinkEnd> sightline::Crazyswarm2Link::end(const dds::EndSetup& setup) const {
  if (setup.model.rolls())
    throw std::invalid_argument(fmt::format(
        "agent.{}.link.kind = crazyswarm2, behind which a {} does not drive, expected a robot that flies",
        setup.name, setup.model.name()));
  return std::make_unique<dds::CrazyswarmLinkEnd>(
      setup.at, setup.link, setup.period,
      setup.inertial && !imu.empty() ? dds::Inertial::read : dds::Inertial::unread);
}
