#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {
namespace {

Term positive(Term t) { return {t.node, false}; }
Term with_sign(Term t, bool negative) { return {t.node, t.negative != negative}; }

/// A hash that is equal on every machine.
std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
  hash = (hash ^ value) * 0x9E3779B97F4A7C15ull;
  hash = (hash ^ (hash >> 32)) * 0xD6E8FEB86659FD93ull;
  return hash ^ (hash >> 29);
}
std::uint64_t mixed(std::uint64_t hash, double value) {
  return mixed(hash, std::bit_cast<std::uint64_t>(value));
}

/// The source of a key besides operands; the values exceed all operations.
enum KeyKind : std::uint64_t { of_operation = 1, of_number = 101, of_parameter, of_product };

}  // namespace

std::size_t Graph::Hash::operator()(const Node& n) const {
  const auto key = [](Term t) { return static_cast<std::size_t>(t.node + 1) * 2 + (t.negative ? 1 : 0); };
  std::size_t h = std::hash<double>()(n.value) + static_cast<std::size_t>(n.op);
  h = h * 0x9E3779B97F4A7C15ull + key(n.a);
  h = h * 0xC2B2AE3D27D4EB4Full + key(n.b);
  return h;
}

bool Graph::stands_before(Term a, Term b) const {
  return key(a) != key(b) ? key(a) < key(b) : a.node < b.node;
}

Graph::Key Graph::key_of(const Node& node) const {
  if (node.op == Op::input) return {0, static_cast<std::uint64_t>(node.value), 0};
  Key k{0, mixed(of_operation, static_cast<std::uint64_t>(node.op)), 0};
  if (node.op == Op::constant) {
    k.shape = mixed(k.shape, node.value);
    return k;
  }
  k.values = k.shape;
  for (const Term t : {node.a, node.b}) {
    if (t.node < 0) continue;
    const std::uint64_t sign = t.negative ? 1 : 0;
    k.height = std::max(k.height, key(t).height + 1);
    k.shape = mixed(mixed(k.shape, key(t).shape), sign);
    k.values = mixed(mixed(mixed(k.values, key(t).shape), key(t).values), sign);
  }
  return k;
}

Term Graph::append(const Node& node, const Key& key) {
  nodes_.push_back(node);
  keys_.push_back(key);
  return {size() - 1, false};
}

Term Graph::unique(const Node& node) {
  const auto [entry, added] = index_.try_emplace(node, size());
  if (added) append(node, key_of(node));
  return {entry->second, false};
}

std::vector<int> Graph::in_order(std::span<const Term> outputs) const {
  std::vector<int> order, open;
  std::vector<bool> done(nodes_.size(), false);
  const auto is_done = [&](Term t) { return t.node < 0 || done[static_cast<std::size_t>(t.node)]; };
  for (const Term out : outputs) {
    open.push_back(out.node);
    while (!open.empty()) {
      const int v = open.back();
      const Node& n = nodes_[static_cast<std::size_t>(v)];
      const bool leaf = n.op == Op::input || n.op == Op::constant;
      // The deeper operand first: its subtree is then computed while few other results are live.
      const Term last = n.b.node >= 0 ? n.b : n.a;
      if (!leaf && !is_done(last)) {
        open.push_back(last.node);
      } else if (!leaf && !is_done(n.a)) {
        open.push_back(n.a.node);
      } else {
        open.pop_back();
        if (is_done({v, false})) continue;
        done[static_cast<std::size_t>(v)] = true;
        order.push_back(v);
      }
    }
  }
  return order;
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

/// The factors are sorted by their keys, so the product is rounded in one way.
Term Graph::product(Factors factors) {
  const bool negative = factors.first < 0;
  factors.first = std::fabs(factors.first);
  const auto leaf = [&](int i) -> const Leaf& { return leaves_[static_cast<std::size_t>(i)]; };
  std::sort(factors.second.begin(), factors.second.end(),
            [&](int i, int j) { return leaf(i).key != leaf(j).key ? leaf(i).key < leaf(j).key : i < j; });
  const auto [entry, added] = names_.try_emplace(factors, size());
  if (added) {
    factors_[size()] = factors;
    double value = factors.first;
    Key k{0, mixed(of_product, factors.first), of_product};
    for (const int i : factors.second) {
      value *= leaf(i).value;
      k.shape = mixed(k.shape, leaf(i).key.shape);
      k.values = mixed(k.values, leaf(i).key.values);
    }
    append({.op = Op::constant, .a = {size(), false}, .value = value}, k);
  }
  return {entry->second, negative};
}

Term Graph::leaf(double value, const Key& key) {
  leaves_.push_back({value, key});
  return product({1.0, {static_cast<int>(leaves_.size()) - 1}});
}

Term Graph::parameter(double value) {
  const std::uint64_t shape = mixed(of_parameter, static_cast<std::uint64_t>(named_++));
  return leaf(value, {0, shape, mixed(shape, value)});
}

Term Graph::number(double value, Term other, bool factor) {
  if (formula_ == 0 || (value == 0 && zeros_ == Zeros::folded)) return constant(value);
  const auto [entry, added] = numbers_.try_emplace({formula_, other.node, factor, value});
  if (added) {
    std::uint64_t shape = mixed(mixed(of_number, static_cast<std::uint64_t>(formula_)), factor ? 1.0 : 0.0);
    // The shape ignores a constant summand of `other`: where that constant is zero, the same
    // formula lacks the summand.
    const bool shifted = node(other).op == Op::add && is_constant(node(other).a);
    const Key& met = key(shifted ? node(other).b : other);
    shape = mixed(shape, met.shape);
    entry->second = leaf(value, {0, shape, mixed(mixed(shape, met.values), value)});
  }
  return entry->second;
}

Term Graph::of_constant(Op op, Term a, double value) {
  return is_parameter(a) ? result({.op = op, .a = a}, value) : constant(value);
}

/// A constant that results from an operation on parameters.
Term Graph::result(const Node& operation, double value) {
  const auto [entry, added] = results_.try_emplace(operation);
  if (added) {
    const Key k = key_of(operation);
    entry->second = leaf(value, {0, k.shape, k.values});
  }
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
  if (!is_parameter(a) && !is_parameter(b)) return constant(constant_value(a) * constant_value(b));
  if (is_zero(a) || is_zero(b)) return constant(0.0);
  Factors all = factors(a);
  const Factors more = factors(b);
  all.first *= more.first;
  all.second.insert(all.second.end(), more.second.begin(), more.second.end());
  return product(std::move(all));
}

Term Graph::add(Term a, Term b) {
  if (is_constant(a) && is_constant(b)) return sum_of_constants(a, b);
  if (is_zero(a)) return b;
  if (is_zero(b)) return a;
  if (a == -b) return constant(0.0);
  if (a == b) return multiply(constant(2.0), a);
  if (is_constant(b)) std::swap(a, b);
  // c + (c' + x): 1 - (1 - s) becomes s again.
  if (is_constant(a) && node(b).op == Op::add && is_constant(node(b).a)) {
    const Node inner = node(b);
    return add(sum_of_constants(a, with_sign(inner.a, b.negative)), with_sign(inner.b, b.negative));
  }
  // The sum with a positive first operand also represents its negative.
  if (!is_constant(a) && stands_before(b, a)) std::swap(a, b);
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
    // A constant factor moves to the front of the whole product: a (c b) then matches c (a b).
    const auto pull = [&](Term factor, Term other) {
      const Node inner = node(factor);
      return with_sign(multiply(inner.a, multiply(inner.b, other)), negative);
    };
    if (draw_constants_ && node(a).op == Op::multiply && is_constant(node(a).a)) return pull(a, b);
    if (draw_constants_ && node(b).op == Op::multiply && is_constant(node(b).a)) return pull(b, a);
    if (stands_before(b, a)) std::swap(a, b);
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
  // Negating a negates the angle; -0 and 0 count as one side, as in a constant.
  return with_sign(unique({.op = Op::angle, .a = positive(a), .b = b}), a.negative);
}

}  // namespace sightline
