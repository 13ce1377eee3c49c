#include <array>
#include <cassert>
#include <map>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {
namespace {

/// Lowers the live part of a graph to instructions over rows; rows are numbered once their kinds
/// are known.
class Lowering {
 public:
  Lowering(const Graph& graph, std::span<const Term> outputs)
      : graph_(graph), outputs_(outputs), order_(graph.in_order(outputs)) {
    count_uses();
    choose_fusions();
    choose_negated();
    last_use_.assign(uses_.size(), -1);
    order_and_lifetimes();
  }

  void emit(int inputs, std::vector<double>& constants, std::vector<Instruction>& out, int& scratch) {
    for (const int v : order_) {
      if (node(at(v)).op == Op::constant) {
        row_[v] = inputs + static_cast<int>(constants.size());
        constants.push_back(node(at(v)).value);
      } else if (node(at(v)).op == Op::input) {
        assert(node(at(v)).value < inputs && "an input of the formula lies outside the program's inputs");
        row_[v] = static_cast<int>(node(at(v)).value);
      }
    }
    first_scratch_ = inputs + static_cast<int>(constants.size());
    for (const int v : order_) {
      if (is_computed(at(v))) lower(v, out);
    }
    scratch = scratch_;
    const int first_output = first_scratch_ + scratch_;
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const bool negate = outputs_[i].negative && !negated_[index(outputs_[i])];
      out.push_back({.code = negate ? Code::negate : Code::copy,
                     .d = first_output + static_cast<int>(i),
                     .a = row_.at(outputs_[i].node)});
    }
  }

 private:
  const Node& node(std::size_t v) const { return graph_.nodes()[v]; }
  const Node& node(Term t) const { return graph_.node(t); }
  std::size_t index(Term t) const { return at(t.node); }
  bool is_computed(std::size_t v) const {
    return !fused_[v] && node(v).op != Op::input && node(v).op != Op::constant;
  }

  void count_uses() {
    uses_.assign(static_cast<std::size_t>(graph_.size()), 0);
    for (const Term t : outputs_) ++uses_[index(t)];
    for (const int v : order_) {
      const Node& n = node(at(v));
      if (n.op == Op::input || n.op == Op::constant) continue;
      ++uses_[index(n.a)];
      if (n.b.node >= 0) ++uses_[index(n.b)];
    }
  }

  /// A product used by one sum alone is fused into that sum.
  void choose_fusions() {
    fused_.assign(uses_.size(), false);
    product_of_.assign(uses_.size(), Term{});
    for (const int live : order_) {
      const std::size_t v = at(live);
      if (node(v).op != Op::add) continue;
      const auto fusible = [&](Term t) { return node(t).op == Op::multiply && uses_[index(t)] == 1; };
      const Node& n = node(v);
      const Term product = fusible(n.b) ? n.b : fusible(n.a) ? n.a : Term{};
      if (product.node < 0) continue;
      product_of_[v] = product;
      fused_[index(product)] = true;
    }
  }

  /// A difference used by one output alone, with a minus, is computed with its operands exchanged.
  void choose_negated() {
    negated_.assign(uses_.size(), false);
    for (const Term t : outputs_) {
      const bool difference = node(t).op == Op::add && node(t).b.negative;
      if (t.negative && difference && uses_[index(t)] == 1) negated_[index(t)] = true;
    }
  }

  template <class Visit>
  void for_each_operand(std::size_t v, Visit&& visit) const {
    const Node& n = node(v);
    if (product_of_[v].node >= 0) {
      const Node& product = node(product_of_[v]);
      visit(product.a);
      visit(product.b);
      visit(product_of_[v].node == n.b.node ? n.a : n.b);
      return;
    }
    visit(n.a);
    if (n.b.node >= 0) visit(n.b);
  }

  void order_and_lifetimes() {
    for (const int v : order_) {
      if (!is_computed(at(v))) continue;
      for_each_operand(at(v), [&](Term t) { last_use_[index(t)] = v; });
    }
    for (const Term t : outputs_) last_use_[index(t)] = graph_.size();
  }

  int take_row() {
    if (free_.empty()) return first_scratch_ + scratch_++;
    const int row = free_.back();
    free_.pop_back();
    return row;
  }

  void lower(int v, std::vector<Instruction>& out) {
    const Node& n = node(static_cast<std::size_t>(v));
    const bool negated = negated_[static_cast<std::size_t>(v)];
    Instruction i{};
    const auto row = [&](Term t) { return row_.at(t.node); };
    std::array<int, 2> minus = {-1, -1};  // scratch for the negations of operands
    const auto operand = [&](Term t) {
      if (!t.negative) return row(t);
      int& place = minus[minus[0] < 0 ? 0 : 1];
      place = take_row();
      out.push_back({.code = Code::negate, .d = place, .a = row(t)});
      return place;
    };
    if (const Term product = product_of_[static_cast<std::size_t>(v)]; product.node >= 0) {
      const bool second = product.node == n.b.node;
      const Term rest = second ? n.a : n.b;
      i = {.code = Code::multiply_add, .a = row(node(product).a), .b = row(node(product).b), .c = row(rest)};
      if (n.b.negative) i.code = second != negated ? Code::subtract_product : Code::multiply_subtract;
    } else {
      switch (n.op) {
        case Op::input:
        case Op::constant:
          return;
        case Op::add:
          i = {.code = n.b.negative ? Code::subtract : Code::add, .a = row(n.a), .b = row(n.b)};
          if (negated) std::swap(i.a, i.b);
          break;
        case Op::multiply:
          i = {.code = Code::multiply, .a = row(n.a), .b = row(n.b)};
          break;
        case Op::reciprocal:
          i = {.code = Code::reciprocal, .a = row(n.a)};
          break;
        case Op::square_root:
          i = {.code = Code::square_root, .a = operand(n.a)};
          break;
        case Op::exponential:
          i = {.code = Code::exponential, .a = operand(n.a)};
          break;
        case Op::logistic:
          i = {.code = Code::logistic, .a = row(n.a)};
          break;
        case Op::relaxed_log:
          i = {.code = Code::relaxed_log, .a = operand(n.a)};
          break;
        case Op::sine:
          i = {.code = Code::sine, .a = row(n.a)};
          break;
        case Op::cosine:
          i = {.code = Code::cosine, .a = row(n.a)};
          break;
        case Op::maximum:
        case Op::angle: {
          const int a = operand(n.a);
          i = {.code = n.op == Op::angle ? Code::angle : Code::maximum, .a = a, .b = operand(n.b)};
          break;
        }
        case Op::logarithm:
          i = {.code = Code::logarithm, .a = operand(n.a)};
          break;
        case Op::softplus:
          i = {.code = Code::softplus, .a = operand(n.a)};
          break;
      }
    }
    // Operands used here for the last time release their rows to the result.
    for (const int place : minus) {
      if (place >= 0) free_.push_back(place);
    }
    for_each_operand(static_cast<std::size_t>(v), [&](Term t) {
      if (last_use_[index(t)] != v) return;
      last_use_[index(t)] = -1;
      if (row(t) >= first_scratch_) free_.push_back(row(t));
    });
    i.d = take_row();
    row_[v] = i.d;
    out.push_back(i);
  }

  const Graph& graph_;
  std::span<const Term> outputs_;
  std::vector<int> order_;  // live nodes
  std::vector<int> uses_;
  std::vector<bool> fused_, negated_;
  std::vector<Term> product_of_;  // the fused product of a sum
  std::vector<int> last_use_;
  std::map<int, int> row_;
  std::vector<int> free_;
  int first_scratch_ = 0, scratch_ = 0;
};

}  // namespace

Program::Program(const Graph& graph, std::span<const Term> outputs, int inputs)
    : inputs_(inputs), outputs_(static_cast<int>(outputs.size())) {
  Lowering(graph, outputs).emit(inputs, constants_, instructions_, scratch_);
}

}  // namespace sightline
