/// One stage of the Newton step, traced once from a model: five short scalar programs without
/// matrices.
///
/// The Riccati stage (riccati.hpp) is written once, as dense loops over any scalar. On the
/// recording scalar, zeros of A, B, J fold; the result is the sparse code of one model. The model's
/// numbers and h are parameters: except for zeros, no value changes the programs. Derivation:
/// docs/equations.md, 11.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/formula/emit.hpp"
#include "sightline/model/model.hpp"
#include "sightline/potential/relaxed_barrier.hpp"

namespace sightline {

/// Components of a robot's Sight that the couplings depend on: the space of their derivatives.
enum class Seen {
  pose,             ///< p, d: 5 numbers
  pose_and_motion,  ///< p, d, v: 8 numbers; v depends on u
  /// p, d, v and the tilt, which may depend on u: 10 numbers; no potential multiplies v by the tilt
  leaning,
  all,  ///< as `leaning`, for arbitrary potentials
};

constexpr int seen_size(Seen seen) {
  return seen == Seen::pose ? 5 : seen == Seen::pose_and_motion ? 8 : sight_size;
}

/// Program whose inputs and outputs form consecutive blocks.
struct BlockProgram {
  Program program;
  std::vector<Block> inputs, outputs;
};

/// Sizes of the blocks of a model's programs. s is the coupled part of the Sight; a symmetric n x n
/// matrix has n (n + 1) / 2 numbers.
struct StageSizes {
  int nx = 0, nu = 0, ns = 0;
  int stored = 0;  ///< distinct non-constant entries of A, B, J
  int before =
      0;  ///< trailing states that hold the inputs of the previous stage, if their rate has a cost; else 0

  constexpr int weights() const { return nx + 2 * nu + 1; }  ///< 2 h Q, 2 h R, u*, rho
  constexpr int coupling() const {
    return ns + ns * (ns + 1) / 2;
  }  ///< gradient and Hessian with respect to s
  constexpr int gain() const { return nu + nu * (nu - 1) / 2 + nu * nx + stored; }  ///< D^-1, L, K, stored
  constexpr int carry() const { return 1 + 2 * nx + nx * (nx + 1) / 2; }  ///< pivot_shift, lambda, e, P

  bool operator==(const StageSizes&) const = default;
};

/// Programs of one model at one stage length h. The Hamiltonian of a stage, times h, is Phi = h
/// l(x, u) + lambda' (x + h f) + c' s(x, u), with c the gradient of all potentials; l holds the
/// robot's tracking cost and its barriers.
///
///   step        x, u -> x + h f, s
///   back        x, u, x*, held, weights, coupling, carry -> H_u, gain, k, previous stage's carry
///   back_first  the same at stage 0: the carry is `pivot_shift` alone
///   precondition_back      p, r, gain -> p of the previous stage, k       right side r in s
///   precondition_forward   y, gain, k -> du, y of the next stage, change of s
///
/// H_u is Phi_u, hence includes the factor h. `held` is an additional weight of an input: infinity
/// if its limit is active, 0 if it is free. `pivot_shift` > 0: a pivot was below its floor at one
/// of the stages so far. du = -(k + K y), each entry in its own unit.
struct StagePrograms {
  StageSizes sizes;
  BlockProgram step, back, back_first, precondition_back, precondition_forward;

  std::array<const BlockProgram*, 5> all() const {
    return {&step, &back, &back_first, &precondition_back, &precondition_forward};
  }
};

/// Minimum accepted pivot of the Riccati factorisation, per h and with the input in its scale.
inline constexpr double pivot_floor = 1e-3;

/// Cost of the input rates, du/dt' diag(R) du/dt. The trailing states then hold the inputs of the
/// previous stage; a step sets them to u. Phi gains R (u - before)^2 / h; at stage 0 the divisor is
/// `first`, the time for which the previous input was in force.
struct RateCost {
  std::span<const double> R{};  ///< nu, parameters; empty: none
  double first = 0.0;           ///< time since the previous input at stage 0 [s]
};

/// The step program alone; equal programs belong to equal models.
BlockProgram trace_step(const Model& model, double h, Seen seen);

/// The sum of barriers alone, over (x, u); equal programs belong to equal limits.
Program trace_barriers(const Model& model, std::span<const RelaxedBarrier> barriers);

/// @param scales  of the inputs, units of rho and of the pivot floor (nu), parameters too; empty: 1
StagePrograms trace_stage(const Model& model, double h, Seen seen,
                          std::span<const RelaxedBarrier> barriers = {}, std::span<const double> scales = {},
                          const RateCost& rates = {});

/// Structure hash: equal for models that differ only in parameter values.
std::uint64_t structure(const StagePrograms& programs);
/// Sum of the sizes of all five programs.
ProgramSize size_of(const StagePrograms& programs);

}  // namespace sightline
