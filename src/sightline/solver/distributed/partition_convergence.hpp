/// How far a partitioned plan is from the optimum of the whole team, exchange by exchange, while time stands.
#pragma once

#include <memory>
#include <vector>

#include "sightline/solver/distributed/partition.hpp"

namespace sightline {

/// What is left after one exchange of all subteams.
struct FromOptimum {
  double input = 0.0;  ///< greatest |u - u*| of any input along the horizon [-]
  double cost = 0.0;   ///< (J(u) - J(u*)) / J(u*); below 0 where masked robots bear costs of others
  double kkt = 0.0;    ///< of the whole team [1/s]
};

/// J of a plan over the horizon from these states: h sum of l(x_k, u_k) + phi(x_N), every weight of the team,
/// masked or not. Bodies that are not controlled keep their velocity.
/// @param u  [stage][input], N x nu
/// @throws std::invalid_argument where states and plan are not of the problem
double horizon_cost(const Ocp& ocp, double time, std::span<const double> states, std::span<const double> u);

/// A solver of the whole team that goes to a stationary point, whatever it takes; to compare with.
std::unique_ptr<Solver> make_reference_solver(const Ocp& ocp);

/// Exchange after exchange at these states. The solver begins from its plan, which all have sent, and is left with the
/// plan of the last exchange. u* is the stationary point that the `reference`, of the same team, finds from the same plan.
/// @return one entry a exchange; none where that finds no stationary point
/// @throws std::invalid_argument for a reference that is no TeamPlanner
std::vector<FromOptimum> partition_convergence(PartitionedSolver& solver, Solver& reference, double time,
                                               std::span<const double> states, int exchanges);

}  // namespace sightline
