/// The converged solution of an Ocp's discretised problem by IPOPT: the yardstick of the real-time solvers, in
/// tests and benchmarks.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/ocp/ocp.hpp"

namespace sightline {

class MultipleShooting;

struct Optimum {
  std::vector<double> u{};  ///< inputs (N x nu)
  double cost = 0.0;        ///< sum h l + phi, of the whole team
  double residual = 0.0;    ///< projected |h H_u|, infinity norm
  double seconds = 0.0;     ///< processor time inside IPOPT [s]
};

/// How good the inputs are that IPOPT is given to begin with.
enum class Guess {
  near,  ///< it stays there: for following an optimum
  far,   ///< it looks around first
};

/// IPOPT works on the sparse program of `MultipleShooting`, the form that suits it, and minimises one function.
/// Where all robots feel their couplings that is the team's cost; with a mask each robot has its own, and they
/// are solved one after the other, those that are watched first.
class IpoptReference {
 public:
  /// @throws std::invalid_argument where robots watch each other in a circle and do not all feel it
  explicit IpoptReference(Ocp ocp);
  ~IpoptReference();

  /// The whole horizon from the states x of all bodies at time t [s], started at the inputs `guess` (N x nu).
  /// @throws std::runtime_error where IPOPT does not converge
  Optimum solve(double t, std::span<const double> x, std::span<const double> guess,
                Guess quality = Guess::near);

 private:
  /// Moves these agents to their optimum, and adds to what that took.
  void move_to_optimum(const std::vector<int>& agents, Guess quality, Optimum& optimum);

  std::unique_ptr<MultipleShooting> shooting_;
  std::vector<std::vector<int>> order_;  // agents that are solved together, one group after the other
};

}  // namespace sightline
