#include "bridges/dds/simulators/ros2_flyer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bridges/dds/links/ros2_flyer_link.hpp"
#include "bridges/dds/simulators/ros2_rover.hpp"
#include "sightline/base/now.hpp"
#include "sightline/model/state_roles.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

constexpr std::int64_t patience_of_flyer = 500'000'000;  // [ns]
constexpr double fastest_flyer = 10.0;                   // limit of a command [m/s]

}  // namespace

Ros2Flyer::Ros2Flyer(dds_entity_t participant, const Ros2Link& link, const Setup& setup, Faults& faults)
    : link_(link),
      setup_(setup),
      rotors_(setup.rotors.value_or(Vehicle::ar_drone())),
      body_(setup.p, setup.heading,
            link.commands == FlightCommands::normalised ? std::optional(rotors_) : setup.rotors,
            link.commands == FlightCommands::normalised ? Commands::tilt : Commands::velocity),
      odometry_(participant, link, setup.origin, faults) {
  if (!link.state.empty())
    state_writer_ = std::make_unique<FaultyWriter>(participant, std_msgs_msg_dds__Int8__desc, link.state,
                                                   of_ros_commands, faults);
  serve(participant, link.takeoff, [this] { return take_off(); });
  serve(participant, link.land, [this] { return land(); });
  const dds_topic_descriptor_t& type =
      link.stamped ? geometry_msgs_msg_dds__TwistStamped__desc : geometry_msgs_msg_dds__Twist__desc;
  readers_.push_back(std::make_unique<RawReader>(
      participant, type, link.cmd_vel, of_ros_commands, std::nullopt, Writers::all,
      [this](const void* m, const Arrival&) {
        on_twist(link_.stamped ? &static_cast<const geometry_msgs_msg_dds__TwistStamped_*>(m)->twist : m);
      }));
}

void Ros2Flyer::serve(dds_entity_t participant, const std::string& name, const std::function<bool()>& act) {
  if (link_.calls == FlightCalls::topics) {
    readers_.push_back(std::make_unique<RawReader>(participant, std_msgs_msg_dds__Empty__desc, name,
                                                   of_ros_commands, std::nullopt, Writers::all,
                                                   [this, act](const void*, const Arrival&) {
                                                     const std::scoped_lock lock(lock_);
                                                     (void)act();
                                                   }));
    return;
  }
  const bool says = link_.calls == FlightCalls::trigger;
  services_.push_back(std::make_unique<ServiceServer>(
      participant, says ? trigger_service : empty_service, name,
      [this, act, says](const void*, void* response) {
        const std::scoped_lock lock(lock_);
        const bool done = act();
        static std::array<char, 1> nothing = {};
        if (says) *static_cast<std_srvs_srv_dds__Trigger_Response_*>(response) = {done, nothing.data()};
        return true;
      }));
}

bool Ros2Flyer::take_off() {
  ++reported_.takeoffs;
  if (refuses_ || state_ != Ros2State::landed) return false;
  state_ = Ros2State::taking_off;
  return true;
}

bool Ros2Flyer::land() {
  ++reported_.landings;
  if (state_ == Ros2State::landed) return false;
  state_ = Ros2State::landing;
  return true;
}

void Ros2Flyer::on_twist(const void* twist) {
  const auto& t = *static_cast<const geometry_msgs_msg_dds__Twist_*>(twist);
  const std::scoped_lock lock(lock_);
  ++reported_.commands;
  const double size =
      std::abs(t.linear.x) + std::abs(t.linear.y) + std::abs(t.linear.z) + std::abs(t.angular.z);
  if (!(size < fastest_flyer)) {
    ++reported_.bad;
    return;
  }
  if (state_ != Ros2State::flying && size > 0) ++reported_.commands_outside;
  wanted_ = {t.linear.x, t.linear.y, t.linear.z, t.angular.z};
  commanded_at_ = monotonic_now();
}

/// Follows a velocity in G; with normalised commands, by tilt.
void Ros2Flyer::follow(const Vec3<double>& v, double r) {
  if (link_.commands == FlightCommands::velocity) return body_.follow(v, {}, r);
  const Motion& m = body_.motion();
  const Vec2<double> d = heading(rotation(m.q));
  const Vec2<double> a = rotate<double>({d.x, -d.y}, {v.x - m.v.x, v.y - m.v.y});
  const double most = gravity * std::tan(rotors_.tilt_max);
  const auto part = [](double x) { return std::clamp(x, -1.0, 1.0); };
  body_.tilt({part(a.x / most), part(-a.y / most), part(v.z / rotors_.climb_max), part(r / rotors_.yaw_max)});
}

void Ros2Flyer::step(std::int64_t number) {
  const std::scoped_lock lock(lock_);
  const Motion& m = body_.motion();
  odometry_.send(m);  // the motion before this step, stamped now
  switch (state_) {
    case Ros2State::landed:
      body_.rest();
      break;
    case Ros2State::taking_off:
      follow({0, 0, takeoff_speed(m.p.z, setup_.altitude)}, 0.0);
      if (m.p.z > setup_.altitude - 0.05) state_ = Ros2State::flying, wanted_ = {};
      break;
    case Ros2State::landing:
      follow({0, 0, landing_speed(m.p.z)}, 0.0);
      if (body_.on_ground()) state_ = Ros2State::landed;
      break;
    case Ros2State::flying:
      if (monotonic_now() - commanded_at_ > patience_of_flyer) {
        follow({}, 0.0);
      } else if (link_.commands == FlightCommands::normalised) {
        body_.tilt({wanted_[0], -wanted_[1], wanted_[2], wanted_[3]});
      } else {
        const Vec2<double> v = rotate<double>(heading(rotation(m.q)), {wanted_[0], wanted_[1]});
        follow({v.x, v.y, wanted_[2]}, wanted_[3]);
      }
      break;
  }
  const std_msgs_msg_dds__Int8_ now{static_cast<std::int8_t>(state_)};
  if (state_writer_ != nullptr && number % 5 == 0) state_writer_->write(&now);
}

Ros2FlyerCounts Ros2Flyer::reported() const {
  const std::scoped_lock lock(lock_);
  return reported_;
}
Motion Ros2Flyer::motion() const {
  const std::scoped_lock lock(lock_);
  return body_.motion();
}
Ros2State Ros2Flyer::state() const {
  const std::scoped_lock lock(lock_);
  return state_;
}
void Ros2Flyer::land_by_itself() {
  const std::scoped_lock lock(lock_);
  state_ = Ros2State::landing;
}
void Ros2Flyer::refuse_requests(bool refuses) {
  const std::scoped_lock lock(lock_);
  refuses_ = refuses;
}

std::string Ros2Flyer::counts() const {
  const Ros2FlyerCounts n = reported();
  const Motion m = motion();
  return fmt::format(
      "{} cmd_vel ({} while it did not fly, {} bad), {} to take off, {} to land, {}, at [{:.2f}, {:.2f}, "
      "{:.2f}] m",
      n.commands, n.commands_outside, n.bad, n.takeoffs, n.landings,
      state() == Ros2State::landed ? "landed" : "in the air", m.p.x, m.p.y, m.p.z);
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::VehicleSimulator> sightline::Ros2Link::simulator(
    const dds::SimulatorSetup& setup) const {
  dds::check_commands(*this, setup.name, setup.model);
  if (flies())
    return std::make_unique<dds::Ros2Flyer>(
        setup.participant, *this,
        dds::Ros2Flyer::Setup{setup.origin, setup.below, setup.heading, setup.altitude, setup.rotors},
        setup.faults);
  return std::make_unique<dds::Ros2Rover>(
      setup.participant, *this,
      dds::Ros2Rover::Setup{.origin = setup.origin,
                            .start = {setup.start.p, upright(setup.start.d), {}, 0.0},
                            .sideward = roles_of(setup.model).velocity_V[1] >= 0},
      setup.faults);
}
