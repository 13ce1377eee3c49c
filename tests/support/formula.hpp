/// Random formulas over every operation there is, safe in their domains, for any scalar.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "tests/support/random.hpp"

namespace sightline {

/// Inputs of a formula in most tests.
inline constexpr int input_count = 3;

/// A random formula, drawn so that no part of it exceeds `limit` in size at the given point.
///
/// Later operations use earlier results, several times over: the formula is a graph, not only a
/// tree.
class Formula {
 public:
  static constexpr double limit = 2.0;

  Formula(Random& random, std::span<const double> point, int operations) : inputs_(point.size()) {
    std::vector<double> values(point.begin(), point.end());
    while (static_cast<int>(steps_.size()) < operations) {
      // Recent results more often than old ones, so that the formula grows deep.
      const auto recent = [&] {
        const std::size_t n = values.size();
        return n - 1 - std::min<std::size_t>(random() % n, random() % n);
      };
      const Step step{random() % operation_count, recent(), recent(), constant(random)};
      // Where its branches meet, a logarithm has no third derivative to take differences by.
      if (step.operation == logarithm && std::fabs(step.c + values[step.a] - 1.0) < 0.05) continue;
      const double value = apply(step, values);
      if (!(std::fabs(value) <= limit)) continue;
      steps_.push_back(step);
      values.push_back(value);
    }
  }

  template <class S>
  S operator()(std::vector<S> x) const {
    for (const Step& step : steps_) x.push_back(apply(step, x));
    return x.back();
  }

  std::size_t inputs() const { return inputs_; }

 private:
  struct Step {
    std::size_t operation, a, b;
    double c;
  };

  static double constant(Random& random) {
    const double special[] = {0.0, 1.0, -1.0, 0.5};
    return random() % 3 == 0 ? special[random() % 4] : uniform(random, -1.5, 1.5);
  }

  static constexpr std::size_t operation_count = 16, logarithm = 12;

  template <class S>
  static S apply(const Step& step, const std::vector<S>& x) {
    using Operation = S (*)(const S& a, const S& b, double c);
    static constexpr Operation operations[operation_count] = {
        [](const S& a, const S& b, double) -> S { return a + b; },
        [](const S& a, const S& b, double) -> S { return a - b; },
        [](const S& a, const S& b, double) -> S { return a * b; },
        [](const S& a, const S& b, double) -> S { return a / (1.0 + b * b); },
        [](const S& a, const S&, double) -> S { return -a; },
        [](const S& a, const S&, double c) -> S { return c * a; },
        [](const S& a, const S&, double c) -> S { return c + a; },
        [](const S& a, const S&, double) -> S { return sqrt(1.0 + a * a); },
        [](const S& a, const S&, double) -> S { return exp(a); },
        [](const S& a, const S&, double) -> S { return logistic(a); },
        [](const S& a, const S&, double) -> S { return sin(a); },
        [](const S& a, const S&, double) -> S { return cos(a); },
        [](const S& a, const S&, double c) -> S { return relaxed_log(c + a); },
        [](const S& a, const S&, double) -> S { return log(1.0 + a * a); },
        [](const S& a, const S&, double) -> S { return softplus(a); },
        [](const S& a, const S& b, double) -> S { return atan2(a, 1.0 + b * b); },
    };
    return operations[step.operation](x[step.a], x[step.b], step.c);
  }

  std::size_t inputs_;
  std::vector<Step> steps_;
};

}  // namespace sightline
