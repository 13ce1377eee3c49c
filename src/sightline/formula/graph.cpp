#include "sightline/formula/graph.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "sightline/math/elementary.hpp"

namespace sightline {
namespace {

Term positive(Term t) { return {t.node, false}; }
Term with_sign(Term t, bool negative) { return {t.node, t.negative != negative}; }

}  // namespace

std::size_t Graph::Hash::operator()(const Node& n) const {
  const auto key = [](Term t) { return static_cast<std::size_t>(t.node + 1) * 2 + (t.negative ? 1 : 0); };
  std::size_t h = std::hash<double>()(n.value) + static_cast<std::size_t>(n.op);
  h = h * 0x9E3779B97F4A7C15ull + key(n.a);
  h = h * 0xC2B2AE3D27D4EB4Full + key(n.b);
  return h;
}

Term Graph::unique(const Node& node) {
  const auto [entry, added] = index_.try_emplace(node, size());
  if (added) nodes_.push_back(node);
  return {entry->second, false};
}

Term Graph::input(int index) { return unique({.op = Op::input, .value = static_cast<double>(index)}); }

Term Graph::constant(double value) {
  const bool negative = value < 0;
  return with_sign(unique({.op = Op::constant, .value = value == 0 ? 0.0 : std::fabs(value)}), negative);
}

Graph::Factors Graph::factors(Term t) const {
  if (!is_parameter(t)) return {constant_value(t), {}};
  Factors f = factors_.at(t.node);
  if (t.negative) f.first = -f.first;
  return f;
}

Term Graph::parameter(const Factors& factors, double value) {
  const bool negative = factors.first < 0;
  const auto [entry, added] = names_.try_emplace({std::fabs(factors.first), factors.second}, size());
  if (added) {
    factors_[size()] = entry->first;
    nodes_.push_back({.op = Op::constant, .a = {size(), false}, .value = negative ? -value : value});
  }
  return {entry->second, negative};
}

Term Graph::number(double value, Term other, bool factor) {
  if (formula_ == 0 || (value == 0 && zeros_ == Zeros::folded)) return constant(value);
  const auto [entry, added] = numbers_.try_emplace({formula_, other.node, factor, value});
  if (added) entry->second = parameter(value);
  return entry->second;
}

Term Graph::of_constant(Op op, Term a, double value) {
  return is_parameter(a) ? result({.op = op, .a = a}, value) : constant(value);
}

/// A constant that comes out of an operation on parameters.
Term Graph::result(const Node& operation, double value) {
  const auto [entry, added] = results_.try_emplace(operation);
  if (added) entry->second = parameter(value);
  return entry->second;
}

Term Graph::sum_of_constants(Term a, Term b) {
  const double sum = constant_value(a) + constant_value(b);
  if (!is_parameter(a) && !is_parameter(b)) return constant(sum);
  if (is_zero(a)) return b;
  if (is_zero(b)) return a;
  if (a == -b) return constant(0.0);
  return result({.op = Op::add, .a = a, .b = b}, sum);
}

Term Graph::product_of_constants(Term a, Term b) {
  const double product = constant_value(a) * constant_value(b);
  if (!is_parameter(a) && !is_parameter(b)) return constant(product);
  if (is_zero(a) || is_zero(b)) return constant(0.0);
  Factors all = factors(a);
  const Factors more = factors(b);
  all.first *= more.first;
  all.second.insert(all.second.end(), more.second.begin(), more.second.end());
  std::sort(all.second.begin(), all.second.end());
  return parameter(all, product);
}

Term Graph::add(Term a, Term b) {
  if (is_constant(a) && is_constant(b)) return sum_of_constants(a, b);
  if (is_zero(a)) return b;
  if (is_zero(b)) return a;
  if (a == -b) return constant(0.0);
  if (a == b) return multiply(constant(2.0), a);
  if (is_constant(b)) std::swap(a, b);
  // c + (c' + x): 1 - (1 - s) is s again.
  if (is_constant(a) && node(b).op == Op::add && is_constant(node(b).a)) {
    const Node inner = node(b);
    return add(sum_of_constants(a, with_sign(inner.a, b.negative)), with_sign(inner.b, b.negative));
  }
  // The sum with a positive first operand stands for its negative too.
  if (!is_constant(a) && a.node > b.node) std::swap(a, b);
  const bool negative = a.negative;
  return with_sign(unique({.op = Op::add, .a = positive(a), .b = with_sign(b, negative)}), negative);
}

Term Graph::multiply(Term a, Term b) {
  const bool negative = a.negative != b.negative;
  a = positive(a);
  b = positive(b);
  if (is_constant(b)) std::swap(a, b);
  if (is_constant(a)) {
    if (is_constant(b)) return with_sign(product_of_constants(a, b), negative);
    if (is_zero(a)) return constant(0.0);
    if (is_number(a, 1.0)) return with_sign(b, negative);
    if (draw_constants_ && node(b).op == Op::multiply && is_constant(node(b).a)) {  // c (c' x)
      const Node inner = node(b);
      return with_sign(multiply(product_of_constants(a, inner.a), inner.b), negative);
    }
  } else {
    // A constant factor stands in front of the whole product: c (a b) is found again from a (c b).
    const auto pull = [&](Term factor, Term other) {
      const Node inner = node(factor);
      return with_sign(multiply(inner.a, multiply(inner.b, other)), negative);
    };
    if (draw_constants_ && node(a).op == Op::multiply && is_constant(node(a).a)) return pull(a, b);
    if (draw_constants_ && node(b).op == Op::multiply && is_constant(node(b).a)) return pull(b, a);
    if (a.node > b.node) std::swap(a, b);
  }
  return with_sign(unique({.op = Op::multiply, .a = a, .b = b}), negative);
}

Term Graph::reciprocal(Term a) {
  if (is_constant(a)) return of_constant(Op::reciprocal, a, 1.0 / constant_value(a));
  return with_sign(unique({.op = Op::reciprocal, .a = positive(a)}), a.negative);
}

Term Graph::square_root(Term a) {
  if (is_constant(a)) return of_constant(Op::square_root, a, sightline::sqrt(constant_value(a)));
  return unique({.op = Op::square_root, .a = a});
}

Term Graph::exponential(Term a) {
  if (is_constant(a)) return of_constant(Op::exponential, a, sightline::exp(constant_value(a)));
  return unique({.op = Op::exponential, .a = a});
}

Term Graph::logistic(Term a) {
  if (is_constant(a)) return of_constant(Op::logistic, a, sightline::logistic(constant_value(a)));
  // sig(-c) = 1 - sig(c): one exponential serves both sides of a limit.
  const Term s = unique({.op = Op::logistic, .a = positive(a)});
  return a.negative ? subtract(constant(1.0), s) : s;
}

Term Graph::relaxed_log(Term a) {
  if (is_constant(a)) return of_constant(Op::relaxed_log, a, sightline::relaxed_log(constant_value(a)));
  return unique({.op = Op::relaxed_log, .a = a});
}

Term Graph::sine(Term a) {
  if (is_constant(a)) return of_constant(Op::sine, a, sightline::sin(constant_value(a)));
  return with_sign(unique({.op = Op::sine, .a = positive(a)}), a.negative);
}

Term Graph::cosine(Term a) {
  if (is_constant(a)) return of_constant(Op::cosine, a, sightline::cos(constant_value(a)));
  return unique({.op = Op::cosine, .a = positive(a)});
}

Term Graph::maximum(Term a, Term b) {
  if (is_constant(a) && is_constant(b)) {
    const double larger = sightline::maximum(constant_value(a), constant_value(b));
    const bool plain = !is_parameter(a) && !is_parameter(b);
    return plain ? constant(larger) : result({.op = Op::maximum, .a = a, .b = b}, larger);
  }
  return unique({.op = Op::maximum, .a = a, .b = b});
}

Term Graph::logarithm(Term a) {
  if (is_constant(a)) return of_constant(Op::logarithm, a, sightline::log(constant_value(a)));
  return unique({.op = Op::logarithm, .a = a});
}

Term Graph::softplus(Term a) {
  if (is_constant(a)) return of_constant(Op::softplus, a, sightline::softplus(constant_value(a)));
  return unique({.op = Op::softplus, .a = a});
}

Term Graph::angle(Term a, Term b) {
  if (is_constant(a) && is_constant(b)) {
    const double angle = sightline::atan2(constant_value(a), constant_value(b));
    const bool plain = !is_parameter(a) && !is_parameter(b);
    return plain ? constant(angle) : result({.op = Op::angle, .a = a, .b = b}, angle);
  }
  // Seen from the other side of the axis the angle turns round; -0 and 0 are one side, as in a constant.
  return with_sign(unique({.op = Op::angle, .a = positive(a), .b = b}), a.negative);
}

}  // namespace sightline
