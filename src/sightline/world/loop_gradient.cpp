#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/formula.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

NewtonRiccatiOptions converging() {
  NewtonRiccatiOptions options;
  options.max_newton_steps = 30;
  options.start_steps = 100;
  options.tolerance = 1e-9;
  options.max_krylov = 30;
  options.krylov_stop = 1e-8;
  return options;
}

/// The Runge-Kutta step of a model and its derivatives by (x, u).
Program trace_runge_kutta(const Model& model, double dt) {
  Graph graph;
  const std::size_t nx = at(model.nx());
  const std::vector<Symbol> x = variables(graph, 0, model.nx()), u = variables(graph, model.nx(), model.nu());
  std::vector<Symbol> next = x, trial = x, rate(nx);
  constexpr std::array<double, 4> weight = {1.0, 2.0, 2.0, 1.0}, ahead = {0.5, 0.5, 1.0, 0.0};
  for (std::size_t stage = 0; stage < 4; ++stage) {
    model.f(std::span<const Symbol>(trial), std::span<const Symbol>(u), std::span<Symbol>(rate));
    for (std::size_t i = 0; i < nx; ++i) {
      next[i] += dt / 6.0 * weight[stage] * rate[i];
      trial[i] = x[i] + ahead[stage] * dt * rate[i];
    }
  }
  std::vector<Term> z, outputs;
  for (int i = 0; i < model.nx() + model.nu(); ++i) z.push_back(graph.input(i));
  for (const Symbol& s : next) outputs.push_back(s.in(graph));
  for (std::size_t i = 0; i < nx; ++i) {
    const std::vector<Term> row = gradient(graph, outputs[i], z);
    outputs.insert(outputs.end(), row.begin(), row.end());
  }
  return Program(graph, outputs, model.nx() + model.nu());
}

}  // namespace

LoopGradient::LoopGradient(const Ocp& ocp, int delay)
    : delay_(delay),
      dt_(ocp.horizon().dt),
      solver_(ocp, converging()),
      gradient_(solver_),
      resting_(resting_inputs(ocp.team())) {
  if (delay < 0) throw_invalid("delay = {} periods, expected >= 0", delay);
  const Team& team = ocp.team();
  for (int b = 0; b < team.bodies(); ++b) {
    const Model& model = team.model(BodyId{b});
    const std::size_t u = team.is_agent(BodyId{b}) ? at(team.input_offset(BodyId{b})) : 0;
    steps_.push_back({model, at(team.state_offset(BodyId{b})), u, roles_of(model).direction[0],
                      trace_runge_kutta(model, dt_)});
  }
  by_parameters_.resize(gradient_.parameters().size());
  by_start_.resize(at(team.nx()));
}

void LoopGradient::Step::denormalise(double* by_state) const {
  if (heading < 0) return;
  const double* const d = &out[at(heading)];
  const double length2 = d[0] * d[0] + d[1] * d[1];
  double* const by_d = by_state + heading;
  const double across = (d[0] * by_d[1] - d[1] * by_d[0]) / (length2 * std::sqrt(length2));
  by_d[0] = -d[1] * across;
  by_d[1] = d[0] * across;
}

std::span<const double> LoopGradient::applied(int k) const {
  return k < delay_ ? std::span<const double>(resting_) : periods_[at(k - delay_)].u;
}

/// F and its derivatives at a period's state.
void LoopGradient::evaluate(Step& step, const Period& from, std::span<const double> u) const {
  std::vector<double> z(from.x.begin() + static_cast<std::ptrdiff_t>(step.x),
                        from.x.begin() + static_cast<std::ptrdiff_t>(step.x) + step.model.nx());
  z.insert(z.end(), u.begin() + static_cast<std::ptrdiff_t>(step.u),
           u.begin() + static_cast<std::ptrdiff_t>(step.u) + step.model.nu());
  step.out = sightline::evaluate(step.program, z);
}

/// Solves for the inputs of a period, from the plan of the one before.
void LoopGradient::plan(int k) {
  const std::size_t nu = resting_.size();
  const int N = solver_.ocp().horizon().N;
  Period& now = periods_[at(k)];
  const Solution solution = solver_.solve(k * dt_, now.x);
  now.u.assign(solution.u.begin(), solution.u.end());
  now.plan.resize(at(N) * nu);
  for (int stage = 0; stage < N; ++stage)
    solver_.plan(stage, std::span(now.plan).subspan(at(stage) * nu, nu));
}

bool LoopGradient::fly(std::span<const double> x0, int periods) {
  if (periods < 1) throw_invalid("fly: periods = {}, expected >= 1", periods);
  if (x0.size() != by_start_.size())
    throw_invalid("fly: x0 has {} numbers, expected {}", x0.size(), by_start_.size());
  periods_.assign(at(periods) + 1, {});
  periods_[0].x.assign(x0.begin(), x0.end());
  solver_.restart();
  for (int k = 0; k < periods; ++k) {
    plan(k);
    const Period& now = periods_[at(k)];
    std::vector<double>& next = periods_[at(k) + 1].x;
    next.resize(x0.size());
    for (Step& step : steps_) {
      evaluate(step, now, applied(k));
      std::copy_n(step.out.begin(), step.model.nx(), &next[step.x]);
      if (!step.model.normalise(&next[step.x])) return false;
    }
  }
  return true;
}

void LoopGradient::follow(std::span<const double> x) {
  const std::size_t nx = by_start_.size(), states = x.size() / nx;
  if (states < 2 || x.size() % nx != 0)
    throw_invalid("follow: x has {} numbers, expected at least two states of {}", x.size(), nx);
  periods_.assign(states, {});
  solver_.restart();
  for (std::size_t k = 0; k < states; ++k) {
    const std::span<const double> here = x.subspan(k * nx, nx);
    periods_[k].x.assign(here.begin(), here.end());
    if (k + 1 < states) plan(static_cast<int>(k));
  }
}

int LoopGradient::differentiate(std::span<const double> by_x, std::span<const double> by_u) {
  const std::size_t nx = by_start_.size(), nu = resting_.size();
  const int periods = static_cast<int>(periods_.size()) - 1, N = solver_.ocp().horizon().N;
  std::fill(by_parameters_.begin(), by_parameters_.end(), 0.0);
  std::vector<double> lambda(nx, 0.0);
  const auto add_cost = [&](int k) {
    for (std::size_t i = 0; i < nx; ++i) lambda[i] += by_x[at(k) * nx + i];
  };
  for (int k = 0; k < periods; ++k) {
    const std::span<const double> cost = by_u.empty() ? by_u : by_u.subspan(at(k) * nu, nu);
    periods_[at(k)].by_u.assign(cost.begin(), cost.end());
    periods_[at(k)].by_u.resize(nu);
  }
  int without = 0;
  for (int k = periods - 1; k >= 0; --k) {
    add_cost(k + 1);
    Period& now = periods_[at(k)];
    for (Step& step : steps_) {
      evaluate(step, now, applied(k));
      const int n = step.model.nx(), columns = n + step.model.nu();
      double* const of_body = &lambda[step.x];
      step.denormalise(of_body);
      std::vector<double> by_z(at(columns), 0.0);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < columns; ++j) by_z[at(j)] += of_body[i] * step.out[at(n + i * columns + j)];
      std::copy_n(by_z.begin(), n, of_body);
      if (k < delay_) continue;
      for (int j = n; j < columns; ++j) periods_[at(k - delay_)].by_u[step.u + at(j - n)] += by_z[at(j)];
    }
    for (int stage = 0; stage < N; ++stage)
      solver_.set_plan(stage, std::span<const double>(now.plan).subspan(at(stage) * nu, nu));
    solver_.solve(k * dt_, now.x);
    if (!gradient_.differentiate(now.by_u)) ++without;
    for (std::size_t i = 0; i < nx; ++i) lambda[i] += gradient_.states()[i];
    for (std::size_t i = 0; i < by_parameters_.size(); ++i) by_parameters_[i] += gradient_.by_parameters()[i];
  }
  add_cost(0);
  by_start_ = lambda;
  for (Step& step : steps_) {  // of the normalised start
    std::copy_n(&periods_[0].x[step.x], step.model.nx(), step.out.begin());
    step.denormalise(&by_start_[step.x]);
  }
  return without;
}

}  // namespace sightline
