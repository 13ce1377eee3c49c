/// Prediction of a state by its model under recorded inputs.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {

/// Predicts x (nx) from `from` to `to` [s] under the inputs of the history and an acceleration w of
/// G [m/s^2], in Runge-Kutta steps of at most 0.05 s.
/// @param input_at  offset of the body's input in the history's rows
/// @param rows  work space of RungeKuttaScratch::rows_needed * nx numbers
/// @return the last input in force, in the history; empty if `to` is not after `from`
inline std::span<const double> carry(const Model& model, std::span<double> x, const InputHistory& history,
                                     std::size_t input_at, double from, double to, const Vec3<double>& w,
                                     std::span<double> rows) noexcept {
  constexpr double longest_step = 0.05;
  std::span<const double> last;
  const bool pushed = w.x != 0 || w.y != 0 || w.z != 0;
  history.visit(from, to, [&](double begin, double end, std::span<const double> u) {
    const auto steps = std::max(1.0, std::ceil((end - begin) / longest_step));
    const auto f = [&](std::span<const double> z, std::span<double> rate) {
      model.f(z.data(), u.data() + input_at, rate.data());
      if (pushed) model.push(z.data(), w, rate.data());
    };
    for (double i = 0; i < steps; ++i) {
      rk4_step(f, x, (end - begin) / steps, {rows});
      static_cast<void>(model.normalise(x.data()));
    }
    last = u.subspan(input_at);
  });
  return last;
}

}  // namespace sightline
