/// The active team: which bodies are present and which couplings are in force, as events change them.
#pragma once

#include <string>
#include <vector>

#include "sightline/ocp/event.hpp"

namespace sightline {

/// Of each body of a roster, what is in force for it: what those need to know that judge and guard commands.
struct Membership {
  std::vector<Presence> presence;  ///< [body]
  std::vector<std::vector<BodyId>>
      partners;                     ///< [robot]: bodies that it feels a coupling with; none unless steered
  std::vector<InputLimits> limits;  ///< [robot]
  Surroundings around{};            ///< as events changed it
};

class ActiveTeam {
 public:
  /// @param all       every body there will ever be, and what couples them at first
  /// @param presence  of each body; those that are missing are there: robots steered, the others on hold
  explicit ActiveTeam(Team all, std::vector<Presence> presence = {});

  /// Makes one change at time t [s]; weights are blended over `ramp` [s].
  /// @return why it cannot be, a sentence: then nothing was changed; else empty
  std::string apply(const Action& action, double t, double ramp);

  /// The robots that are steered, and what they feel, at time t and on. Bodies are in the order of all(); a robot
  /// that is not steered is an obstacle with its heading to those that feel it, and to those that a swarm keeps off
  /// it. Terms that have faded away are left out.
  /// @throws std::invalid_argument where no robot is left
  Team team(double t) const;
  /// When the last weight that moves at t comes to rest [s]; minus infinity where none moves.
  double at_rest_from(double t) const;

  Membership membership() const;

  const Team& all() const { return now_.all; }
  /// A robot as it is tuned now.
  const Agent& agent(AgentId robot) const { return now_.agents[now_.place(robot)]; }
  const std::vector<Presence>& presence() const { return now_.presence; }
  Presence presence(BodyId body) const { return now_.presence[at(body)]; }
  /// Those in force or fading, of bodies that are there or not.
  const std::vector<Coupling>& couplings() const { return now_.couplings; }
  const std::vector<Constraint>& constraints() const { return now_.constraints; }
  /// Whether a coupling or constraint of that name is in force or fading in.
  bool has_term(std::string_view name) const { return now_.has_term(name); }

 private:
  std::vector<Coupling> swarm_couplings() const;

  TeamState now_;
};

}  // namespace sightline
