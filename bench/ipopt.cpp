#include "bench/ipopt.hpp"

#include <IpStdCInterface.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <stdexcept>
#include <string>

#include "bench/shooting.hpp"
#include "sightline/base.hpp"

namespace sightline {
namespace {

bool feels(const Coupling& coupling, BodyId body) {
  return std::find(coupling.felt_by.begin(), coupling.felt_by.end(), body) != coupling.felt_by.end();
}

/// Groups of agents (indices), in an order in which they can be solved.
std::vector<std::vector<int>> solving_order(const Ocp& ocp) {
  const Team& team = ocp.team();
  const int n = static_cast<int>(ocp.agent_bodies().size());
  bool shared = true;
  for (const Coupling& c : team.couplings()) {
    for (const BodyId body : {c.between.first, c.between.second})
      shared &= !team.is_agent(body) || feels(c, body);
    shared &= !c.has_third() || !team.is_agent(c.third);
  }
  std::vector<std::vector<int>> order;
  if (shared) {
    order.emplace_back();
    for (int a = 0; a < n; ++a) order[0].push_back(a);
    return order;
  }
  std::vector<bool> solved(at(n), false);
  const auto waits = [&](int a, int b) {
    const BodyId mine = ocp.agent_bodies()[at(a)], other = ocp.agent_bodies()[at(b)];
    return std::any_of(team.couplings().begin(), team.couplings().end(), [&](const Coupling& c) {
      return feels(c, mine) && (c.between.first == other || c.between.second == other || c.third == other);
    });
  };
  while (static_cast<int>(order.size()) < n) {
    int next = -1;
    for (int a = 0; a < n && next < 0; ++a) {
      bool ready = !solved[at(a)];
      for (int b = 0; b < n; ++b) ready &= b == a || solved[at(b)] || !waits(a, b);
      if (ready) next = a;
    }
    if (next < 0) {
      throw std::invalid_argument(
          "robots watch each other in a circle that not all of them feel, expected a problem with one "
          "optimum");
    }
    solved[at(next)] = true;
    order.push_back({next});
  }
  return order;
}

/// The callbacks of IPOPT. The trajectories follow the point that IPOPT requests.
struct Callbacks {
  static MultipleShooting& at_point(const double* w, UserDataPtr user) {
    MultipleShooting& problem = *static_cast<MultipleShooting*>(user);
    if (w != nullptr) problem.move_to(w);
    return problem;
  }
  static void places(const std::vector<MultipleShooting::Nonzero>& entries, int* row, int* column) {
    for (const MultipleShooting::Nonzero& e : entries) *row++ = e.row, *column++ = e.column;
  }
  static Bool cost(int, double* w, Bool, double* value, UserDataPtr user) {
    *value = at_point(w, user).cost();
    return std::isfinite(*value) ? TRUE : FALSE;
  }
  static Bool gradient(int, double* w, Bool, double* dJ, UserDataPtr user) {
    at_point(w, user).gradient(dJ);
    return TRUE;
  }
  static Bool defects(int, double* w, Bool, int, double* d, UserDataPtr user) {
    at_point(w, user).defects(d);
    return TRUE;
  }
  static Bool jacobian(int, double* w, Bool, int, int, int* row, int* column, double* values,
                       UserDataPtr user) {
    MultipleShooting& problem = at_point(w, user);
    if (values == nullptr) {
      places(problem.jacobian(), row, column);
    } else {
      problem.jacobian_values(values);
    }
    return TRUE;
  }
  static Bool hessian(int, double* w, Bool, double sigma, int, double* lambda, Bool, int, int* row,
                      int* column, double* values, UserDataPtr user) {
    MultipleShooting& problem = at_point(w, user);
    if (values == nullptr) {
      places(problem.hessian(), row, column);
    } else {
      problem.hessian_values(sigma, lambda, values);
    }
    return TRUE;
  }
};

/// |w - clamp(w - slope)| of the Lagrangian, infinity norm.
double projected_slope(MultipleShooting& shooting, const std::vector<double>& w,
                       const std::vector<double>& multipliers, const std::vector<double>& low,
                       const std::vector<double>& high) {
  std::vector<double> slope(w.size()), values(shooting.jacobian().size());
  shooting.gradient(slope.data());
  shooting.jacobian_values(values.data());
  for (std::size_t e = 0; e < values.size(); ++e)
    slope[at(shooting.jacobian()[e].column)] += values[e] * multipliers[at(shooting.jacobian()[e].row)];
  double worst = 0.0;
  for (std::size_t i = 0; i < w.size(); ++i)
    worst = std::max(worst, std::fabs(w[i] - std::clamp(w[i] - slope[i], low[i], high[i])));
  return worst;
}

/// Processor time of this thread [s]: during a long solve other threads may preempt it.
double thread_seconds() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void set_options(IpoptProblem problem, Guess quality) {
  const auto word = [&](std::string key, std::string value) {
    AddIpoptStrOption(problem, key.data(), value.data());
  };
  const auto number = [&](std::string key, double value) { AddIpoptNumOption(problem, key.data(), value); };
  const auto integer = [&](std::string key, int value) { AddIpoptIntOption(problem, key.data(), value); };
  integer("print_level", 0);
  word("sb", "yes");
  word("nlp_scaling_method", "none");
  // Accurate from 1e-10 on; a few more iterations bring weakly active inputs to their limits.
  number("tol", 1e-13);
  number("acceptable_tol", 1e-10);
  integer("acceptable_iter", 4);
  number("bound_relax_factor", 0.0);
  if (quality == Guess::far) return;
  number("mu_init", 1e-6);
  number("bound_push", 1e-8);
  number("bound_frac", 1e-8);
}

}  // namespace

IpoptReference::IpoptReference(Ocp ocp)
    : shooting_(std::make_unique<MultipleShooting>(std::move(ocp))),
      order_(solving_order(shooting_->ocp())) {}
IpoptReference::~IpoptReference() = default;

void IpoptReference::move_to_optimum(const std::vector<int>& agents, Guess quality, Optimum& optimum) {
  shooting_->choose(agents);
  std::vector<double> low, high, w = shooting_->point();
  shooting_->bounds(low, high);
  std::vector<double> zero(at(shooting_->constraints()), 0.0), multipliers(zero);
  const IpoptProblem problem = CreateIpoptProblem(
      shooting_->unknowns(), low.data(), high.data(), shooting_->constraints(), zero.data(), zero.data(),
      static_cast<int>(shooting_->jacobian().size()), static_cast<int>(shooting_->hessian().size()), 0,
      Callbacks::cost, Callbacks::defects, Callbacks::gradient, Callbacks::jacobian, Callbacks::hessian);
  set_options(problem, quality);
  const double begin = thread_seconds();
  const ApplicationReturnStatus status =
      IpoptSolve(problem, w.data(), nullptr, nullptr, multipliers.data(), nullptr, nullptr, shooting_.get());
  optimum.seconds += thread_seconds() - begin;
  FreeIpoptProblem(problem);
  if (status != Solve_Succeeded && status != Solved_To_Acceptable_Level) {
    throw std::runtime_error(fmt::format("IPOPT did not converge (status {})", static_cast<int>(status)));
  }
  shooting_->move_to(w.data());
  optimum.residual = std::max(optimum.residual, projected_slope(*shooting_, w, multipliers, low, high));
}

Optimum IpoptReference::solve(double t, std::span<const double> x, std::span<const double> guess,
                              Guess quality) {
  Optimum optimum{};
  shooting_->set(t, x, guess);
  for (const std::vector<int>& agents : order_) move_to_optimum(agents, quality, optimum);
  std::vector<int> all(shooting_->ocp().agent_bodies().size());
  std::iota(all.begin(), all.end(), 0);
  shooting_->choose(all);
  optimum.u = shooting_->inputs();
  optimum.cost = shooting_->cost();
  return optimum;
}

}  // namespace sightline
