/// Globalisation of a step that cannot be trusted: a line search on the cost, which may also lengthen the step.
///
/// Where all agents share one cost there is one search for all. In a cascade each agent has a cost of
/// its own, given the plans of those it feels: one search for each agent, in the order of the influence graph.
/// In a cyclic team, or in a deep cascade, all searches run at once, each on its agent's own cost.
#pragma once

#include <vector>

#include "sightline/solver/newton/krylov.hpp"

namespace sightline {

/// Who searches.
enum class Searching {
  all,
  who_stood,  ///< whoever found no way in the search before; the others stay where they are
};

class Descent {
 public:
  Descent(std::span<const BodyPotential> potentials, const Layout& layout, const InfluenceGraph& graph);

  /// u <- start + alpha d within the limits, alpha of each unit such that its cost does not rise. Past the deadline no second
  /// length is tried: whoever rises by the first stays where it is.
  /// @return the smallest alpha of those that search; 0 where a cost rises along d from the start
  double search(Groups& groups, Couplings& couplings, const double* start, const double* d, const double* low,
                const double* high, double* u, double* s, ThreadPool& pool, Searching who = Searching::all,
                const Deadline& deadline = {}) noexcept;
  /// Whether costs are sure to lead on: one cost for all, or agents in order. Not where all search at once.
  bool sure() const { return sure_; }
  /// Whether a cost fell in the last search, beyond what rounding does to it.
  bool fell() const { return fell_; }

 private:
  /// Agents that move by one alpha, and what they cost together.
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
  double share_ = 1.0;             // of a pair's cost that each of the two has
  int levels_ = 1;
  bool sure_ = true, fell_ = false;
};

}  // namespace sightline
