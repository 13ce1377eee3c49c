#include "sightline/judge/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/judge/event_description.hpp"
#include "sightline/potential/protection.hpp"

namespace sightline {
namespace {

constexpr double lost_after = 2.0;        // this long out of view at the end is a failure [s]
constexpr std::size_t events_max = 1000;  // in the summary; the log has all

/// True if two potentials of one kind state the same limit, compared at some near and far
/// positions.
bool same_limit(const Potential& a, const Potential& b) {
  constexpr double far = 1000.0;  // [m]
  constexpr std::array<Vec3<double>, 7> places = {
      {{1.0, 0.5, 0.25}, {far, 0, 0}, {-far, 0, 0}, {0, far, 0}, {0, -far, 0}, {0, 0, far}, {0, 0, -far}}};
  return a.name() == b.name() && std::all_of(places.begin(), places.end(), [&](const Vec3<double>& p) {
           const Sight<double> one{{p, {1.0, 0.0}}, {}}, other{{{}, {1.0, 0.0}}, {}};
           return a.violation(one, other) == b.violation(one, other);
         });
}

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : no_value;
}

// An extreme starts at infinity and stays there without samples.
double counted(double value) { return std::isfinite(value) ? value : no_value; }

}  // namespace

Summary::Summary(const Scenario& scenario, std::size_t controllers)
    : scenario_(scenario),
      present_(scenario),
      safety_(scenario),
      plans_(scenario, controllers),
      localization_(scenario),
      period_(scenario.horizon.dt),
      leans_(leaning_bodies(scenario)),
      inputs_(scenario),
      drift_(scenario.team, scenario.simulation.settle) {
  const Team& team = scenario_.team;
  const std::vector<Coupling> couplings = all_couplings(scenario_);
  for (const Observation& pair : observations(couplings)) add_view(pair);
  for (const Coupling& c : couplings) {
    add_limit(c.term.potential, c.between.first, c.between.second, c.third);
  }
  for (const Constraint& c : team.constraints()) add_limit(c.term.potential, c.agent, c.agent, {});
  for (int i = 0; i < team.bodies(); ++i) {
    if (!team.is_agent(BodyId{i})) continue;
    robots_.push_back({BodyId{i}, TrackingError(team.model(BodyId{i}), scenario.simulation.rms_from)});
    robots_.back().leans = leans_[at(BodyId{i})];
  }
  sights_.resize(static_cast<std::size_t>(team.bodies()));
  presence_.assign(sights_.size(), Presence::steered);
  find_what_is_in_force();
  const double solves = scenario_.simulation.duration / period_ * static_cast<double>(controllers);
  solve_us_.reserve(static_cast<std::size_t>(std::clamp(solves, 0.0, 1e6)) + 1);
}

void Summary::add_view(const Observation& pair) {
  views_.push_back({pair, infinity, -infinity, -infinity, no_value, no_value});
  views_.back().from_leaning = leans_[at(pair.observer)];
}

void Summary::add_limit(const Potential& potential, BodyId a, BodyId b, BodyId third) {
  if (potential.violation({}, {}) == -infinity) return;
  const Team& team = scenario_.team;
  const std::string who =
      a == b ? std::string(team.name(a)) : fmt::format("{}-{}", team.name(a), team.name(b));
  const std::string past = third.index < 0 ? "" : fmt::format(" past {}", team.name(third));
  limits_.push_back({fmt::format("{} {}{}", potential.name(), who, past), potential, a, b, no_value});
  limits_.back().third = third;
}

/// Views and limits count only while their couplings or constraints are in force.
void Summary::find_what_is_in_force() {
  const std::vector<Coupling> couplings = present_.couplings();
  const std::vector<Constraint> constraints = present_.constraints();
  const std::vector<Observation> observed = observations(couplings);
  // Add pairs that only became known during the flight.
  for (const Observation& o : observed) {
    const auto same = [&](const View& v) { return is_same_view(v.pair, o); };
    if (std::none_of(views_.begin(), views_.end(), same)) add_view(o);
  }
  for (View& view : views_) {
    const auto now = std::find_if(observed.begin(), observed.end(),
                                  [&](const Observation& o) { return is_same_view(o, view.pair); });
    const bool was_in_force = std::exchange(view.in_force, now != observed.end());
    if (view.in_force) view.pair.potential = now->potential, view.pair.third = now->third;
    if (view.in_force && !was_in_force) view.in_since = view.out_since = no_value;
  }
  find_limits_in_force(couplings, constraints);
  const std::vector<BodyId> requested = present_.observers();
  for (Robot& robot : robots_) {
    const bool observes = std::any_of(views_.begin(), views_.end(), [&](const View& view) {
      return view.in_force && view.pair.observer == robot.body;
    });
    robot.is_idle = !observes && std::find(requested.begin(), requested.end(), robot.body) != requested.end();
  }
}

/// Each of several equal limits on the same bodies has its own entry in limits_.
void Summary::find_limits_in_force(const std::vector<Coupling>& couplings,
                                   const std::vector<Constraint>& constraints) {
  struct Stated {
    const Potential* potential;
    BodyId a, b, third{};
  };
  std::vector<Stated> stated;
  for (const Coupling& c : couplings) {
    stated.push_back({&c.term.potential, c.between.first, c.between.second, c.third});
  }
  for (const Constraint& c : constraints) stated.push_back({&c.term.potential, c.agent, c.agent});
  for (Limit& limit : limits_) limit.in_force = false;
  const auto take = [&](const Stated& s, auto&& fits) {
    const auto limit = std::find_if(limits_.begin(), limits_.end(), [&](const Limit& l) {
      return !l.in_force && l.a == s.a && l.b == s.b && l.third == s.third && fits(l);
    });
    if (limit == limits_.end()) return false;
    limit->in_force = true;
    limit->potential = *s.potential;
    return true;
  };
  // Equal limits continue. A minimum distance that was removed while broken is judged until the
  // bodies have separated.
  std::erase_if(stated, [&](const Stated& s) {
    return take(s, [&](const Limit& limit) { return same_limit(limit.potential, *s.potential); });
  });
  for (Limit& limit : limits_) {
    if (!limit.in_force && !keeps_apart(limit.potential)) limit.broken_since = no_value;
  }
  // A new limit continues an ended one of its kind, or begins.
  for (const Stated& s : stated) {
    const bool follows = take(s, [&](const Limit& limit) {
      return std::isnan(limit.broken_since) && limit.potential.name() == s.potential->name();
    });
    if (!follows) add_limit(*s.potential, s.a, s.b, s.third);
  }
}

void Summary::add(const Sample& sample) {
  if (sample.of == Sample::Of::states) return add_states(sample);
  if (present_.follow(sample)) {
    find_what_is_in_force();
    drift_.restart(present_.couplings());
  }
  std::copy(sample.presence.begin(), sample.presence.end(), presence_.begin());
  ++updates_;
  end_ = sample.time + period_;
  if (!all_finite(sample)) ++not_finite_;
  stage_cost_ = present_.cost(sample);
  cost_ += period_ * stage_cost_;
  look(sample);
  inputs_.add(sample, present_);
  add_robots(sample);
  add_views(sample);
  add_limits(sample.time);
  add_solvers(sample);
  plans_.add(sample);
  localization_.add(sample);
  drift_.add(sample, sights_, present_);
}

/// States without an update: positions are judged, references and couplings are not.
void Summary::add_states(const Sample& sample) {
  if (!all_finite(sample)) ++not_finite_;
  look(sample);
  inputs_.add_states(sample, present_);
  add_events(sample);
  drift_.add(sample, sights_, present_);
}

void Summary::look(const Sample& sample) {
  for (int i = 0; i < scenario_.team.bodies(); ++i)
    sights_[at(BodyId{i})] = true_sight(scenario_.team, BodyId{i}, sample);
  safety_.add(sample, sights_);
}

void Summary::add_robots(const Sample& sample) {
  for (Robot& robot : robots_) {
    if (robot.is_idle) robot.idle.count(sample.time, period_);
    if (robot.leans && is_there(robot.body)) {
      const bool settled = sample.time >= scenario_.simulation.settle - same_time;
      const Vec2<double>& lean = sight(robot.body).lean;
      const double steep = norm(lean.x, lean.y);
      if (settled) robot.steepest = std::max(robot.steepest, steep);
      robot.planned.add(scenario_.team, robot.body, sample, std::atan(steep), settled);
    }
    if (const Agent* const steered = present_.agent(robot.body))
      robot.error.add(*steered, sample.time, sight(robot.body));
  }
}

void Summary::add_views(const Sample& sample) {
  const double time = sample.time;
  for (View& view : views_) {
    if (!view.in_force) continue;
    view.time.count(time, period_);
    const auto seen_of = [&](BodyId body) { return sight(body); };
    const Sight<double> observer = first_sight(seen_of, view.pair.observer, view.pair.third);
    const Sight<double>& target = sight(view.pair.target);
    const double angle = view_angle(view.pair.mount, observer, target.p);
    const bool seen = is_in_view(view.pair, observer, target, time);
    double &begun = seen ? view.in_since : view.out_since, &over = seen ? view.out_since : view.in_since;
    if (std::isnan(begun)) begun = time;
    over = no_value;
    const bool settled = time >= scenario_.simulation.settle - same_time;
    if (view.from_leaning) view.planned.add(scenario_.team, view.pair, sample, angle, settled);
    if (!settled) continue;
    const double distance = norm(observer.p - target.p);
    view.nearest = std::min(view.nearest, distance);
    view.farthest = std::max(view.farthest, distance);
    view.angle_max = std::max(view.angle_max, angle);
    view.angles += angle;
    ++view.settled;
    view.seen += seen ? 1 : 0;
  }
}

void Summary::add_limits(double time) {
  for (Limit& limit : limits_) {
    const bool all_there =
        is_there(limit.a) && is_there(limit.b) && (limit.third.index < 0 || is_there(limit.third));
    if (!limit.in_force && (std::isnan(limit.broken_since) || !all_there)) continue;
    const auto seen_of = [&](BodyId body) { return sight(body); };
    const double excess =
        limit.potential.violation(first_sight(seen_of, limit.a, limit.third), sight(limit.b), time);
    if (excess <= 0) limit.broken_since = no_value;
    if (excess <= 0 && !limit.in_force) continue;
    ++limit.counted;
    limit.time.count(time, period_);
    if (excess <= 0) continue;
    if (std::isnan(limit.broken_since)) limit.broken_since = time;
    ++limit.broken;
    limit.longest = std::max(limit.longest, end_ - limit.broken_since);
    limit.worst = std::max(limit.worst, excess);
  }
}

void Summary::add_solvers(const Sample& sample) {
  std::int64_t allocations = 0;
  for (const SolverRecord& record : sample.solvers) {
    ++statuses_[static_cast<std::size_t>(record.status)];
    solve_us_.add(record.solve_us);
    allocations += record.allocations;
    pairs_ = std::max(pairs_, record.pairs);
  }
  allocations_ = std::max(allocations_, allocations);
  add_events(sample);
}

void Summary::add_events(const Sample& sample) {
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[static_cast<std::size_t>(i)];
    if (event.kind == EventKind::pairs_left_out)
      left_out_ = std::max(left_out_, static_cast<int>(event.value));
    if (event.kind != EventKind::solver_status && events_.size() < events_max) events_.push_back(event);
  }
}

std::vector<std::string> Summary::out_of_view() const {
  const Team& team = scenario_.team;
  std::vector<std::string> sentences;
  for (const View& view : views_) {
    if (view.in_force && end_ - view.out_since >= lost_after - same_time) {
      sentences.push_back(fmt::format("{} has not seen {} since {:.2f} s", team.name(view.pair.observer),
                                      team.name(view.pair.target), view.out_since));
    }
  }
  return sentences;
}

std::vector<SummaryValues::Chatter> Summary::chatter() const {
  const Team& team = scenario_.team;
  const auto is_region = [](const Weighted& term) { return term.potential.rounding().has_value(); };
  const auto feels_region = [&](BodyId robot) {
    const auto felt = [&](const Coupling& c) {
      return is_region(c.term) && std::count(c.felt_by.begin(), c.felt_by.end(), robot) > 0;
    };
    const auto own = [&](const Constraint& c) { return is_region(c.term) && c.agent == robot; };
    const std::vector<Coupling> couplings = all_couplings(scenario_);
    return std::any_of(couplings.begin(), couplings.end(), felt) ||
           std::any_of(team.constraints().begin(), team.constraints().end(), own);
  };
  std::vector<SummaryValues::Chatter> all;
  for (const Chatter::Found& found : inputs_.chatter().found()) {
    const auto robot = std::find_if(robots_.rbegin(), robots_.rend(), [&](const Robot& r) {
      return static_cast<std::size_t>(team.input_offset(r.body)) <= found.input;
    });
    const std::size_t input = found.input - static_cast<std::size_t>(team.input_offset(robot->body));
    all.push_back({std::string(team.name(robot->body)), std::string(team.model(robot->body).inputs()[input]),
                   found.from, found.share, found.jump, feels_region(robot->body)});
  }
  return all;
}

SummaryValues Summary::values() const {
  const Team& team = scenario_.team;
  const auto name = [&](BodyId body) { return std::string(team.name(body)); };
  SummaryValues v;
  v.updates = updates_;
  v.cost = cost_;
  v.solve_us = {solve_us_.mean(), solve_us_.quantile(0.5), solve_us_.quantile(0.99), solve_us_.greatest()};
  v.allocations_per_update = allocations_;
  v.statuses = statuses_;
  v.not_finite = not_finite_;
  v.input_violations = inputs_.raw_beyond();
  v.applied_violations = inputs_.beyond();
  v.max_abs_input = inputs_.largest_raw();
  v.pairs_active_max = pairs_;
  v.pairs_left_out_max = left_out_;
  v.min_distance = counted(safety_.least_distance());
  for (const View& view : views_) {
    const RobotCamera* const camera = scenario_.vision.camera_of(view.pair.observer, &view.pair.mount);
    v.pairs.push_back({name(view.pair.observer), name(view.pair.target),
                       camera == nullptr ? std::string() : camera->sensor, counted(view.nearest),
                       counted(view.farthest), counted(view.angle_max), view.in_since,
                       share(view.seen, view.settled), view.time, view.from_leaning,
                       view.settled > 0 ? view.angles / static_cast<double>(view.settled) : no_value,
                       view.planned.rms(), view.planned.mean()});
  }
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Robot& robot = robots_[i];
    const InputRecord::Robot& inputs = inputs_.robots()[i];
    v.robots.push_back({name(robot.body), robot.error.rms_position(), robot.error.offset(),
                        robot.error.rms_rest(), robot.error.rms_heading(), inputs.energy,
                        robot.leans ? std::atan(robot.steepest) : no_value, robot.planned.max(),
                        robot.planned.rms(),
                        team.agent(robot.body).rate_max.empty() ? no_value : inputs.rate_ratio});
    if (robot.idle.total > 0) v.idle_observers.push_back({name(robot.body), robot.idle});
  }
  for (const Limit& limit : limits_) {
    v.limits.push_back({limit.name, share(limit.broken, limit.counted), limit.longest, limit.worst,
                        std::string(limit.potential.limit_unit()), limit.time});
  }
  v.chatter = chatter();
  if (const auto found = drift_.found()) {
    v.drift.emplace();
    for (const Drift::Found& drift : *found)
      v.drift->push_back({name(drift.robot), drift.v, drift.from_reference});
  }
  for (const Event& event : events_) {
    v.events.push_back({event.time, event_words(to_string(event.kind), event.value,
                                                {[&](int body) { return name(BodyId{body}); },
                                                 [&](int place) {
                                                   const TeamEvent* const of =
                                                       flown_event(scenario_.script, scenario_.tuned.get(),
                                                                   static_cast<std::size_t>(place));
                                                   return of != nullptr ? of->name : "?";
                                                 }})});
  }
  return v;
}

}  // namespace sightline
