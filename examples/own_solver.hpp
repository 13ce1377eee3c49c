// A solver of one's own that scenarios call by name: `[solver] name = "one_move"`.
#pragma once

#include <algorithm>
#include <sightline/solver.hpp>
#include <utility>

struct OneMoveOptions {
  int steps = 5;
  double rate = 0.2;

  static constexpr auto parameters() {
    using sightline::parameter, sightline::Parameters, sightline::above_zero;
    using O = OneMoveOptions;
    return Parameters{parameter("steps", &O::steps, "", {1, 100, "1 to 100"}, "gradient steps of an update"),
                      parameter("rate", &O::rate, "", above_zero, "length of a gradient step")};
  }
};

/// Plans one input for the whole horizon T, robot by robot and without couplings, by gradient steps on
///
///   J(u) = (x(T) - x*)' Q (x(T) - x*) + (u - u*)' R (u - u*)
class OneMove final : public sightline::Solver {
 public:
  OneMove(const sightline::Team& team, const sightline::Horizon& horizon, const OneMoveOptions& options)
      : ocp_(team, horizon), options_(options), u_(resting_inputs(team)), raw_u_(u_) {
    for (const sightline::Agent& agent : team.agents()) {
      const auto nx = static_cast<std::size_t>(agent.model.nx());
      x_.resize(std::max(x_.size(), nx)), x_ref_.resize(x_.size());
    }
    u_min_.resize(u_.size()), u_max_.resize(u_.size());
  }

  std::string_view name() const override { return "one_move"; }
  const sightline::Ocp& ocp() const override { return ocp_; }

  sightline::Solution solve(double time, std::span<const double> states) noexcept override {
    using sightline::Status;
    if (!sightline::all_finite(states))
      return {.u = u_, .raw_u = raw_u_, .x = {}, .status = Status::invalid_state};
    const sightline::Team& team = ocp_.team();
    for (const sightline::BodyId body : ocp_.agent_bodies()) {
      const sightline::Agent& agent = team.agent(body);
      const auto nu = static_cast<std::size_t>(agent.model.nu());
      const auto first = static_cast<std::size_t>(team.input_offset(body));
      const std::span<double> u = std::span(u_).subspan(first, nu),
                              raw = std::span(raw_u_).subspan(first, nu);
      const std::span<double> low = std::span(u_min_).first(nu), high = std::span(u_max_).first(nu);
      agent.limits.at(time, low, high);
      agent.x_ref(time + ocp_.horizon().T, agent.model, reference_of(agent));
      const double* x = states.data() + team.state_offset(body);
      for (int step = 0; step < options_.steps; ++step) {
        for (std::size_t i = 0; i < nu; ++i) {
          const double kept = u[i];
          u[i] = kept + difference;
          const double above = cost(agent, x, u);
          u[i] = kept - difference;
          const double slope = (above - cost(agent, x, u)) / (2 * difference);
          raw[i] = kept - options_.rate * slope;
          u[i] = std::clamp(raw[i], low[i], high[i]);
        }
      }
    }
    return {.u = u_, .raw_u = raw_u_, .x = {}, .status = Status::stepped};
  }
  double kkt(double, std::span<const double>) noexcept override {
    return std::numeric_limits<double>::infinity();
  }
  void planned(double, std::span<double> u) const noexcept override {
    if (u.size() == u_.size()) std::copy(u_.begin(), u_.end(), u.begin());
  }
  void restart() noexcept override {
    for (const sightline::BodyId body : ocp_.agent_bodies()) {
      const sightline::Agent& agent = ocp_.team().agent(body);
      std::copy(agent.u_ref.begin(), agent.u_ref.end(), u_.begin() + ocp_.team().input_offset(body));
    }
  }

 private:
  static constexpr double difference = 1e-4;

  std::span<double> reference_of(const sightline::Agent& agent) noexcept {
    return std::span(x_ref_).first(static_cast<std::size_t>(agent.model.nx()));
  }
  double cost(const sightline::Agent& agent, const double* now, std::span<const double> u) noexcept {
    const sightline::Horizon& horizon = ocp_.horizon();
    std::copy_n(now, agent.model.nx(), x_.begin());
    for (int k = 0; k < horizon.N; ++k) agent.model.step(x_.data(), u.data(), horizon.h());
    double sum = 0.0;
    for (std::size_t i = 0; i < agent.Q.size(); ++i)
      sum += agent.Q[i] * (x_[i] - x_ref_[i]) * (x_[i] - x_ref_[i]);
    for (std::size_t i = 0; i < u.size(); ++i)
      sum += agent.R[i] * (u[i] - agent.u_ref[i]) * (u[i] - agent.u_ref[i]);
    return sum;
  }

  sightline::Ocp ocp_;
  OneMoveOptions options_;
  std::vector<double> u_, raw_u_, x_, x_ref_, u_min_, u_max_;
};
