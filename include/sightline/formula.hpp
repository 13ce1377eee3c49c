/// Formulas as data: recorded from C++ or parsed from text, differentiated, interpreted, printed as C++.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <compare>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

// A formula as a directed graph of operations, each distinct operation stored once.
//
// References carry the signs, nodes do not: -(a b), (-a) b and a (-b) are one product, referenced
// by a negative `Term`. The graph of a gradient thus shares all common parts. Zeros, ones and
// constants fold away on entry.
//
// The graph depends on the formula alone, not on the order in which its operands were computed;
// C++ leaves that order to the compiler. A structural key orders the operands of sums and
// products, and passes over the nodes use `in_order`. Every compiler therefore derives and prints
// the same programs.

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

// The recording scalar: arithmetic on it appends to a graph.
//
// A formula that is a template over its scalar runs once on `Symbol`. The resulting graph yields
// value, gradient and Hessian. Comparisons are missing on purpose: a recorded formula is one
// expression, valid everywhere.

class Symbol {
 public:
  Symbol() = default;
  Symbol(double constant) : constant_(constant) {}
  Symbol(Graph& graph, Term term) : graph_(&graph), term_(term) {}

  /// The term in the given graph; a constant enters the graph here.
  Term in(Graph& graph) const { return graph_ != nullptr ? term_ : graph.constant(constant_); }

  friend Symbol operator+(const Symbol& a, const Symbol& b) {
    return combine(a, b, &Graph::add, [](double x, double y) { return x + y; });
  }
  friend Symbol operator-(const Symbol& a, const Symbol& b) {
    return combine(a, b, &Graph::subtract, [](double x, double y) { return x - y; });
  }
  friend Symbol operator*(const Symbol& a, const Symbol& b) {
    return combine(a, b, &Graph::multiply, [](double x, double y) { return x * y; });
  }
  friend Symbol operator/(const Symbol& a, const Symbol& b) {
    if (a.graph_ == nullptr && b.graph_ == nullptr) return a.constant_ / b.constant_;
    return a * apply(b, &Graph::reciprocal, [](double x) { return 1.0 / x; });
  }
  friend Symbol operator-(const Symbol& a) {
    return a.graph_ != nullptr ? Symbol(*a.graph_, -a.term_) : Symbol(-a.constant_);
  }
  Symbol& operator+=(const Symbol& b) { return *this = *this + b; }
  Symbol& operator-=(const Symbol& b) { return *this = *this - b; }
  Symbol& operator*=(const Symbol& b) { return *this = *this * b; }

  friend Symbol sqrt(const Symbol& a) {
    return apply(a, &Graph::square_root, [](double x) { return sightline::sqrt(x); });
  }
  friend Symbol exp(const Symbol& a) {
    return apply(a, &Graph::exponential, [](double x) { return sightline::exp(x); });
  }
  friend Symbol logistic(const Symbol& a) {
    return apply(a, &Graph::logistic, [](double x) { return sightline::logistic(x); });
  }
  friend Symbol relaxed_log(const Symbol& a) {
    return apply(a, &Graph::relaxed_log, [](double x) { return sightline::relaxed_log(x); });
  }
  friend Symbol log(const Symbol& a) {
    return apply(a, &Graph::logarithm, [](double x) { return sightline::log(x); });
  }
  friend Symbol softplus(const Symbol& a) {
    return apply(a, &Graph::softplus, [](double x) { return sightline::softplus(x); });
  }
  friend Symbol atan2(const Symbol& a, const Symbol& b) {
    return combine(a, b, &Graph::angle, [](double y, double x) { return sightline::atan2(y, x); });
  }
  friend Symbol sin(const Symbol& a) {
    return apply(a, &Graph::sine, [](double x) { return sightline::sin(x); });
  }
  friend Symbol cos(const Symbol& a) {
    return apply(a, &Graph::cosine, [](double x) { return sightline::cos(x); });
  }
  /// For the solver's own algebra only: maximum has no derivative, so a formula to be derived must
  /// not use it.
  friend Symbol maximum(const Symbol& a, const Symbol& b) {
    return combine(a, b, &Graph::maximum, [](double x, double y) { return sightline::maximum(x, y); });
  }

 private:
  template <class OnNumbers>
  static Symbol combine(const Symbol& a, const Symbol& b, Term (Graph::*on_terms)(Term, Term),
                        OnNumbers numbers) {
    Graph* graph = a.graph_ != nullptr ? a.graph_ : b.graph_;
    if (graph == nullptr) return numbers(a.constant_, b.constant_);
    const bool factor = on_terms == &Graph::multiply;
    const Term left = a.graph_ != nullptr ? a.term_ : graph->number(a.constant_, b.term_, factor);
    const Term right = b.graph_ != nullptr ? b.term_ : graph->number(b.constant_, a.term_, factor);
    return {*graph, (graph->*on_terms)(left, right)};
  }
  template <class OnNumber>
  static Symbol apply(const Symbol& a, Term (Graph::*on_term)(Term), OnNumber number) {
    if (a.graph_ == nullptr) return number(a.constant_);
    return {*a.graph_, (a.graph_->*on_term)(a.term_)};
  }

  Graph* graph_ = nullptr;  // null: a constant
  Term term_{};
  double constant_ = 0.0;
};

/// n variables of a graph, inputs first, first + 1, ...
inline std::vector<Symbol> variables(Graph& graph, int first, int n) {
  std::vector<Symbol> symbols;
  for (int i = 0; i < n; ++i) symbols.emplace_back(graph, graph.input(first + i));
  return symbols;
}

// A graph's outputs as a short list of instructions: dead nodes dropped, products fused into sums,
// memory reused.

/// The operation of one instruction on the rows a, b, c; d is its result.
enum class Code : std::uint8_t {
  copy,               ///< d = a
  negate,             ///< d = -a
  add,                ///< d = a + b
  subtract,           ///< d = a - b
  multiply,           ///< d = a b
  multiply_add,       ///< d = a b + c, rounded once
  multiply_subtract,  ///< d = a b - c, rounded once
  subtract_product,   ///< d = c - a b, rounded once
  reciprocal,         ///< d = 1 / a
  square_root,
  exponential,
  logistic,
  relaxed_log,
  sine,
  cosine,
  maximum,  ///< d = a where a > b, else b
  logarithm,
  softplus,
  angle,  ///< d = atan2(a, b)
};

struct Instruction {
  Code code{};
  int d = 0, a = 0, b = 0, c = 0;  ///< rows

  bool operator==(const Instruction&) const = default;
};

/// Rows 0 .. inputs-1 are the inputs. One row per constant follows, then scratch, then one row per
/// output.
class Program {
 public:
  Program() = default;
  /// @param inputs  number of inputs; all inputs in the outputs have a smaller index
  Program(const Graph& graph, std::span<const Term> outputs, int inputs);

  int inputs() const { return inputs_; }
  int outputs() const { return outputs_; }
  int scratch() const { return scratch_; }
  int rows() const { return first_output() + outputs_; }
  int first_constant() const { return inputs_; }
  int first_scratch() const { return inputs_ + static_cast<int>(constants_.size()); }
  int first_output() const { return first_scratch() + scratch_; }
  std::span<const double> constants() const { return constants_; }
  std::span<const Instruction> instructions() const { return instructions_; }

  bool operator==(const Program&) const = default;

 private:
  int inputs_ = 0, outputs_ = 0, scratch_ = 0;
  std::vector<double> constants_;
  std::vector<Instruction> instructions_;
};

// Evaluation of a program over rows of numbers, one pack of lanes per operation.

/// Zeroed memory for rows of doubles, aligned to `row_alignment`. Large blocks use pages of 2 MB if
/// the system has them.
class Rows {
 public:
  Rows() = default;
  /// n rows of at least `length` doubles each, every row padded to whole packs.
  Rows(int n, int length);
  /// The same in external memory of room(n, length) doubles, with that alignment; the memory must
  /// outlive this object.
  Rows(int n, int length, double* memory);
  static std::ptrdiff_t room(int n, int length) {
    return static_cast<std::ptrdiff_t>(n) * static_cast<std::ptrdiff_t>(padded(length));
  }

  double* operator[](int row) { return memory_.get() + static_cast<std::ptrdiff_t>(row) * stride_; }
  const double* operator[](int row) const {
    return memory_.get() + static_cast<std::ptrdiff_t>(row) * stride_;
  }
  int count() const { return count_; }
  int stride() const { return stride_; }
  std::span<double> all() { return {memory_.get(), size()}; }
  std::span<const double> all() const { return {memory_.get(), size()}; }

 private:
  struct Free {
    std::size_t alignment;  // 0: external memory
    void operator()(double* memory) const;
  };
  std::size_t size() const { return static_cast<std::size_t>(count_) * static_cast<std::size_t>(stride_); }

  int count_ = 0, stride_ = 0;
  std::unique_ptr<double[], Free> memory_{nullptr, Free{0}};
};

/// A program bound to the rows it reads and writes. Binding allocates, running does not.
///
/// The caller owns the input and output rows. They have one common length and are aligned and
/// padded as `Rows`. Results are written in place, in the padding too.
class Evaluation {
 public:
  Evaluation() = default;
  /// @param program  must outlive the evaluation
  /// @param length   numbers per row: the points at which the formula is evaluated
  Evaluation(const Program& program, int length);
  Evaluation(Program&&, int) = delete;

  void input(int i, const double* row) { at(i) = const_cast<double*>(row); }  // never written
  void output(int i, double* row) { at(program_->first_output() + i) = row; }

  /// Evaluates all points. Every input and output must be bound; outputs must not overlap inputs.
  void run() const noexcept;

 private:
  double*& at(int row) { return rows_[static_cast<std::size_t>(row)]; }

  const Program* program_ = nullptr;
  int packs_ = 0;
  Rows own_;  // constants and scratch
  std::vector<double*> rows_;
};

/// The outputs of a program at one point, for tests and set-up; allocates.
std::vector<double> evaluate(const Program& program, std::span<const double> inputs);

// Symbolic gradient and Hessian of a formula, in its own graph.
//
// One reverse sweep with edge pushing (Gower and Mello 2012) computes both. It pushes second
// derivatives from a node to its operands together with the adjoint. It therefore visits only
// interacting pairs, and value, gradient and Hessian share all common parts.

/// Entry (i, j), i <= j, of the upper triangle of a symmetric n x n matrix stored row by row.
constexpr int upper_index(int i, int j, int n) { return i * n - i * (i - 1) / 2 + (j - i); }

struct Derivatives {
  std::vector<Term> first;   ///< n: d out / d variable_i
  std::vector<Term> second;  ///< n (n + 1) / 2: d2 out / d variable_i d variable_j, `upper_index`
};

/// First derivatives of `out` with respect to the given input nodes; terms of the same graph.
std::vector<Term> gradient(Graph& graph, Term out, std::span<const Term> variables);

/// First and second derivatives of `out` with respect to the given input nodes; terms of the same
/// graph.
Derivatives derive(Graph& graph, Term out, std::span<const Term> variables);

// Prints a program as straight-line C++ over any lane.
//
// The numbers of the program are not printed but passed in an array. One function therefore serves
// all parameter values of a model, as long as the operations stay the same.

/// A named contiguous range of a program's inputs or outputs.
struct Block {
  std::string_view name;
  int size = 0;

  bool operator==(const Block&) const = default;
};

/// Hash of a program's structure; equal for programs that differ only in the values of their
/// constants.
std::uint64_t structure(const Program& program);

/// The counts a printed function relies on, besides its structure, which is a hash.
struct ProgramSize {
  int inputs = 0, outputs = 0, constants = 0, instructions = 0;

  bool operator==(const ProgramSize&) const = default;
};
ProgramSize size_of(const Program& program);

/// The program as a function template over the lane L, instructions before a long path first:
///
///   template <class L> static void name(const double* constants, const double* in..., double* out...)
///
/// with one argument per block; the packs of a block are contiguous. An output block NAME_out is the
/// block NAME of the next call. The bits equal the interpreter's.
std::string emit(const Program& program, std::string_view name, std::span<const Block> inputs,
                 std::span<const Block> outputs);

// Units of measurement for positions and motions.

/// Powers of metre and second, counted in halves, so that the root of a unit is a unit. Angles and
/// plain numbers have power 0.
struct Unit {
  int metre = 0, second = 0;

  bool operator==(const Unit&) const = default;
  friend Unit operator*(Unit a, Unit b) { return {a.metre + b.metre, a.second + b.second}; }
  friend Unit operator/(Unit a, Unit b) { return {a.metre - b.metre, a.second - b.second}; }
};

namespace units {
inline constexpr Unit none{}, length{2, 0}, time{0, 2}, velocity{2, -2};
}

/// A unit with its name and its size in SI units.
struct NamedUnit {
  std::string_view name;
  Unit unit;
  double factor;
};

/// Finds m, cm, mm, km, rad, deg, s, ms or Hz; none for another name.
std::optional<NamedUnit> unit_named(std::string_view name);

/// `unit` to a power of at most 64; none if the result has powers other than whole halves.
std::optional<Unit> to_power(Unit unit, double power);

/// Text of a unit: "m^2", "m/s", "1/s"; "a plain number or an angle".
std::string to_string(Unit unit);

// A formula read from text: a list of operations over named quantities, for any scalar.
//
// On `Symbol` it appends itself to a graph, as a formula written in C++ does; from there on the
// two are treated alike.

class Expression {
 public:
  enum class Kind {
    variable,
    constant,
    add,
    subtract,
    multiply,
    divide,
    negate,
    root,  ///< sqrt(a + width^2): all functions with a corner use it
    sine,
    cosine,
    angle,  ///< atan2(a, b)
    exponential,
    logarithm,
    logistic,  ///< 1 / (1 + e^-a)
    softplus,  ///< ln(1 + e^a)
  };
  /// Operands a and b are earlier steps; for a variable, a is its index.
  struct Step {
    Kind kind{};
    int a = -1, b = -1;
    double value = 0.0;

    friend bool operator<(const Step& s, const Step& t) {
      return std::tie(s.kind, s.a, s.b, s.value) < std::tie(t.kind, t.a, t.b, t.value);
    }
  };

  /// The constant zero.
  Expression() : steps_{{Kind::constant}} {}
  /// @param smoothed  names of the functions with a corner in the formula
  Expression(std::vector<Step> steps, std::optional<Unit> unit, std::set<std::string> smoothed)
      : steps_(std::move(steps)), unit_(unit), smoothed_(std::move(smoothed)) {}

  static Expression variable(int index, Unit unit) { return {{{Kind::variable, index}}, unit, {}}; }
  static Expression constant(double value, std::optional<Unit> unit) {
    return {{{Kind::constant, -1, -1, value}}, unit, {}};
  }

  /// The value at the variables. Roots are smoothed over `width` (in their unit), and exact at
  /// width 0.
  template <class S>
  S operator()(std::span<const S> variables, double width) const {
    std::vector<S> v;
    v.reserve(steps_.size());
    for (const Step& step : steps_) v.push_back(apply<S>(step, variables, v, width));
    return v.back();
  }
  /// The same without allocation: `scratch` holds one value per step.
  template <class S>
  S operator()(std::span<const S> variables, double width, std::span<S> scratch) const {
    assert(scratch.size() >= steps_.size() && "scratch holds a value for each step");
    for (std::size_t i = 0; i < steps_.size(); ++i)
      scratch[i] = apply<S>(steps_[i], variables, scratch, width);
    return scratch[steps_.size() - 1];
  }

  /// Steps ordered so that operands come first; the last step is the result.
  std::span<const Step> steps() const { return steps_; }
  /// The unit; none if a number without a unit leaves it open.
  std::optional<Unit> unit() const { return unit_; }
  const std::set<std::string>& smoothed() const { return smoothed_; }
  bool is_constant() const { return steps_.back().kind == Kind::constant; }
  bool uses(int variable) const {
    return std::any_of(steps_.begin(), steps_.end(),
                       [&](const Step& s) { return s.kind == Kind::variable && s.a == variable; });
  }

 private:
  template <class S>
  static S apply(const Step& step, std::span<const S> variables, std::span<const S> v, double width) {
    const auto a = [&]() -> const S& { return v[static_cast<std::size_t>(step.a)]; };
    const auto b = [&]() -> const S& { return v[static_cast<std::size_t>(step.b)]; };
    switch (step.kind) {
      case Kind::variable:
        return variables[static_cast<std::size_t>(step.a)];
      case Kind::constant:
        return step.value;
      case Kind::add:
        return a() + b();
      case Kind::subtract:
        return a() - b();
      case Kind::multiply:
        return a() * b();
      case Kind::divide:
        return a() / b();
      case Kind::negate:
        return -a();
      case Kind::root:
        return sqrt(a() + width * width);
      case Kind::sine:
        return sin(a());
      case Kind::cosine:
        return cos(a());
      case Kind::angle:
        return atan2(a(), b());
      case Kind::exponential:
        return exp(a());
      case Kind::logarithm:
        return log(a());
      case Kind::logistic:
        return logistic(a());
      case Kind::softplus:
        return softplus(a());
    }
    return step.value;
  }

  std::vector<Step> steps_;
  std::optional<Unit> unit_;
  std::set<std::string> smoothed_;
};

/// Builds an Expression: each distinct step once, constants folded, finite or not.
class ExpressionBuilder {
 public:
  using Kind = Expression::Kind;

  int variable(int index) { return unique({Kind::variable, index}); }
  int constant(double value) { return unique({Kind::constant, -1, -1, value}); }
  /// One of add, subtract, multiply, divide and angle.
  int binary(Kind kind, int a, int b);
  /// One of negate, root, sine, cosine, exponential, logarithm, logistic and softplus.
  int unary(Kind kind, int a);
  /// base^n; for a root, each factor root^2 becomes the root's argument.
  int power(int base, int n);
  int absolute(int a) { return unary(Kind::root, power(a, 2)); }
  /// The larger or the smaller of a and b: half of a + b plus or minus |a - b|.
  int larger(int a, int b) { return half_of_sum(Kind::add, a, b); }
  int smaller(int a, int b) { return half_of_sum(Kind::subtract, a, b); }
  /// Appends all steps of another expression and returns the result's step.
  int copy(const Expression& expression);

  std::optional<double> value(int step) const;
  std::size_t size() const { return steps_.size(); }
  /// An expression with only the steps that `result` needs.
  Expression finish(int result, std::optional<Unit> unit, std::set<std::string> smoothed) const;

 private:
  const Expression::Step& at(int step) const { return steps_[static_cast<std::size_t>(step)]; }
  int unique(const Expression::Step& step);
  int half_of_sum(Kind kind, int a, int b);

  std::vector<Expression::Step> steps_;
  std::map<Expression::Step, int> index_;
};

// Tokens of a formula's text, and the error that points at one of them.

/// Longest formula accepted [bytes].
inline constexpr std::size_t formula_size_max = 100'000;

/// Error in the text of a formula. what() is "line:column: sentence"; both count from 1, columns in
/// characters.
class FormulaError : public std::invalid_argument {
 public:
  FormulaError(std::string_view text, std::size_t offset, std::string sentence, std::string definition = {});

  /// Offset of the token in the text [bytes].
  std::size_t offset() const { return offset_; }
  const std::string& sentence() const { return sentence_; }
  /// The name with the rejected definition; empty for the formula itself.
  const std::string& definition() const { return definition_; }

 private:
  std::size_t offset_;
  std::string sentence_, definition_;
};

enum class TokenKind { number, name, sign, end };

struct Token {
  TokenKind kind{};
  std::size_t begin = 0;
  std::string_view text;
  double value = 0.0;

  bool is(std::string_view sign) const { return kind == TokenKind::sign && text == sign; }
};

/// A token as text for a message.
std::string shown(const Token& token);

/// Whether the name is a letter followed by letters, digits and _.
bool is_word(std::string_view name);

/// Iterates over the tokens of a text. It is a view: the text must outlive it. A copy continues
/// from the same position.
class Lexer {
 public:
  /// @throws FormulaError for a text that is too long; every function here throws it for an invalid
  ///   token
  explicit Lexer(std::string_view text);

  /// The current token.
  const Token& token() const { return token_; }
  /// Returns the current token and advances to the next one.
  Token take();

  /// @throws FormulaError
  [[noreturn]] void throw_invalid(std::size_t offset, std::string sentence) const;

 private:
  void next();
  void take_text(TokenKind kind, std::size_t size);
  void number();
  void name();
  [[noreturn]] void unknown_character() const;

  std::string_view text_;
  std::size_t at_ = 0;
  Token token_;
};

// The formula language: parses text into an `Expression`, or throws an error that points at the
// token.
//
//   limit     = sum  comparison sum  { comparison sum }       comparison: < <= > >=, a chain in one direction
//   sum       = product { ("+" | "-") product }
//   product   = signed { ("*" | "/") signed }
//   signed    = { "-" | "+" } power
//   power     = atom [ "^" signed ]                           from the right, before the sign: -x^2 = -(x^2)
//   atom      = number [unit] | name | function "(" sum { "," sum } ")" | "(" sum ")"
//   unit      = unit_power { "/" unit_power } | "/" unit_power { "/" unit_power }
//
// Units are checked where they are given: a number without one fits anywhere. An even power undoes
// a root: norm(x, y)^2 is x^2 + y^2, and no corner remains to smooth. docs/potentials.md lists the
// functions.

/// Limits of the input: nesting depth of brackets and powers, and number of steps.
inline constexpr int formula_depth_max = 100;
inline constexpr std::size_t formula_steps_max = 1000;

/// Names and their meaning: a variable or an expression.
using Vocabulary = std::map<std::string, Expression, std::less<>>;

/// Whether a user may give this name to a parameter: a word that is no function, unit or constant.
bool is_free_name(std::string_view name);

/// Parses a formula with one value.
/// @throws FormulaError
Expression parse_formula(std::string_view text, const Vocabulary& names);

/// Parses one or more comparisons into quantities c, with c <= 0 where the comparison holds: a < b
/// gives c = a - b. A chain a < b < c gives one quantity per sign.
/// @throws FormulaError
std::vector<Expression> parse_limits(std::string_view text, const Vocabulary& names);

struct Definition {
  std::string name, text;
};

/// Adds names defined by formulas, which may use each other in any order.
/// @throws FormulaError with `definition` set, for a definition that is no formula or depends on
///   itself
void define(Vocabulary& names, std::span<const Definition> definitions);

// Fast evaluation of a program over one pack of lanes, as threaded code. The schedule places
// instructions where their operands are ready. Each function runs a short chain of instructions
// with its running result in a register, then jumps to the next function.

/// A program over W points side by side, with its inputs and outputs in blocks of packs. Running
/// does not allocate.
template <int W>
class Threaded {
 public:
  /// @param inputs, outputs  rows of each block, in the program's order
  Threaded(const Program& program, std::span<const int> inputs, std::span<const int> outputs);

  /// Takes one pointer per block. Outputs must not overlap inputs, because run() writes outputs
  /// before it has read all inputs.
  void run(std::initializer_list<const double*> inputs, std::initializer_list<double*> outputs) noexcept;

 private:
  using L = Lane<W>;
  using Vector = typename L::Vector;
  /// A row: its block above, its offset there below, read as one word.
  using Place = std::uint32_t;
  /// One function, the place of its result, and the operands of each of its instructions. The
  /// result passes on in a register.
  struct Step {
    void (*run)(Vector before, const Step* step, double* const* blocks) = nullptr;
    Place d = 0;
    std::array<Place, 7> operands{};
  };

  static constexpr int number_bits = 20;
  static Place place(std::size_t block, int row);
  static double* address(Place place, double* const* blocks) {
    return blocks[place >> number_bits] + (place & ((1u << number_bits) - 1));
  }
  template <int shape>
  static void run_chain(Vector before, const Step* step, double* const* blocks);
  template <Code code>
  static void run_alone(Vector before, const Step* step, double* const* blocks);
  static void finish(Vector, const Step*, double* const*) {}

  Rows own_;                     // block 0: constants and scratch
  std::vector<double*> blocks_;  // followed by the caller's blocks
  std::vector<Step> steps_;
};

}  // namespace sightline
