/// Globalisation of an unreliable step: a line search on the cost, which may also lengthen the
/// step.
///
/// If all agents share one cost, there is one search for all. In a cascade each agent has its own
/// cost, given the plans it depends on: one search per agent, in the order of the influence graph.
/// In a cyclic team or a deep cascade all searches run in parallel, each on its agent's own cost.
#pragma once

#include <vector>

#include "sightline/solver/newton/krylov.hpp"

namespace sightline {

/// Which units take part in a search.
enum class Searching {
  all,
  who_stood,  ///< units without a decrease in the previous search; the others keep their inputs
};

class Descent {
 public:
  Descent(std::span<const BodyPotential> potentials, const Layout& layout, const InfluenceGraph& graph);

  /// u <- start + alpha d within the limits; alpha per unit such that its cost does not rise. After
  /// the deadline no second length is tried: a unit whose cost rises at the first keeps its start.
  /// @return the smallest alpha of the searching units; 0 if a cost rises along d from the start
  double search(Groups& groups, Couplings& couplings, const double* start, const double* d, const double* low,
                const double* high, double* u, double* s, ThreadPool& pool, Searching who = Searching::all,
                const Deadline& deadline = {}) noexcept;
  /// Whether a cost decrease guarantees progress: one cost for all, or agents in order; false for
  /// parallel searches.
  bool sure() const { return sure_; }
  /// Whether a cost fell in the last search by more than rounding.
  bool fell() const { return fell_; }

 private:
  /// Agents that move by one alpha, and their common cost.
  struct Unit {
    int level = 0;
    std::vector<int> agents, potentials;
    double before = 0.0, best = 0.0, cost = 0.0, alpha = 0.0;
    bool searches = true, settled = false;
  };

  void move(const Unit& unit, double alpha, const double* start, const double* d, const double* low,
            const double* high, double* u) const noexcept;
  void evaluate_costs(int level, Groups& groups, Couplings& couplings, const double* u, double* s,
                      ThreadPool& pool) noexcept;

  Layout layout_;
  std::vector<Unit> units_;
  std::vector<double> values_;     // of each potential
  std::vector<char> wanted_;       // of each potential
  std::vector<char> moved_;        // of each group
  Rows own_;                       // of each lane of each group
  std::vector<double> of_swarms_;  // of each agent
  double share_ = 1.0;             // part of a pair's cost assigned to each of its agents
  int levels_ = 1;
  bool sure_ = true, fell_ = false;
};

}  // namespace sightline
