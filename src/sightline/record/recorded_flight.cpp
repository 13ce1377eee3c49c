#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/log.hpp"
#include "sightline/record/localization_log.hpp"
#include "sightline/record/log_table.hpp"
#include "sightline/record/period_order.hpp"

namespace sightline {
namespace {}  // namespace

MeasurementLog::MeasurementLog(const Team& team, MessageSink& sink, const std::vector<RobotGoals>& goals)
    : team_(team), sink_(sink), message_(sink), detections_(size(team.bodies())) {
  constexpr LogTopic measurement = log_topic("/BODY/measurement"), goal = log_topic("/ROBOT/goal"),
                     team_answer = log_topic("/team");
  const SchemaId measurements = measurement.add_schema(sink);
  for (int i = 0; i < team.bodies(); ++i)
    bodies_.push_back(measurement.open(sink, measurements, team.name(BodyId{i})));
  for (const RobotGoals& robot : goals)
    goals_.push_back({robot.track, goal.open(sink, goal.add_schema(sink), team.name(robot.robot))});
  changes_ = team_answer.open(sink, team_answer.add_schema(sink));
}

/// Schema of detections, added with the first detection.
SchemaId MeasurementLog::detection() {
  if (!detection_) detection_ = log_topic("/OBSERVER/detection").add_schema(sink_);
  return *detection_;
}

/// Adds the goals that arrived up to `time` [s].
void MeasurementLog::add_goals(double time) {
  for (Goals& robot : goals_) {
    for (; robot.written < robot.track->messages() && robot.track->time(robot.written) <= time;
         ++robot.written) {
      robot.track->waypoints(robot.written, waypoints_);
      message_.begin(robot.track->time(robot.written));
      const auto list = [&](std::string_view key, auto&& each) {
        numbers_.clear();
        for (const Waypoint& waypoint : waypoints_) each(waypoint);
        message_.put(key, numbers_);
      };
      list("after", [&](const Waypoint& w) { numbers_.push_back(w.after); });
      list("p", [&](const Waypoint& w) { numbers_.insert(numbers_.end(), {w.p.x, w.p.y, w.p.z}); });
      list("heading", [&](const Waypoint& w) { numbers_.push_back(w.heading); });
      message_.send(robot.channel, time);
    }
  }
}

void MeasurementLog::add(const Sample& sample) {
  add_goals(sample.time);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const BodyId body{static_cast<int>(i)};
    message_.begin(sample.time);
    message_.put("stamp", sample.stamps[i]);
    message_.put(
        "x",
        std::span(sample.measured).subspan(size(team_.state_offset(body)), size(team_.model(body).nx())));
    message_.send(bodies_[i], sample.time);
  }
  for (std::size_t i = 0; i < sample.detection_count; ++i) {
    const Detection& seen = sample.detections[i];
    message_.begin(sample.time);
    message_.put("stamp", seen.stamp);
    message_.put("arrival", seen.arrival);
    message_.put("target", team_.name(seen.target));
    message_.put("tags", seen.tags);
    message_.put("p", std::array{seen.p.x, seen.p.y, seen.p.z});
    message_.put("q", std::array{seen.q.w, seen.q.x, seen.q.y, seen.q.z});
    message_.put("covariance", seen.covariance);
    auto& channel = detections_[at(seen.observer)];
    if (!channel)
      channel = log_topic("/OBSERVER/detection").open(sink_, detection(), team_.name(seen.observer));
    message_.send(*channel, sample.time);
  }
  if (!sample.team_answered) return;
  message_.begin(sample.time);
  message_.send(changes_, sample.time);
}

/// Passes each message to the reader of its topic; the first body's state begins a period.
class RecordedFlight::Reader {
 public:
  explicit Reader(RecordedFlight& flight) : flight_(flight) {
    const Team& team = flight.team_;
    for (int i = 0; i < team.bodies(); ++i) {
      const BodyId body{i};
      takes_[log_topic("/BODY/state").of(team.name(body))] = [this, body](const McapMessage&) {
        if (at(body) == 0) begin_period();
        take_turn(states_, body.index, "state");
        copy_state(body, period().truth);
      };
      takes_[log_topic("/BODY/measurement").of(team.name(body))] = [this, body](const McapMessage&) {
        take_turn(measurements_, body.index, "measurement");
        copy_state(body, period().measured);
        const double stamp = text_.number("stamp");
        period().stamps[at(body)] = std::isnan(stamp) ? -std::numeric_limits<double>::infinity() : stamp;
      };
      takes_[log_topic("/OBSERVER/detection").of(team.name(body))] = [this, body](const McapMessage&) {
        detect(body);
      };
      takes_[log_topic("/BODY/broadcast").of(team.name(body))] = [this, body](const McapMessage&) {
        period().broadcasts.push_back({body, broadcast_of(text_)});
        raise(flight_.most_.broadcasts, period().broadcasts.size());
      };
      if (!team.is_agent(body)) continue;
      takes_[log_topic("/ROBOT/input").of(team.name(body))] = [this, body,
                                                               number = agents_++](const McapMessage&) {
        take_turn(inputs_, number, "input");
        const std::span<const double> u = text_.numbers("u");
        copy(u, flight_.team_.model(body).nu(), flight_.team_.input_offset(body), period().u);
      };
      takes_[log_topic("/ROBOT/motion").of(team.name(body))] = [this, body](const McapMessage&) {
        period().motions.push_back({body, motion_of(text_)});
        raise(flight_.most_.motions, period().motions.size());
      };
      takes_[log_topic("/ROBOT/localization").of(team.name(body))] = [this, body](const McapMessage&) {
        period().estimates.push_back({body, estimate_of(text_)});
      };
    }
    for (const RobotGoals& robot : flight.goals_)
      takes_[log_topic("/ROBOT/goal").of(team.name(robot.robot))] =
          [this, track = robot.track](const McapMessage&) { read_goal(track); };
    takes_["/team"] = [this](const McapMessage&) { period().team_answered = true; };
    takes_["/events"] = [this](const McapMessage&) {
      const std::string_view kind = text_.word("kind");
      const bool misses = kind == to_string(EventKind::missed_period),
                 ready = kind == to_string(EventKind::robot_ready);
      if (!misses && !ready && kind != to_string(EventKind::robot_refused)) return;
      const std::int64_t number = flight_.number(text_.number("time")),
                         value = std::llround(text_.number("value"));
      if (misses) return order_.miss(number, value);
      flight_.joinings_.push_back(
          {number, BodyId{static_cast<int>(value)}, ready ? Joining::ready : Joining::refused});
    };
  }

  void take(const McapMessage& message) {
    const auto found = takes_.find(message.topic);
    if (found == takes_.end()) {
      if (message.topic.ends_with("/solver")) read_solver(message);
      return;
    }
    text_.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
    found->second(message);
  }

  /// Removes an incomplete last period and all periods after a gap.
  void end() {
    auto& periods = flight_.periods_;
    if (!drop_states() && !periods.empty() && !is_whole()) periods.pop_back();
    for (std::size_t i = 0; i < periods.size(); ++i) {
      if (order_.follows(flight_.number(periods[i].time))) continue;
      flight_.lost_after_ = i > 0 ? periods[i - 1].time : 0.0;
      periods.resize(i);
      return;
    }
  }

 private:
  RecordedPeriod& period() {
    if (flight_.periods_.empty()) throw std::runtime_error("a message before the first state");
    return flight_.periods_.back();
  }

  /// States without measurements and inputs belong to no period of the loop: a missed one, or after
  /// the last command.
  bool drop_states() {
    const bool alone = !flight_.periods_.empty() && measurements_ == 0 && inputs_ == 0;
    if (alone) flight_.periods_.pop_back();
    return alone;
  }

  void begin_period() {
    const Team& team = flight_.team_;
    const bool dropped = drop_states();
    if (!dropped && !flight_.periods_.empty() && measurements_ == 0)
      throw std::runtime_error("it holds no measurements, as those of sightline before it had replay");
    if (!dropped && !flight_.periods_.empty() && !is_whole())
      throw std::runtime_error(fmt::format(
          "{} states, {} measurements and {} inputs of the period at {} s, expected {}, {} and {}", states_,
          measurements_, inputs_, period().time, team.bodies(), team.bodies(), agents_));
    states_ = measurements_ = inputs_ = 0;
    RecordedPeriod& next = flight_.periods_.emplace_back();
    next.time = text_.number("time");
    next.measured.resize(size(team.nx()));
    next.truth.resize(size(team.nx()));
    next.stamps.resize(size(team.bodies()));
    next.u.resize(size(team.nu()));
  }

  bool is_whole() const {
    const int bodies = flight_.team_.bodies();
    return states_ == bodies && measurements_ == bodies && inputs_ == agents_;
  }
  /// Checks that a period has one message of each kind and body, in the order of the team.
  void take_turn(int& count, int number, std::string_view what) {
    if (number != count)
      throw std::runtime_error(fmt::format("the {} {} of the period at {} s where {} is expected", what,
                                           number, period().time, count));
    ++count;
  }

  static void raise(std::size_t& most, std::size_t count) { most = std::max(most, count); }
  static void copy(std::span<const double> from, int count, int offset, std::vector<double>& to) {
    if (from.size() != size(count))
      throw std::runtime_error(fmt::format("{} numbers in a message, expected {}", from.size(), count));
    std::copy(from.begin(), from.end(), to.begin() + offset);
  }
  void copy_state(BodyId body, std::vector<double>& to) {
    copy(text_.numbers("x"), flight_.team_.model(body).nx(), flight_.team_.state_offset(body), to);
  }

  void detect(BodyId observer) {
    Detection seen{.observer = observer, .target = flight_.team_.find(text_.word("target"))};
    if (seen.target.index < 0) throw std::runtime_error("a detection of no body of the team");
    seen.stamp = text_.number("stamp");
    seen.arrival = text_.number("arrival");
    seen.tags = static_cast<int>(text_.number("tags"));
    const std::span<const double> p = text_.numbers("p"), q = text_.numbers("q"),
                                  covariance = text_.numbers("covariance");
    if (p.size() != 3 || q.size() != 4 || covariance.size() != seen.covariance.size())
      throw std::runtime_error("a detection of another length, expected 3, 4 and 21 numbers");
    seen.p = {p[0], p[1], p[2]};
    seen.q = {q[0], q[1], q[2], q[3]};
    std::copy(covariance.begin(), covariance.end(), seen.covariance.begin());
    period().detections.push_back(seen);
    raise(flight_.most_.detections, period().detections.size());
  }

  void read_goal(const std::shared_ptr<GoalTrack>& track) {
    const std::span<const double> after = text_.numbers("after"), p = text_.numbers("p"),
                                  heading = text_.numbers("heading");
    if (after.empty() || after.size() > GoalTrack::path_most || p.size() != 3 * after.size() ||
        heading.size() != after.size())
      throw std::runtime_error("a goal of another length, expected 1 to 64 waypoints");
    RecordedGoal& goal = flight_.sent_.emplace_back(RecordedGoal{text_.number("time"), track, {}});
    for (std::size_t i = 0; i < after.size(); ++i)
      goal.waypoints.push_back({after[i], {p[3 * i], p[3 * i + 1], p[3 * i + 2]}, heading[i]});
  }

  void read_solver(const McapMessage& message) {
    text_.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
    period().status.push_back(status_named(text_.word("status")));
  }

  static Status status_named(std::string_view name) {
    for (int i = 0; i < status_count; ++i) {
      const auto status = static_cast<Status>(i);
      if (to_string(status) == name) return status;
    }
    throw std::runtime_error(fmt::format("status = \"{}\", expected one of a solver", name));
  }

  RecordedFlight& flight_;
  LogText text_;
  std::map<std::string, std::function<void(const McapMessage&)>, std::less<>> takes_;
  PeriodOrder order_;
  int agents_ = 0;
  int states_ = 0, measurements_ = 0, inputs_ = 0;  // of the last period
};

RecordedFlight::RecordedFlight(const std::filesystem::path& log, Team team, std::vector<double> start,
                               double period, std::vector<RobotGoals> goals)
    : team_(std::move(team)), start_(std::move(start)), period_(period), goals_(std::move(goals)) {
  for (const RobotGoals& robot : goals_) robot.track->clear();
  McapReader mcap(log);
  if (!mcap.ok()) throw std::runtime_error(mcap.error());
  const auto words = mcap.metadata().find("sightline");
  absent_robots_stay_ = words != mcap.metadata().end() && words->second.contains(absent_stay);
  Reader reader(*this);
  try {
    mcap.visit([&](const McapMessage& message) { reader.take(message); });
    reader.end();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{} cannot be replayed: {}", log.string(), error.what()));
  }
  if (!mcap.ok()) throw std::runtime_error(mcap.error());
  if (periods_.empty())
    throw std::runtime_error(fmt::format("{} holds no {}, expected the log of a run", log.string(),
                                         lost_after_
                                             ? "samples of the first period, from which a replay starts"
                                             : "measurements of a whole period"));
  truncated_ = mcap.truncated();
}

std::int64_t RecordedFlight::number(double time) const noexcept { return std::llround(time / period_); }

Measured RecordedFlight::measure(double) noexcept {
  const RecordedPeriod& now = periods_[std::min(next_, periods_.size() - 1)];
  measured_ = true;
  for (; next_goal_ < sent_.size() && sent_[next_goal_].time <= now.time; ++next_goal_)
    (void)sent_[next_goal_].track->add(sent_[next_goal_].time, sent_[next_goal_].waypoints);
  return {.measured = now.measured,
          .stamps = now.stamps,
          .truth = now.truth,
          .detections = now.detections,
          .motions = now.motions,
          .broadcasts = now.broadcasts};
}

/// Returns false after the last period.
bool RecordedFlight::apply(double, std::span<const double>, const Command&, double, std::int64_t) noexcept {
  if (std::exchange(measured_, false)) ++next_;
  return next_ < periods_.size();
}

/// The recorded answer of this period; without one, the robot still took off.
Joining RecordedFlight::prepare(BodyId robot) noexcept {
  if (!absent_robots_stay_) return Joining::at_once;
  const std::int64_t now = number(periods_[std::min(next_, periods_.size() - 1)].time);
  for (const RecordedJoining& joining : joinings_)
    if (joining.number == now && joining.robot == robot) return joining.answer;
  return Joining::waits;
}

std::int64_t RecordedFlight::wait(std::int64_t k) noexcept {
  return next_ < periods_.size() ? std::max(k, number(periods_[next_].time)) : k;
}

TeamDue RecordedFlight::team_due(std::int64_t) const noexcept {
  return next_ < periods_.size() && periods_[next_].team_answered ? TeamDue::now : TeamDue::not_yet;
}

}  // namespace sightline
