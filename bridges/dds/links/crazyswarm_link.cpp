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

constexpr Nanoseconds crazyflie_second = 1'000'000'000;
constexpr Nanoseconds pose_old = crazyflie_second / 2, supervisor_old = 5 * crazyflie_second / 2;
constexpr Nanoseconds setpoints_end_most = 50'000'000;  // timeout of the stop answer
constexpr int looks_least = 5;                          // discovery checks required, at 5 Hz
constexpr Nanoseconds takeoff_patience = 2 * crazyflie_second;
constexpr std::uint32_t remain_valid = 100;         // [ms]; new firmware ignores it
constexpr double setpoints_apart_most = 0.1;        // [s]
constexpr double same_period = 0.1;                 // part of a period, for jitter of the status
constexpr double arriving_least = 0.9;              // share of the unicast packets
constexpr double landing_pace = 0.3;                // [m/s]
constexpr double landing_time_least = 1.0;          // [s]
constexpr double touchdown_height = 0.02;           // above the ground, where the motors stop [m]
constexpr double descended = 0.1, at_height = 0.1;  // [m]
constexpr std::array<const char*, 4> other_setpoints = {"/cmd_hover", "/cmd_velocity_world", "/cmd_position",
                                                        "/cmd_vel_legacy"};

builtin_interfaces_msg_dds__Duration_ ros_duration(double seconds) {
  const RosTime time = to_ros(std::llround(1e9 * seconds));
  return {time.sec, time.nanosec};
}

geometry_msgs_msg_dds__Vector3_ vector3(const Vec3<double>& a) { return {a.x, a.y, a.z}; }

}  // namespace

int periods_of_setpoint(int latency, double rate, double period) noexcept {
  const double by_latency = 1e-3 * latency / period, by_rate = rate > 0 ? 1 / (rate * period) : by_latency,
               most = std::max(1.0, setpoints_apart_most / period);
  if (by_latency <= 1) return 1;
  return static_cast<int>(std::clamp(std::ceil(std::min(by_latency, by_rate) - same_period), 1.0, most));
}

CrazyswarmLinkEnd::CrazyswarmLinkEnd(Port participant, const Link& link, double period)
    : crazyflie_(std::get<Crazyswarm2Link>(link.kind)),
      from_(link.poses),
      origin_(link.origin),
      period_(period),
      full_state_(std::make_unique<RawWriter>(participant, crazyflie_interfaces_msg_dds__FullState__desc,
                                              crazyflie_.name_space + "/cmd_full_state", of_ros_commands)),
      takeoff_(participant, takeoff_service, crazyflie_.name_space + "/takeoff"),
      land_(participant, land_service, crazyflie_.name_space + "/land"),
      arm_(participant, arm_service, crazyflie_.name_space + "/arm"),
      setpoints_stop_(participant, setpoints_stop_service, crazyflie_.name_space + "/notify_setpoints_stop"),
      emergency_(participant, empty_service, crazyflie_.name_space + "/emergency"),
      poses_(link.origin) {
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

// The server counts packets from one status to the next.
void CrazyswarmLinkEnd::on_status(const void* message, Nanoseconds arrived) {
  const auto& m = *static_cast<const crazyflie_interfaces_msg_dds__Status_*>(message);
  Status& s = taken_;
  if (s.first == 0) {
    s.first = arrived;
  } else {
    s.sent += m.num_tx_unicast, s.received += m.num_rx_unicast;
    s.rate = m.num_tx_unicast / (1e-9 * static_cast<double>(arrived - s.arrived));
  }
  s.arrived = arrived, s.supervisor = m.supervisor_info, s.pm_state = m.pm_state;
  s.voltage = m.battery_voltage, s.latency = m.latency_unicast;
  status_.put(s);
}

LinkFacts CrazyswarmLinkEnd::facts(Nanoseconds now) noexcept {
  (void)status_.look(last_status_);
  const int needed = periods_of_setpoint(last_status_.latency, last_status_.rate, period_);
  each_ = phase_ < Phase::setpoints ? needed : std::max(each_.load(), needed);
  const bool flies = has(is_flying);
  down_ = down_ || (landing_ == Landing::requested && !flies);
  LinkFacts facts;
  facts.there = poses_.is_fresh(now, pose_old) && now - last_status_.arrived < supervisor_old;
  // A self-arming firmware is armed on the ground, too; it counts as armed only from our request to
  // its landing.
  facts.armed = has(is_armed) && (!has(arms_itself) || (phase_ != Phase::ground && !down_));
  facts.landed = !flies;
  const bool may_arm = has(arms_itself) ? has(can_fly) : has(can_be_armed);
  facts.checked = received_ && may_arm && !flies && battery_is_good() && !poses_.of_second_writer() &&
                  !poses_.in_other_frames() && (arm_.there() || has(arms_itself));
  facts.contested = rivals_ > 0;
  facts.restarted = speakers_ >= 0 && status_reader_->writers_came() > speakers_;
  facts.failsafe = has(is_tumbled) || has(is_locked) || has(is_crashed);
  // In flight the firmware's low-battery state decides, because the voltage sags with each thrust
  // peak.
  if (last_status_.pm_state >= battery_low) facts.unfit = LinkReason::battery_low;
  const double seconds = 1e-9 * static_cast<double>(now - requested_at_);
  facts.airborne = flies && phase_ >= Phase::takeoff && height() > crazyflie_.takeoff_height - at_height &&
                   (phase_ != Phase::takeoff || seconds > crazyflie_.takeoff_time);
  facts.refused = phase_ == Phase::takeoff && !flies &&
                  seconds > crazyflie_.takeoff_time + 1e-9 * static_cast<double>(takeoff_patience);
  const bool lands = landing_ == Landing::requested &&
                     (land_.answer() == Answer::accepted || height() < land_from_ - descended || !flies);
  facts.mode = phase_ == Phase::takeoff  ? AutopilotMode::takeoff
               : lands                   ? AutopilotMode::land
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
      landing_ = Landing::setpoints_end;
      const crazyflie_interfaces_srv_dds__NotifySetpointsStop_Request_ end{0, remain_valid};
      (void)setpoints_stop_.call(&end);
      break;
    }
  }
}

/// The server may execute requests out of order, so the second request waits for the answer to the
/// first. A vehicle that never flew is disarmed.
void CrazyswarmLinkEnd::go_on_landing(Nanoseconds now) noexcept {
  const bool answered = last_status_.arrived > requested_at_;
  if (landing_ == Landing::requested && answered && !has(is_flying) && has(is_armed) && !has(arms_itself) &&
      !std::exchange(disarms_, true)) {
    const crazyflie_interfaces_srv_dds__Arm_Request_ disarm{false};
    (void)arm_.call(&disarm);
  }
  if (landing_ != Landing::setpoints_end) return;
  if (setpoints_stop_.answer() == Answer::none && now - requested_at_ < setpoints_end_most) return;
  landing_ = Landing::requested;
  const double time = std::max(landing_time_least, height() / landing_pace);
  const crazyflie_interfaces_srv_dds__Land_Request_ down{0, static_cast<float>(touchdown_height),
                                                         ros_duration(time)};
  (void)land_.call(&down);
}

void CrazyswarmLinkEnd::send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept {
  request(output.request, now);
  if (landing_ == Landing::setpoints_end && !output.heartbeat)
    landing_ = Landing::none;  // it has left our control
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
  for (ServiceCaller* caller : {&takeoff_, &land_, &arm_, &setpoints_stop_, &emergency_})
    caller->watch(writers);
  // By then, discovery has found the other writers.
  const bool here =
      full_state_->matched() > 0 && takeoff_.there() && land_.there() && setpoints_stop_.there();
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
  const double rate = static_cast<double>(s.sent) / (1e-9 * static_cast<double>(s.arrived - s.first)),
               share = static_cast<double>(s.received) / static_cast<double>(s.sent);
  const bool lossy = s.received > 0 && share < arriving_least, rare = rate * period_ < 1.0;
  const std::string figures =
      fmt::format("{:.0f} unicast packets a second{}, latency {} ms", rate,
                  s.received > 0 ? fmt::format(", of which {:.0f} % arrive", 100 * share) : "", s.latency);
  if (each_ > 1)
    to.add(Aspect::radio, Light::red,
           "{}, expected {:g} ms at most: it receives a set-point each {} periods; set horizon.period = {:g} "
           "s, or have fewer Crazyflies on a radio",
           figures, 1e3 * period_, each_.load(), each_ * period_);
  else if (lossy)
    to.add(Aspect::radio, Light::red,
           "{}, expected {:.0f} % at least: set a greater horizon.period or another channel", figures,
           100 * arriving_least);
  else
    to.add(Aspect::radio, rare ? Light::unknown : Light::green, "{}{}", figures,
           rare ? fmt::format("; a set-point each period needs {:.0f}: if the radio carries no more, set a "
                              "greater horizon.period",
                              1 / period_)
                : "");
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
  if (!full_state_->received(around.readers))
    to.add(Aspect::topics, Light::red, "{}: {}", full_state_->topic(), why_stale(*full_state_, around));
  const bool known = status_.count() > 0;
  for (const ServiceCaller* caller : {&takeoff_, &land_, &setpoints_stop_, &arm_})
    if (!caller->there() && (caller != &arm_ || (known && !has(arms_itself))))
      to.add(Aspect::topics, Light::red, "{}: no server", caller->service());
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
  return fmt::format("{}, {} of its status, a set-point each {} periods", poses_.counts(),
                     status_reader_->counts().received.load(), each_.load());
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::LinkEnd> sightline::Crazyswarm2Link::end(const dds::EndSetup& setup) const {
  if (setup.model.rolls())
    throw std::invalid_argument(fmt::format(
        "agent.{}.link.kind = crazyswarm2, behind which a {} does not drive, expected a robot that flies",
        setup.name, setup.model.name()));
  return std::make_unique<dds::CrazyswarmLinkEnd>(setup.at, setup.link, setup.period);
}
