/// The active team: which bodies are present and which couplings are in force, as events change
/// them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/ocp/event.hpp"
#include "sightline/ocp/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/potential/ramp.hpp"

namespace sightline {

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
  Reference reference(AgentId id, double t) const;
  /// Whether a coupling or constraint of that name is in force or fading in.
  bool has_term(std::string_view name) const;
};

/// Present state of each body of a team, for the evaluation and the guard of commands.
struct Membership {
  std::vector<Presence> presence;  ///< [body]
  std::vector<std::vector<BodyId>>
      partners;                     ///< [robot]: bodies with couplings that act on it; empty unless steered
  std::vector<InputLimits> limits;  ///< [robot]
  Surroundings around{};            ///< changes by events
};

class ActiveTeam {
 public:
  /// @param all       every body of the flight, and the initial couplings
  /// @param presence  of each body; missing entries: robots are steered, other bodies on hold
  explicit ActiveTeam(Team all, std::vector<Presence> presence = {});

  /// Applies one change at time t [s]; weights are blended over `ramp` [s].
  /// @return the reason of a rejection, a sentence, with the team unchanged; else empty
  std::string apply(const Action& action, double t, double ramp);

  /// The steered robots and the terms that act on them, from time t on. Bodies keep the order of
  /// all(). A robot that is not steered is an obstacle with its heading, for the robots coupled
  /// with it and for the robots of its swarms. Terms that have faded out are omitted.
  /// @throws std::invalid_argument if no steered robot is left
  Team team(double t) const;
  /// Time at which the last ramp that is active at t ends [s]; minus infinity without one.
  double at_rest_from(double t) const;

  Membership membership() const;

  const Team& all() const { return now_.all; }
  /// A robot with its present tuning.
  const Agent& agent(AgentId robot) const { return now_.agents[now_.place(robot)]; }
  const std::vector<Presence>& presence() const { return now_.presence; }
  Presence presence(BodyId body) const { return now_.presence[at(body)]; }
  /// Couplings in force or fading, of present and of absent bodies.
  const std::vector<Coupling>& couplings() const { return now_.couplings; }
  const std::vector<Constraint>& constraints() const { return now_.constraints; }
  /// Whether a coupling or constraint of that name is in force or fading in.
  bool has_term(std::string_view name) const { return now_.has_term(name); }

 private:
  std::vector<Coupling> swarm_couplings() const;

  TeamState now_;
};

}  // namespace sightline
