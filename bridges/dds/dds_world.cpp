#include "bridges/dds/dds_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "bridges/dds/px4_link.hpp"
#include "bridges/dds/ros2_link.hpp"
#include "sightline/base/index.hpp"

namespace sightline::dds {
namespace {

std::unique_ptr<LinkEnd> made_end(dds_entity_t participant, const Link& link, std::string_view name,
                                  const Model& model, bool loopback) {
  if (link.poses != PoseSource::odometry)
    throw std::invalid_argument(
        fmt::format("agent.{}.link.poses = {}, which this bridge does not fly by yet, expected odometry",
                    name, pose_sources[static_cast<std::size_t>(link.poses)]));
  if (std::holds_alternative<Px4Link>(link.kind))
    return std::make_unique<Px4LinkEnd>(participant, link, loopback ? Stamps::of_this_machine : Stamps::none);
  if (std::holds_alternative<Ros2Link>(link.kind)) {
    if (!model.rolls())
      throw std::invalid_argument(fmt::format(
          "agent.{}.link.kind = ros2, by which a {} does not take off yet, expected a robot that drives",
          name, model.name()));
    return std::make_unique<Ros2LinkEnd>(participant, link);
  }
  throw std::invalid_argument(
      fmt::format("agent.{}.link.kind = {}, which this bridge does not fly yet, expected px4 or ros2", name,
                  link.kind_name()));
}

/// Refuses what would not be what the scenario says.
const Scenario& flown(const Scenario& scenario) {
  if (!scenario.fleet)
    throw std::invalid_argument("fleet is missing, expected a [fleet] that says how the robots are reached");
  if (changes_in_flight(scenario))
    throw std::invalid_argument("event = the team changes in flight, which a fleet does not follow yet");
  for (const UncooperativeBody& body : scenario.uncooperative) {
    if (body.motion)
      throw std::invalid_argument(fmt::format(
          "{} moves, and no topic says where it is, expected a body at rest", scenario.team.name(body.body)));
  }
  return scenario;
}

void sleep_until(std::int64_t t) noexcept {
  const timespec wake = {t / 1'000'000'000, t % 1'000'000'000};
  while (monotonic_now() < t) ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
}

}  // namespace

DdsWorld::DdsWorld(const Scenario& scenario, std::shared_ptr<Domain> domain, const LinkTimes& times)
    : team_(flown(scenario).team),
      start_(scenario.x0),
      measured_(scenario.x0),
      stamps_(size(team_.bodies()), -std::numeric_limits<double>::infinity()),
      rest_(size(team_.nu())),
      period_(std::llround(1e9 * scenario.horizon.dt)),
      times_(times),
      domain_(std::move(domain)) {
  times_.task = scenario.simulation.duration + 60.0;
  const bool loopback = scenario.fleet->network.interfaces == std::vector<std::string>{"lo"};
  for (const Link& link : scenario.fleet->links) {
    const std::string name(team_.name(link.robot));
    const Model& model = team_.model(link.robot);
    std::unique_ptr<LinkEnd> end = made_end(domain_->participant(), link, name, model, loopback);
    robots_.push_back({name, std::move(end), RobotState(model), LinkMachine(times_),
                       size(team_.state_offset(link.robot)), size(team_.input_offset(link.robot))});
  }
  watcher_ = std::thread([this, list = WriterList(domain_->participant())]() mutable {
    while (!done_) {
      const std::vector<SeenWriter> writers = list.look();
      for (Robot& robot : robots_) robot.end->watch(writers);
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  });
}

DdsWorld::~DdsWorld() {
  done_ = true;
  watcher_.join();
}

Measured DdsWorld::measure(double t) noexcept {
  if (!begun_) origin_ = monotonic_now() - std::llround(1e9 * t);
  begun_ = seen_ = true;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    SeenMotion seen;
    if (!robots_[i].end->look(seen)) continue;
    robots_[i].model.write(seen.motion, &measured_[robots_[i].x]);
    stamps_[i] = 1e-9 * static_cast<double>(seen.stamp - origin_);
  }
  // What is at rest is where the scenario says.
  std::fill(stamps_.begin() + static_cast<std::ptrdiff_t>(robots_.size()), stamps_.end(), t);
  return {measured_, stamps_, {}};
}

bool DdsWorld::apply(double, std::span<const double> believed, std::span<const double> u, double,
                     std::int64_t) noexcept {
  // Of missed periods nothing can be told any more.
  if (!std::exchange(seen_, false)) return true;
  step_all(LinkOrder::task, believed, u);
  return each_is({LinkState::holding, LinkState::flying});
}

void DdsWorld::step_all(LinkOrder order, std::span<const double> believed,
                        std::span<const double> u) noexcept {
  const std::int64_t now = monotonic_now();
  const double t = 1e-9 * static_cast<double>(now);
  for (Robot& robot : robots_) {
    const LinkOutput output = robot.machine.step(t, robot.end->facts(now), order);
    Command command;
    if (output.setpoint == Setpoint::task)
      command = robot.model.command(&believed[robot.x], &u[robot.u], 1e-9 * static_cast<double>(period_));
    else
      robot.model.rest();
    robot.end->send(output, command, now);
  }
}

bool DdsWorld::each_is(std::initializer_list<LinkState> states) const {
  return std::all_of(robots_.begin(), robots_.end(), [&](const Robot& r) {
    return std::find(states.begin(), states.end(), r.machine.state()) != states.end();
  });
}

bool DdsWorld::in_our_hands() const {
  return std::any_of(robots_.begin(), robots_.end(), [](const Robot& r) { return r.machine.in_our_hands(); });
}

void DdsWorld::tell_changes(const TellPerson& tell) {
  for (Robot& robot : robots_) {
    const LinkState state = robot.machine.state();
    if (state == robot.told) continue;
    robot.told = state;
    const LinkReason reason = robot.machine.reason();
    tell(fmt::format("{}: {}{}{}", robot.name, to_string(state), reason != LinkReason::as_asked ? ", " : "",
                     reason != LinkReason::as_asked ? to_string(reason) : ""));
  }
}

template <class Done>
void DdsWorld::steps_until(LinkOrder order, const Interrupts& interrupts, const TellPerson& tell,
                           Done&& done) {
  for (std::int64_t next = monotonic_now(); !done();
       next = std::max(next + period_, monotonic_now() - period_)) {
    sleep_until(next);
    step_all(interrupts >= 2 ? LinkOrder::hand_over : order, {}, {});
    tell_changes(tell);
  }
}

bool DdsWorld::take_off(Arming arming, const Interrupts& interrupts, const TellPerson& tell) {
  using S = LinkState;
  const auto out = [&] {
    return interrupts > 0 || !each_is({S::waiting, S::ready, S::arming, S::taking_off, S::holding});
  };
  steps_until(LinkOrder::check, interrupts, tell, [&] { return out() || each_is({S::ready}); });
  if (each_is({S::ready}) && interrupts == 0) {
    if (arming == Arming::dry_run) {
      tell("all are ready, none is armed: a dry run");
      steps_until(LinkOrder::land, interrupts, tell, [&] { return !in_our_hands() && each_is({S::done}); });
      return false;
    }
    steps_until(LinkOrder::take_off, interrupts, tell, [&] {
      return out() || std::all_of(robots_.begin(), robots_.end(), [](Robot& r) {
               return r.machine.state() == S::taking_off && r.end->facts(monotonic_now()).airborne;
             });
    });
    if (!out())
      steps_until(LinkOrder::hold, interrupts, tell, [&] { return out() || each_is({S::holding}); });
    if (!out()) return true;
  } else {
    const std::vector<SeenWriter> writers = WriterList(domain_->participant()).look();
    for (Robot& robot : robots_) {
      if (robot.machine.state() != S::done && robot.machine.state() != S::waiting) continue;
      for (const std::string& sentence : robot.end->obstacles(writers))
        tell(fmt::format("{}: {}", robot.name, sentence));
    }
  }
  land(interrupts, tell);
  return false;
}

void DdsWorld::land(const Interrupts& interrupts, const TellPerson& tell) {
  steps_until(LinkOrder::land, interrupts, tell, [&] {
    return each_is({LinkState::done, LinkState::pilot});
  });
}

std::string DdsWorld::ended() const {
  for (const Robot& robot : robots_) {
    if (robot.machine.reason() != LinkReason::as_asked)
      return fmt::format("{}: {}; the others landed", robot.name, to_string(robot.machine.reason()));
  }
  return {};
}

std::vector<std::string> DdsWorld::faults() const {
  std::vector<std::string> sentences;
  for (const Robot& robot : robots_) {
    if (robot.machine.reason() != LinkReason::as_asked)
      sentences.push_back(fmt::format("{}: {}", robot.name, to_string(robot.machine.reason())));
  }
  return sentences;
}

std::vector<std::string> DdsWorld::counts() const {
  std::vector<std::string> lines;
  for (const Robot& robot : robots_) lines.push_back(fmt::format("{}: {}", robot.name, robot.end->counts()));
  if (complaints() > 0)
    lines.push_back(fmt::format("{} packets that could not be read: {}", complaints(), last_complaint()));
  return lines;
}

}  // namespace sightline::dds
