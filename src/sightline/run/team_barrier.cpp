#include "sightline/run/team_barrier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sightline/base/bounded.hpp"
#include "sightline/safety/zone.hpp"

namespace sightline {
namespace {

/// Options of a robot that lands: without the floor, and without that of its rooms.
BarrierOptions without_floor(BarrierOptions options) {
  options.floor = BarrierOptions{}.floor;
  options.zones = zones_to_land(std::move(options.zones));
  return options;
}

}  // namespace

std::pair<std::vector<double>, std::vector<double>> tightest_limits(
    const Team& team, BodyId robot, const std::vector<LimitsToCome>& to_come) {
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

std::vector<Ability> abilities_of(const Team& team, const std::vector<LimitsToCome>& to_come) {
  std::vector<Ability> all;
  std::vector<std::string_view> models;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (!team.is_agent(body)) continue;
    const Model& model = team.model(body);
    auto [u_min, u_max] = tightest_limits(team, body, to_come);
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

void validate_barriers(const Team& team, const GuardOptions& options) {
  const std::vector<Ability> abilities = abilities_of(team, options.limits_to_come);
  validate(options.barrier_options, options.period);
  for (std::size_t i = 0; i < abilities.size(); ++i)
    (void)Barrier(team.agents()[i].model, abilities[i].can, options.period, options.barrier_options);
}

BarrierOptions counted_options(const GuardOptions& options) {
  BarrierOptions counted = options.barrier_options;
  for (const double delay : options.command_delays)
    counted.command_delay = std::max(counted.command_delay, delay);
  return counted;
}

Neighbour counted_neighbour(const GuardOptions& options, BodyId robot, BodyId other,
                            const Sight<double>& seen, bool is_carried, double age, double sigma) noexcept {
  const BodySafety& safety = options.bodies[at(other)];
  const bool is_late = !is_carried && !options.command_delays.empty();
  return {.p = seen.p,
          .v = seen.v,
          .d_hard = safety.d_hard,
          .speed_max = safety.speed_max,
          .age = age + (is_late ? options.command_delays[at(robot)] : 0.0),
          .sigma = sigma,
          .tie = robot.index < other.index ? 1.0 : -1.0};
}

TeamBarrier::TeamBarrier(const Team& team, const GuardOptions& options)
    : team_(team),
      options_(options),
      oldest_(options.supervisor.value_or(SupervisorOptions{}).times.hold_after),
      before_(static_cast<std::size_t>(team.nu())),
      sights_(options.bodies.size()),
      threats_(team.bodies()) {
  const std::vector<Ability> abilities = abilities_of(team_, options_.limits_to_come);
  const BarrierOptions counted = counted_options(options_);
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
                       .barrier = barrier(counted),
                       .landing = barrier(without_floor(counted)),
                       .u_min = u_min,
                       .u_max = u_max,
                       .wanted = u_min,
                       .kept = u_min,
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
  pool_ = thread_pool_if(static_cast<int>(robots_.size()) >= GuardOptions::shared_from, options_.pool);
  for (int i = 0; i < pool_->threads(); ++i)
    requesters_.push_back({ThreatSelection::Requester(team_.bodies()),
                           std::vector<Neighbour>(options_.bodies.size()),
                           std::vector<BodyId>(options_.bodies.size())});
  records_.resize(robots_.size());
  conflicts_.reserve(robots_.size());
}

void TeamBarrier::set_limits(std::span<const InputLimits> limits) noexcept {
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].limits = &limits[i];
}

void TeamBarrier::keep_distances(double t, const TeamSituation& now, std::span<double> u) noexcept {
  conflicts_.clear();
  if (robots_.empty()) return;
  for (Robot& of : robots_) {
    now.limit(*of.limits, t, of.u, of.u_min, of.u_max);
    of.part = of.barrier.part(of.u_min, of.u_max);
  }
  see_all(now);
  pool_->share(static_cast<int>(robots_.size()),
               [&](int i, int thread) noexcept { keep_distance(now, at(i), u, requesters_[at(thread)]); });
  share_conflicts(now);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Robot& of = robots_[i];
    if (records_[i].conflict && !of.was_in_conflict) conflicts_.push_back(of.body);
    if (of.is_kept && options_.barrier == BarrierMode::on)
      std::copy(of.kept.begin(), of.kept.end(), u.begin() + static_cast<std::ptrdiff_t>(of.u));
  }
  std::copy(u.begin(), u.end(), before_.begin());
}

/// Collects all bodies that are in the world and were measured once. A robot of the team is at the
/// state where its command takes effect, an absent robot is where it was measured. Any other body
/// is at its last estimate, with a greater age.
void TeamBarrier::see_all(const TeamSituation& now) noexcept {
  threats_.clear();
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    const bool is_agent = team_.is_agent(body), is_there = now.is_there(body);
    if (!is_there && (!is_agent || now.absent.empty())) continue;
    if (!std::isfinite(now.ages[at(body)])) continue;
    const std::span<const double> states = !is_there ? now.absent : is_agent ? now.x : now.estimated;
    sights_[at(body)] = team_.model(body).sight(&states[static_cast<std::size_t>(team_.state_offset(body))],
                                                before_.data() + (is_agent ? team_.input_offset(body) : 0));
    const BodySafety& safety = options_.bodies[at(body)];
    threats_.add({i, sights_[at(body)].p, sights_[at(body)].v, safety.d_hard,
                  now.is_grounded(body) ? 0.0 : safety.speed_max});
  }
}

/// Whether a body keeps its distance to the robot as well, by its own barrier.
bool TeamBarrier::gives_way(const TeamSituation& now, const Robot& robot, BodyId other) const noexcept {
  // A robot behind a link lands by its autopilot.
  const Presence presence = now.presence[at(other)];
  if (presence == Presence::absent || (presence == Presence::land && !now.absent.empty())) return false;
  if (kinds_[at(robot.body)] != kinds_[at(other)] || robot.barrier.lags()) return false;
  if (team_.is_agent(other) ? now.is_grounded(other) : now.connectivity == nullptr) return false;
  return now.connectivity == nullptr || now.connectivity->receives_from(robot.body, other);
}

/// Standard deviation of a body's position, each axis [m].
double TeamBarrier::sigma_of(const TeamSituation& now, BodyId body) const noexcept {
  return now.sigmas[at(body)] > 0 ? std::min(now.sigmas[at(body)], Guard::sigma_most)
                                  : options_.position_sigma;
}

/// The data of another body for the barrier of a robot.
Neighbour TeamBarrier::neighbour_of(const TeamSituation& now, const Robot& robot,
                                    BodyId other) const noexcept {
  Neighbour neighbour = counted_neighbour(
      options_, robot.body, other, sights_[at(other)], team_.is_agent(other) && now.is_there(other),
      std::min(now.ages[at(other)], oldest_), norm(sigma_of(now, robot.body), sigma_of(now, other)));
  if (now.is_grounded(other)) neighbour.speed_max = 0.0;
  if (!gives_way(now, robot, other)) return neighbour;
  neighbour.behavior = Behavior::cooperative;
  if (team_.is_agent(other)) neighbour.part = robot_of(other).part;
  return neighbour;
}

/// The other bodies that a robot's barrier considers.
std::span<Neighbour> TeamBarrier::neighbours_of(const TeamSituation& now, const Robot& robot,
                                                Requester& requester) const noexcept {
  std::vector<Neighbour>& neighbours = requester.neighbours;
  std::size_t count = 0;
  const auto add = [&](BodyId other) {
    requester.others[count] = other;
    neighbours[count++] = neighbour_of(now, robot, other);
  };
  if (threats_.size() <= Barrier::most_neighbours + 1 || robot.barrier.drives()) {
    for (int i = 0; i < threats_.size(); ++i) {
      const BodyId other{threats_.id(i)};
      if (other != robot.body) add(other);
    }
    return std::span(neighbours).first(count);
  }
  for (int i = 0; i < threats_.size(); ++i)
    requester.threats.cooperative[at(i)] = gives_way(now, robot, BodyId{threats_.id(i)}) ? 1.0 : 0.0;
  const Sight<double>& self = sights_[at(robot.body)];
  for (const int other : threats_.nearest_threats(robot.body.index, self.p, self.v, Barrier::most_neighbours,
                                                  requester.threats))
    add(BodyId{other});
  return std::span(neighbours).first(count);
}

void TeamBarrier::keep_distance(const TeamSituation& now, std::size_t robot, std::span<const double> u,
                                Requester& requester) noexcept {
  Robot& of = robots_[robot];
  const FallbackLevel level = now.levels[at(of.body)];
  BarrierRecord& record = records_[robot];
  of.was_in_conflict = record.conflict;
  record = {};
  // The barrier neither acts on a grounded, absent or unmeasured robot, nor on one that its
  // autopilot lands, nor considers a body without a position.
  const bool descends = now.presence[at(of.body)] == Presence::land;
  of.is_kept = level != FallbackLevel::grounded && now.is_there(of.body) &&
               std::isfinite(now.ages[at(of.body)]) && !(descends && !now.absent.empty());
  if (!of.is_kept) {
    of.maneuver.plan = {};
    return;
  }
  of.lands = level == FallbackLevel::land || descends;
  const std::span<const double> wanted = u.subspan(of.u, of.nu);
  std::copy(wanted.begin(), wanted.end(), of.wanted.begin());
  of.maneuver_before = of.maneuver;
  filter(now, robot, neighbours_of(now, of, requester));
}

void TeamBarrier::filter(const TeamSituation& now, std::size_t robot,
                         std::span<const Neighbour> neighbours) noexcept {
  Robot& of = robots_[robot];
  std::copy(of.wanted.begin(), of.wanted.end(), of.kept.begin());
  of.maneuver = of.maneuver_before;
  const Barrier& barrier = of.lands ? of.landing : of.barrier;
  const BarrierResult result =
      barrier.filter(now.x.subspan(of.x, of.nx), neighbours, of.u_min, of.u_max, of.kept, of.maneuver);
  records_[robot] = {result.active, result.conflict, result.reserve};
}

/// What the command of a robot that shares a conflict lacks of its half of the distance to another
/// one [m]; any other robot provides its half.
double TeamBarrier::lacked(const TeamSituation& now, BodyId by, const Robot& robot) const noexcept {
  if (!team_.is_agent(by) || !robot_of(by).shares) return 0.0;
  const Robot& other = robot_of(by);
  const Neighbour neighbour = neighbour_of(now, other, robot.body);
  if (neighbour.behavior != Behavior::cooperative) return 0.0;
  return other.barrier.lacked(now.x.subspan(other.x, other.nx), neighbour, other.u_min, other.u_max,
                              other.kept);
}

/// Filters the command of a robot once more: it provides `more` times what the others' commands lack
/// of their halves, and may use what they provide beyond.
void TeamBarrier::filter_again(const TeamSituation& now, std::size_t robot, double more) noexcept {
  Requester& requester = requesters_.front();
  const std::span<Neighbour> neighbours = neighbours_of(now, robots_[robot], requester);
  for (std::size_t k = 0; k < neighbours.size(); ++k) {
    if (neighbours[k].behavior != Behavior::cooperative) continue;
    const double lacks = lacked(now, requester.others[k], robots_[robot]);
    neighbours[k].lacks = lacks > 0 ? more * lacks : lacks;
  }
  filter(now, robot, neighbours);
  robots_[robot].shares = true;
}

/// Where a robot cannot provide its half of a distance, since other bodies or walls are in its way,
/// the other robot provides the rest: the halves are of a sum, which alone counts.
void TeamBarrier::share_conflicts(const TeamSituation& now) noexcept {
  constexpr int most = 16;         // commands filtered again, which bounds the time of a period
  constexpr double slight = 1e-6;  // [m]
  // A robot without a command that keeps all distances misses each by the same amount. Twice this
  // amount frees it of one distance, so that it can keep the others. One that a wall stops does not
  // miss less for that: later no more than what is missed.
  constexpr std::array rounds = {2.0, 1.0, 1.0};
  int left = most;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    robots_[i].shares = records_[i].conflict && !robots_[i].barrier.drives();
  for (const double more : rounds) {
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const Robot& of = robots_[i];
      if (!of.shares || !records_[i].conflict) continue;
      Bounded<std::size_t, Barrier::most_neighbours> partners;
      Requester& requester = requesters_.front();
      const std::span<const Neighbour> neighbours = neighbours_of(now, of, requester);
      for (std::size_t k = 0; k < neighbours.size() && !partners.is_full(); ++k) {
        const BodyId other = requester.others[k];
        if (neighbours[k].behavior == Behavior::cooperative && team_.is_agent(other))
          partners.push_back(team_.agent_index(other));
      }
      for (const std::size_t partner : partners) {
        if (left < 2 || lacked(now, of.body, robots_[partner]) <= slight) continue;
        filter_again(now, partner, more);
        --left;
      }
      if (left == 0) return;
      // Alone it would receive the same command.
      if (std::none_of(partners.begin(), partners.end(), [&](std::size_t p) { return robots_[p].shares; }))
        continue;
      filter_again(now, i, more);
      --left;
    }
  }
}

}  // namespace sightline
