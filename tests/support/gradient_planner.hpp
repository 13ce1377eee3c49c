/// A solver of the tests' own that can plan in a team that changes: projected gradient steps on
/// single shooting. It takes bodies that are not controlled to keep their velocity, whatever is
/// predicted of them.
#pragma once

#include <algorithm>
#include <cmath>

#include "sightline/solver.hpp"
#include "sightline/solvers.hpp"

namespace sightline {

class GradientPlanner : public Solver, public TeamPlanner {
 public:
  GradientPlanner(Team team, const Horizon& horizon)
      : ocp_(std::move(team), horizon),
        hamiltonian_(ocp_),
        nu_(static_cast<std::size_t>(ocp_.nu())),
        u_(nu_ * static_cast<std::size_t>(horizon.N)),
        F_(u_),
        u_now_(nu_),
        raw_u_(nu_),
        x_now_(static_cast<std::size_t>(ocp_.nx())),
        X_(x_now_.size() * static_cast<std::size_t>(horizon.N + 1)),
        Lambda_(X_) {}

  std::string_view name() const override { return "gradient_planner"; }
  const Ocp& ocp() const override { return ocp_; }
  TeamPlanner* team_planner() noexcept override { return this; }
  double tolerance() const noexcept override { return 1e-3; }

  Solution solve(double time, std::span<const double> states) noexcept override {
    Solution solution{.u = u_now_, .raw_u = raw_u_, .x = X_, .status = Status::invalid_state};
    if (!accept(time, states)) return solution;
    constexpr int steps = 20;
    constexpr double rate = 0.1;
    for (int i = 0; i < steps; ++i) {
      solution.residual = descend(rate);
      if (!std::isfinite(solution.residual)) {
        restart();
        solution.status = Status::not_finite;
        return solution;
      }
    }
    std::copy_n(u_.begin(), nu_, raw_u_.begin());
    std::copy_n(u_.begin(), nu_, u_now_.begin());
    time_ = time;
    solution.status = solution.residual <= tolerance() ? Status::converged : Status::stepped;
    solution.iterations = steps;
    return solution;
  }
  double kkt(double time, std::span<const double> states) noexcept override {
    return accept(time, states) ? descend(0.0) : std::numeric_limits<double>::infinity();
  }
  void planned(double time, std::span<double> u) const noexcept override {
    const double stage = (time - time_) / ocp_.horizon().h();
    plan(static_cast<int>(std::clamp(std::isfinite(stage) ? stage : 0.0, 0.0, ocp_.horizon().N - 1.0)), u);
  }
  void restart() noexcept override { std::fill(u_.begin(), u_.end(), 0.0); }

  void plan(int k, std::span<double> u) const noexcept override {
    if (is_stage(k, u)) std::copy_n(u_.begin() + k * static_cast<std::ptrdiff_t>(nu_), nu_, u.begin());
  }
  void set_plan(int k, std::span<const double> u) noexcept override {
    if (is_stage(k, u)) std::copy(u.begin(), u.end(), u_.begin() + k * static_cast<std::ptrdiff_t>(nu_));
  }
  void set_prediction(const Prediction&) noexcept override {}

 private:
  bool is_stage(int k, std::span<const double> u) const {
    return k >= 0 && k < ocp_.horizon().N && u.size() == nu_;
  }

  bool accept(double time, std::span<const double> states) noexcept {
    if (!std::isfinite(time) || states.size() != x_now_.size()) return false;
    std::copy(states.begin(), states.end(), x_now_.begin());
    const Team& team = ocp_.team();
    for (int i = 0; i < team.bodies(); ++i) {
      if (!team.model(BodyId{i}).normalise(&x_now_[static_cast<std::size_t>(team.state_offset(BodyId{i}))]))
        return false;
    }
    hamiltonian_.set_time(time, ocp_.horizon().h(), x_now_.data());
    return true;
  }

  /// u <- u - rate H_u, within the limits. @return the residual before
  double descend(double rate) noexcept {
    const int stride = ocp_.nu();
    hamiltonian_.roll_out(x_now_.data(), u_.data(), stride, nullptr, 0.0, X_.data());
    hamiltonian_.linearise(X_.data(), u_.data(), stride);
    hamiltonian_.costates(X_.data(), nullptr, 0.0, Lambda_.data(), F_.data(), stride);
    double residual = 0.0;
    for (std::size_t i = 0; i < u_.size(); ++i) {
      const int k = static_cast<int>(i / nu_);
      const double low = hamiltonian_.u_min(k)[i % nu_], high = hamiltonian_.u_max(k)[i % nu_];
      const double gap = std::fabs(u_[i] - std::clamp(u_[i] - F_[i], low, high));
      residual = gap <= residual ? residual : gap;  // NaN stays
      u_[i] = std::clamp(u_[i] - rate * F_[i], low, high);
    }
    return residual;
  }

  Ocp ocp_;
  Hamiltonian hamiltonian_;
  std::size_t nu_;
  double time_ = 0.0;
  std::vector<double> u_, F_, u_now_, raw_u_, x_now_, X_, Lambda_;
};

inline MakeSolver gradient_planner_of(const Horizon& horizon) {
  return [horizon](Team team) { return std::make_unique<GradientPlanner>(std::move(team), horizon); };
}

}  // namespace sightline
