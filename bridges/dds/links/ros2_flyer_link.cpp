#include "bridges/dds/links/ros2_flyer_link.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "sightline/base/now.hpp"
#include "sightline/world/flight_controller.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

constexpr Nanoseconds flyer_state_old = 2'500'000'000, quiet_for = 500'000'000;
constexpr double flyer_height = 0.3, standing_height = 0.15;  // above its start [m]
constexpr double quiet_climb = 0.15;                          // slower vertical motion counts as level [m/s]
constexpr double flyer_descended = 0.1;                       // [m]

bool accepts_trigger(const void* response) {
  return static_cast<const std_srvs_srv_dds__Trigger_Response_*>(response)->success;
}

}  // namespace

void check_commands(const Ros2Link& link, std::string_view name, const Model& model) {
  if (link.flies() == model.rolls())
    throw std::invalid_argument(fmt::format(
        "agent.{}.link.takeoff {}, expected {}", name,
        model.rolls() ? fmt::format("= {}, where a {} drives", link.takeoff, model.name()) : "is missing",
        model.rolls() ? "a robot that flies"
                      : fmt::format("it and land, by which a {} flies", model.name())));
  if (!link.flies()) return;
  const bool normalised = link.commands == FlightCommands::normalised;
  const Commands wanted = normalised ? Commands::tilt : Commands::velocity;
  if (commands_of(model) != wanted)
    throw std::invalid_argument(fmt::format(
        "agent.{}.link.commands = {}, which are no inputs of a {}, expected one of {}", name,
        normalised ? "normalised" : "velocity", model.name(), robots_with_vehicles(std::array{wanted})));
}

TriggerCall::TriggerCall(Port participant, const std::string& name, FlightCalls calls) : name_(name) {
  if (calls == FlightCalls::topics)
    topic_ = std::make_unique<RawWriter>(participant, std_msgs_msg_dds__Empty__desc, name, of_ros_commands);
  else if (calls == FlightCalls::empty)
    service_ = std::make_unique<ServiceCaller>(participant, empty_service, name);
  else
    service_ = std::make_unique<ServiceCaller>(participant, trigger_service, name, accepts_trigger);
}

void TriggerCall::send() noexcept {
  const std_msgs_msg_dds__Empty_ nothing{};  // the requests of both services are empty, too
  if (service_)
    (void)service_->call(&nothing);
  else
    (void)topic_->write(&nothing);
}

void TriggerCall::watch(std::span<const SeenWriter> writers) {
  if (service_) return service_->watch(writers);
  received_ = topic_->matched() > 0;
  rivals_ = topic_->rivals(writers);
}

Ros2FlyerLinkEnd::Ros2FlyerLinkEnd(Port participant, const Link& whole)
    : Ros2LinkEnd(participant, whole),
      takeoff_(participant, link().takeoff, link().calls),
      land_(participant, link().land, link().calls) {
  if (link().state.empty()) return;
  reader_ = std::make_unique<RawReader>(
      participant, std_msgs_msg_dds__Int8__desc, link().state, of_sensors, std::nullopt, Writers::all,
      [this](const void* message, const Arrival& arrival) {
        state_.put({arrival.monotonic, static_cast<const std_msgs_msg_dds__Int8_*>(message)->data});
      });
}

LinkFacts Ros2FlyerLinkEnd::facts(Nanoseconds now) noexcept {
  (void)state_.look(last_state_);
  const Motion& m = motion();
  if (!(std::abs(m.v.z) < quiet_climb)) moved_at_ = now;
  const bool quiet = now - moved_at_ > quiet_for, begun = phase_ != Phase::ground;
  const double height = m.p.z - ground_;
  const bool flies = says() ? is(Ros2State::flying) : begun && height > flyer_height && quiet,
             stands = says() ? is(Ros2State::landed) : !begun || (height < standing_height && quiet);
  down_ = down_ || (phase_ == Phase::landing && stands);
  LinkFacts facts = Ros2LinkEnd::facts(now);
  if (says()) facts.there = facts.there && now - last_state_.arrived < flyer_state_old;
  facts.checked = facts.checked && takeoff_.there() && land_.there() && stands;
  facts.armed = begun && !down_;
  facts.landed = stands;
  facts.airborne = phase_ >= Phase::takeoff && flies;
  facts.contested = facts.contested || takeoff_.rivals() + land_.rivals() > 0;
  facts.restarted = speakers_ >= 0 && says() && reader_->writers_came() > speakers_;
  facts.refused = phase_ == Phase::takeoff && takeoff_.answer() == Answer::refused;
  // A state change that we did not request comes from another operator.
  const bool taken = says() && (is(Ros2State::landed) || is(Ros2State::landing)),
             lands = taken || height < land_from_ - flyer_descended || stands;
  facts.mode = phase_ == Phase::takeoff     ? AutopilotMode::takeoff
               : phase_ == Phase::setpoints ? (taken ? AutopilotMode::other : AutopilotMode::offboard)
               : phase_ == Phase::landing   ? (lands ? AutopilotMode::land : AutopilotMode::offboard)
                                            : AutopilotMode::other;
  return facts;
}

void Ros2FlyerLinkEnd::send(const LinkOutput& output, const Command& command, Nanoseconds) noexcept {
  switch (output.request) {
    case Request::none:
    case Request::hold:
    case Request::origin:
      break;
    case Request::arm:
      phase_ = Phase::ours;
      ground_ = motion().p.z;
      if (says()) speakers_ = reader_->writers_came();
      break;
    case Request::take_off:
      phase_ = Phase::takeoff;
      takeoff_.send();
      break;
    case Request::offboard:
      phase_ = Phase::setpoints;
      break;
    case Request::land:
      if (phase_ != Phase::landing) land_from_ = motion().p.z - ground_;
      phase_ = Phase::landing;
      [[fallthrough]];
    case Request::emergency:  // the link cannot stop motors
      steer({}, 0.0);         // some drivers keep the last command
      land_.send();
      break;
  }
  if (output.setpoint == Setpoint::none || phase_ != Phase::setpoints) return;
  const bool task = output.setpoint == Setpoint::task;
  const std::array<double, 4> u = task ? command.u : std::array<double, 4>{};
  // (24) counts u_s to the right, a Twist to the left.
  steer({u[0], link().commands == FlightCommands::normalised ? -u[1] : u[1], u[2]}, u[3]);
}

void Ros2FlyerLinkEnd::watch(std::span<const SeenWriter> writers) {
  Ros2LinkEnd::watch(writers);
  takeoff_.watch(writers);
  land_.watch(writers);
}

void Ros2FlyerLinkEnd::examine(const Surroundings& around, FindingList& to) {
  const LinkFacts f = facts(monotonic_now());
  for (const TriggerCall* signal : {&takeoff_, &land_}) {
    if (!signal->there(around))
      to.add(Aspect::topics, Light::red, "{}: {}", signal->name(),
             link().calls == FlightCalls::topics ? "it has no subscriber" : "no server");
    if (signal->rivals() > 0)
      to.add(Aspect::writers, Light::red, "{}: another program writes to it", signal->name());
  }
  if (says() && state_.count() == 0)
    to.add(Aspect::topics, Light::red, "{}: no message, {}", reader_->topic(),
           why_nothing_comes(*reader_, around));
  Ros2LinkEnd::examine(around, to);
  if (f.landed)
    to.add(Aspect::state, Light::green, "on the ground");
  else if (!says() || state_.count() > 0)
    to.add(Aspect::state, Light::red, "it is not on the ground");
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::LinkEnd> sightline::Ros2Link::end(const dds::EndSetup& setup) const {
  dds::check_commands(*this, setup.name, setup.model);
  if (flies()) return std::make_unique<dds::Ros2FlyerLinkEnd>(setup.at, setup.link);
  return std::make_unique<dds::Ros2LinkEnd>(setup.at, setup.link);
}
