/// Symbolic gradient and Hessian of a formula, in its own graph.
///
/// One reverse sweep with edge pushing (Gower and Mello 2012) computes both. It pushes second
/// derivatives from a node to its operands together with the adjoint. It therefore visits only
/// interacting pairs, and value, gradient and Hessian share all common parts.
#pragma once

#include <span>
#include <vector>

#include "sightline/formula/graph.hpp"

namespace sightline {

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

}  // namespace sightline
