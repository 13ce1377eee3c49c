/// A formula as a directed graph of operations, each distinct operation stored once.
///
/// References carry the signs, nodes do not: -(a b), (-a) b and a (-b) are one product, referenced
/// by a negative `Term`. The graph of a gradient thus shares all common parts. Zeros, ones and
/// constants fold away on entry.
///
/// The graph depends on the formula alone, not on the order in which its operands were computed;
/// C++ leaves that order to the compiler. A structural key orders the operands of sums and
/// products, and passes over the nodes use `in_order`. Every compiler therefore derives and prints
/// the same programs.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sightline {

/// The operation of a node on its operands a, b.
enum class Op : std::uint8_t {
  input,        ///< a variable of the formula
  constant,     ///< a number, >= 0 unless it belongs to a parameter
  add,          ///< a + b; a is positive, b has a sign
  multiply,     ///< a b; both positive
  reciprocal,   ///< 1 / a; a positive
  square_root,  ///< sqrt(a)
  exponential,  ///< e^a
  logistic,     ///< 1 / (1 + e^-a); a positive
  relaxed_log,  ///< ln a for a >= 1, below it the parabola of the same curvature; twice differentiable
  sine,         ///< sin a; a positive
  cosine,       ///< cos a; a positive
  maximum,      ///< the larger of a and b; not differentiable here
  logarithm,    ///< ln a
  softplus,     ///< ln(1 + e^a)
  angle,        ///< angle of the direction (b, a) from the axis of b, in [-pi, pi]; a positive, b has a sign
};

/// A node of a graph, or its negative.
struct Term {
  int node = -1;
  bool negative = false;

  friend Term operator-(Term t) { return {t.node, !t.negative}; }
  bool operator==(const Term&) const = default;
};

struct Node {
  Op op{};
  Term a{}, b{};       ///< operands; b only of sums, products, maxima, angles; a of a parameter: itself
  double value = 0.0;  ///< of a constant; for an input, its index

  bool operator==(const Node&) const = default;
};

/// Treatment of zero among numbers that are parameters.
enum class Zeros {
  kept,    ///< an ordinary parameter: formulas of one shape share one graph
  folded,  ///< part of the shape: operations with it fold away
};

/// The graph. Nodes are stored in the order of their creation, operands first.
class Graph {
 public:
  Term input(int index);
  Term constant(double value);

  Term add(Term a, Term b);
  Term multiply(Term a, Term b);
  Term reciprocal(Term a);
  Term square_root(Term a);
  Term exponential(Term a);
  Term logistic(Term a);
  Term relaxed_log(Term a);
  Term sine(Term a);
  Term cosine(Term a);
  Term maximum(Term a, Term b);
  Term logarithm(Term a);
  Term softplus(Term a);
  Term angle(Term a, Term b);

  Term subtract(Term a, Term b) { return add(a, -b); }

  /// Begins a formula whose numbers are parameters. No parameter folds away or merges with another
  /// because of its value, so formulas of one shape have one graph for all numbers. Only equal
  /// numbers that meet one term in the same way, within one formula, are the same parameter.
  void keep_parameters(Zeros zeros = Zeros::kept) {
    formula_ = ++formulas_;
    zeros_ = zeros;
  }
  /// Ends that mode: numbers fold away and are identified by their value again.
  void keep_values() { formula_ = 0; }
  /// A distinct parameter, which folds nothing away for any value.
  Term parameter(double value);
  /// A number of the formula that combines with `other`, as a factor or as a summand.
  Term number(double value, Term other, bool factor);

  /// Whether a constant factor moves to the front of a product: c (a b) for a (c b). That exposes
  /// common parts during differentiation. In matrix products it multiplies the same factor again in
  /// each column.
  void draw_constants(bool on) { draw_constants_ = on; }

  bool is_constant(Term t) const { return node(t).op == Op::constant; }
  /// Value of a constant term, including its sign.
  double constant_value(Term t) const { return t.negative ? -node(t).value : node(t).value; }
  bool is_zero(Term t) const { return is_number(t, 0.0); }

  /// Whether a term is a constant that is not identified by its value.
  bool is_parameter(Term t) const { return is_constant(t) && node(t).a.node >= 0; }

  const Node& node(Term t) const { return nodes_[static_cast<std::size_t>(t.node)]; }
  std::span<const Node> nodes() const { return nodes_; }
  int size() const { return static_cast<int>(nodes_.size()); }

  /// The nodes that the outputs need, operands first: depth first from the first output to the
  /// last. The order of one formula is the same in whatever order its nodes were created.
  std::vector<int> in_order(std::span<const Term> outputs) const;

 private:
  struct Hash {
    std::size_t operator()(const Node& n) const;
  };

  /// Sort key of a node among operands: lower height first, inputs by their index, others by their
  /// structure. Values of parameters are no part of the shape; they decide only between equal
  /// shapes.
  struct Key {
    int height = 0;
    std::uint64_t shape = 0, values = 0;

    auto operator<=>(const Key&) const = default;
  };

  /// Products of parameters are identified by their factors, in any order; other results by their
  /// operation.
  using Factors = std::pair<double, std::vector<int>>;

  const Key& key(Term t) const { return keys_[static_cast<std::size_t>(t.node)]; }
  bool stands_before(Term a, Term b) const;
  Key key_of(const Node& node) const;
  Term unique(const Node& node);
  Term append(const Node& node, const Key& key);
  bool is_number(Term t, double value) const {
    return is_constant(t) && !is_parameter(t) && node(t).value == value;
  }
  Factors factors(Term t) const;
  /// A distinct parameter that is no product.
  Term leaf(double value, const Key& key);
  Term product(Factors factors);
  Term result(const Node& operation, double value);
  Term of_constant(Op op, Term a, double value);
  Term sum_of_constants(Term a, Term b);
  Term product_of_constants(Term a, Term b);

  bool draw_constants_ = true;
  int formulas_ = 0, formula_ = 0;  // formula_ 0: numbers are identified by their value
  Zeros zeros_ = Zeros::kept;
  std::map<std::tuple<int, int, bool, double>, Term> numbers_;  // [formula, other, factor, value]
  std::map<Factors, int> names_;                                // node of a parameter
  std::map<int, Factors> factors_;                              // the inverse of names_
  std::unordered_map<Node, Term, Hash> results_;
  struct Leaf {
    double value;
    Key key;
  };
  std::vector<Leaf> leaves_;  // parameters that are no product
  int named_ = 0;             // parameters outside the numbers of a formula
  std::vector<Node> nodes_;
  std::vector<Key> keys_;
  std::unordered_map<Node, int, Hash> index_;
};

}  // namespace sightline
