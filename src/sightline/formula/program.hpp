/// A graph's outputs as a short list of instructions: dead nodes dropped, products fused into sums,
/// memory reused.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/formula/graph.hpp"

namespace sightline {

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

}  // namespace sightline
