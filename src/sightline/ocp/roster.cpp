#include "sightline/ocp/roster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <stdexcept>

#include "sightline/potential/protection.hpp"

namespace sightline {
namespace {

Ramp fading_in(double t, double duration) {
  return duration > 0 ? Ramp{.begin = t, .duration = duration, .from = 0.0, .to = 1.0} : Ramp{};
}
/// From what is in force at t.
Ramp fading_out(const Ramp& now, double t, double duration) {
  return {.begin = t, .duration = duration, .from = now.at(t), .to = 0.0};
}
bool lasts(const Ramp& ramp) { return ramp.to > 0; }
bool is_over(const Ramp& ramp, double t) { return !lasts(ramp) && t >= ramp.begin + ramp.duration; }
bool has_settled(const Ramp& ramp, double t) {
  return ramp.from == ramp.to || t >= ramp.begin + ramp.duration;
}
Ramp settled(const Ramp& ramp, double t) { return lasts(ramp) && has_settled(ramp, t) ? Ramp{} : ramp; }

bool joins(const Between& between, BodyId a, BodyId b) {
  return (between.first == a && between.second == b) || (between.first == b && between.second == a);
}

bool felt_by_all(const Coupling& coupling, const std::vector<AgentId>& agents) {
  return std::all_of(agents.begin(), agents.end(), [&](AgentId agent) {
    return std::find(coupling.felt_by.begin(), coupling.felt_by.end(), agent) != coupling.felt_by.end();
  });
}

/// Puts a term that fades in beside the one that fades out.
template <class Term>
void replace(std::vector<Term>& terms, std::size_t i, Term next, double t, double ramp) {
  next.ramp = fading_in(t, ramp);
  terms[i].name.clear();
  terms[i].ramp = fading_out(terms[i].ramp, t, ramp);
  terms.push_back(std::move(next));
}

template <class Term>
auto find_term(std::vector<Term>& terms, std::string_view name) {
  return std::find_if(terms.begin(), terms.end(),
                      [&](const Term& term) { return term.name == name && lasts(term.ramp); });
}

}  // namespace

/// One change, at a time and over a time; gives why it cannot be.
struct Roster::Change {
  Roster& roster;
  double t, ramp;

  std::string name(BodyId body) const { return std::string(roster.all_.name(body)); }
  bool is_there(BodyId body) const { return roster.presence(body) != Presence::absent; }
  Presence& presence(BodyId body) const { return roster.presence_[at(body)]; }
  Agent& agent(AgentId id) const { return roster.agents_[roster.place(id)]; }

  std::string operator()(const RemoveBody& remove) const {
    const BodyId body = remove.body;
    const bool robot = roster.all_.is_agent(body);
    if (!is_there(body)) return fmt::format("\"{}\" is not there, expected one that is", name(body));
    if (robot && remove.afterwards != Afterwards::vanish && presence(body) != Presence::steered) {
      return fmt::format("\"{}\" is not steered any more, expected a robot that is", name(body));
    }
    const auto steered = std::count(roster.presence_.begin(), roster.presence_.end(), Presence::steered);
    if (presence(body) == Presence::steered && steered == 1) {
      return fmt::format("\"{}\" is the last robot, expected another to be left", name(body));
    }
    if (robot && remove.afterwards != Afterwards::vanish) {
      presence(body) = remove.afterwards == Afterwards::hold ? Presence::hold : Presence::land;
      return {};
    }
    presence(body) = Presence::absent;
    if (ramp == 0) return {};
    // What the others felt of it fades away; what stays waits for its return.
    for (std::size_t i = 0, n = roster.couplings_.size(); i < n; ++i) {
      Coupling ghost = roster.couplings_[i];
      if (!lasts(ghost.ramp) || (ghost.between.first != body && ghost.between.second != body)) continue;
      ghost.name.clear();
      ghost.ramp = fading_out(ghost.ramp, t, ramp);
      roster.couplings_.push_back(std::move(ghost));
    }
    return {};
  }

  std::string operator()(const AddBody& add) const {
    const BodyId body = add.body;
    const bool robot = roster.all_.is_agent(body), was_there = is_there(body);
    if (presence(body) == Presence::steered || (!robot && was_there)) {
      return fmt::format("\"{}\" is there already, expected one that is not", name(body));
    }
    presence(body) = robot ? Presence::steered : Presence::hold;
    for (Coupling& c : roster.couplings_) {
      const bool of_it = c.between.first == body || c.between.second == body;
      const bool felt_before = was_there && (c.felt_by.size() > 1 || c.felt_by[0] != body);
      if (of_it && lasts(c.ramp) && !felt_before) c.ramp = fading_in(t, ramp);
    }
    for (Constraint& c : roster.constraints_) {
      if (c.agent == body && lasts(c.ramp)) c.ramp = fading_in(t, ramp);
    }
    return {};
  }

  std::string operator()(const AddCoupling& add) const {
    return enter(add.coupling, roster.couplings_,
                 [](Team& trial, Coupling c) { trial.couple(std::move(c)); });
  }
  std::string operator()(const AddConstraint& add) const {
    return enter(add.constraint, roster.constraints_,
                 [](Team& trial, Constraint c) { trial.constrain(std::move(c)); });
  }
  template <class Term, class Add>
  std::string enter(const Term& given, std::vector<Term>& terms, Add&& add) const {
    if (roster.has_term(given.name)) {
      return fmt::format("\"{}\" is there already, expected a name that is free", given.name);
    }
    Term term = given;
    term.name.clear();
    try {
      Team trial = roster.all_;
      add(trial, term);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    term.name = given.name;
    term.ramp = fading_in(t, ramp);
    terms.push_back(std::move(term));
    return {};
  }

  std::string operator()(const RemoveTerm& remove) const {
    const auto fade = [&](auto& terms) {
      const auto found = find_term(terms, remove.name);
      if (found == terms.end()) return false;
      found->ramp = fading_out(found->ramp, t, ramp);
      found->name.clear();
      return true;
    };
    if (fade(roster.couplings_) || fade(roster.constraints_)) return {};
    return fmt::format("no coupling or constraint \"{}\" is in force, expected the name of one", remove.name);
  }

  std::string operator()(const RetuneTerm& retune) const {
    if (retune.weight && !(*retune.weight >= 0 && *retune.weight <= std::numeric_limits<double>::max())) {
      return fmt::format("weight = {}, expected >= 0", *retune.weight);
    }
    std::string refusal =
        fmt::format("no coupling or constraint \"{}\" is in force, expected the name of one", retune.name);
    const auto swap = [&](auto& terms) {
      const auto found = find_term(terms, retune.name);
      if (found == terms.end()) return;
      refusal.clear();
      auto next = *found;
      if (retune.weight) next.term.weight = *retune.weight;
      if (retune.potential && retune.potential->is_pair() != next.term.potential.is_pair()) {
        refusal = fmt::format("{} is of another kind than \"{}\", expected one between as many bodies",
                              retune.potential->name(), retune.name);
        return;
      }
      if (retune.potential) next.term.potential = *retune.potential;
      replace(terms, static_cast<std::size_t>(found - terms.begin()), std::move(next), t, ramp);
    };
    swap(roster.couplings_);
    if (!refusal.empty()) swap(roster.constraints_);
    return refusal;
  }

  std::string operator()(const RetuneAgent& retune) const {
    Agent next = agent(retune.agent);
    if (retune.Q) next.Q = *retune.Q;
    if (retune.R) next.R = *retune.R;
    if (retune.Q_f) next.Q_f = *retune.Q_f;
    if (retune.u_ref) next.u_ref = *retune.u_ref;
    if (retune.limits) next.limits = *retune.limits;
    return set(retune.agent, std::move(next));
  }
  std::string operator()(const SetReference& change) const {
    Agent next = agent(change.agent);
    next.x_ref = change.reference;
    Reference before = roster.reference(change.agent, t);
    if (std::string refusal = set(change.agent, std::move(next)); !refusal.empty()) return refusal;
    std::erase_if(roster.turns_, [&](const Turn& turn) { return turn.agent == change.agent; });
    if (ramp > 0) roster.turns_.push_back({change.agent, std::move(before), fading_in(t, ramp)});
    return {};
  }
  /// As Team would take it.
  std::string set(AgentId id, Agent next) const {
    try {
      Team trial;
      trial.add(next);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    agent(id) = std::move(next);
    return {};
  }

  std::string operator()(const Observe& observe) const {
    const auto& [observer, target] = observe;
    if (observer == target) return fmt::format("\"{}\" cannot observe itself", name(observer));
    auto& couplings = roster.couplings_;
    const auto looks =
        std::find_if(couplings.begin(), couplings.end(), [&, who = observer](const Coupling& c) {
          return lasts(c.ramp) && c.between.first == who && watches(c.term.potential);
        });
    if (looks == couplings.end()) {
      return fmt::format("\"{}\" has no sensor on anything, expected a robot that observes", name(observer));
    }
    const BodyId before = looks->between.second;
    if (before == target) {
      return fmt::format("\"{}\" observes \"{}\" already, expected another", name(observer), name(target));
    }
    const std::size_t n = couplings.size();
    /// Whether another coupling than the i-th keeps the observer off this body, felt by all who feel the i-th.
    const auto is_kept_off = [&, who = observer](BodyId whom, const std::vector<AgentId>& felt_by,
                                                 std::size_t i) {
      for (std::size_t j = 0; j < n; ++j) {
        const Coupling& c = couplings[j];
        if (j != i && lasts(c.ramp) && c.term.weight > 0 && joins(c.between, who, whom) &&
            felt_by_all(c, felt_by) && !keep_outs(c.term.potential).empty()) {
          return true;
        }
      }
      return false;
    };
    for (std::size_t i = 0; i < n; ++i) {
      if (!lasts(couplings[i].ramp) || !joins(couplings[i].between, observer, before)) continue;
      // By this one it is observed itself, with the sensor of the other: that goes on.
      if (couplings[i].between.first == before && watches(couplings[i].term.potential)) continue;
      const bool stays = keeps_apart(couplings[i].term.potential);
      Coupling next = couplings[i];
      BodyId& end = next.between.first == before ? next.between.first : next.between.second;
      end = target;
      if (roster.all_.is_agent(target)) {
        std::replace(next.felt_by.begin(), next.felt_by.end(), AgentId{before}, AgentId{target});
      } else {
        std::erase(next.felt_by, AgentId{before});
      }
      if (stays && (next.felt_by.empty() || is_kept_off(target, next.felt_by, i))) continue;
      if (stays) {
        next.name.clear();
        next.ramp = fading_in(t, ramp);
        couplings.push_back(std::move(next));
        continue;
      }
      // What goes over leaves behind the limits in it that keep the two apart.
      const bool needs_none = is_kept_off(before, couplings[i].felt_by, i);
      for (Potential& limit :
           needs_none ? std::vector<Potential>() : keep_outs(couplings[i].term.potential)) {
        Coupling apart = couplings[i];
        apart.term.potential = std::move(limit);
        apart.name.clear();
        apart.ramp = fading_in(t, ramp);
        couplings.push_back(std::move(apart));
      }
      if (next.felt_by.empty()) {
        couplings[i].name.clear();
        couplings[i].ramp = fading_out(couplings[i].ramp, t, ramp);
      } else {
        replace(couplings, i, std::move(next), t, ramp);
      }
    }
    return {};
  }
};

Roster::Roster(Team all, std::vector<Presence> presence)
    : all_(std::move(all)),
      agents_(all_.agents()),
      couplings_(all_.couplings()),
      constraints_(all_.constraints()),
      presence_(std::move(presence)) {
  for (int i = static_cast<int>(presence_.size()); i < all_.bodies(); ++i) {
    presence_.push_back(all_.is_agent(BodyId{i}) ? Presence::steered : Presence::hold);
  }
}

std::string Roster::apply(const Action& action, double t, double ramp) {
  // What has faded away makes room.
  const auto over = [t](const auto& term) { return is_over(term.ramp, t); };
  std::erase_if(couplings_, over);
  std::erase_if(constraints_, over);
  return std::visit(Change{*this, t, ramp}, action);
}

/// What keeps the steered robots of a swarm off those of it that brake or sink.
std::vector<Coupling> Roster::swarm_couplings() const {
  std::vector<Coupling> couplings;
  for (const Swarm& swarm : all_.swarms()) {
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

Team Roster::team(double t) const {
  const auto steered = [&](BodyId body) { return presence(body) == Presence::steered; };
  const auto in_force = [&](const Coupling& c) {
    if (is_over(c.ramp, t)) return false;
    const bool fades_out = !lasts(c.ramp);
    const auto there = [&](BodyId body) { return fades_out || presence(body) != Presence::absent; };
    return there(c.between.first) && there(c.between.second) &&
           std::any_of(c.felt_by.begin(), c.felt_by.end(), steered);
  };
  std::vector<Coupling> couplings = couplings_, of_swarms = swarm_couplings();
  std::move(of_swarms.begin(), of_swarms.end(), std::back_inserter(couplings));
  std::vector<bool> wanted(presence_.size());
  for (int i = 0; i < all_.bodies(); ++i) {
    wanted[at(BodyId{i})] =
        steered(BodyId{i}) || (!all_.is_agent(BodyId{i}) && presence(BodyId{i}) != Presence::absent);
  }
  for (const Coupling& c : couplings) {
    if (in_force(c)) wanted[at(c.between.first)] = wanted[at(c.between.second)] = true;
  }

  Team team;
  std::vector<BodyId> id(presence_.size());
  for (int i = 0; i < all_.bodies(); ++i) {
    const BodyId body{i};
    if (!wanted[at(body)]) continue;
    if (steered(body)) {
      Agent agent = agents_[place(AgentId{body})];
      agent.x_ref = reference(AgentId{body}, t);
      id[at(body)] = team.add(std::move(agent));
    } else {
      id[at(body)] = team.add(Obstacle{std::string(all_.name(body)), all_.is_agent(body)});
    }
  }
  if (team.agents().empty())
    throw std::invalid_argument("no robot is left in the team, expected one at least");
  for (Coupling& c : couplings) {
    if (!in_force(c)) continue;
    std::erase_if(c.felt_by, [&](AgentId agent) { return !steered(agent); });
    for (AgentId& agent : c.felt_by) agent = AgentId{id[at(agent)]};
    c.between = {id[at(c.between.first)], id[at(c.between.second)]};
    c.ramp = settled(c.ramp, t);
    team.couple(std::move(c));
  }
  for (Constraint c : constraints_) {
    if (is_over(c.ramp, t) || !steered(c.agent)) continue;
    c.agent = AgentId{id[at(c.agent)]};
    c.ramp = settled(c.ramp, t);
    team.constrain(std::move(c));
  }
  for (const Swarm& swarm : all_.swarms()) {
    std::vector<AgentId> flying;
    for (const AgentId agent : swarm.agents) {
      if (steered(agent)) flying.push_back(AgentId{id[at(agent)]});
    }
    if (flying.size() >= 2) team.keep_apart(swarm.term, std::move(flying), swarm.radius, swarm.capacity);
  }
  for (const BarrierTerm& b : all_.barriers()) {
    if (steered(b.agent)) team.constrain(b.barrier, AgentId{id[at(b.agent)]});
  }
  return team;
}

Membership Roster::membership() const {
  Membership now{.presence = presence_, .partners = {}, .limits = {}};
  for (const Agent& agent : agents_) now.limits.push_back(agent.limits);
  now.partners.resize(agents_.size());
  for (const Coupling& c : couplings_) {
    const auto is_there = [&](BodyId body) { return presence(body) != Presence::absent; };
    if (!lasts(c.ramp) || !is_there(c.between.first) || !is_there(c.between.second)) continue;
    for (const AgentId robot : c.felt_by) {
      if (presence(robot) != Presence::steered) continue;
      std::vector<BodyId>& partners = now.partners[place(robot)];
      const BodyId other = c.between.first == robot ? c.between.second : c.between.first;
      if (std::find(partners.begin(), partners.end(), other) == partners.end()) partners.push_back(other);
    }
  }
  return now;
}

std::size_t Roster::place(AgentId id) const {
  return static_cast<std::size_t>(&all_.agent(id) - all_.agents().data());
}

Reference Roster::reference(AgentId id, double t) const {
  const Reference& last = agents_[place(id)].x_ref;
  const auto turn =
      std::find_if(turns_.begin(), turns_.end(), [&](const Turn& it) { return it.agent == id; });
  if (turn == turns_.end() || has_settled(turn->ramp, t)) return last;
  return Reference::between(turn->from, last, turn->ramp);
}

double Roster::at_rest_from(double t) const {
  double end = -std::numeric_limits<double>::infinity();
  const auto count = [&](const Ramp& ramp) {
    if (!has_settled(ramp, t)) end = std::max(end, ramp.begin + ramp.duration);
  };
  for (const Coupling& c : couplings_) count(c.ramp);
  for (const Constraint& c : constraints_) count(c.ramp);
  for (const Turn& turn : turns_) count(turn.ramp);
  return end;
}

bool Roster::has_term(std::string_view name) const {
  if (name.empty()) return false;
  const auto called = [&](const auto& term) { return term.name == name && lasts(term.ramp); };
  return std::any_of(couplings_.begin(), couplings_.end(), called) ||
         std::any_of(constraints_.begin(), constraints_.end(), called);
}

}  // namespace sightline
