#include <algorithm>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "sightline/events.hpp"
#include "sightline/ocp/apply_action.hpp"
#include "sightline/potential/protection.hpp"

namespace sightline {
namespace {

Ramp settled(const Ramp& ramp, double t) { return ramp.lasts() && ramp.has_settled(t) ? Ramp{} : ramp; }

}  // namespace

Reference TeamState::reference(AgentId id, double t) const {
  const Reference& last = agents[place(id)].x_ref;
  const auto turn = std::find_if(turns.begin(), turns.end(), [&](const Turn& it) { return it.agent == id; });
  if (turn == turns.end() || turn->ramp.has_settled(t)) return last;
  return Reference::between(turn->from, last, turn->ramp);
}

bool TeamState::has_term(std::string_view name) const {
  const auto called = [&](const auto& term) { return term.name == name && term.ramp.lasts(); };
  return !name.empty() && (std::any_of(couplings.begin(), couplings.end(), called) ||
                           std::any_of(constraints.begin(), constraints.end(), called));
}

ActiveTeam::ActiveTeam(Team all, std::vector<Presence> presence) {
  now_ = {.all = std::move(all),
          .agents = {},
          .couplings = {},
          .constraints = {},
          .turns = {},
          .presence = std::move(presence),
          .around = {}};
  now_.agents = now_.all.agents();
  now_.couplings = now_.all.couplings();
  now_.constraints = now_.all.constraints();
  for (int i = static_cast<int>(now_.presence.size()); i < now_.all.bodies(); ++i) {
    now_.presence.push_back(now_.all.is_agent(BodyId{i}) ? Presence::steered : Presence::hold);
  }
}

std::string ActiveTeam::apply(const Action& action, double t, double ramp) {
  // Terms that have faded out free their names.
  const auto over = [t](const auto& term) { return term.ramp.is_over(t); };
  std::erase_if(now_.couplings, over);
  std::erase_if(now_.constraints, over);
  return apply_action(action, now_, t, ramp);
}

/// Couplings that keep the steered robots of a swarm off its robots that brake or descend.
std::vector<Coupling> ActiveTeam::swarm_couplings() const {
  std::vector<Coupling> couplings;
  for (const Swarm& swarm : now_.all.swarms()) {
    for (std::size_t i = 0; i < swarm.agents.size(); ++i) {
      for (std::size_t j = i + 1; j < swarm.agents.size(); ++j) {
        const AgentId a = swarm.agents[i], b = swarm.agents[j];
        const bool a_steered = presence(a) == Presence::steered;
        if (presence(a) == Presence::absent || presence(b) == Presence::absent) continue;
        if (a_steered == (presence(b) == Presence::steered)) continue;
        couplings.push_back({.term = swarm.term, .between = {a, b}, .felt_by = {a_steered ? a : b}});
      }
    }
  }
  return couplings;
}

Team ActiveTeam::team(double t) const {
  const auto steered = [&](BodyId body) { return presence(body) == Presence::steered; };
  const auto in_force = [&](const Coupling& c) {
    if (c.ramp.is_over(t)) return false;
    const bool fades_out = !c.ramp.lasts();
    const auto there = [&](BodyId body) { return fades_out || presence(body) != Presence::absent; };
    return there(c.between.first) && there(c.between.second) && (!c.has_third() || there(c.third)) &&
           std::any_of(c.felt_by.begin(), c.felt_by.end(), steered);
  };
  std::vector<Coupling> couplings = now_.couplings, of_swarms = swarm_couplings();
  std::move(of_swarms.begin(), of_swarms.end(), std::back_inserter(couplings));
  std::vector<bool> wanted(now_.presence.size());
  for (int i = 0; i < now_.all.bodies(); ++i) {
    wanted[at(BodyId{i})] =
        steered(BodyId{i}) || (!now_.all.is_agent(BodyId{i}) && presence(BodyId{i}) != Presence::absent);
  }
  for (const Coupling& c : couplings) {
    if (!in_force(c)) continue;
    wanted[at(c.between.first)] = wanted[at(c.between.second)] = true;
    if (c.has_third()) wanted[at(c.third)] = true;
  }

  Team team;
  std::vector<BodyId> id(now_.presence.size());
  for (int i = 0; i < now_.all.bodies(); ++i) {
    const BodyId body{i};
    if (!wanted[at(body)]) continue;
    if (steered(body)) {
      Agent agent = now_.agents[now_.place(AgentId{body})];
      agent.x_ref = now_.reference(AgentId{body}, t);
      id[at(body)] = team.add(std::move(agent));
    } else {
      id[at(body)] = team.add(Obstacle{std::string(now_.all.name(body)), now_.all.is_agent(body)});
    }
  }
  if (team.agents().empty())
    throw std::invalid_argument("no robot is left in the team, expected one at least");
  for (Coupling& c : couplings) {
    if (!in_force(c)) continue;
    std::erase_if(c.felt_by, [&](AgentId agent) { return !steered(agent); });
    for (AgentId& agent : c.felt_by) agent = AgentId{id[at(agent)]};
    c.between = {id[at(c.between.first)], id[at(c.between.second)]};
    if (c.has_third()) c.third = id[at(c.third)];
    c.ramp = settled(c.ramp, t);
    team.couple(std::move(c));
  }
  for (Constraint c : now_.constraints) {
    if (c.ramp.is_over(t) || !steered(c.agent)) continue;
    c.agent = AgentId{id[at(c.agent)]};
    c.ramp = settled(c.ramp, t);
    team.constrain(std::move(c));
  }
  for (const Swarm& swarm : now_.all.swarms()) {
    std::vector<AgentId> flying;
    for (const AgentId agent : swarm.agents) {
      if (steered(agent)) flying.push_back(AgentId{id[at(agent)]});
    }
    if (flying.size() >= 2) team.keep_apart(swarm.term, std::move(flying), swarm.radius, swarm.capacity);
  }
  for (const BarrierTerm& b : now_.all.barriers()) {
    if (steered(b.agent)) team.constrain(b.barrier, AgentId{id[at(b.agent)]});
  }
  return team;
}

Membership ActiveTeam::membership() const {
  Membership now{.presence = now_.presence, .partners = {}, .limits = {}, .around = now_.around};
  for (const Agent& agent : now_.agents) now.limits.push_back(agent.limits);
  now.partners.resize(now_.agents.size()), now.observed.resize(now_.agents.size());
  const auto enter = [](std::vector<BodyId>& bodies, BodyId body) {
    if (std::find(bodies.begin(), bodies.end(), body) == bodies.end()) bodies.push_back(body);
  };
  for (const Coupling& c : now_.couplings) {
    const auto is_there = [&](BodyId body) { return presence(body) != Presence::absent; };
    if (!c.ramp.lasts() || !is_there(c.between.first) || !is_there(c.between.second)) continue;
    for (const AgentId robot : c.felt_by) {
      if (presence(robot) != Presence::steered) continue;
      enter(now.partners[now_.place(robot)], c.between.first == robot ? c.between.second : c.between.first);
    }
    const auto [first, second] = c.between;
    if (now_.all.is_agent(first) && presence(first) == Presence::steered && observes(c.term.potential))
      enter(now.observed[now_.place(AgentId{first})], second);
  }
  return now;
}

double ActiveTeam::at_rest_from(double t) const {
  double end = -std::numeric_limits<double>::infinity();
  const auto count = [&](const Ramp& ramp) {
    if (!ramp.has_settled(t)) end = std::max(end, ramp.begin + ramp.duration);
  };
  for (const Coupling& c : now_.couplings) count(c.ramp);
  for (const Constraint& c : now_.constraints) count(c.ramp);
  for (const Turn& turn : now_.turns) count(turn.ramp);
  return end;
}

}  // namespace sightline
