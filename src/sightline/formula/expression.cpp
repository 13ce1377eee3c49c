#include <array>
#include <cmath>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

double fold(Expression::Kind kind, double a, double b) {
  const std::array<Expression::Step, 3> steps = {
      {{Expression::Kind::constant, -1, -1, a}, {Expression::Kind::constant, -1, -1, b}, {kind, 0, 1, 0.0}}};
  return Expression({steps.begin(), steps.end()}, {}, {})(std::span<const double>(), 0.0);
}

}  // namespace

std::optional<double> ExpressionBuilder::value(int step) const {
  return at(step).kind == Kind::constant ? std::optional(at(step).value) : std::nullopt;
}

int ExpressionBuilder::unique(const Expression::Step& step) {
  // NaN has no place in an order; the parser rejects it as soon as it appears.
  if (std::isnan(step.value)) {
    steps_.push_back(step);
    return static_cast<int>(steps_.size()) - 1;
  }
  const auto [entry, added] = index_.try_emplace(step, static_cast<int>(steps_.size()));
  if (added) steps_.push_back(step);
  return entry->second;
}

int ExpressionBuilder::binary(Kind kind, int a, int b) {
  const std::optional<double> x = value(a), y = value(b);
  return x && y ? constant(fold(kind, *x, *y)) : unique({kind, a, b});
}

int ExpressionBuilder::unary(Kind kind, int a) {
  const std::optional<double> x = value(a);
  return x ? constant(fold(kind, *x, 0.0)) : unique({kind, a});
}

int ExpressionBuilder::power(int base, int n) {
  if (n == 0) return constant(1.0);
  if (n < 0) return binary(Kind::divide, constant(1.0), power(base, -n));
  if (at(base).kind == Kind::root && n >= 2) {
    const int even = power(at(base).a, n / 2);
    return n % 2 == 0 ? even : binary(Kind::multiply, even, base);
  }
  // By repeated squaring, from the highest bit.
  int result = base;
  int bit = 1;
  while (2 * bit <= n) bit *= 2;
  while ((bit /= 2) > 0) {
    result = binary(Kind::multiply, result, result);
    if ((n & bit) != 0) result = binary(Kind::multiply, result, base);
  }
  return result;
}

int ExpressionBuilder::half_of_sum(Kind kind, int a, int b) {
  const int distance = absolute(binary(Kind::subtract, a, b));
  return binary(Kind::multiply, constant(0.5), binary(kind, binary(Kind::add, a, b), distance));
}

int ExpressionBuilder::copy(const Expression& expression) {
  std::vector<int> place;
  const auto moved = [&](int step) { return step < 0 ? -1 : place[static_cast<std::size_t>(step)]; };
  for (const Expression::Step& step : expression.steps()) {
    const bool variable = step.kind == Kind::variable;
    place.push_back(unique({step.kind, variable ? step.a : moved(step.a), moved(step.b), step.value}));
  }
  return place.back();
}

Expression ExpressionBuilder::finish(int result, std::optional<Unit> unit,
                                     std::set<std::string> smoothed) const {
  std::vector<int> place(static_cast<std::size_t>(result) + 1, -1);
  place.back() = 0;
  for (int i = result; i >= 0; --i) {
    if (place[static_cast<std::size_t>(i)] < 0 || at(i).kind == Kind::variable) continue;
    for (const int operand : {at(i).a, at(i).b}) {
      if (operand >= 0) place[static_cast<std::size_t>(operand)] = 0;
    }
  }
  std::vector<Expression::Step> steps;
  for (int i = 0; i <= result; ++i) {
    if (place[static_cast<std::size_t>(i)] < 0) continue;
    place[static_cast<std::size_t>(i)] = static_cast<int>(steps.size());
    Expression::Step step = at(i);
    if (step.kind != Kind::variable) {
      if (step.a >= 0) step.a = place[static_cast<std::size_t>(step.a)];
      if (step.b >= 0) step.b = place[static_cast<std::size_t>(step.b)];
    }
    steps.push_back(step);
  }
  return {std::move(steps), unit, std::move(smoothed)};
}

}  // namespace sightline
