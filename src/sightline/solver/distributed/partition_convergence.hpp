/// Distance of a partitioned plan from the optimum of the whole team, per exchange, at constant
/// time.
#pragma once

#include <memory>
#include <vector>

#include "sightline/solvers.hpp"

namespace sightline {

/// Distance from the optimum after one exchange of all subteams.
struct FromOptimum {
  double input = 0.0;  ///< largest |u - u*| of all inputs along the horizon [-]
  double cost = 0.0;   ///< (J(u) - J(u*)) / J(u*); negative if masked robots bear costs of others
  double kkt = 0.0;    ///< of the whole team [1/s]
};

/// J of a plan over the horizon from these states: h sum of l(x_k, u_k) + phi(x_N), with every
/// weight of the team, masked or not. Uncontrolled bodies keep their velocity.
/// @param u  [stage][input], N x nu
/// @throws std::invalid_argument if states or plan do not match the problem
double horizon_cost(const Ocp& ocp, double time, std::span<const double> states, std::span<const double> u);

/// Makes a whole-team solver that iterates to a stationary point regardless of time; a reference.
std::unique_ptr<Solver> make_reference_solver(const Ocp& ocp);

/// Runs exchanges at these states. The solver starts from its plan, which all subteams have sent,
/// and ends with the plan of the last exchange. u* is the stationary point that `reference`, a
/// solver of the same team, finds from the same plan.
/// @return one entry per exchange; empty if `reference` finds no stationary point
/// @throws std::invalid_argument if `reference` is no TeamPlanner
std::vector<FromOptimum> partition_convergence(PartitionedSolver& solver, Solver& reference, double time,
                                               std::span<const double> states, int exchanges);

}  // namespace sightline
