/// The operation of each instruction, over any scalar: the one table for all interpreters of
/// programs. The C++ text that emit.cpp prints is equivalent.
#pragma once

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {

/// Number of codes; the last is `angle`.
inline constexpr int codes = static_cast<int>(Code::angle) + 1;

/// Number of operands a, b, c that a code reads, in that order.
constexpr int operand_count(Code code) {
  switch (code) {
    case Code::add:
    case Code::subtract:
    case Code::multiply:
    case Code::maximum:
    case Code::angle:
      return 2;
    case Code::multiply_add:
    case Code::multiply_subtract:
    case Code::subtract_product:
      return 3;
    default:
      return 1;
  }
}

/// The result of an instruction; operands beyond operand_count(code) are ignored.
template <Code code, class L>
L operation(L a, [[maybe_unused]] L b, [[maybe_unused]] L c) {
  if constexpr (code == Code::copy) return a;
  if constexpr (code == Code::negate) return -a;
  if constexpr (code == Code::add) return a + b;
  if constexpr (code == Code::subtract) return a - b;
  if constexpr (code == Code::multiply) return a * b;
  if constexpr (code == Code::multiply_add) return fma(a, b, c);
  if constexpr (code == Code::multiply_subtract) return multiply_subtract(a, b, c);
  if constexpr (code == Code::subtract_product) return subtract_product(a, b, c);
  if constexpr (code == Code::reciprocal) return L(1.0) / a;
  if constexpr (code == Code::square_root) return sqrt(a);
  if constexpr (code == Code::exponential) return exp(a);
  if constexpr (code == Code::logistic) return logistic(a);
  if constexpr (code == Code::relaxed_log) return relaxed_log(a);
  if constexpr (code == Code::sine) return sin(a);
  if constexpr (code == Code::cosine) return cos(a);
  if constexpr (code == Code::maximum) return maximum(a, b);
  if constexpr (code == Code::logarithm) return log(a);
  if constexpr (code == Code::softplus) return softplus(a);
  if constexpr (code == Code::angle) return atan2(a, b);
}

}  // namespace sightline
