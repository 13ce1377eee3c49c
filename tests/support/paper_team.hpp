/// The two robots of section 7.1, (60)-(70): uav0 observes, uav1 flies a circle. docs/equations.md,
/// 9.
#pragma once

#include <utility>
#include <vector>

#include "sightline/potentials.hpp"
#include "sightline/team.hpp"

namespace sightline::paper {

enum class Variant {
  joint,   ///< both robots feel the three couplings
  masked,  ///< uav0 alone does, as in the paper
};

inline constexpr AgentId uav0{{0}}, uav1{{1}};

using Options = AgentOptions<Multirotor>;

inline Circle target_path() { return {.centre = {0, 0, 1}, .radius = 0.5, .rate = 0.3}; }
inline Options observer() { return {.Q = {0, 0, 0, 0, 0, 0.7, 0.7}}; }
inline Options target() { return {.Q = {1.5, 1.5, 1.6, 1, 1, 0, 0}, .x_ref = target_path(), .name = "uav1"}; }

/// @param limits  u_min and u_max of every input, in place of -1 and 1
inline Team team(Variant variant, std::pair<double, double> limits = {-1.0, 1.0}) {
  Team team;
  for (Options options : {observer(), target()}) {
    options.u_min.fill(limits.first);
    options.u_max.fill(limits.second);
    team.add(Multirotor{}, options);
  }
  const auto who = variant == Variant::joint ? felt_by({uav0, uav1}) : felt_by(uav0);
  team.couple(0.4 * SensorCone{}, Between{uav0, uav1}, who);
  team.couple(0.4 * Cohesion{}, Between{uav0, uav1}, who);
  team.couple(0.4 * KeepOut{}, Between{uav0, uav1}, who);
  return team;
}

/// uav1 with nobody watching.
inline Team target_alone() {
  Team team;
  team.add(Multirotor{}, target());
  return team;
}

inline std::vector<double> start() { return {-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0}; }
/// So far off that limits become active.
inline std::vector<double> saturating_start() { return {-4.6, 1.4, 0.9, 1, 0, 0, 0, -3, 2, 0.2, 0, 1, 0, 0}; }

}  // namespace sightline::paper
