#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

/// First and second derivatives of one operation with respect to its (at most two, distinct)
/// operands.
struct Local {
  int count = 0;
  std::array<int, 2> operand{};
  std::array<Term, 2> first{};
  std::array<Term, 3> second{};  // aa, ab, bb; node -1 where zero
};

/// Added to x^2 + y^2 in the derivatives of an angle; they are then zero at the origin instead of
/// 0/0.
constexpr double square_of_nothing = 1e-24;

Term signed_one(Graph& g, Term operand) { return operand.negative ? -g.constant(1.0) : g.constant(1.0); }

Local differentiate(Graph& g, int v, bool second_order) {
  const Node n = g.nodes()[static_cast<std::size_t>(v)];
  const Term self{v, false};
  Local d{.count = 1, .operand = {n.a.node, n.b.node}, .first = {}, .second = {}};
  const Term two = g.constant(2.0), one = g.constant(1.0);
  switch (n.op) {
    case Op::input:
    case Op::constant:
      d.count = 0;
      break;
    case Op::add:
      d.count = 2;
      d.first = {one, signed_one(g, n.b)};
      break;
    case Op::multiply:
      if (n.a.node == n.b.node) {
        d.first[0] = g.multiply(two, n.a);
        d.second[0] = two;
      } else {
        d.count = 2;
        d.first = {n.b, n.a};
        d.second[1] = one;
      }
      break;
    case Op::reciprocal: {
      const Term squared = g.multiply(self, self);
      d.first[0] = -squared;
      if (second_order) d.second[0] = g.multiply(two, g.multiply(squared, self));
      break;
    }
    case Op::square_root: {
      const Term half_inverse = g.multiply(g.constant(0.5), g.reciprocal(self));
      d.first[0] = g.multiply(signed_one(g, n.a), half_inverse);
      if (second_order) {
        const Term inverse = g.reciprocal(self);
        d.second[0] = g.multiply(g.constant(-0.25), g.multiply(inverse, g.multiply(inverse, inverse)));
      }
      break;
    }
    case Op::exponential:
      d.first[0] = g.multiply(signed_one(g, n.a), self);
      d.second[0] = self;
      break;
    case Op::logistic: {  // (36): s' = s (1 - s), s'' = s' (1 - 2 s)
      const Term rest = g.subtract(one, self);
      d.first[0] = g.multiply(self, rest);
      if (second_order) d.second[0] = g.multiply(d.first[0], g.subtract(rest, self));
      break;
    }
    case Op::relaxed_log: {  // m = max(a, 1): 1/m + (m - a), -1/m^2
      const Term above = g.maximum(n.a, one), inverse = g.reciprocal(above);
      d.first[0] = g.multiply(signed_one(g, n.a), g.add(inverse, g.subtract(above, n.a)));
      if (second_order) d.second[0] = -g.multiply(inverse, inverse);
      break;
    }
    case Op::sine:
      d.first[0] = g.cosine(n.a);
      d.second[0] = -self;
      break;
    case Op::cosine:
      d.first[0] = -g.sine(n.a);
      d.second[0] = -self;
      break;
    case Op::logarithm: {  // of -v as of v: 1 / v
      const Term inverse = g.reciprocal({n.a.node, false});
      d.first[0] = inverse;
      if (second_order) d.second[0] = -g.multiply(inverse, inverse);
      break;
    }
    case Op::softplus: {
      const Term s = g.logistic(n.a);
      d.first[0] = g.multiply(signed_one(g, n.a), s);
      if (second_order) d.second[0] = g.multiply(s, g.subtract(one, s));
      break;
    }
    case Op::angle: {
      if (n.a.node == n.b.node) {  // direction (v, v) or (-v, v): constant on either side of 0
        d.count = 0;
        break;
      }
      d.count = 2;
      const Term y = n.a, x = n.b, sign = signed_one(g, n.b);
      const Term squares = g.add(g.multiply(x, x), g.multiply(y, y));
      const Term inverse = g.reciprocal(g.add(squares, g.constant(square_of_nothing)));
      d.first = {g.multiply(x, inverse), g.multiply(sign, g.multiply(-y, inverse))};
      if (second_order) {
        const Term inverse2 = g.multiply(inverse, inverse);
        const Term twist = g.multiply(two, g.multiply(g.multiply(x, y), inverse2));
        d.second = {-twist,
                    g.multiply(sign, g.multiply(g.subtract(g.multiply(y, y), g.multiply(x, x)), inverse2)),
                    twist};
      }
      break;
    }
    case Op::maximum:
      throw std::invalid_argument(
          "a formula takes the maximum of what it is derived by, expected a smooth formula");
  }
  return d;
}

/// The reverse sweep over the nodes of one output. Nodes are identified by their place in the
/// output's order, so sums form in one way for any recording order.
class Sweep {
 public:
  Sweep(Graph& graph, Term out, std::span<const Term> variables, bool second_order)
      : graph_(graph), second_order_(second_order), order_(graph.in_order(std::span(&out, 1))) {
    // Variables come first: the later node of a pair pushes a shared second derivative, and a
    // variable pushes nothing.
    std::stable_partition(order_.begin(), order_.end(), [&](int v) {
      return graph.nodes()[index(v)].op == Op::input || graph.nodes()[index(v)].op == Op::constant;
    });
    place_.assign(index(graph.size()), -1);
    for (std::size_t i = 0; i < order_.size(); ++i) place_[index(order_[i])] = static_cast<int>(i);
    adjoint_.resize(order_.size());
    second_.resize(order_.size());
    varies_ = depends_on(variables);
    adjoint_.back() = graph.constant(out.negative ? -1.0 : 1.0);
    for (std::size_t i = order_.size(); i-- > 0;) {
      if (varies_[i]) push(static_cast<int>(i));
    }
  }

  Term first(Term variable) const {
    const int i = place(variable);
    return i < 0 ? graph_.constant(0.0) : or_zero(adjoint_[index(i)]);
  }

  Term second(Term a, Term b) const {
    const auto [low, high] = std::minmax({place(a), place(b)});
    if (low < 0) return graph_.constant(0.0);
    const auto& row = second_[index(high)];
    const auto entry = row.find(low);
    return entry == row.end() ? graph_.constant(0.0) : entry->second;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  /// Place of a node in the order; -1 if the output does not need it.
  int place(Term t) const { return index(t.node) < place_.size() ? place_[index(t.node)] : -1; }
  Term or_zero(Term t) const { return t.node < 0 ? graph_.constant(0.0) : t; }

  std::vector<bool> depends_on(std::span<const Term> variables) const {
    std::vector<bool> varies(order_.size(), false);
    for (const Term v : variables) {
      if (place(v) >= 0) varies[index(place(v))] = true;
    }
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Node& n = graph_.nodes()[index(order_[i])];
      if (n.op == Op::input || n.op == Op::constant) continue;
      varies[i] = varies[index(place(n.a))] || (n.b.node >= 0 && varies[index(place(n.b))]);
    }
    return varies;
  }

  void accumulate(Term& sum, Term t) const {
    if (!graph_.is_zero(t)) sum = sum.node < 0 ? t : graph_.add(sum, t);
  }
  void accumulate_second(int a, int b, Term t) {
    if (graph_.is_zero(t)) return;
    const auto [low, high] = std::minmax(a, b);
    accumulate(second_[index(high)].try_emplace(low, Term{}).first->second, t);
  }

  /// Pushes the adjoint and the second derivatives that end at a node to its operands.
  void push(int v) {
    const Term adjoint = adjoint_[index(v)];
    if (adjoint.node < 0 && second_[index(v)].empty()) return;
    Local d = differentiate(graph_, order_[index(v)], second_order_);
    if (d.count == 0) return;
    for (int i = 0; i < d.count; ++i) d.operand[index(i)] = place_[index(d.operand[index(i)])];
    std::array<bool, 2> active{};
    for (std::size_t i = 0; i < static_cast<std::size_t>(d.count); ++i)
      active[i] = varies_[index(d.operand[i])];

    if (second_order_) push_second(v, d, active, adjoint);
    if (adjoint.node < 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(d.count); ++i) {
      if (active[i]) accumulate(adjoint_[index(d.operand[i])], graph_.multiply(adjoint, d.first[i]));
    }
  }

  void push_second(int v, const Local& d, std::array<bool, 2> active, Term adjoint) {
    const auto count = static_cast<std::size_t>(d.count);
    const auto row = std::move(second_[index(v)]);
    for (const auto& [other, w] : row) {
      if (other == v) {
        for (std::size_t i = 0; i < count; ++i) {
          if (active[i])
            accumulate_second(d.operand[i], d.operand[i],
                              graph_.multiply(graph_.multiply(d.first[i], d.first[i]), w));
        }
        if (active[0] && active[1]) {
          accumulate_second(d.operand[0], d.operand[1],
                            graph_.multiply(graph_.multiply(d.first[0], d.first[1]), w));
        }
        continue;
      }
      for (std::size_t i = 0; i < count; ++i) {
        if (!active[i]) continue;
        const Term pushed = graph_.multiply(d.first[i], w);
        const bool doubled = d.operand[i] == other;  // both ends of the edge coincide
        accumulate_second(d.operand[i], other,
                          doubled ? graph_.multiply(graph_.constant(2.0), pushed) : pushed);
      }
    }
    second_[index(v)].clear();
    if (adjoint.node < 0) return;
    if (d.second[0].node >= 0 && active[0]) {
      accumulate_second(d.operand[0], d.operand[0], graph_.multiply(adjoint, d.second[0]));
    }
    if (count == 2 && d.second[1].node >= 0 && active[0] && active[1]) {
      accumulate_second(d.operand[0], d.operand[1], graph_.multiply(adjoint, d.second[1]));
    }
    if (count == 2 && d.second[2].node >= 0 && active[1]) {
      accumulate_second(d.operand[1], d.operand[1], graph_.multiply(adjoint, d.second[2]));
    }
  }

  Graph& graph_;
  bool second_order_;
  std::vector<int> order_, place_;  // order_: nodes by place; place_: the inverse
  std::vector<bool> varies_;
  std::vector<Term> adjoint_;                // node -1: zero so far
  std::vector<std::map<int, Term>> second_;  // [place]: partner <= place -> second derivative
};

}  // namespace

std::vector<Term> gradient(Graph& graph, Term out, std::span<const Term> variables) {
  const Sweep sweep(graph, out, variables, false);
  std::vector<Term> first;
  for (const Term v : variables) first.push_back(sweep.first(v));
  return first;
}

Derivatives derive(Graph& graph, Term out, std::span<const Term> variables) {
  const Sweep sweep(graph, out, variables, true);
  Derivatives d;
  for (std::size_t i = 0; i < variables.size(); ++i) {
    d.first.push_back(sweep.first(variables[i]));
    for (std::size_t j = i; j < variables.size(); ++j)
      d.second.push_back(sweep.second(variables[i], variables[j]));
  }
  return d;
}

}  // namespace sightline
