/// A formula as a directed graph of operations, each distinct operation stored once.
///
/// Signs are kept on the references, not in nodes: -(a b), (-a) b and a (-b) are the same product seen
/// through a negative `Term`, so the graph of a gradient shares all it can. Zeros, ones and constants fold
/// away on entry.
///
/// What is recorded depends on the formula alone, and not on the order in which its operands were computed, which
/// C++ leaves to the compiler: operands of sums and products are ordered by a key of their structure, and whoever
/// goes through the nodes does so in `in_order`. So every compiler derives and prints the same programs.
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

/// What a node computes from its operands a, b.
enum class Op : std::uint8_t {
  input,        ///< a variable of the formula
  constant,     ///< a number, >= 0 unless it is a parameter's
  add,          ///< a + b; a is positive, b has a sign
  multiply,     ///< a b; both positive
  reciprocal,   ///< 1 / a; a positive
  square_root,  ///< sqrt(a)
  exponential,  ///< e^a
  logistic,     ///< 1 / (1 + e^-a); a positive
  relaxed_log,  ///< ln a for a >= 1, below it the parabola of the same curvature; has two derivatives
  sine,         ///< sin a; a positive
  cosine,       ///< cos a; a positive
  maximum,      ///< the larger of a and b; has no derivative
  logarithm,    ///< ln a
  softplus,     ///< ln(1 + e^a)
  angle,        ///< of the direction (b, a) from the axis of b, in [-pi, pi]; a positive, b has a sign
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
  Term a{}, b{};       ///< operands; b of sums, products, maxima and angles alone; a of a parameter: itself
  double value = 0.0;  ///< of a constant; the index of an input

  bool operator==(const Node&) const = default;
};

/// What a zero is among numbers that are parameters.
enum class Zeros {
  kept,    ///< a parameter as any: a formula of one shape stays one graph
  folded,  ///< a part of the shape: what it meets is not there
};

/// The graph; nodes are stored in the order of their creation, operands first.
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

  /// Opens a formula whose numbers are parameters: none folds away by its value, none is another by its value,
  /// so formulas of one shape are one graph whatever their numbers. Only a number that meets one term twice in
  /// one way, and in one formula, is the same parameter.
  void keep_parameters(Zeros zeros = Zeros::kept) {
    formula_ = ++formulas_;
    zeros_ = zeros;
  }
  /// Ends it: numbers fold away, and are known by their value, again.
  void keep_values() { formula_ = 0; }
  /// A number of its own, which folds nothing away whatever its value.
  Term parameter(double value);
  /// A number of the formula that meets `other`, as a factor or as a summand.
  Term number(double value, Term other, bool factor);

  /// Whether a constant factor is drawn to the front of a product, c (a b) for a (c b). That finds common
  /// parts while differentiating; in products of matrices it multiplies the same factor again in each column.
  void draw_constants(bool on) { draw_constants_ = on; }

  bool is_constant(Term t) const { return node(t).op == Op::constant; }
  /// Value of a constant term, its sign included.
  double constant_value(Term t) const { return t.negative ? -node(t).value : node(t).value; }
  bool is_zero(Term t) const { return is_number(t, 0.0); }

  /// Whether a term is a constant that is not known by its value.
  bool is_parameter(Term t) const { return is_constant(t) && node(t).a.node >= 0; }

  const Node& node(Term t) const { return nodes_[static_cast<std::size_t>(t.node)]; }
  std::span<const Node> nodes() const { return nodes_; }
  int size() const { return static_cast<int>(nodes_.size()); }

  /// The nodes that the outputs need, operands first: depth first from the first output to the last. The same for one
  /// formula, in whatever order its nodes were created.
  std::vector<int> in_order(std::span<const Term> outputs) const;

 private:
  struct Hash {
    std::size_t operator()(const Node& n) const;
  };

  /// Where a node stands among operands: the shallow ones first, inputs by their index, others by what they are made
  /// of; by the values of parameters, which are no part of the shape, only where all else is equal.
  struct Key {
    int height = 0;
    std::uint64_t shape = 0, values = 0;

    auto operator<=>(const Key&) const = default;
  };

  /// Products of parameters are known by their factors, in any order; other results by how they came about.
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
  /// A parameter of its own.
  Term leaf(double value, const Key& key);
  Term product(Factors factors);
  Term result(const Node& operation, double value);
  Term of_constant(Op op, Term a, double value);
  Term sum_of_constants(Term a, Term b);
  Term product_of_constants(Term a, Term b);

  bool draw_constants_ = true;
  int formulas_ = 0, formula_ = 0;  // 0: numbers are known by their value
  Zeros zeros_ = Zeros::kept;
  std::map<std::tuple<int, int, bool, double>, Term> numbers_;  // [formula, other, factor, value]
  std::map<Factors, int> names_;                                // node of a parameter
  std::map<int, Factors> factors_;                              // and back
  std::unordered_map<Node, Term, Hash> results_;
  struct Leaf {
    double value;
    Key key;
  };
  std::vector<Leaf> leaves_;  // parameters that are no product
  int named_ = 0;             // parameters that are no number of a formula
  std::vector<Node> nodes_;
  std::vector<Key> keys_;
  std::unordered_map<Node, int, Hash> index_;
};

}  // namespace sightline
