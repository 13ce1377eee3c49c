/// One step of x' = f(x).
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace sightline {

/// Scratch of one Runge-Kutta step of a state of n numbers.
struct RungeKuttaScratch {
  static constexpr std::size_t rows_needed = 5;
  std::span<double> rows;  ///< 5 n numbers: k1..k4 and the trial state
};

/// x <- x + s/6 (k1 + 2 k2 + 2 k3 + k4), the classical Runge-Kutta step of length s.
/// @param f  called as f(x, rate), writes x' of the state x into rate; both have the length of x.
template <class F>
void rk4_step(F&& f, std::span<double> x, double s, RungeKuttaScratch scratch) {
  const std::size_t n = x.size();
  const auto row = [&](std::size_t i) { return scratch.rows.subspan(i * n, n); };
  const std::span<double> trial = row(4);
  f(std::span<const double>(x), row(0));
  constexpr std::array<double, 3> fraction = {0.5, 0.5, 1.0};
  for (std::size_t stage = 0; stage < 3; ++stage) {
    for (std::size_t i = 0; i < n; ++i) trial[i] = x[i] + fraction[stage] * s * row(stage)[i];
    f(std::span<const double>(trial), row(stage + 1));
  }
  for (std::size_t i = 0; i < n; ++i) {
    x[i] += s / 6 * (row(0)[i] + 2 * row(1)[i] + 2 * row(2)[i] + row(3)[i]);
  }
}

}  // namespace sightline
