#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"

namespace sightline {
namespace {

GuardOptions completed(const Team& team, GuardOptions options) {
  options.bodies.resize(static_cast<std::size_t>(team.bodies()));
  return options;
}

std::optional<Supervisor> supervisor_of(const Team& team, const GuardOptions& options) {
  if (!options.supervisor) return std::nullopt;
  SupervisorOptions supervisor = *options.supervisor;
  supervisor.command_delays = options.command_delays;
  return std::optional<Supervisor>(std::in_place, team, supervisor);
}

BarrierOptions without_floor(BarrierOptions options) {
  options.floor = BarrierOptions{}.floor;
  return options;
}

/// The tightest limits of a robot over the run.
std::pair<std::vector<double>, std::vector<double>> tightest(const Team& team, BodyId robot,
                                                             const std::vector<LimitsToCome>& to_come) {
  const Agent& agent = team.agent(robot);
  std::vector<double> u_min = agent.limits.u_min().front(), u_max = agent.limits.u_max().front();
  const auto tighten = [&](const InputLimits& limits) {
    for (std::size_t k = 0; k < limits.times().size(); ++k) {
      for (std::size_t i = 0; i < u_min.size(); ++i) {
        u_min[i] = std::max(u_min[i], limits.u_min()[k][i]);
        u_max[i] = std::min(u_max[i], limits.u_max()[k][i]);
      }
    }
  };
  tighten(agent.limits);
  for (const LimitsToCome& next : to_come) {
    if (next.robot == robot) tighten(next.limits);
  }
  for (std::size_t i = 0; i < u_min.size(); ++i) {
    if (u_min[i] <= u_max[i]) continue;
    throw std::invalid_argument(
        fmt::format("the limits of \"{}\" over the run have no {} in common, expected some that the barrier "
                    "can always give",
                    agent.name, agent.model.inputs()[i]));
  }
  return {u_min, u_max};
}

/// A robot's abilities within its tightest limits, and its kind.
struct Ability {
  std::vector<double> u_min, u_max;
  Authority can;
  int kind;  // robots of one kind have like motion and rely on each other
};

/// The abilities of each robot. Robots of one kind use the least acceleration and the greatest push
/// and rise among them, so that each robot's assumptions about the others hold.
std::vector<Ability> abilities_of(const Team& team, const std::vector<LimitsToCome>& to_come) {
  std::vector<Ability> all;
  std::vector<std::string_view> models;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (!team.is_agent(body)) continue;
    const Model& model = team.model(body);
    auto [u_min, u_max] = tightest(team, body, to_come);
    const Authority can = authority_of(model, u_min, u_max);
    int kind = static_cast<int>(all.size());
    for (std::size_t r = all.size(); r-- > 0;)
      if (models[r] == model.name() && moves_alike(all[r].can, can)) kind = all[r].kind;
    models.push_back(model.name());
    all.push_back({std::move(u_min), std::move(u_max), can, kind});
  }
  for (Ability& one : all) {
    for (const Ability& other : all) {
      if (one.kind != other.kind) continue;
      one.can.acceleration = std::min(one.can.acceleration, other.can.acceleration);
      one.can.push = std::max(one.can.push, other.can.push);
      one.can.rise = std::max(one.can.rise, other.can.rise);
    }
  }
  return all;
}

EventKind kind_of(FallbackLevel level) {
  switch (level) {
    case FallbackLevel::valid:
      return EventKind::valid;
    case FallbackLevel::predicted:
      return EventKind::predicted;
    case FallbackLevel::slowed:
      return EventKind::slowed;
    case FallbackLevel::hold:
      return EventKind::hold;
    case FallbackLevel::land:
      return EventKind::land;
    case FallbackLevel::grounded:
      break;
  }
  return EventKind::grounded;
}

EventKind kind_of(MeasurementFault fault) {
  switch (fault) {
    case MeasurementFault::none:  // never in a notice
    case MeasurementFault::not_finite:
      return EventKind::measurement_not_finite;
    case MeasurementFault::heading:
      return EventKind::measurement_heading;
    case MeasurementFault::world:
      return EventKind::measurement_world;
    case MeasurementFault::speed:
      return EventKind::measurement_speed;
    case MeasurementFault::jump:
      return EventKind::measurement_jump;
    case MeasurementFault::frozen:
      return EventKind::measurement_frozen;
    case MeasurementFault::time:
      break;
  }
  return EventKind::measurement_time;
}

EventKind kind_of(const Notice& notice) {
  return std::visit([](auto what) { return kind_of(what); }, notice.what);
}

}  // namespace

void validate(const Team& team, const GuardOptions& options) {
  if (options.supervisor) validate(team, *options.supervisor);
  validate(team, options.searchers, options.search);
  if (options.barrier == BarrierMode::off) return;
  (void)abilities_of(team, options.limits_to_come);
  validate(options.barrier_options, options.period);
}

Guard::Guard(const Team& team, const GuardOptions& options)
    : team_(team),
      options_(completed(team, options)),
      stale_(options_.bodies.size()),
      supervisor_(supervisor_of(team, options)),
      search_(team_, options_.searchers, options_.search),
      searches_(options_.searchers.size()),
      estimated_(team, std::vector<double>(static_cast<std::size_t>(team.nx()))),
      ages_(options_.bodies.size()),
      stamps_(options_.bodies.size()),
      before_(static_cast<std::size_t>(team.nu())),
      sigmas_(options_.bodies.size()),
      presence_(options_.bodies.size(), Presence::steered),
      levels_(options_.bodies.size(), FallbackLevel::valid),
      oldest_(options.supervisor.value_or(SupervisorOptions{}).times.hold_after) {
  events_.reserve(4 * options_.bodies.size());
  if (options_.barrier == BarrierMode::off) return;
  const std::vector<Ability> abilities = abilities_of(team_, options_.limits_to_come);
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    if (!team_.is_agent(body)) continue;
    const Agent& agent = team_.agent(body);
    const auto& [u_min, u_max, can, kind] = abilities[robots_.size()];
    const auto barrier = [&, &ability = can](const BarrierOptions& o) {
      return Barrier(agent.model, ability, options_.period, o);
    };
    robots_.push_back({.body = body,
                       .x = static_cast<std::size_t>(team_.state_offset(body)),
                       .u = static_cast<std::size_t>(team_.input_offset(body)),
                       .nx = static_cast<std::size_t>(agent.model.nx()),
                       .nu = u_min.size(),
                       .barrier = barrier(options_.barrier_options),
                       .landing = barrier(without_floor(options_.barrier_options)),
                       .u_min = u_min,
                       .u_max = u_max,
                       .reported = u_min,
                       .limits = &agent.limits});
  }
  // A robot of another part is known by its model's name.
  kinds_.assign(options_.bodies.size(), -1);
  for (std::size_t r = 0; r < robots_.size(); ++r) kinds_[at(robots_[r].body)] = abilities[r].kind;
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    if (team_.is_agent(body)) continue;
    for (std::size_t r = robots_.size(); r-- > 0;) {
      if (team_.model(robots_[r].body).name() == options_.bodies[at(body)].robot)
        kinds_[at(body)] = abilities[r].kind;
    }
  }
  sights_.resize(options_.bodies.size());
  threats_ = ThreatSelection(team_.bodies());
  pool_ = thread_pool_if(static_cast<int>(robots_.size()) >= GuardOptions::shared_from, options_.pool);
  for (int i = 0; i < pool_->threads(); ++i)
    requesters_.push_back(
        {ThreatSelection::Requester(team_.bodies()), std::vector<Neighbour>(options_.bodies.size())});
  records_.resize(robots_.size());
}

const ValidStates& Guard::accept_measurement(double t, std::span<const double> measured,
                                             std::span<const double> stamps,
                                             std::span<const double> sigma) noexcept {
  events_.clear();
  if (sigma.empty())
    std::fill(sigmas_.begin(), sigmas_.end(), 0.0);
  else
    std::copy(sigma.begin(), sigma.end(), sigmas_.begin());
  if (supervisor_) {
    const std::span<const double> estimate = supervisor_->accept_measurement(t, measured, stamps, sigma);
    for (std::size_t i = 0; i < ages_.size(); ++i) {
      ages_[i] = std::max(0.0, supervisor_->age(BodyId{static_cast<int>(i)}));
      stamps_[i] = t - ages_[i];
    }
    return estimated_.take(estimate, stamps_);
  }
  (void)estimated_.take(measured, stamps);
  awaits_position_ = false;
  for (std::size_t i = 0; i < ages_.size(); ++i) {
    const bool known = !std::isinf(sigmas_[i]);
    ages_[i] = known ? std::max(0.0, t - estimated_.stamps()[i]) : infinity;
    awaits_position_ |= !known && presence_[i] != Presence::absent;
  }
  return estimated_;
}

void Guard::follow(const Membership& now, double t, std::span<const double> x) noexcept {
  std::copy(now.presence.begin(), now.presence.end(), presence_.begin());
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].limits = &now.limits[i];
  if (supervisor_) supervisor_->follow(now, t, x);
  search_.follow(now);
}

void Guard::look(double t, std::span<const View> views) noexcept {
  search_.look(t, views, estimated_);
  for (int i = 0; i < search_.robots(); ++i) {
    const SearchPhase phase = search_.phase(i);
    const bool ends = phase == SearchPhase::none;
    if (phase == SearchPhase::stand || ends != searches_[at(i)]) continue;
    searches_[at(i)] = !ends;
    tell({t, ends ? EventKind::found : EventKind::search, 0, static_cast<double>(search_.robot(i).index)});
  }
}

/// Reports bodies whose messages become stale, and those that are received again.
void Guard::emit_stale(double t) noexcept {
  for (int i = 0; connectivity_ != nullptr && i < team_.bodies(); ++i) {
    const bool stale = is_there(BodyId{i}) && !connectivity_->is_received(BodyId{i});
    if (stale == (stale_[at(i)] != 0)) continue;
    stale_[at(i)] = stale;
    tell({t, stale ? EventKind::stale : EventKind::received, 0, static_cast<double>(i)});
  }
}

void Guard::fall_back(double t, const ValidStates& x, std::span<const double> plan_ages,
                      std::span<const double> added, std::span<double> u) noexcept {
  if (supervisor_) {
    supervisor_->command(t, x, plan_ages, added, u);
    for (const Notice& notice : supervisor_->notices()) {
      tell({t, kind_of(notice), 0, static_cast<double>(notice.body.index)});
    }
    for (int i = 0; i < team_.bodies(); ++i) {
      const BodyId body{i};
      if (team_.is_agent(body)) levels_[at(body)] = supervisor_->level(body);
    }
  }
  search_.command(t, x, levels_, added, u);
  emit_stale(t);
}

void Guard::keep_distances(double t, const ValidStates& x, std::span<const double> added,
                           std::span<double> u) noexcept {
  for (Robot& of : robots_) {
    of.limits->at(t, of.u_min, of.u_max);
    for (std::size_t k = 0; k < of.nu; ++k) of.u_min[k] -= added[of.u + k], of.u_max[k] -= added[of.u + k];
    of.part = of.barrier.part(of.u_min, of.u_max);
  }
  if (!robots_.empty()) {
    see_all(x);
    pool_->share(static_cast<int>(robots_.size()),
                 [&](int i, int thread) noexcept { keep_distance(at(i), x, u, requesters_[at(thread)]); });
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      if (records_[i].conflict && !robots_[i].was_in_conflict)
        tell({t, EventKind::barrier_conflict, 0, static_cast<double>(robots_[i].body.index)});
    }
  }
  std::copy(u.begin(), u.end(), before_.begin());
}

/// Collects all bodies that are present and were measured once. A robot of the team is at the state
/// where its command takes effect; any other body is at its last estimate, with a greater age.
void Guard::see_all(std::span<const double> x) noexcept {
  threats_.clear();
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    if (!is_there(body) || !std::isfinite(ages_[at(body)])) continue;
    const bool is_agent = team_.is_agent(body);
    sights_[at(body)] = team_.model(body).sight(
        &(is_agent ? x
                   : std::span<const double>(estimated_))[static_cast<std::size_t>(team_.state_offset(body))],
        before_.data() + (is_agent ? team_.input_offset(body) : 0));
    const BodySafety& safety = options_.bodies[at(body)];
    threats_.add({i, sights_[at(body)].p, sights_[at(body)].v, safety.d_hard,
                  is_grounded(body) ? 0.0 : safety.speed_max});
  }
}

/// Whether a body keeps its distance to the robot as well, by its own barrier.
bool Guard::gives_way(const Robot& robot, BodyId other) const noexcept {
  if (kinds_[at(robot.body)] != kinds_[at(other)] || robot.barrier.climbs_late()) return false;
  if (team_.is_agent(other) ? is_grounded(other) : connectivity_ == nullptr) return false;
  return connectivity_ == nullptr || connectivity_->receives_from(robot.body, other);
}

void Guard::record(double t, std::span<const double> u) noexcept {
  if (supervisor_) supervisor_->record(t, u);
}

/// Standard deviation of a body's position, each axis [m].
double Guard::sigma_of(BodyId body) const noexcept {
  return sigmas_[at(body)] > 0 ? std::min(sigmas_[at(body)], sigma_most) : options_.position_sigma;
}

/// The data of another body for the barrier of a robot.
Neighbour Guard::neighbour_of(const Robot& robot, BodyId other) const noexcept {
  const Sight<double>& sight = sights_[at(other)];
  const BodySafety& safety = options_.bodies[at(other)];
  Neighbour neighbour{
      .p = sight.p,
      .v = sight.v,
      .d_hard = safety.d_hard,
      .speed_max = is_grounded(other) ? 0.0 : safety.speed_max,
      .age = std::min(ages_[at(other)], oldest_) + (team_.is_agent(other) ? 0.0 : delay_of(robot.body)),
      .sigma = norm(sigma_of(robot.body), sigma_of(other)),
      .tie = robot.body.index < other.index ? 1.0 : -1.0};
  if (!gives_way(robot, other)) return neighbour;
  neighbour.behavior = Behavior::cooperative;
  if (team_.is_agent(other)) neighbour.part = robot_of(other).part;
  return neighbour;
}

/// The other bodies that a robot's barrier considers.
std::span<const Neighbour> Guard::neighbours_of(const Robot& robot, Requester& requester) const noexcept {
  std::vector<Neighbour>& neighbours = requester.neighbours;
  std::size_t count = 0;
  if (threats_.size() <= Barrier::most_neighbours + 1) {
    for (int i = 0; i < threats_.size(); ++i) {
      const BodyId other{threats_.id(i)};
      if (other != robot.body) neighbours[count++] = neighbour_of(robot, other);
    }
    return std::span(neighbours).first(count);
  }
  for (int i = 0; i < threats_.size(); ++i)
    requester.threats.cooperative[at(i)] = gives_way(robot, BodyId{threats_.id(i)}) ? 1.0 : 0.0;
  const Sight<double>& self = sights_[at(robot.body)];
  for (const int other : threats_.nearest_threats(robot.body.index, self.p, self.v, Barrier::most_neighbours,
                                                  requester.threats))
    neighbours[count++] = neighbour_of(robot, BodyId{other});
  return std::span(neighbours).first(count);
}

void Guard::keep_distance(std::size_t robot, std::span<const double> x, std::span<double> u,
                          Requester& requester) noexcept {
  Robot& of = robots_[robot];
  const FallbackLevel level = supervisor_ ? supervisor_->level(of.body) : FallbackLevel::valid;
  BarrierRecord& record = records_[robot];
  of.was_in_conflict = record.conflict;
  record = {};
  // The barrier neither acts on a grounded, absent or unmeasured robot, nor considers a body
  // without a position.
  if (level == FallbackLevel::grounded || !is_there(of.body) || !std::isfinite(ages_[at(of.body)])) return;
  const std::span<double> applied = u.subspan(of.u, of.nu);
  std::copy(applied.begin(), applied.end(), of.reported.begin());
  const bool lands = level == FallbackLevel::land || presence_[at(of.body)] == Presence::land;
  const Barrier& barrier = lands ? of.landing : of.barrier;
  const BarrierResult result =
      barrier.filter(x.subspan(of.x, of.nx), neighbours_of(of, requester), of.u_min, of.u_max,
                     options_.barrier == BarrierMode::on ? applied : std::span(of.reported), of.maneuver);
  record = {result.active, result.conflict, result.reserve};
}

void Guard::tell(const Event& event) noexcept {
  if (events_.size() < events_.capacity()) events_.push_back(event);
}

}  // namespace sightline
