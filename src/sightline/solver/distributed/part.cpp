#include "sightline/solver/distributed/part.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "sightline/base/index.hpp"

namespace sightline {
namespace {

bool is_among(std::span<const AgentId> agents, BodyId body) {
  return std::find(agents.begin(), agents.end(), body) != agents.end();
}

/// Who of the part feels it.
std::vector<AgentId> felt_within(const Coupling& coupling, std::span<const AgentId> own) {
  std::vector<AgentId> feel;
  for (const AgentId agent : coupling.felt_by) {
    if (is_among(own, agent)) feel.push_back(agent);
  }
  return feel;
}

}  // namespace

Team part_of(const Team& whole, std::span<const AgentId> own) {
  if (own.empty()) throw std::invalid_argument("a part has no robot, expected at least one");
  for (const AgentId agent : own) {
    if (agent.index < 0 || agent.index >= whole.bodies() || !whole.is_agent(agent)) {
      throw std::invalid_argument(
          fmt::format("a part names body {}, expected a robot of the team", agent.index));
    }
  }
  std::vector<bool> seen(at(whole.bodies()), false);
  for (const Coupling& c : whole.couplings()) {
    if (felt_within(c, own).empty()) continue;
    seen[at(c.between.first.index)] = seen[at(c.between.second.index)] = true;
  }
  Team part;
  for (int i = 0; i < whole.bodies(); ++i) {
    if (is_among(own, BodyId{i})) part.add(whole.agent(BodyId{i}));
  }
  for (int i = 0; i < whole.bodies(); ++i) {
    if (seen[at(i)] && !is_among(own, BodyId{i})) part.add(Obstacle{std::string(whole.name(BodyId{i}))});
  }
  const auto here = [&](BodyId body) { return part.find(whole.name(body)); };
  for (const Coupling& c : whole.couplings()) {
    std::vector<AgentId> feel = felt_within(c, own);
    if (feel.empty()) continue;
    for (AgentId& agent : feel) agent = AgentId{here(agent)};
    Coupling of_part = c;
    of_part.between = {here(c.between.first), here(c.between.second)};
    of_part.felt_by = std::move(feel);
    part.couple(std::move(of_part));
  }
  for (const Swarm& swarm : whole.swarms()) {
    std::vector<AgentId> members;
    for (const AgentId agent : swarm.agents) {
      if (is_among(own, agent)) members.push_back(AgentId{here(agent)});
    }
    if (members.empty()) continue;
    if (members.size() < swarm.agents.size()) {
      throw std::invalid_argument(
          fmt::format("{} keeps robots of several parts apart, expected all of a swarm in one part",
                      swarm.term.potential.name()));
    }
    part.keep_apart(swarm.term, std::move(members), swarm.radius, swarm.capacity);
  }
  for (const Constraint& c : whole.constraints()) {
    if (!is_among(own, c.agent)) continue;
    Constraint of_part = c;
    of_part.agent = AgentId{here(c.agent)};
    part.constrain(std::move(of_part));
  }
  for (const BarrierTerm& b : whole.barriers()) {
    if (is_among(own, b.agent)) part.constrain(b.barrier, AgentId{here(b.agent)});
  }
  return part;
}

Part::Part(const Team& whole, std::span<const AgentId> own, const MakeSolver& make)
    : whole_(whole), in_part_(at(whole.bodies()), -1), solver_(make(part_of(whole, own))) {
  planner_ = &team_planner_of(*solver_, "a team that plans in parts");
  const Team& team = ocp().team();
  const Horizon& horizon = ocp().horizon();
  for (int i = 0; i < team.bodies(); ++i) {
    in_whole_.push_back(whole.find(team.name(BodyId{i})));
    in_part_[at(in_whole_.back().index)] = i;
  }
  const std::size_t stages = at(horizon.N + 1);
  int nx_max = 0;
  for (const Agent& agent : whole.agents()) {
    nx_max = std::max(nx_max, agent.model.nx());
    no_input_.resize(std::max(no_input_.size(), agent.R.size()), 0.0);
  }
  x_.resize(at(team.nx()));
  u_.resize(at(team.nu()));
  rate_.resize(at(nx_max));
  path_.resize(stages * x_.size());
  for (const BodyId body : ocp().agent_bodies()) told_.push_back({.who = in_whole(body), .h = horizon.h()});
  for (Prediction& told : told_) told.sights.reserve(stages);
  heard_.sights.reserve(stages);
}

/// What the part knows of the states; of a robot outside, where it is and how it moves.
void Part::gather(std::span<const double> states) noexcept {
  const Team& team = ocp().team();
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId there = in_whole(BodyId{i});
    const double* const from = states.data() + whole_.state_offset(there);
    double* const to = &x_[at(team.state_offset(BodyId{i}))];
    if (team.is_agent(BodyId{i}) || !whole_.is_agent(there)) {
      std::copy_n(from, team.model(BodyId{i}).nx(), to);
      continue;
    }
    const Sight<double> s = whole_.model(there).sight(from, no_input_.data());
    write_body(s, {to, at(team.model(BodyId{i}).nx())});
  }
}

/// x_{k+1} = x_k + h f(x_k, u_k) of the own robots; the others as they are now. What is not finite is not told.
void Part::roll_out(double time) noexcept {
  const Team& team = ocp().team();
  const int N = ocp().horizon().N;
  const double h = ocp().horizon().h();
  for (Prediction& told : told_) {
    told.time = time;
    told.sights.clear();
  }
  std::copy(x_.begin(), x_.end(), path_.begin());
  for (const BodyId body : ocp().agent_bodies()) {
    if (!team.model(body).normalise(&path_[at(team.state_offset(body))])) return;
  }
  for (int k = 0; k <= N; ++k) {
    if (k < N) planner_->plan(k, u_);
    double* const x = &path_[at(k) * x_.size()];
    if (k < N) std::copy_n(x, x_.size(), x + x_.size());
    for (std::size_t i = 0; i < told_.size(); ++i) {
      const BodyId body = ocp().agent_bodies()[i];
      const Model& model = team.model(body);
      const int offset = team.state_offset(body);
      const double* const u = u_.data() + team.input_offset(body);
      told_[i].sights.push_back(model.sight(x + offset, u));
      if (k == N) continue;
      model.f(x + offset, u, rate_.data());
      for (int j = 0; j < model.nx(); ++j) x[at(offset + j) + x_.size()] += h * rate_[at(j)];
    }
  }
  for (Prediction& told : told_) {
    if (!told.is_finite()) told.sights.clear();
  }
}

Solution Part::solve(double time, std::span<const double> states) noexcept {
  if (states.size() != at(whole_.nx())) return solver_->solve(time, {});
  gather(states);
  const Solution solution = solver_->solve(time, x_);
  if (!gives_plan(solution.status)) return solution;
  roll_out(time);
  return solution;
}

void Part::look_ahead(double time, std::span<const double> states) noexcept {
  if (states.size() != at(whole_.nx())) return;
  gather(states);
  roll_out(time);
}

double Part::kkt(double time, std::span<const double> states) noexcept {
  if (states.size() != at(whole_.nx())) return solver_->kkt(time, {});
  gather(states);
  return solver_->kkt(time, x_);
}

void Part::hear(const Prediction& told) noexcept {
  if (!told.sights.empty()) set_prediction(told);
}

void Part::set_prediction(const Prediction& told) noexcept {
  const bool known = told.who.index >= 0 && told.who.index < whole_.bodies();
  const int here = known ? in_part_[at(told.who.index)] : -1;
  if (here < 0 || ocp().team().is_agent(BodyId{here})) return;
  const bool fits = told.sights.size() <= heard_.sights.capacity() && told.h > 0;
  if (!fits || !told.is_finite()) return;
  heard_.who = BodyId{here};
  heard_.time = told.time;
  heard_.h = told.h;
  heard_.sights.assign(told.sights.begin(), told.sights.end());
  planner_->set_prediction(heard_);
}

void Part::restart() noexcept {
  solver_->restart();
  for (Prediction& told : told_) told.sights.clear();
}

}  // namespace sightline
