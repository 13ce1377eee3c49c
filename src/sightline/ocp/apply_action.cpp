#include "sightline/ocp/apply_action.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>

#include "sightline/potential/protection.hpp"

namespace sightline {
namespace {

/// A change at time t [s], whose weights are blended over `ramp` [s].
struct TeamChange {
  TeamState& now;
  double t, ramp;

  std::string_view name(BodyId body) const { return now.all.name(body); }
  bool is_robot(BodyId body) const { return now.all.is_agent(body); }
  bool is_there(BodyId body) const { return presence(body) != Presence::absent; }
  Presence& presence(BodyId body) const { return now.presence[at(body)]; }
  const Agent& agent(AgentId id) const { return now.agents[now.place(id)]; }

  Ramp fading_in() const {
    return ramp > 0 ? Ramp{.begin = t, .duration = ramp, .from = 0.0, .to = 1.0} : Ramp{};
  }
  /// Fades out the i-th term from the present value of its ramp; its name becomes free.
  template <class Term>
  void fade_out(std::vector<Term>& terms, std::size_t i) const {
    terms[i].name.clear();
    terms[i].ramp = {.begin = t, .duration = ramp, .from = terms[i].ramp.at(t), .to = 0.0};
  }
  /// Fades out the i-th term and appends one that fades in.
  template <class Term>
  void replace(std::vector<Term>& terms, std::size_t i, Term next) const {
    next.ramp = fading_in();
    fade_out(terms, i);
    terms.push_back(std::move(next));
  }
  /// Index of the lasting term of that name; the number of terms if there is none.
  template <class Term>
  static std::size_t index(const std::vector<Term>& terms, std::string_view name) {
    const auto lasting = [&](const Term& term) { return term.name == name && term.ramp.lasts(); };
    return static_cast<std::size_t>(std::find_if(terms.begin(), terms.end(), lasting) - terms.begin());
  }
  /// Calls edit(terms, i) for the lasting coupling or constraint of that name.
  /// @return why the change is rejected, a sentence; else empty
  template <class Edit>
  std::string edit_term(std::string_view name, Edit&& edit) const {
    const std::size_t i = index(now.couplings, name), j = index(now.constraints, name);
    if (i < now.couplings.size()) return edit(now.couplings, i);
    if (j < now.constraints.size()) return edit(now.constraints, j);
    return fmt::format("no coupling or constraint \"{}\" is in force, expected the name of one", name);
  }

  /// Gives a robot a new tuning. @return why a Team rejects it, a sentence; else empty
  std::string tune(AgentId id, Agent next) const {
    try {
      Team trial;
      trial.add(next);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    now.agents[now.place(id)] = std::move(next);
    return {};
  }
  /// Adds a term that fades in.
  /// @param add  adds the term to a trial team, which may reject it
  template <class Term, class Add>
  std::string enter(const Term& given, std::vector<Term>& terms, Add&& add) const {
    if (now.has_term(given.name))
      return fmt::format("\"{}\" is there already, expected a name that is free", given.name);
    Term term = given;
    term.name.clear();
    try {
      Team trial = now.all;
      add(trial, term);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    term.name = given.name;
    term.ramp = fading_in();
    terms.push_back(std::move(term));
    return {};
  }
};

std::string apply(const RemoveBody& remove, const TeamChange& change) {
  const BodyId body = remove.body;
  Presence& presence = change.presence(body);
  const bool stays = change.is_robot(body) && remove.afterwards != Afterwards::vanish;
  if (presence == Presence::absent) {
    return fmt::format("\"{}\" is not there, expected one that is", change.name(body));
  }
  if (stays && presence != Presence::steered) {
    return fmt::format("\"{}\" is not steered any more, expected a robot that is", change.name(body));
  }
  const auto& all = change.now.presence;
  if (presence == Presence::steered && std::count(all.begin(), all.end(), Presence::steered) == 1) {
    return fmt::format("\"{}\" is the last robot, expected another to be left", change.name(body));
  }
  if (stays) {
    presence = remove.afterwards == Afterwards::hold ? Presence::hold : Presence::land;
    return {};
  }
  presence = Presence::absent;
  if (change.ramp == 0) return {};
  // Copies of its couplings fade out for the other robots; the originals stay for its return.
  auto& couplings = change.now.couplings;
  for (std::size_t i = 0, n = couplings.size(); i < n; ++i) {
    Coupling ghost = couplings[i];
    const auto& [first, second] = ghost.between;
    if (!ghost.ramp.lasts() || (first != body && second != body && ghost.third != body)) continue;
    couplings.push_back(std::move(ghost));
    change.fade_out(couplings, couplings.size() - 1);
  }
  return {};
}

bool is_view_set(const Coupling& c) { return c.ramp.lasts() && c.name.starts_with(name_of_view_sets); }

std::string apply(const RemoveTerm& remove, const TeamChange& change) {
  return change.edit_term(remove.name, [&](auto& terms, std::size_t i) {
    change.fade_out(terms, i);
    return std::string();
  });
}

std::string apply(const AddBody& add, const TeamChange& change) {
  const BodyId body = add.body;
  Presence& presence = change.presence(body);
  const bool robot = change.is_robot(body), was_there = change.is_there(body);
  if (presence == Presence::steered || (!robot && was_there)) {
    return fmt::format("\"{}\" is there already, expected one that is not", change.name(body));
  }
  presence = robot ? Presence::steered : Presence::hold;
  for (Coupling& c : change.now.couplings) {
    const bool of_it = c.between.first == body || c.between.second == body || c.third == body;
    const bool felt_before = was_there && (c.felt_by.size() > 1 || c.felt_by[0] != body);
    if (of_it && c.ramp.lasts() && !felt_before) c.ramp = change.fading_in();
  }
  for (Constraint& c : change.now.constraints) {
    if (c.agent == body && c.ramp.lasts()) c.ramp = change.fading_in();
  }
  return {};
}

std::string apply(const AddCoupling& add, const TeamChange& change) {
  return change.enter(add.coupling, change.now.couplings,
                      [](Team& trial, Coupling c) { trial.couple(std::move(c)); });
}

std::string apply(const AddConstraint& add, const TeamChange& change) {
  return change.enter(add.constraint, change.now.constraints,
                      [](Team& trial, Constraint c) { trial.constrain(std::move(c)); });
}

std::string apply(const RetuneAgent& retune, const TeamChange& change) {
  Agent next = change.agent(retune.agent);
  if (retune.Q) next.Q = *retune.Q;
  if (retune.R) next.R = *retune.R;
  if (retune.Q_f) next.Q_f = *retune.Q_f;
  if (retune.u_ref) next.u_ref = *retune.u_ref;
  if (retune.limits) next.limits = *retune.limits;
  return change.tune(retune.agent, std::move(next));
}

std::string apply(const RetuneTerm& retune, const TeamChange& change) {
  const std::string& name = retune.name;
  const auto& weight = retune.weight;
  const auto& potential = retune.potential;
  if (weight && !(*weight >= 0 && *weight <= std::numeric_limits<double>::max())) {
    return fmt::format("weight = {}, expected >= 0", *weight);
  }
  return change.edit_term(name, [&](auto& terms, std::size_t i) {
    auto next = terms[i];
    if (weight) next.term.weight = *weight;
    if (potential && potential->is_pair() != next.term.potential.is_pair()) {
      return fmt::format("{} is of another kind than \"{}\", expected one between as many bodies",
                         potential->name(), name);
    }
    if (potential && potential->sees_third() != next.term.potential.sees_third()) {
      return fmt::format("{} looks past {} third body, \"{}\" past {}, expected one that does alike",
                         potential->name(), potential->sees_third() ? "a" : "no", name,
                         potential->sees_third() ? "none" : "one");
    }
    if (potential) next.term.potential = *potential;
    change.replace(terms, i, std::move(next));
    return std::string();
  });
}

bool joins(const Coupling& c, BodyId a, BodyId b) {
  return (c.between.first == a && c.between.second == b) || (c.between.first == b && c.between.second == a);
}

/// Whether one of the first n couplings other than `but` keeps the two bodies apart and acts on all
/// agents of `felt_by`.
bool are_kept_apart(BodyId a, BodyId b, const std::vector<Coupling>& couplings, std::size_t n,
                    std::size_t but, const std::vector<AgentId>& felt_by) {
  for (std::size_t j = 0; j < n; ++j) {
    const Coupling& c = couplings[j];
    const bool felt = std::all_of(felt_by.begin(), felt_by.end(), [&](AgentId agent) {
      return std::find(c.felt_by.begin(), c.felt_by.end(), agent) != c.felt_by.end();
    });
    if (j != but && felt && c.ramp.lasts() && c.term.weight > 0 && joins(c, a, b) &&
        !keep_outs(c.term.potential).empty()) {
      return true;
    }
  }
  return false;
}

std::string apply(const Observe& observe, const TeamChange& change) {
  const AgentId observer = observe.observer;
  const BodyId target = observe.target;
  if (observer == target) return fmt::format("\"{}\" cannot observe itself", change.name(observer));
  auto& couplings = change.now.couplings;
  std::optional<SensorMount> through = observe.through;
  const auto is_through = [&](const Potential& potential) {
    return !through || potential.mount() == nullptr || *potential.mount() == *through;
  };
  const auto looks = std::find_if(couplings.begin(), couplings.end(), [&](const Coupling& c) {
    return c.ramp.lasts() && c.between.first == observer && observes(c.term.potential) &&
           is_through(c.term.potential);
  });
  if (looks == couplings.end()) {
    return fmt::format(
        "\"{}\" {}, expected a robot that observes", change.name(observer),
        observe.through ? "observes nothing by the sensor that is to turn" : "has no sensor on anything");
  }
  const BodyId before = looks->between.second;
  if (before == target) {
    return fmt::format("\"{}\" observes \"{}\" already, expected another", change.name(observer),
                       change.name(target));
  }
  if (const SensorMount* const mount = looks->term.potential.mount()) through = *mount;
  for (std::size_t i = 0, n = couplings.size(); i < n; ++i) {
    if (!couplings[i].ramp.lasts() || !joins(couplings[i], observer, before)) continue;
    if (is_view_set(couplings[i])) continue;
    // Another sensor of the observer stays on the previous target.
    if (couplings[i].between.first == observer && !is_through(couplings[i].term.potential)) continue;
    // The previous target observes the observer by this coupling, with its own sensor: it stays.
    if (couplings[i].between.first == before && observes(couplings[i].term.potential)) continue;
    const bool stays = keeps_apart(couplings[i].term.potential);
    Coupling next = couplings[i];
    BodyId& end = next.between.first == before ? next.between.first : next.between.second;
    end = target;
    if (change.is_robot(target)) {
      std::replace(next.felt_by.begin(), next.felt_by.end(), AgentId{before}, AgentId{target});
    } else {
      std::erase(next.felt_by, AgentId{before});
    }
    if (next.third == target) next.felt_by.clear();  // the potential would look past its own target
    if (stays) {
      if (next.felt_by.empty() || are_kept_apart(observer, target, couplings, n, i, next.felt_by)) continue;
      next.name.clear();
      next.ramp = change.fading_in();
      couplings.push_back(std::move(next));
      continue;
    }
    // A coupling that moves leaves behind its limits that keep the two apart.
    if (!are_kept_apart(observer, before, couplings, n, i, couplings[i].felt_by)) {
      for (Potential& limit : keep_outs(couplings[i].term.potential)) {
        Coupling apart = couplings[i];
        apart.term.potential = std::move(limit);
        if (!apart.term.potential.sees_third()) apart.third = {};
        apart.name.clear();
        apart.ramp = change.fading_in();
        couplings.push_back(std::move(apart));
      }
    }
    if (next.felt_by.empty()) {
      change.fade_out(couplings, i);
    } else {
      change.replace(couplings, i, std::move(next));
    }
  }
  return {};
}

std::string apply(const SetReference& set, const TeamChange& change) {
  Agent next = change.agent(set.agent);
  next.x_ref = set.reference;
  Reference before = change.now.reference(set.agent, change.t);
  if (std::string refusal = change.tune(set.agent, std::move(next)); !refusal.empty()) return refusal;
  std::erase_if(change.now.turns, [&](const Turn& turn) { return turn.agent == set.agent; });
  if (change.ramp > 0) change.now.turns.push_back({set.agent, std::move(before), change.fading_in()});
  return {};
}

std::string apply(const HandOver& hand_over, const TeamChange& change) {
  TeamState before = change.now;
  auto& couplings = change.now.couplings;
  for (const std::string& name : hand_over.names) {
    if (const std::size_t i = change.index(couplings, name); i < couplings.size())
      change.fade_out(couplings, i);
  }
  for (const Coupling& coupling : hand_over.couplings) {
    if (std::string refusal = apply(AddCoupling{coupling}, change); !refusal.empty()) {
      change.now = std::move(before);
      return refusal;
    }
  }
  return {};
}

std::string apply(const MoveBody& move, const TeamChange& change) {
  if (change.is_robot(move.body))
    return fmt::format("\"{}\" is a robot, expected a target or an obstacle", change.name(move.body));
  if (!change.is_there(move.body))
    return fmt::format("\"{}\" is not there, expected a body that is", change.name(move.body));
  auto& moves = change.now.around.moves;
  std::erase_if(moves, [&](const Surroundings::Move& other) { return other.body == move.body; });
  moves.push_back({move.body, move.p, change.t, change.ramp});
  return {};
}

std::string apply(const SetWind& wind, const TeamChange& change) {
  change.now.around.wind = Surroundings::Wind{wind.acceleration, change.t, change.ramp};
  return {};
}

std::string apply(const InjectFault& inject, const TeamChange& change) {
  auto& faults = change.now.around.faults;
  std::erase_if(faults, [&](const Surroundings::Fault& fault) { return fault.until <= change.t; });
  if (faults.size() >= Surroundings::faults_max)
    return fmt::format("{} faults are in force already, expected fewer", faults.size());
  faults.push_back({inject.kind, inject.body, inject.offset, change.t, change.t + inject.lasts});
  return {};
}

/// Fades out the sets of views whose pair no coupling observes any more.
void end_unobserved_sets(const TeamChange& change) {
  auto& couplings = change.now.couplings;
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const auto observes_pair = [&](const Coupling& c) {
      return c.ramp.lasts() && is_view_of(c, couplings[i].between);
    };
    if (is_view_set(couplings[i]) && std::none_of(couplings.begin(), couplings.end(), observes_pair))
      change.fade_out(couplings, i);
  }
}

}  // namespace

bool is_view_of(const Coupling& coupling, Between pair) {
  return coupling.between.first == pair.first && coupling.between.second == pair.second &&
         observes(coupling.term.potential);
}

std::string apply_action(const Action& action, TeamState& now, double t, double ramp) {
  const TeamChange change = {now, t, ramp};
  std::string refusal = std::visit([&](const auto& it) { return apply(it, change); }, action);
  if (refusal.empty()) end_unobserved_sets(change);
  return refusal;
}

}  // namespace sightline
