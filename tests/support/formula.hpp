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
/// Later operations use earlier results, several times over: the formula is a graph, not only a tree.
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
      const Step step{static_cast<Kind>(random() % kinds), recent(), recent(), constant(random)};
      // Where its branches meet, a logarithm has no third derivative to take differences by.
      if (step.kind == Kind::logarithm && std::fabs(step.c + values[step.a] - 1.0) < 0.05) continue;
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
  enum class Kind {
    add,
    subtract,
    multiply,
    divide,
    negate,
    scale,
    shift,
    root,
    exponential,
    sigmoid,
    sine,
    cosine,
    logarithm,
    logarithm_of_square,
    softplus_of,
    angle
  };
  static constexpr int kinds = 16;

  struct Step {
    Kind kind;
    std::size_t a, b;
    double c;
  };

  static double constant(Random& random) {
    const double special[] = {0.0, 1.0, -1.0, 0.5};
    return random() % 3 == 0 ? special[random() % 4] : uniform(random, -1.5, 1.5);
  }

  template <class S>
  static S apply(const Step& step, const std::vector<S>& x) {
    const S& a = x[step.a];
    const S& b = x[step.b];
    switch (step.kind) {
      case Kind::add:
        return a + b;
      case Kind::subtract:
        return a - b;
      case Kind::multiply:
        return a * b;
      case Kind::divide:
        return a / (1.0 + b * b);
      case Kind::negate:
        return -a;
      case Kind::scale:
        return step.c * a;
      case Kind::shift:
        return step.c + a;
      case Kind::root:
        return sqrt(1.0 + a * a);
      case Kind::exponential:
        return exp(a);
      case Kind::sigmoid:
        return logistic(a);
      case Kind::sine:
        return sin(a);
      case Kind::cosine:
        return cos(a);
      case Kind::logarithm:
        return relaxed_log(step.c + a);
      case Kind::logarithm_of_square:
        return log(1.0 + a * a);
      case Kind::softplus_of:
        return softplus(a);
      case Kind::angle:
        return atan2(a, 1.0 + b * b);
    }
    return a;
  }

  std::size_t inputs_;
  std::vector<Step> steps_;
};

}  // namespace sightline
