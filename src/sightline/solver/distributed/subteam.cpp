#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

bool is_among(std::span<const AgentId> agents, BodyId body) {
  return std::find(agents.begin(), agents.end(), body) != agents.end();
}

/// Agents of the subteam on which the coupling acts.
std::vector<AgentId> felt_within(const Coupling& coupling, std::span<const AgentId> own) {
  std::vector<AgentId> feel;
  for (const AgentId agent : coupling.felt_by) {
    if (is_among(own, agent)) feel.push_back(agent);
  }
  return feel;
}

}  // namespace

Team subteam_of(const Team& whole, std::span<const AgentId> own, Others others) {
  if (own.empty()) throw std::invalid_argument("a part has no robot, expected at least one");
  for (const AgentId agent : own) {
    if (agent.index < 0 || agent.index >= whole.bodies() || !whole.is_agent(agent)) {
      throw std::invalid_argument(
          fmt::format("a part names body {}, expected a robot of the team", agent.index));
    }
  }
  std::vector<bool> seen(at(whole.bodies()), others == Others::all);
  for (const Coupling& c : whole.couplings()) {
    if (felt_within(c, own).empty()) continue;
    seen[at(c.between.first)] = seen[at(c.between.second)] = true;
    if (c.has_third()) seen[at(c.third)] = true;
  }
  Team subteam;
  for (int i = 0; i < whole.bodies(); ++i) {
    if (is_among(own, BodyId{i})) subteam.add(whole.agent(BodyId{i}));
  }
  for (int i = 0; i < whole.bodies(); ++i) {
    if (seen[at(i)] && !is_among(own, BodyId{i})) subteam.add(Obstacle{std::string(whole.name(BodyId{i}))});
  }
  const auto here = [&](BodyId body) { return subteam.find(whole.name(body)); };
  for (const Coupling& c : whole.couplings()) {
    std::vector<AgentId> feel = felt_within(c, own);
    if (feel.empty()) continue;
    for (AgentId& agent : feel) agent = AgentId{here(agent)};
    Coupling of_subteam = c;
    of_subteam.between = {here(c.between.first), here(c.between.second)};
    if (c.has_third()) of_subteam.third = here(c.third);
    of_subteam.felt_by = std::move(feel);
    subteam.couple(std::move(of_subteam));
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
    subteam.keep_apart(swarm.term, std::move(members), swarm.radius, swarm.capacity);
  }
  for (const Constraint& c : whole.constraints()) {
    if (!is_among(own, c.agent)) continue;
    Constraint of_subteam = c;
    of_subteam.agent = AgentId{here(c.agent)};
    subteam.constrain(std::move(of_subteam));
  }
  for (const BarrierTerm& b : whole.barriers()) {
    if (is_among(own, b.agent)) subteam.constrain(b.barrier, AgentId{here(b.agent)});
  }
  return subteam;
}

Subteam::Subteam(const Team& whole, std::span<const AgentId> own, const MakeSolver& make, Others others)
    : whole_(whole), in_subteam_(at(whole.bodies()), -1), solver_(make(subteam_of(whole, own, others))) {
  planner_ = &team_planner_of(*solver_, "a team that plans in parts");
  const Team& team = ocp().team();
  const Horizon& horizon = ocp().horizon();
  for (int i = 0; i < team.bodies(); ++i) {
    in_whole_.push_back(whole.find(team.name(BodyId{i})));
    in_subteam_[at(in_whole_.back().index)] = i;
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
  for (const BodyId body : ocp().agent_bodies())
    predictions_.push_back({.who = in_whole(body), .h = horizon.h()});
  for (Prediction& prediction : predictions_) prediction.sights.reserve(stages);
  received_.sights.reserve(stages);
}

/// Copies the states of the subteam's bodies; of a robot outside, position and velocity only.
void Subteam::gather(std::span<const double> states) noexcept {
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

/// Rolls out x_{k+1} = x_k + h f(x_k, u_k) of the own robots; other bodies stay at their present
/// state. Predictions that are not finite are cleared.
void Subteam::roll_out(double time) noexcept {
  const Team& team = ocp().team();
  const int N = ocp().horizon().N;
  const double h = ocp().horizon().h();
  for (Prediction& prediction : predictions_) {
    prediction.time = time;
    prediction.sights.clear();
  }
  std::copy(x_.begin(), x_.end(), path_.begin());
  if (!planned_) std::fill(u_.begin(), u_.end(), 0.0);
  for (const BodyId body : ocp().agent_bodies()) {
    if (!team.model(body).normalise(&path_[at(team.state_offset(body))])) return;
  }
  for (int k = 0; k <= N; ++k) {
    if (k < N && planned_) planner_->plan(k, u_);
    double* const x = &path_[at(k) * x_.size()];
    if (k < N) std::copy_n(x, x_.size(), x + x_.size());
    for (std::size_t i = 0; i < predictions_.size(); ++i) {
      const BodyId body = ocp().agent_bodies()[i];
      const Model& model = team.model(body);
      const int offset = team.state_offset(body);
      const double* const u = u_.data() + team.input_offset(body);
      predictions_[i].sights.push_back(model.sight(x + offset, u));
      if (k == N) continue;
      model.f(x + offset, u, rate_.data());
      for (int j = 0; j < model.nx(); ++j) x[at(offset + j) + x_.size()] += h * rate_[at(j)];
    }
  }
  for (Prediction& prediction : predictions_) {
    if (!prediction.is_finite()) prediction.sights.clear();
  }
}

Solution Subteam::solve(double time, std::span<const double> states) noexcept {
  if (states.size() != at(whole_.nx())) return solver_->solve(time, {});
  gather(states);
  const Solution solution = solver_->solve(time, x_);
  if (!gives_plan(solution.status)) return solution;
  planned_ = true;
  roll_out(time);
  return solution;
}

void Subteam::predict(double time, std::span<const double> states) noexcept {
  if (states.size() != at(whole_.nx())) return;
  gather(states);
  roll_out(time);
}

double Subteam::kkt(double time, std::span<const double> states) noexcept {
  if (states.size() != at(whole_.nx())) return solver_->kkt(time, {});
  gather(states);
  return solver_->kkt(time, x_);
}

/// Local id of a body of the whole team that is planned elsewhere; -1: not coupled with this
/// subteam, or planned here.
int Subteam::place_of(BodyId who) const noexcept {
  const bool known = who.index >= 0 && who.index < whole_.bodies();
  const int here = known ? in_subteam_[at(who.index)] : -1;
  return here >= 0 && !ocp().team().is_agent(BodyId{here}) ? here : -1;
}

void Subteam::put(const Prediction& prediction, double time) noexcept {
  const int here = place_of(prediction.who);
  const bool fits = prediction.sights.size() <= received_.sights.capacity() && prediction.h > 0;
  if (here < 0 || !fits || !std::isfinite(time) || !prediction.is_finite()) return;
  received_.who = BodyId{here};
  received_.time = time;
  received_.h = prediction.h;
  received_.sights.assign(prediction.sights.begin(), prediction.sights.end());
  planner_->set_prediction(received_);
}

void Subteam::receive(const Prediction& prediction, double time) noexcept {
  if (!prediction.sights.empty()) put(prediction, time);
}

void Subteam::set_prediction(const Prediction& prediction) noexcept { put(prediction, prediction.time); }

void Subteam::forget(BodyId who) noexcept {
  const int here = place_of(who);
  if (here < 0) return;
  received_.who = BodyId{here};
  received_.sights.clear();
  planner_->set_prediction(received_);
}

void Subteam::restart() noexcept {
  solver_->restart();
  planned_ = false;
  for (Prediction& prediction : predictions_) prediction.sights.clear();
}

}  // namespace sightline
