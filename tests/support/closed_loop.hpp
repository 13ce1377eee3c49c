/// The smallest closed loop: a solver, and its own model as the plant.
#pragma once

#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/solver.hpp"

namespace sightline {

/// The states of all bodies dt [s] later under held inputs, by one Runge-Kutta step; headings
/// normalised.
inline void advance(const Team& team, std::vector<double>& x, std::span<const double> u, double dt) {
  std::vector<double> scratch(RungeKuttaScratch::rows_needed * x.size());
  const auto each = [&](auto&& f) {
    for (int i = 0; i < team.bodies(); ++i) f(team.model(BodyId{i}), team.state_offset(BodyId{i}), BodyId{i});
  };
  rk4_step(
      [&](std::span<const double> state, std::span<double> rate) {
        each([&](const Model& model, int at, BodyId body) {
          model.f(state.data() + at, u.data() + team.input_offset(body), rate.data() + at);
        });
      },
      x, dt, {scratch});
  each([&](const Model& model, int at, BodyId) { (void)model.normalise(x.data() + at); });
}

/// Flies `updates` periods from the states x at time t [s].
/// @param see  called as see(t, x, solution) after each update, before the plant moves
/// @return the last states
template <class See>
std::vector<double> fly(Solver& solver, std::vector<double> x, int updates, See&& see, double t = 0.0) {
  const double dt = solver.ocp().horizon().dt;
  for (int k = 0; k < updates; ++k) {
    const double now = t + dt * k;
    const Solution solution = solver.solve(now, x);
    see(now, std::as_const(x), solution);
    advance(solver.ocp().team(), x, solution.u, dt);
  }
  return x;
}

inline std::vector<double> fly(Solver& solver, std::vector<double> x, int updates) {
  return fly(solver, std::move(x), updates, [](double, const std::vector<double>&, const Solution&) {});
}

}  // namespace sightline
