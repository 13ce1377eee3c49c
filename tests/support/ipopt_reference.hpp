/// The converged solution of an Ocp's discretised problem, by IPOPT: the yardstick of the real-time solvers.
#pragma once

#include <IpStdCInterface.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "sightline/solver/hamiltonian.hpp"

namespace sightline {

struct Optimum {
  std::vector<double> u;  ///< inputs (N x nu)
  double cost = 0.0;      ///< sum h l + phi
  double residual = 0.0;  ///< projected |h H_u|, infinity norm
};

/// Single shooting over the inputs of all stages, within their limits, with exact gradient and Hessian.
///
/// The team must be the optimum of one function: every coupling felt by both of its robots.
class IpoptReference {
 public:
  explicit IpoptReference(const Ocp& ocp)
      : ocp_(ocp),
        hamiltonian_(ocp_),
        n_(ocp_.horizon().N * ocp_.nu()),
        X_(static_cast<std::size_t>((ocp_.horizon().N + 1) * ocp_.nx())),
        Lambda_(X_) {}

  /// The whole horizon from the states x at time t [s], started at the inputs `guess`.
  /// @throws std::runtime_error where IPOPT does not converge
  Optimum solve(double t, const std::vector<double>& x, const std::vector<double>& guess) {
    hamiltonian_.set_time(t, ocp_.horizon().h());
    t_ = t;
    x_ = x;
    std::vector<double> low, high;
    for (int i = 0; i < ocp_.horizon().N; ++i) {
      low.insert(low.end(), hamiltonian_.u_min(i), hamiltonian_.u_min(i) + ocp_.nu());
      high.insert(high.end(), hamiltonian_.u_max(i), hamiltonian_.u_max(i) + ocp_.nu());
    }
    const IpoptProblem problem =
        CreateIpoptProblem(n_, low.data(), high.data(), 0, nullptr, nullptr, 0, n_ * (n_ + 1) / 2, 0, cost,
                           no_constraints, gradient, no_jacobian, hessian);
    char print_level[] = "print_level", sb[] = "sb", yes[] = "yes", tol[] = "tol";
    AddIpoptIntOption(problem, print_level, 0);
    AddIpoptStrOption(problem, sb, yes);
    AddIpoptNumOption(problem, tol, 1e-11);
    Optimum optimum{.u = guess};
    const ApplicationReturnStatus status =
        IpoptSolve(problem, optimum.u.data(), nullptr, &optimum.cost, nullptr, nullptr, nullptr, this);
    FreeIpoptProblem(problem);
    if (status != Solve_Succeeded && status != Solved_To_Acceptable_Level) {
      throw std::runtime_error("IPOPT did not converge");
    }
    std::vector<double> F(optimum.u.size());
    slope(optimum.u.data(), F.data());
    for (std::size_t k = 0; k < F.size(); ++k) {
      const double u = optimum.u[k];
      optimum.residual = std::max(optimum.residual, std::fabs(u - std::clamp(u - F[k], low[k], high[k])));
    }
    return optimum;
  }

 private:
  static IpoptReference& self(void* user) { return *static_cast<IpoptReference*>(user); }

  double h() const { return ocp_.horizon().h(); }

  /// dJ/du = h H_u.
  void slope(const double* u, double* dJ) {
    hamiltonian_.roll_out(x_.data(), u, ocp_.nu(), nullptr, 0.0, X_.data());
    hamiltonian_.linearise(X_.data(), u, ocp_.nu());
    hamiltonian_.costates(X_.data(), nullptr, 0.0, Lambda_.data(), dJ, ocp_.nu());
    for (int k = 0; k < n_; ++k) dJ[k] *= h();
  }

  static Bool cost(Index, Number* u, Bool, Number* value, UserDataPtr user) {
    IpoptReference& r = self(user);
    const Team& team = r.ocp_.team();
    const auto nx = static_cast<std::size_t>(team.nx()), nu = static_cast<std::size_t>(team.nu());
    const auto N = static_cast<std::size_t>(r.ocp_.horizon().N);
    r.hamiltonian_.roll_out(r.x_.data(), u, team.nu(), nullptr, 0.0, r.X_.data());
    double J = 0.0;
    for (std::size_t i = 0; i < N; ++i) {
      const double tau = r.t_ + static_cast<double>(i) * r.h();
      J += r.h() * stage_cost(team, tau, {&r.X_[i * nx], nx}, {u + i * nu, nu});
    }
    for (const BodyId body : r.ocp_.agent_bodies()) {
      const Agent& agent = team.agent(body);
      std::vector<double> x_ref(agent.Q_f.size());
      agent.x_ref(r.t_ + r.ocp_.horizon().T, agent.model, x_ref);
      const double* const x = &r.X_[N * nx + static_cast<std::size_t>(team.state_offset(body))];
      for (std::size_t j = 0; j < x_ref.size(); ++j)
        J += agent.Q_f[j] * (x_ref[j] - x[j]) * (x_ref[j] - x[j]);
    }
    *value = J;
    return TRUE;
  }

  static Bool gradient(Index, Number* u, Bool, Number* dJ, UserDataPtr user) {
    self(user).slope(u, dJ);
    return TRUE;
  }

  static Bool hessian(Index n, Number* u, Bool, Number scale, Index, Number*, Bool, Index, Index* row,
                      Index* column, Number* values, UserDataPtr user) {
    IpoptReference& r = self(user);
    if (values == nullptr) {
      for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j <= i; ++j) *row++ = i, *column++ = j;
      }
      return TRUE;
    }
    std::vector<double> unit(static_cast<std::size_t>(n)), dF(unit);
    r.slope(u, dF.data());
    r.hamiltonian_.curve(r.Lambda_.data());
    for (Index i = 0; i < n; ++i) {
      unit[static_cast<std::size_t>(i)] = 1.0;
      r.hamiltonian_.tangent(unit.data(), dF.data(), r.ocp_.nu());
      unit[static_cast<std::size_t>(i)] = 0.0;
      for (Index j = 0; j <= i; ++j) *values++ = scale * r.h() * dF[static_cast<std::size_t>(j)];
    }
    return TRUE;
  }

  static Bool no_constraints(Index, Number*, Bool, Index, Number*, UserDataPtr) { return TRUE; }
  static Bool no_jacobian(Index, Number*, Bool, Index, Index, Index*, Index*, Number*, UserDataPtr) {
    return TRUE;
  }

  Ocp ocp_;
  Hamiltonian hamiltonian_;
  int n_;
  std::vector<double> X_, Lambda_, x_;
  double t_ = 0.0;
};

}  // namespace sightline
