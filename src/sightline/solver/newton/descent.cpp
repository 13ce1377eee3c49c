#include "sightline/solver/newton/descent.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sightline {
namespace {

constexpr int doublings = 6;
constexpr double rounding = 1e-12;  // of costs, relative
constexpr int deepest = 4;          // a deeper cascade is searched in parallel

}  // namespace

Descent::Descent(std::span<const BodyPotential> potentials, const Layout& layout, const InfluenceGraph& graph)
    : layout_(layout),
      values_(potentials.size()),
      wanted_(potentials.size()),
      moved_(layout.groups.size()),
      own_(static_cast<int>(layout.groups.size()), layout.width),
      of_swarms_(layout.agents.size()) {
  const int agents = static_cast<int>(layout.agents.size()), all = static_cast<int>(potentials.size());
  if (graph.kind == Influence::mutual) {
    Unit& team = units_.emplace_back();
    team.agents.resize(layout.agents.size());
    team.potentials.resize(potentials.size());
    std::iota(team.agents.begin(), team.agents.end(), 0);
    std::iota(team.potentials.begin(), team.potentials.end(), 0);
    share_ = 0.5;
    return;
  }
  const bool in_order = graph.kind == Influence::cascade && graph.depth <= deepest;
  if (in_order) levels_ = graph.depth + 1;
  sure_ = in_order || graph.kind == Influence::none;
  for (int a = 0; a < agents; ++a) {
    Unit& unit = units_.emplace_back();
    unit.agents = {a};
    if (in_order) unit.level = graph.depth_of[static_cast<std::size_t>(a)];
    for (int p = 0; p < all; ++p) {
      const BodyPotential& potential = potentials[static_cast<std::size_t>(p)];
      const bool felt =
          (potential.a == a && potential.ends.a_feels) || (potential.b == a && potential.ends.b_feels);
      if (felt) unit.potentials.push_back(p);
    }
  }
}

void Descent::move(const Unit& unit, double alpha, const double* start, const double* d, const double* low,
                   const double* high, double* u) const noexcept {
  for (const int a : unit.agents) {
    const Layout::View view = layout_.u(a);
    for (int k = 0; k < layout_.stages; ++k) {
      for (int i = 0; i < layout_.part(a).nu; ++i) {
        const std::ptrdiff_t at = view(k, i);
        u[at] =
            alpha > 0.0 ? clamp(start[at] + alpha * d[at], low[at], high[at]) : start[at];  // d may be null
      }
    }
  }
}

/// Evaluates the costs of a level's unsettled units: only these have moved.
void Descent::evaluate_costs(int level, Groups& groups, Couplings& couplings, const double* u, double* s,
                             ThreadPool& pool) noexcept {
  std::fill(wanted_.begin(), wanted_.end(), 0);
  std::fill(moved_.begin(), moved_.end(), 0);
  const auto each = [&](auto&& f) {
    for (Unit& unit : units_) {
      if (unit.level == level && unit.searches && !unit.settled) f(unit);
    }
  };
  each([&](const Unit& unit) {
    for (const int a : unit.agents) moved_[static_cast<std::size_t>(layout_.place(a).group)] = 1;
    for (const int p : unit.potentials) wanted_[static_cast<std::size_t>(p)] = 1;
  });
  groups.each(pool, [&](int g, int) noexcept {
    if (moved_[static_cast<std::size_t>(g)] == 0) return;
    groups.roll_out(g, u, s);
    groups.own_costs(g, u, own_[g]);
  });
  couplings.values(s, values_, wanted_);
  std::fill(of_swarms_.begin(), of_swarms_.end(), 0.0);
  couplings.swarm_values(s, of_swarms_);
  each([&](Unit& unit) {
    unit.cost = 0.0;
    for (const int a : unit.agents) {
      const Layout::Place& place = layout_.place(a);
      unit.cost += own_[place.group][place.lane] + share_ * of_swarms_[static_cast<std::size_t>(a)];
    }
    for (const int p : unit.potentials) unit.cost += values_[static_cast<std::size_t>(p)];
  });
}

double Descent::search(Groups& groups, Couplings& couplings, const double* start, const double* d,
                       const double* low, const double* high, double* u, double* s, ThreadPool& pool,
                       Searching who, const Deadline& deadline) noexcept {
  std::copy_n(start, layout_.u_length, u);
  double smallest = 1.0;
  fell_ = false;
  for (Unit& unit : units_) unit.searches = who == Searching::all || unit.alpha == 0.0;
  for (int level = 0; level < levels_; ++level) {
    groups.roll_out(u, s, pool);
    const auto each = [&](auto&& f) {
      for (Unit& unit : units_) {
        if (unit.level == level && unit.searches) f(unit);
      }
    };
    const auto try_at = [&](double alpha) {
      each([&](Unit& unit) {
        if (!unit.settled) move(unit, alpha, start, d, low, high, u);
      });
      evaluate_costs(level, groups, couplings, u, s, pool);
    };
    each([](Unit& unit) { unit.settled = false; });
    evaluate_costs(level, groups, couplings, u, s, pool);
    each([](Unit& unit) {
      unit.before = unit.best = unit.cost;
      unit.alpha = 0.0;
    });
    // If a cost rises while other units move, steps below a thirtieth rarely help.
    const int halvings = sure_ ? 12 : 6;
    bool pending = true;
    double alpha = 1.0;
    for (int i = 0; i < halvings && pending; ++i, alpha *= 0.5) {
      if (i > 0 && deadline.passed()) break;
      try_at(alpha);
      pending = false;
      each([&](Unit& unit) {
        if (unit.settled) return;
        unit.settled = unit.cost < unit.before + rounding * std::fabs(unit.before);
        pending |= !unit.settled;
        if (unit.settled) unit.alpha = alpha, unit.best = unit.cost;
      });
      if (i > 0 || !pending || sure_) continue;
      // Other units have moved: the reference cost must include their motion, so that only the
      // unit's own step is compared.
      try_at(0.0);
      each([](Unit& unit) {
        if (!unit.settled) unit.before = unit.best = unit.cost;
      });
    }
    // A damped step may be far too short.
    each([&](Unit& unit) { unit.settled = unit.alpha < 1.0; });
    alpha = 2.0;
    for (int i = 0; i < doublings; ++i, alpha *= 2.0) {
      bool growing = false;
      each([&](Unit& unit) { growing |= !unit.settled; });
      if (!growing || deadline.passed()) break;
      try_at(alpha);
      each([&](Unit& unit) {
        if (unit.settled) return;
        unit.settled = !(unit.cost < unit.best);
        if (!unit.settled) unit.alpha = alpha, unit.best = unit.cost;
      });
    }
    each([&](Unit& unit) {
      move(unit, unit.alpha, start, d, low, high, u);
      smallest = std::min(smallest, unit.alpha);
      fell_ |= unit.best < unit.before - rounding * std::fabs(unit.before);
    });
  }
  return smallest;
}

}  // namespace sightline
