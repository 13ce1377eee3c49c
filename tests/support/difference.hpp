/// Derivatives by central differences of fourth order, in long double: the yardstick of every
/// derivative.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "tests/support/wide.hpp"

namespace sightline {

/// f is called with a vector of Wide and gives a Wide.
template <class F>
class CentralDifference {
 public:
  CentralDifference(F f, std::span<const double> x, long double step = 2e-4L)
      : f_(std::move(f)), step_(step) {
    for (const double v : x) x_.emplace_back(v);
  }

  /// d f / d x_i.
  double first(std::size_t i) {
    return static_cast<double>(along(i, [&] { return f_(x_).value(); }));
  }
  /// d2 f / d x_i d x_j.
  double second(std::size_t i, std::size_t j) {
    return static_cast<double>(along(i, [&] { return along(j, [&] { return f_(x_).value(); }); }));
  }

 private:
  template <class Value>
  long double along(std::size_t i, Value&& value) {
    const Wide here = x_[i];
    const auto at = [&](int steps) {
      x_[i] = Wide(here.value() + steps * step_, 0);
      return value();
    };
    const long double near = at(1) - at(-1), far = at(2) - at(-2);
    x_[i] = here;
    return (8 * near - far) / (12 * step_);
  }

  F f_;
  long double step_;
  std::vector<Wide> x_;
};

}  // namespace sightline
