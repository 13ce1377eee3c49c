/// State of a team in flight, and one change of it: the input of an event's action.
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
  absent,   ///< not in the world
  steered,  ///< a robot of the team
  hold,     ///< present, not controlled: a robot that brakes and stays, a target or an obstacle
  land,     ///< a robot that brakes and descends
};

/// A robot whose reference blends from the previous to the present one.
struct Turn {
  AgentId agent;
  Reference from;
  Ramp ramp;
};

/// State that events change. Bodies are those of `all`.
struct TeamState {
  Team all;                         ///< only its bodies are used
  std::vector<Agent> agents;        ///< with present tuning, in the order of `all`
  std::vector<Coupling> couplings;  ///< in force or fading
  std::vector<Constraint> constraints;
  std::vector<Turn> turns;
  std::vector<Presence> presence;  ///< of each body
  Surroundings around{};

  /// Index of a robot in `agents`.
  std::size_t place(AgentId id) const {
    return static_cast<std::size_t>(&all.agent(id) - all.agents().data());
  }
  /// Reference of a robot from time t [s] on.
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
  /// From the present value of the ramp.
  Ramp fading_out(const Ramp& before) const {
    return {.begin = t, .duration = ramp, .from = before.at(t), .to = 0.0};
  }
  /// Fades out the i-th term; its name becomes free.
  template <class Term>
  void fade_out(std::vector<Term>& terms, std::size_t i) const {
    terms[i].name.clear();
    terms[i].ramp = fading_out(terms[i].ramp);
  }
  /// Fades out the i-th term and appends one that fades in.
  template <class Term>
  void replace(std::vector<Term>& terms, std::size_t i, Term next) const {
    next.ramp = fading_in();
    fade_out(terms, i);
    terms.push_back(std::move(next));
  }
  /// The lasting term of that name; the end if there is none.
  template <class Term>
  static auto find(std::vector<Term>& terms, std::string_view name) {
    return std::find_if(terms.begin(), terms.end(),
                        [&](const Term& term) { return term.name == name && term.ramp.lasts(); });
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
};

/// The error for a term that is not in force, which no event can change.
inline std::string no_such_term(std::string_view name) {
  return fmt::format("no coupling or constraint \"{}\" is in force, expected the name of one", name);
}

/// Subject of a change of a body or a term, by which contradictions are found.
inline std::string body_subject(const Team& all, BodyId body) {
  return fmt::format("\"{}\"", all.name(body));
}
inline std::string term_subject(std::string_view name) {
  return name.empty() ? std::string() : fmt::format("the coupling or constraint \"{}\"", name);
}

}  // namespace sightline
