#include "bridges/dds/dds_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>

#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/scenario/starts.hpp"

namespace sightline::dds {
namespace {

constexpr std::int64_t looks_each = 200'000'000;  // examination interval before a flight [ns]
constexpr double rises_before = 15.0;             // from the take-off of a robot to its event with a time [s]

/// Rejects events that add a robot which cannot take off in the task.
void refuse_added_robots(const Scenario& scenario) {
  for (const LocalizedRobot& localized : scenario.localization.robots)
    if (is_absent_at_start(scenario, localized.robot))
      throw std::invalid_argument(
          fmt::format("agent.{}.present = false, expected true: the pose of a robot localized by vision must "
                      "be known before it joins",
                      scenario.team.name(localized.robot)));
  const std::vector<TeamEvent>& events = scenario.script.events;
  const auto may_hold = [&](BodyId robot) {
    return std::any_of(events.begin(), events.end(), [&](const TeamEvent& event) {
      return std::any_of(event.actions.begin(), event.actions.end(), [&](const Action& action) {
        const auto* const remove = std::get_if<RemoveBody>(&action);
        return remove != nullptr && remove->body == robot && remove->afterwards == Afterwards::hold;
      });
    });
  };
  for (std::size_t i = 0; i < events.size(); ++i) {
    for (const Action& action : events[i].actions) {
      const auto* const add = std::get_if<AddBody>(&action);
      if (add == nullptr || !scenario.team.is_agent(add->body) || is_absent_at_start(scenario, add->body) ||
          may_hold(add->body))
        continue;
      throw std::invalid_argument(
          fmt::format("event[{0}].add = \"{1}\", expected a robot with present = false, or one that an event "
                      "lets hold: {1} takes off at the start, and no robot takes off twice in a flight",
                      i, scenario.team.name(add->body)));
    }
  }
}

/// Time in the task at which a robot takes off for an event with a time [s]; infinity: none.
double rises_at(const Scenario& scenario, BodyId robot) {
  double earliest = std::numeric_limits<double>::infinity();
  for (const TeamEvent& event : scenario.script.events) {
    const auto* const timed = std::get_if<AtTime>(&event.trigger);
    if (timed == nullptr || !event.stage.empty() || timed->t >= scenario.simulation.duration) continue;
    for (const Action& action : event.actions)
      if (const auto* const add = std::get_if<AddBody>(&action); add != nullptr && add->body == robot)
        earliest = std::min(earliest, timed->t - rises_before);
  }
  return earliest;
}

/// Rejects scenarios that the fleet cannot follow.
const Scenario& flown(const Scenario& scenario) {
  const std::vector<BodyLink>& links = fleet_of(scenario).bodies;
  refuse_added_robots(scenario);
  for (const UncooperativeBody& body : scenario.uncooperative) {
    const bool seen =
        std::any_of(links.begin(), links.end(), [&](const BodyLink& link) { return link.body == body.body; });
    if (body.motion && !seen)
      throw std::invalid_argument(
          fmt::format("{} moves, and no topic has its pose, expected a link with poses, or a body at rest",
                      scenario.team.name(body.body)));
  }
  return scenario;
}

/// Waiting times of a part: for robots of other parts, and for its own robots that already fly to
/// land.
constexpr double ready_of_part = 120.0, begins_together = 20.0;  // [s]
/// The task waits at most stands_within until each holding robot moves slower than `standing`.
constexpr double stands_within = 2.0, standing = 0.03;  // [s], [m/s]

LinkTimes times_of_task(LinkTimes times, const Scenario& scenario) {
  times.task = scenario.simulation.duration + 60.0;
  if (plans_apart(scenario)) times.ready = std::max(times.ready, ready_of_part);
  return times;
}

/// Bounds from [safety]: flying robots have a floor and a ceiling, ground robots have none.
GoalSpace goal_space(const Scenario& scenario, const Model& model) {
  GoalSpace space;
  if (!scenario.safety) return space;
  space.world = scenario.safety->world;
  space.zones = scenario.safety->barrier_options.zones;
  if (model.rolls()) return space;
  space.floor = scenario.safety->barrier_options.floor;
  space.ceiling = scenario.safety->barrier_options.ceiling;
  return space;
}

constexpr double never_seen = -std::numeric_limits<double>::infinity();

LinkTiming::Delay delay_of(const DelayHistogram& times) {
  return {times.within(0.5), times.within(0.99), times.within(1.0)};
}

}  // namespace

DdsWorld::DdsWorld(const Scenario& scenario, std::shared_ptr<Domain> domain, const LinkTimes& times,
                   PublishMode publish)
    : scenario_(flown(scenario)),
      team_(scenario_.team),
      start_(scenario.x0),
      measured_(scenario.x0),
      stamps_(size(team_.bodies()), never_seen),
      attitudes_(size(team_.bodies()), no_attitude),
      period_(to_nanoseconds(scenario.horizon.dt)),
      times_(times_of_task(times, scenario_)),
      node_(fleet_of(scenario).network.node),
      domain_(std::move(domain)),
      robots_(made_robots(publish)),
      published_(robots_.size()),
      bodies_(scenario_, domain_->participant()),
      telemetry_(scenario_, ends(), domain_->participant()),
      preflight_(scenario_, examined(), bodies_, domain_->participant(), times_.listened) {
  if (publish == PublishMode::on && plans_apart(scenario_))
    talk_ = std::make_unique<PredictionExchange>(scenario_, domain_->participant());
  if (publish == PublishMode::on)
    services_ = std::make_unique<OperatorServices>(domain_->participant(), node_, calls_);
  if (publish == PublishMode::on && fleet_of(scenario).network.topics)
    topics_ = std::make_unique<FlightPublisher>(scenario, domain_->participant(),
                                                [this](std::size_t i) { return robots_[i].end->counts(); });
  watcher_.start([this, list = WriterList(domain_->participant())]() mutable {
    while (!done_) {
      const std::vector<SeenWriter> writers = list.look();
      for (Robot& robot : robots_) robot.end->watch(writers);
      report_news();
      rival_ = services_ != nullptr && services_->has_rival(writers);
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  });
}

std::vector<DdsWorld::Robot> DdsWorld::made_robots(PublishMode publish) const {
  std::vector<Robot> robots;
  for (const Link& link : fleet_of(scenario_).links) {
    const std::string name(team_.name(link.robot));
    const Model& model = team_.model(link.robot);
    const GoalSpace space = goal_space(scenario_, model);
    const double height = sight_at_start(scenario_, link.robot).p.z;
    std::unique_ptr<LinkEnd> end = made_end({.at = {domain_->participant(), publish},
                                             .link = link,
                                             .name = name,
                                             .model = model,
                                             .network = fleet_of(scenario_).network,
                                             .height = std::max(height, space.floor),
                                             .inertial = uses_attitude_filter(scenario_, link.robot),
                                             .period = scenario_.horizon.dt});
    const bool absent = is_absent_at_start(scenario_, link.robot);
    LinkTimes limits = times_;
    if (absent) limits.called += limits.task;
    robots.push_back({.name = name,
                      .end = std::move(end),
                      .model = RobotState(model),
                      .machine = LinkMachine(limits),
                      .body = size(link.robot.index),
                      .x = size(team_.state_offset(link.robot)),
                      .u = size(team_.input_offset(link.robot)),
                      .place = JoiningPlace(scenario_, link.robot)});
    robots.back().estimated = link.poses.estimated();
    robots.back().role = absent ? Role::grounded : Role::flies;
    robots.back().rises_at = rises_at(scenario_, link.robot);
    const auto goals = std::find_if(scenario_.goals.begin(), scenario_.goals.end(),
                                    [&](const RobotGoals& of) { return of.robot == link.robot; });
    if (goals == scenario_.goals.end()) continue;
    robots.back().track = goals->track;
    robots.back().goals = std::make_unique<GoalSubscriber>(domain_->participant(), link.goals, space);
  }
  return robots;
}

std::vector<LinkEnd*> DdsWorld::ends() const {
  std::vector<LinkEnd*> all;
  for (const Robot& robot : robots_) all.push_back(robot.end.get());
  return all;
}

std::vector<ExaminedRobot> DdsWorld::examined() const {
  std::vector<ExaminedRobot> all;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    all.push_back({robots_[i].name, &fleet_of(scenario_).links[i], robots_[i].end.get(), telemetry_.tags()});
  return all;
}

DdsWorld::~DdsWorld() {
  done_ = true;
  watcher_.join();
}

void DdsWorld::set_presence(std::span<const Presence> presence) noexcept {
  for (Robot& robot : robots_) {
    const Presence now = presence[robot.body];
    if (now == Presence::steered || now == Presence::hold)
      robot.role = Role::flies;
    else if (robot.role == Role::flies)
      robot.role = Role::leaves;
  }
}

Joining DdsWorld::prepare(BodyId body) noexcept {
  Robot& robot = robots_[at(body)];
  if (robot.role == Role::grounded) robot.role = Role::joins;
  if (robot.role == Role::leaves || robot.machine.state() >= LinkState::landing) return Joining::refused;
  return robot.holds ? Joining::ready : Joining::waits;
}

void DdsWorld::call_off(BodyId body) noexcept {
  Robot& robot = robots_[at(body)];
  const bool refused = robot.machine.state() >= LinkState::landing;  // itself
  if (robot.role != Role::joins || refused) return;
  robot.rises_at = std::numeric_limits<double>::infinity();
  robot.called_off = robot.machine.in_our_hands();
  robot.role = robot.called_off ? Role::leaves : Role::grounded;
}

LinkOrder DdsWorld::order_of(Robot& robot, LinkOrder order, double t) const noexcept {
  if (robot.role != Role::joins) robot.fit_at = t;
  if (order >= LinkOrder::land) return order;
  switch (robot.role) {
    case Role::grounded:
      return LinkOrder::check;
    case Role::joins:
      return order_of_joining(robot, t);
    case Role::leaves:
      return LinkOrder::land;
    case Role::flies:
      break;
  }
  return order;
}

/// A robot takes off to join only where it joins, and while its own checks pass. If either fails
/// for as long as a robot may take until it is ready, it is not fit to fly.
LinkOrder DdsWorld::order_of_joining(Robot& robot, double t) const noexcept {
  const bool waits = robot.machine.state() <= LinkState::ready;
  if (robot.placed && (!waits || robot.facts.checked)) robot.fit_at = t;
  LinkReason& unfit = robot.facts.unfit;
  if (unfit == LinkReason::as_requested && t - robot.fit_at >= times_.ready)
    unfit = robot.placed ? LinkReason::not_ready : LinkReason::misplaced;
  return waits && robot.fit_at < t && unfit == LinkReason::as_requested ? LinkOrder::check : LinkOrder::hold;
}

Measured DdsWorld::measure(double t) noexcept {
  const std::int64_t now = monotonic_now(), due = to_nanoseconds(t);
  if (!begun_) origin_ = now - due, begun_cpu_ = to_seconds(process_time()), telemetry_.begin();
  if (!begun_ && talk_) talk_->begin(origin_);
  for (Robot& robot : robots_) {
    if (!robot.track) continue;
    if (!begun_) robot.track->clear(), robot.goals->forget();
    robot.goals->pass_on(t, *robot.track);
  }
  begun_ = seen_ = true;
  ++periods_;
  wakes_.add(to_seconds(now - origin_ - due));
  // Bodies without a link are at rest where the scenario places them.
  std::fill(stamps_.begin(), stamps_.end(), t);
  for (Robot& robot : robots_) {
    SeenMotion seen;
    // A vision-localized robot has no measured position; its attitude is known with the place of its frame.
    const bool there = robot.end->look(seen), came = there && !robot.estimated;
    if (came) robot.model.write(seen.motion, &measured_[robot.x]);
    stamps_[robot.body] = came ? to_seconds(seen.stamp - origin_) : never_seen;
    attitudes_[robot.body] = came                   ? seen.motion.q
                             : there && robot.knows ? in_G(robot.frame, seen.motion).q
                                                    : no_attitude;
  }
  bodies_.measure(origin_, measured_, stamps_);
  Measured all = {measured_, stamps_, {}};
  all.attitudes = attitudes_;
  telemetry_.measure(origin_, all);
  return all;
}

bool DdsWorld::apply(double t, std::span<const double> estimated, const sightline::Command& u, double,
                     std::int64_t periods) noexcept {
  // Without a measurement since the last call, these periods were missed; no command can be sent
  // for them.
  if (!std::exchange(seen_, false)) {
    periods_ += periods, missed_ += periods;
    return true;
  }
  for (Robot& robot : robots_)
    if (robot.role == Role::grounded && t >= robot.rises_at) robot.role = Role::joins;
  step_all(LinkOrder::task, estimated, u);
  return each_in_team([](const Robot& r) {
    return r.machine.state() == LinkState::holding || r.machine.state() == LinkState::flying;
  });
}

void DdsWorld::step_all(LinkOrder order, std::span<const double> estimated,
                        std::span<const double> u) noexcept {
  if (calls_.is_emergency()) order = LinkOrder::emergency;
  const std::int64_t now = monotonic_now();
  const double t = to_seconds(now);
  const bool seen = order == LinkOrder::task || bodies_.are_seen(now);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    robot.facts = robot.end->facts(now);
    robot.facts.checked = robot.facts.checked && preflight_.is_clear(i) && seen;
    const LinkOrder own = order_of(robot, order, t);
    const LinkOutput output = robot.machine.step(t, robot.facts, own);
    Command command;
    RobotShown shown = {
        .state = robot.machine.state(), .reason = robot.machine.reason(), .facts = robot.facts};
    shown.seen = robot.end->look(shown.last);
    const bool risen = shown.state == LinkState::holding && robot.facts.risen;
    if (!risen) robot.risen_since = t;
    robot.placed = shown.seen && robot.place.holds(shown.last.motion);
    robot.holds = risen && robot.placed &&
                  (norm(shown.last.motion.v) < standing || t - robot.risen_since >= stands_within);
    published_[i].joins = robot.role == Role::joins;
    published_[i].called_off = robot.called_off;
    published_[i].reason = shown.reason;
    published_[i].state = shown.state;
    if (output.setpoint == Setpoint::task)
      command = robot.model.command(&estimated[robot.x], &u[robot.u], to_seconds(period_));
    else
      robot.model.rest();
    if (robot.estimated) {
      const bool has_estimate = !estimated.empty();
      if (has_estimate) {
        const Motion& odometry = shown.last.motion;
        const Motion at = robot.model.motion(&estimated[robot.x], &u[robot.u]);
        const double age = to_seconds(now - shown.last.stamp);
        robot.frame = carried_frame(odometry, age, at);
        command = in_local(robot.frame, command);
        shown.last.motion = {at.p, at.q, at.v, at.r};
      }
      shown.seen = shown.seen && has_estimate && robot.knows;
    }
    robot.end->send(output, command, now);
    if (topics_ == nullptr) continue;
    topics_->show(i, shown);
  }
}

bool DdsWorld::each_is(std::initializer_list<LinkState> states) const {
  return std::all_of(robots_.begin(), robots_.end(), [&](const Robot& r) {
    return std::find(states.begin(), states.end(), r.machine.state()) != states.end();
  });
}

bool DdsWorld::each_stands() const {
  return each_in_team([](const Robot& r) {
    SeenMotion seen;
    return r.end->look(seen) && norm(seen.motion.v) < standing;
  });
}

bool DdsWorld::in_our_hands() const {
  return std::any_of(robots_.begin(), robots_.end(), [](const Robot& r) { return r.machine.in_our_hands(); });
}

void DdsWorld::report_changes(const PrintMessage& print) {
  for (Robot& robot : robots_) {
    if (const std::string reply = robot.end->reply(); !reply.empty())
      print(fmt::format("{}: {}", robot.name, reply));
  }
  report_states(print);
}

void DdsWorld::report_states(const PrintMessage& print) {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const LinkState state = published_[i].state;
    if (state == std::exchange(robots_[i].reported, state)) continue;
    const LinkReason reason = published_[i].reason;
    const bool fails = reason != LinkReason::as_requested;
    print(fmt::format("{}: {}{}{}{}", robots_[i].name, to_string(state), fails ? ", " : "",
                      fails ? to_string(reason) : "",
                      fails && published_[i].joins ? ": it does not join, the others fly on"
                      : state == LinkState::landing && published_[i].called_off ? ": its event is ignored"
                                                                                : ""));
  }
}

void DdsWorld::report_news() {
  const std::scoped_lock lock(news_);
  if (!news_go_to_) return;
  report_states(news_go_to_);
  if (talk_)
    for (const std::string& sentence : talk_->news()) news_go_to_(sentence);
  for (Robot& robot : robots_) {
    if (!robot.goals) continue;
    for (const std::string& sentence : robot.goals->news())
      news_go_to_(fmt::format("{}: {}", robot.name, sentence));
  }
}

void DdsWorld::report_all(const std::string& sentence, const PrintMessage& print) {
  print(sentence);
  if (topics_ != nullptr) topics_->add_sentence(sentence);
}

void DdsWorld::show(const Sample& sample) noexcept {
  for (Robot& robot : robots_)
    if (robot.estimated && robot.body < sample.estimates.size())
      robot.knew = (robot.knows = sample.estimates[robot.body].known) || robot.knew;
  if (topics_ != nullptr) topics_->show(sample);
}

template <class Done>
void DdsWorld::steps_until(LinkOrder order, const Interrupts& interrupts, const PrintMessage& print,
                           Done&& done) {
  for (std::int64_t next = next_multiple(monotonic_now(), period_); !done();
       next = next_multiple(std::max(next + period_, monotonic_now() - period_), period_)) {
    sleep_until(next);
    step_all(interrupts >= 2 ? LinkOrder::hand_over : order, {}, {});
    if (talk_) stand(order);
    report_changes(print);
  }
}

/// Publishes to other parts where the robots are while they do not fly the task.
void DdsWorld::stand(LinkOrder order) noexcept {
  for (Robot& robot : robots_) {
    SeenMotion seen;
    if (robot.end->look(seen)) robot.model.write(seen.motion, &measured_[robot.x]);
  }
  const bool holds = settled_ && each_is({LinkState::holding});
  const PartPhase phase = order == LinkOrder::check  ? PartPhase::ground
                          : order >= LinkOrder::land ? PartPhase::landing
                          : holds                    ? PartPhase::holding
                                                     : PartPhase::rising;
  talk_->stand(phase, measured_);
}

/// Waits for a common start with the parts that are received, at most begins_together.
void DdsWorld::begin_together(const Interrupts& interrupts, const PrintMessage& print) {
  const Nanoseconds until = monotonic_now() + to_nanoseconds(begins_together);
  const auto flies = [&] { return each_is({LinkState::holding}) && interrupts == 0 && !calls_.to_land(); };
  steps_until(LinkOrder::hold, interrupts, print, [&] {
    return !flies() || monotonic_now() >= std::min(until, talk_->begins().value_or(until));
  });
  if (flies() && !talk_->all_hold())
    report_all(fmt::format("begins without part {}, which does not hold after {} s", talk_->awaited(),
                           begins_together),
               print);
}

bool DdsWorld::take_off(Arming arming, const Interrupts& interrupts, const PrintMessage& print) {
  using S = LinkState;
  const auto out = [&] {
    return interrupts > 0 || !refusals_.empty() || calls_.to_land() ||
           !each_is({S::waiting, S::ready, S::arming, S::taking_off, S::holding});
  };
  // Examination takes part of a period, which is safe because waiting robots receive no set-points.
  std::int64_t looked = 0;
  const auto look_around = [&] {
    if (monotonic_now() - looked <= looks_each) return;
    preflight_.clear(), looked = monotonic_now();
    if (!talk_) return;
    for (const std::string& sentence : talk_->news()) print(sentence);
    for (Robot& robot : robots_) {
      if (arming != Arming::real || !robot.end->facts(looked).armed) continue;
      arming = Arming::on_call;
      report_all(fmt::format("{}: it is flying already, by another program: waiting until it has landed",
                             robot.name),
                 print);
    }
  };
  steps_until(LinkOrder::check, interrupts, print, [&] {
    look_around();
    return out() || each_is({S::ready});
  });
  if (rival_ && each_is({S::ready})) {
    refusals_.push_back(fmt::format(
        "fleet.node = \"{}\", by which another program serves, expected a name of its own", node_));
    report_all(refusals_.back(), print);
  }
  if (arming == Arming::on_call && !out()) {
    calls_.is_at(FlightPhase::waiting);
    report_all(fmt::format("all are ready: {}/start lets them take off", node_), print);
    steps_until(LinkOrder::check, interrupts, print, [&] {
      look_around();
      return out() || calls_.started();
    });
  }
  preflight_.clear();  // they may have been ready for long, so earlier findings may be outdated
  if (each_is({S::ready}) && preflight_.all_clear() && !out()) {
    if (arming == Arming::dry_run) {
      report_all("all are ready, none is armed: a dry run", print);
      steps_until(LinkOrder::land, interrupts, print, [&] { return !in_our_hands() && each_is({S::done}); });
      return false;
    }
    calls_.is_at(FlightPhase::taking_off);
    steps_until(LinkOrder::take_off, interrupts, print, [&] {
      return out() || each_in_team([](const Robot& r) {
               return r.machine.state() == S::taking_off && r.facts.airborne;
             });
    });
    if (!out())
      steps_until(LinkOrder::hold, interrupts, print, [&] {
        return out() ||
               each_in_team([](const Robot& r) { return r.machine.state() == S::holding && r.facts.risen; });
      });
    for (Robot& robot : robots_) robot.end->stop_examining();
    const Nanoseconds until = monotonic_now() + to_nanoseconds(stands_within);
    if (!out())
      steps_until(LinkOrder::hold, interrupts, print,
                  [&] { return out() || each_stands() || monotonic_now() > until; });
    settled_ = !out();
    if (!out() && talk_) begin_together(interrupts, print);
    if (!out()) {
      report_all("the task begins", print);
      calls_.is_at(FlightPhase::task);
      const std::scoped_lock lock(news_);
      news_go_to_ = print;
      return true;
    }
  } else {
    const bool ready = each_is({S::ready});
    for (const std::string& sentence : preflight_.refusals()) {
      if (ready) refusals_.push_back(sentence);
      print(sentence);
    }
  }
  land(interrupts, print);
  return false;
}

std::vector<RobotPose> DdsWorld::poses() {
  std::vector<RobotPose> all;
  for (Robot& robot : robots_) {
    RobotPose& pose = all.emplace_back(RobotPose{robot.name});
    SeenMotion seen;
    if (!robot.end->look(seen) || robot.estimated) continue;
    const Vec2<double> d = heading(rotation(seen.motion.q));
    pose.known = true;
    pose.p = seen.motion.p;
    pose.heading = std::atan2(d.y, d.x);
    pose.age = to_seconds(monotonic_now() - seen.stamp);
  }
  return all;
}

void DdsWorld::land(const Interrupts& interrupts, const PrintMessage& print) {
  calls_.is_at(FlightPhase::landing);
  report_news();
  {
    const std::scoped_lock lock(news_);
    news_go_to_ = {};
  }
  if (begun_ && !cpu_)
    cpu_ = (to_seconds(process_time()) - begun_cpu_) / to_seconds(monotonic_now() - origin_);
  steps_until(LinkOrder::land, interrupts, print, [&] {
    return each_is({LinkState::done, LinkState::pilot});
  });
  const std::vector<RobotPose> last = poses();
  for (std::size_t i = 0; i < last.size(); ++i)
    if (last[i].known && robots_[i].machine.reason() != LinkReason::as_requested)
      report_all(fmt::format("{}: last at [{:.2f}, {:.2f}, {:.2f}] m in G, {:.1f} s ago", last[i].robot,
                             last[i].p.x, last[i].p.y, last[i].p.z, last[i].age),
                 print);
  calls_.is_at(FlightPhase::over);
}

std::vector<std::string> DdsWorld::reasons() const {
  std::vector<std::string> sentences;
  for (const Robot& robot : robots_)
    if (robot.machine.reason() != LinkReason::as_requested)
      sentences.push_back(fmt::format("{}: {}", robot.name, to_string(robot.machine.reason())));
  return sentences;
}

std::string DdsWorld::ended() const {
  std::vector<std::string> sentences = reasons();
  if (!sentences.empty() && sentences.size() < robots_.size()) sentences.emplace_back("the others landed");
  return fmt::format("{}", fmt::join(sentences, "; "));
}

std::vector<std::string> DdsWorld::faults() const {
  std::vector<std::string> sentences = reasons();
  sentences.insert(sentences.begin(), refusals_.begin(), refusals_.end());
  for (const Robot& robot : robots_)
    if (robot.estimated && begun_ && !robot.knew)
      sentences.push_back(fmt::format("{}: its position stayed unknown: its camera saw no tags", robot.name));
  return sentences;
}

LinkTiming DdsWorld::timing() const {
  DelayHistogram arrivals;
  for (const Robot& robot : robots_) arrivals.add(robot.end->subscriber().lateness());
  return {periods_, missed_, delay_of(wakes_), delay_of(arrivals), cpu_.value_or(0.0)};
}

std::vector<std::string> DdsWorld::counts() const {
  std::vector<std::string> lines;
  if (periods_ > 0) {
    const LinkTiming t = timing();
    lines.push_back(fmt::format(
        "{} periods, {} missed; wake-up late by {:.3f} ms at the median, {:.3f} at 99 %, {:.3f} "
        "at most; poses later than the fastest by {:.3f} ms, {:.3f}, {:.3f}; {:.1f} % of one core",
        t.periods, t.missed, 1e3 * t.wake.median, 1e3 * t.wake.p99, 1e3 * t.wake.most, 1e3 * t.arrival.median,
        1e3 * t.arrival.p99, 1e3 * t.arrival.most, 1e2 * t.cpu));
  }
  for (const Robot& robot : robots_) {
    lines.push_back(fmt::format("{}: {}", robot.name, robot.end->counts()));
    if (robot.estimated)
      lines.push_back(
          fmt::format("{}: {}", robot.name, telemetry_.tags()->counts(BodyId{static_cast<int>(robot.body)})));
    if (robot.goals) lines.push_back(fmt::format("{}: {}", robot.name, robot.goals->counts()));
  }
  bodies_.counts(lines);
  if (talk_)
    for (const std::string& line : talk_->counts()) lines.push_back(line);
  if (topics_ != nullptr) lines.push_back(topics_->counts());
  if (complaints() > 0)
    lines.push_back(fmt::format("{} packets that could not be read: {}", complaints(), last_complaint()));
  return lines;
}

}  // namespace sightline::dds
