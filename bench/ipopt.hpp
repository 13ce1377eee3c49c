/// The converged solution of an Ocp's discretised problem by IPOPT: the reference for the real-time
/// solvers, in tests and benchmarks.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/team.hpp"

namespace sightline {

class MultipleShooting;

struct Optimum {
  std::vector<double> u{};  ///< inputs (N x nu)
  double cost = 0.0;        ///< sum h l + phi, of the whole team
  double residual = 0.0;    ///< projected |h H_u|, infinity norm
  double seconds = 0.0;     ///< processor time inside IPOPT [s]
};

/// Quality of the initial inputs for IPOPT.
enum class Guess {
  near,  ///< IPOPT stays nearby: to follow an optimum
  far,   ///< IPOPT explores first
};

/// IPOPT solves the sparse program of `MultipleShooting` and minimises one function. If the
/// couplings are in the cost of all robots, that function is the team's cost. With a mask each
/// robot has its own cost, and robots are solved one after the other, observed robots first.
class IpoptReference {
 public:
  /// @throws std::invalid_argument if the observations form a cycle and a coupling is missing from
  ///   the cost of one of its robots
  explicit IpoptReference(Ocp ocp);
  ~IpoptReference();

  /// Solves the whole horizon from the states x of all bodies at time t [s], started at the inputs
  /// `guess` (N x nu).
  /// @throws std::runtime_error if IPOPT does not converge
  Optimum solve(double t, std::span<const double> x, std::span<const double> guess,
                Guess quality = Guess::near);

 private:
  /// Moves these agents to their optimum, and adds the solve's time.
  void move_to_optimum(const std::vector<int>& agents, Guess quality, Optimum& optimum);

  std::unique_ptr<MultipleShooting> shooting_;
  std::vector<std::vector<int>> order_;  // groups of agents solved together, in their order
};

}  // namespace sightline
