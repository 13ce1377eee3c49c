/// Inequalities of one robot in addition to its input limits: c(x, u) <= 0, enforced by a relaxed
/// logarithmic barrier (Feller and Ebenbauer 2017) in its stage cost. docs/equations.md, 12.
///
/// A limit is a struct with `template <class S> S operator()(...) const` that returns c, <= 0 where
/// the limit holds. Its arguments are the robot's Sight, or its state and input:
///
///   S operator()(const Sight<S>& robot) const;
///   S operator()(std::span<const S> x, std::span<const S> u) const;
///
/// The second form may define `int states() const` and `int inputs() const`, the numbers of entries
/// that it reads.
#pragma once

#include <cmath>
#include <span>

#include "sightline/potential/potential.hpp"

namespace sightline {

template <class C, class S>
concept LimitOver = requires(const C& c, const Sight<S>& robot) {
  { c(robot) } -> std::same_as<S>;
}
|| requires(const C& c, const std::span<const S>& z) {
  { c(z, z) } -> std::same_as<S>;
};

/// A limit c(x, u) <= 0 of any type; immutable and shared.
class Limit {
 public:
  /// @throws std::invalid_argument from the limit's own check()
  template <class C>
  requires LimitOver<C, double> && LimitOver<C, Symbol> Limit(const C& limit)
      : block_(std::make_shared<const Block<C>>(limit)) {
    if constexpr (Described<C>) check_parameters(limit);
    if constexpr (requires { limit.check(); }) limit.check();
  }

  std::string_view name() const { return block_->name; }
  /// Descriptions of its parameters; empty if the limit does not describe them.
  std::vector<ParameterText> parameters() const { return block_->parameters(); }
  /// Minimum numbers of states and inputs of the robot.
  int states() const { return block_->states; }
  int inputs() const { return block_->inputs; }

  /// c of a robot with this Sight, state x (nx) and input u (nu).
  double operator()(const Sight<double>& robot, std::span<const double> x,
                    std::span<const double> u) const noexcept {
    return block_->value(robot, x, u);
  }
  Symbol operator()(const Sight<Symbol>& robot, std::span<const Symbol> x, std::span<const Symbol> u) const {
    return block_->trace(robot, x, u);
  }

 private:
  struct Interface {
    std::string_view name = "limit";
    int states = 0, inputs = 0;

    virtual ~Interface() = default;
    virtual std::vector<ParameterText> parameters() const = 0;
    virtual double value(const Sight<double>& robot, std::span<const double> x,
                         std::span<const double> u) const noexcept = 0;
    virtual Symbol trace(const Sight<Symbol>& robot, std::span<const Symbol> x,
                         std::span<const Symbol> u) const = 0;
  };

  template <class C>
  struct Block final : Interface {
    C limit;

    explicit Block(const C& c) : limit(c) {
      if constexpr (requires { C::name; }) this->name = C::name;
      if constexpr (requires { limit.states(); }) this->states = limit.states();
      if constexpr (requires { limit.inputs(); }) this->inputs = limit.inputs();
    }
    std::vector<ParameterText> parameters() const override { return parameter_texts(limit); }
    template <class S>
    S at([[maybe_unused]] const Sight<S>& robot, [[maybe_unused]] std::span<const S> x,
         [[maybe_unused]] std::span<const S> u) const {
      if constexpr (requires { limit(robot); }) {
        return limit(robot);
      } else {
        return limit(x, u);
      }
    }
    double value(const Sight<double>& robot, std::span<const double> x,
                 std::span<const double> u) const noexcept override {
      return or_nan([&] { return at<double>(robot, x, u); });
    }
    Symbol trace(const Sight<Symbol>& robot, std::span<const Symbol> x,
                 std::span<const Symbol> u) const override {
      return at<Symbol>(robot, x, u);
    }
  };

  std::shared_ptr<const Interface> block_;
};

/// Cost of a limit: a logarithm inside, a parabola from -c = delta outwards. It is finite and
/// convex in c everywhere, with two continuous derivatives.
///
///   B(c) = -mu ln(-c)                                       for -c >= delta
///   B(c) = mu/2 (((-c - 2 delta) / delta)^2 - 1) - mu ln delta   beyond
struct RelaxedBarrier {
  Limit limit;
  double mu = 0.05;
  double delta = 0.02;

  static constexpr auto parameters() {
    constexpr Bounds of_limit = {above_zero.low, above_zero.high, "> 0, in the unit of the limit"};
    return std::tuple{parameter("mu", &RelaxedBarrier::mu, "", above_zero,
                                "weight; the smaller, the nearer one comes to the limit"),
                      parameter("delta", &RelaxedBarrier::delta, "", of_limit,
                                "where the parabola takes over; 2 mu / delta must exceed the force")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this, limit.name()); }

  /// B(c).
  template <class S>
  S of(const S& c) const {
    return -mu * (std::log(delta) + relaxed_log(c * (-1.0 / delta)));
  }

  /// B of a robot, with the arguments of `Limit`.
  template <class S>
  S operator()(const Sight<S>& robot, std::span<const S> x, std::span<const S> u) const {
    return of<S>(limit(robot, x, u));
  }
};

}  // namespace sightline
