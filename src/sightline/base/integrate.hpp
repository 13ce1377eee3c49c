/// Runge-Kutta steps of x' = f(x).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>

namespace sightline {

/// Scratch of one Runge-Kutta step of a state of n numbers.
struct RungeKuttaScratch {
  static constexpr std::size_t rows_needed = 5;
  std::span<double> rows;  ///< 5 n numbers: k1..k4 and the trial state
};

/// x <- x + s/6 (k1 + 2 k2 + 2 k3 + k4), the classical Runge-Kutta step of length s.
/// @param f  called as f(x, rate); writes x' of the state x into rate; both have the length of x
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

/// The same step for a state of n numbers, equal to the bit. It is written without loops: compilers
/// vectorise such a loop in one place and unroll it in the next.
/// @param f  called as f(x), returns x'
template <std::size_t n, class F>
std::array<double, n> rk4_step(F&& f, const std::array<double, n>& x, double s) {
  const auto each = [](auto entry) {
    return [&]<std::size_t... i>(std::index_sequence<i...>) { return std::array<double, n>{entry(i)...}; }
    (std::make_index_sequence<n>());
  };
  const auto trial = [&](double fraction, const std::array<double, n>& k) {
    return f(each([&](std::size_t i) { return x[i] + fraction * s * k[i]; }));
  };
  const std::array<double, n> k1 = f(x), k2 = trial(0.5, k1), k3 = trial(0.5, k2), k4 = trial(1.0, k3);
  return each([&](std::size_t i) { return x[i] + s / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]); });
}

}  // namespace sightline
