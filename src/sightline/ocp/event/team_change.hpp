/// A team in flight, and one change of it: what an action of an event is given.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/ocp/event/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/potential/ramp.hpp"

namespace sightline {

enum class Presence : std::uint8_t {
  absent,   ///< nowhere
  steered,  ///< a robot of the team
  hold,     ///< present, but not controlled: a robot that brakes and stays, a target or an obstacle
  land,     ///< a robot that brakes and sinks
};

/// A robot whose reference is blended from the last one to the present one.
struct Turn {
  AgentId agent;
  Reference from;
  Ramp ramp;
};

/// What events change. Bodies are those of `all`.
struct TeamState {
  Team all;                         ///< bodies alone count
  std::vector<Agent> agents;        ///< as tuned now, in the order of `all`
  std::vector<Coupling> couplings;  ///< in force or fading
  std::vector<Constraint> constraints;
  std::vector<Turn> turns;
  std::vector<Presence> presence;  ///< of each body
  Surroundings around{};

  /// Of a robot, in `agents`.
  std::size_t place(AgentId id) const {
    return static_cast<std::size_t>(&all.agent(id) - all.agents().data());
  }
  /// What a robot follows at time t [s].
  Reference reference(AgentId id, double t) const {
    const Reference& last = agents[place(id)].x_ref;
    const auto turn =
        std::find_if(turns.begin(), turns.end(), [&](const Turn& it) { return it.agent == id; });
    if (turn == turns.end() || turn->ramp.has_settled(t)) return last;
    return Reference::between(turn->from, last, turn->ramp);
  }
  /// Whether a coupling or constraint of that name is in force or fading in.
  bool has_term(std::string_view name) const {
    const auto called = [&](const auto& term) { return term.name == name && term.ramp.lasts(); };
    return !name.empty() && (std::any_of(couplings.begin(), couplings.end(), called) ||
                             std::any_of(constraints.begin(), constraints.end(), called));
  }
};

/// A change at time t [s], whose weights are blended over `ramp` [s].
struct TeamChange {
  TeamState& now;
  double t, ramp;

  std::string name(BodyId body) const { return std::string(now.all.name(body)); }
  bool is_robot(BodyId body) const { return now.all.is_agent(body); }
  bool is_there(BodyId body) const { return presence(body) != Presence::absent; }
  Presence& presence(BodyId body) const { return now.presence[at(body)]; }
  const Agent& agent(AgentId id) const { return now.agents[now.place(id)]; }

  Ramp fading_in() const {
    return ramp > 0 ? Ramp{.begin = t, .duration = ramp, .from = 0.0, .to = 1.0} : Ramp{};
  }
  /// From what is in force now.
  Ramp fading_out(const Ramp& before) const {
    return {.begin = t, .duration = ramp, .from = before.at(t), .to = 0.0};
  }
  /// Lets the i-th fade out, which no event speaks of any more.
  template <class Term>
  void fade_out(std::vector<Term>& terms, std::size_t i) const {
    terms[i].name.clear();
    terms[i].ramp = fading_out(terms[i].ramp);
  }
  /// Puts one that fades in beside the i-th, which fades out.
  template <class Term>
  void replace(std::vector<Term>& terms, std::size_t i, Term next) const {
    next.ramp = fading_in();
    fade_out(terms, i);
    terms.push_back(std::move(next));
  }
  /// The term of that name which lasts; the end where there is none.
  template <class Term>
  static auto find(std::vector<Term>& terms, std::string_view name) {
    return std::find_if(terms.begin(), terms.end(),
                        [&](const Term& term) { return term.name == name && term.ramp.lasts(); });
  }

  /// Tunes a robot anew. @return why a Team would not take it, a sentence; else empty
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
};

/// Of a term that no event can change, since it is not in force.
inline std::string no_such_term(std::string_view name) {
  return fmt::format("no coupling or constraint \"{}\" is in force, expected the name of one", name);
}

/// What a body or a term is called where two changes of it contradict each other.
inline std::string body_subject(const Team& all, BodyId body) {
  return fmt::format("\"{}\"", all.name(body));
}
inline std::string term_subject(std::string_view name) {
  return name.empty() ? std::string() : fmt::format("the coupling or constraint \"{}\"", name);
}

}  // namespace sightline
