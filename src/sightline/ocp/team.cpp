#include "sightline/team.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"

namespace sightline {
namespace {

void check_reference(std::string_view agent, const Reference& x_ref, int nx) {
  const std::size_t n = x_ref.length();
  if (n != 0 && n != static_cast<std::size_t>(nx))
    throw_invalid("{}.x_ref has {} numbers, expected {}", agent, n, nx);
  if (n == 0 && nx > Reference::max_states)
    throw_invalid(
        "{}.x_ref is a pose of a robot of {} states, expected all of its states: a pose suits at most {}",
        agent, nx, Reference::max_states);
}

void check_weights(std::string_view agent, std::string_view field, const std::vector<double>& w, int n,
                   bool positive) {
  if (static_cast<int>(w.size()) != n)
    throw_invalid("{}.{} has {} entries, expected {}", agent, field, w.size(), n);
  for (const double v : w) {
    if (!std::isfinite(v) || v < 0 || (positive && v == 0)) {
      throw_invalid("{}.{} = {}, expected {} 0", agent, field, v, positive ? ">" : ">=");
    }
  }
}

}  // namespace

InputLimits::InputLimits(std::vector<double> u_min, std::vector<double> u_max)
    : InputLimits(std::vector<double>{0.0}, std::vector<std::vector<double>>{std::move(u_min)},
                  std::vector<std::vector<double>>{std::move(u_max)}) {}

InputLimits::InputLimits(std::vector<double> times, std::vector<std::vector<double>> u_min,
                         std::vector<std::vector<double>> u_max)
    : times_(std::move(times)), u_min_(std::move(u_min)), u_max_(std::move(u_max)) {
  if (times_.empty() || u_min_.size() != times_.size() || u_max_.size() != times_.size()) {
    throw_invalid("limits have {} times, {} u_min and {} u_max, expected as many of each", times_.size(),
                  u_min_.size(), u_max_.size());
  }
  for (std::size_t k = 0; k < times_.size(); ++k) {
    if (!std::isfinite(times_[k])) throw_invalid("limits.times = {}, expected finite and rising", times_[k]);
    if (k > 0 && !(times_[k] > times_[k - 1])) {
      throw_invalid("limits.times = {} after {}, expected finite and rising", times_[k], times_[k - 1]);
    }
    if (u_min_[k].size() != u_max_[k].size() || u_min_[k].size() != u_min_[0].size()) {
      throw_invalid("limits: u_min has {} entries, u_max has {}, expected as many in all", u_min_[k].size(),
                    u_max_[k].size());
    }
    for (std::size_t i = 0; i < u_min_[k].size(); ++i) {
      if (!(u_min_[k][i] < u_max_[k][i]) || !std::isfinite(u_min_[k][i]) || !std::isfinite(u_max_[k][i])) {
        throw_invalid("limits: u_min[{0}] = {1}, u_max[{0}] = {2}, expected u_min < u_max, both finite", i,
                      u_min_[k][i], u_max_[k][i]);
      }
    }
  }
}

void InputLimits::at(double t, std::span<double> u_min, std::span<double> u_max) const noexcept {
  std::size_t k = 0;
  while (k + 1 < times_.size() && times_[k + 1] <= t) ++k;
  std::copy_n(u_min_[k].begin(), std::min(u_min.size(), u_min_[k].size()), u_min.begin());
  std::copy_n(u_max_[k].begin(), std::min(u_max.size(), u_max_[k].size()), u_max.begin());
}

std::vector<double> input_scales(const Agent& agent) {
  constexpr double unlimited = 1000.0;
  std::vector<double> scales(agent.R.size(), 0.0);
  const auto &u_min = agent.limits.u_min(), &u_max = agent.limits.u_max();
  for (std::size_t i = 0; i < scales.size(); ++i) {
    for (std::size_t k = 0; k < u_min.size(); ++k)
      scales[i] = std::max(scales[i], 0.5 * u_max[k][i] - 0.5 * u_min[k][i]);
    const double typical = 1.0 / std::sqrt(agent.R[i]);
    if (scales[i] > unlimited * typical) scales[i] = typical;
  }
  return scales;
}

std::vector<AgentId> felt_by(std::initializer_list<AgentId> agents) { return agents; }
std::vector<AgentId> felt_by(AgentId agent) { return {agent}; }

BodyId Team::enter(std::string name, const Model& model, int agent) {
  if (find(name).index >= 0)
    throw_invalid("the name \"{}\" is given twice, expected one body of a name", name);
  const BodyId id{bodies()};
  bodies_.push_back({std::move(name), model, agent, nx_, nu_});
  nx_ += model.nx();
  nu_ += model.nu();
  return id;
}

AgentId Team::add(Agent agent) {
  if (agent.name.empty()) agent.name = fmt::format("uav{}", agents_.size());
  const int nx = agent.model.nx(), nu = agent.model.nu();
  if (agent.Q_f.empty()) agent.Q_f.assign(static_cast<std::size_t>(nx), 0.0);
  if (agent.u_ref.empty()) agent.u_ref.assign(static_cast<std::size_t>(nu), 0.0);
  check_weights(agent.name, "Q", agent.Q, nx, false);
  check_weights(agent.name, "R", agent.R, nu, true);
  check_weights(agent.name, "Q_f", agent.Q_f, nx, false);
  if (!agent.rate_max.empty()) check_weights(agent.name, "rate_max", agent.rate_max, nu, true);
  if (!agent.R_rate.empty()) check_weights(agent.name, "R_rate", agent.R_rate, nu, false);
  if (static_cast<int>(agent.u_ref.size()) != nu || !all_finite(agent.u_ref)) {
    throw_invalid("{}.u_ref has {} entries, expected {} finite numbers", agent.name, agent.u_ref.size(), nu);
  }
  if (static_cast<int>(agent.limits.u_min()[0].size()) != nu) {
    throw_invalid("{}.u_min has {} entries, expected {}", agent.name, agent.limits.u_min()[0].size(), nu);
  }
  check_reference(agent.name, agent.x_ref, nx);
  const BodyId id = enter(agent.name, agent.model, static_cast<int>(agents_.size()));
  agents_.push_back(std::move(agent));
  return AgentId{id};
}

void Team::set_reference(AgentId agent, Reference x_ref) {
  check_reference(name(agent), x_ref, model(agent).nx());
  agents_.at(static_cast<std::size_t>(bodies_[index(agent)].agent)).x_ref = std::move(x_ref);
}

BodyId Team::add(Obstacle obstacle) {
  if (obstacle.name.empty())
    obstacle.name = fmt::format("obstacle{}", bodies() - static_cast<int>(agents_.size()));
  const Model model = obstacle.has_heading ? Model(PosedBody{}) : Model(Body{});
  return enter(std::move(obstacle.name), model, -1);
}

void Team::check_body(BodyId body) const {
  if (body.index < 0 || body.index >= bodies()) {
    throw_invalid("body {} is not in the team, expected an id that add() returned", body.index);
  }
}

void Team::check_weight(const Weighted& term) const {
  if (!std::isfinite(term.weight) || term.weight < 0) {
    throw_invalid("weight = {} of {}, expected >= 0", term.weight, term.potential.name());
  }
}

/// Names belong to lasting terms; a term that fades out frees its name.
void Team::check_new_name(std::string_view called) const {
  if (called.empty()) return;
  const auto has_it = [&](const auto& term) { return term.name == called && term.ramp.to > 0; };
  if (std::any_of(couplings_.begin(), couplings_.end(), has_it) ||
      std::any_of(constraints_.begin(), constraints_.end(), has_it)) {
    throw_invalid("the name \"{}\" is given to two couplings or constraints, expected one of a name", called);
  }
}

bool alike(const Coupling& a, const Coupling& b) {
  return a.between.first == b.between.first && a.between.second == b.between.second && a.third == b.third &&
         a.felt_by == b.felt_by && a.ramp == b.ramp;
}

void Team::couple(const Weighted& term, Between between) {
  std::vector<AgentId> all;
  for (const BodyId body : {between.first, between.second}) {
    check_body(body);
    if (is_agent(body)) all.push_back(AgentId{body});
  }
  couple(term, between, std::move(all));
}

void Team::couple(const Weighted& term, Between between, std::vector<AgentId> felt_by) {
  couple({.term = term, .between = between, .felt_by = std::move(felt_by)});
}

void Team::couple(Coupling coupling) {
  const auto& [term, between, felt_by, called, ramp, third] = coupling;
  check_new_name(called);
  check_body(between.first);
  check_body(between.second);
  check_weight(term);
  if (!term.potential.is_pair()) {
    throw_invalid("{} sees one robot alone, expected a potential between two bodies", term.potential.name());
  }
  if (between.first == between.second)
    throw_invalid("\"{}\" is coupled with itself, expected two bodies", name(between.first));
  check_third(coupling);
  if (felt_by.empty()) {
    throw_invalid(
        "the coupling {} of \"{}\" and \"{}\" is felt by no robot, expected at least one robot of the two",
        term.potential.name(), name(between.first), name(between.second));
  }
  for (const AgentId agent : felt_by) {
    check_body(agent);
    if (std::count(felt_by.begin(), felt_by.end(), agent) > 1) {
      throw_invalid("felt_by names \"{}\" twice, expected each robot once", name(agent));
    }
    if (!is_agent(agent) || (agent != between.first && agent != between.second)) {
      throw_invalid("felt_by names \"{}\", expected a robot of between = [\"{}\", \"{}\"]", name(agent),
                    name(between.first), name(between.second));
    }
  }
  couplings_.push_back(std::move(coupling));
}

/// A coupling has a third body if and only if its potential looks past one; it is neither of the
/// two.
void Team::check_third(const Coupling& coupling) const {
  const auto& [first, second] = coupling.between;
  const std::string_view potential = coupling.term.potential.name();
  if (coupling.has_third()) check_body(coupling.third);
  if (coupling.has_third() != coupling.term.potential.sees_third()) {
    if (coupling.has_third())
      throw_invalid("{} does not look past the third body \"{}\", expected a potential that does, or none",
                    potential, name(coupling.third));
    throw_invalid("{} looks past a third body, expected a coupling that names one as its third", potential);
  }
  if (coupling.third == first || coupling.third == second)
    throw_invalid("the third body of {} is \"{}\", expected another than its two", potential,
                  name(coupling.third));
}

void Team::keep_apart(const Weighted& term, std::vector<AgentId> agents, double radius, int capacity) {
  for (const AgentId agent : agents) {
    check_body(agent);
    if (!is_agent(agent)) throw_invalid("\"{}\" is not controlled, expected a robot", name(agent));
    if (std::count(agents.begin(), agents.end(), agent) > 1) {
      throw_invalid("agents names \"{}\" twice, expected each robot once", name(agent));
    }
  }
  Swarm swarm{.term = term, .agents = std::move(agents), .radius = radius, .capacity = capacity};
  swarm.check();
  swarms_.push_back(std::move(swarm));
}

void Team::constrain(const Weighted& term, AgentId agent) {
  constrain(Constraint{.term = term, .agent = agent});
}

void Team::constrain(Constraint constraint) {
  const auto& [term, agent, called, ramp] = constraint;
  check_new_name(called);
  check_body(agent);
  check_weight(term);
  if (!is_agent(agent)) throw_invalid("\"{}\" is not controlled, expected a robot", name(agent));
  if (term.potential.is_pair()) {
    throw_invalid("{} lies between two bodies, expected a potential of one robot", term.potential.name());
  }
  constraints_.push_back(std::move(constraint));
}

void Team::constrain(const RelaxedBarrier& barrier, AgentId agent) {
  check_body(agent);
  barrier.check();
  const std::string_view limit = barrier.limit.name();
  if (!is_agent(agent)) throw_invalid("\"{}\" is not controlled, expected a robot", name(agent));
  const Model& m = model(agent);
  if (m.nx() < barrier.limit.states() || m.nu() < barrier.limit.inputs()) {
    throw_invalid("{} reads {} states and {} inputs, \"{}\" has {} and {}, expected as many at least", limit,
                  barrier.limit.states(), barrier.limit.inputs(), name(agent), m.nx(), m.nu());
  }
  barriers_.push_back({barrier, agent});
}

std::vector<RelaxedBarrier> Team::barriers(BodyId body) const {
  std::vector<RelaxedBarrier> list;
  for (const BarrierTerm& term : barriers_) {
    if (term.agent == body) list.push_back(term.barrier);
  }
  return list;
}

void Team::refuse_body(BodyId body) const {
  throw std::out_of_range(fmt::format("body {} is not in the team of {}, expected an id that add() returned",
                                      body.index, bodies()));
}

const Agent& Team::agent(BodyId body) const { return agents_[agent_index(body)]; }

std::size_t Team::agent_index(BodyId robot) const {
  if (!is_agent(robot)) {
    throw std::out_of_range(fmt::format("\"{}\" is not controlled, expected a robot", name(robot)));
  }
  return static_cast<std::size_t>(bodies_[index(robot)].agent);
}

BodyId Team::find(std::string_view name) const {
  const auto found =
      std::find_if(bodies_.begin(), bodies_.end(), [&](const Entry& e) { return e.name == name; });
  return found == bodies_.end() ? BodyId{} : BodyId{static_cast<int>(found - bodies_.begin())};
}

std::vector<double> resting_inputs(const Team& team) {
  std::vector<double> u;
  for (const Agent& agent : team.agents()) u.insert(u.end(), agent.u_ref.begin(), agent.u_ref.end());
  return u;
}

}  // namespace sightline
