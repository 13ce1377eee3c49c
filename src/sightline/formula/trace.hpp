/// The recording scalar: arithmetic on it appends to a graph.
///
/// A formula that is a template over its scalar runs once on `Symbol`. The resulting graph yields
/// value, gradient and Hessian. Comparisons are missing on purpose: a recorded formula is one
/// expression, valid everywhere.
#pragma once

#include <vector>

#include "sightline/base/elementary.hpp"
#include "sightline/formula/graph.hpp"

namespace sightline {

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

}  // namespace sightline
