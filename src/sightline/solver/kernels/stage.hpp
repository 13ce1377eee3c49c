/// One stage of the Newton step, traced once from a model: five short programs that know nothing of matrices.
///
/// The Riccati stage (riccati.hpp) is written once, as dense loops over any scalar. Run on the recording scalar, zeros
/// of A, B, J fold away, and what is left is the sparse code one would have written by hand. The model's numbers and
/// h are parameters: but for a parameter that is zero, no value of them changes the programs.
/// Derivation: docs/equations.md, 11.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/formula/emit.hpp"
#include "sightline/model/model.hpp"
#include "sightline/potential/relaxed_barrier.hpp"

namespace sightline {

/// What the couplings see of a robot, and so the space in which they are formed.
enum class Seen {
  pose,             ///< p, d: 5 numbers
  pose_and_motion,  ///< p, d, v: 8 numbers; v depends on u
  leaning,  ///< p, d, v and the lean, which may depend on u: 10 numbers; no potential multiplies v by the lean
  all,      ///< the same, whatever the potentials are
};

constexpr int seen_size(Seen seen) {
  return seen == Seen::pose ? 5 : seen == Seen::pose_and_motion ? 8 : sight_size;
}

/// A program whose inputs and outputs stand in blocks, one after the other.
struct BlockProgram {
  Program program;
  std::vector<Block> inputs, outputs;
};

/// Numbers in the blocks of a model's programs; s is what is seen, a symmetric n x n matrix has n (n + 1)
/// / 2.
struct StageSizes {
  int nx = 0, nu = 0, ns = 0;
  int stored = 0;  ///< distinct entries of A, B, J that change
  int before =
      0;  ///< of the states, inputs of the stage before: the last ones, where their rate costs; else none

  constexpr int weights() const { return nx + 2 * nu + 1; }  ///< 2 h Q, 2 h R, u*, rho
  constexpr int coupling() const {
    return ns + ns * (ns + 1) / 2;
  }  ///< gradient and Hessian with respect to s
  constexpr int gain() const { return nu + nu * (nu - 1) / 2 + nu * nx + stored; }  ///< D^-1, L, K, stored
  constexpr int carry() const { return 1 + 2 * nx + nx * (nx + 1) / 2; }  ///< pivot_shift, lambda, e, P

  bool operator==(const StageSizes&) const = default;
};

/// The programs of one model at one stage length h. Each stage's Hamiltonian, times h, is
/// Phi = h l(x, u) + lambda' (x + h f) + c' s(x, u), with c the gradient of all potentials; l holds the robot's
/// tracking cost and its barriers.
///
///   step        x, u -> x + h f, s
///   back        x, u, x*, held, weights, coupling, carry -> H_u, gain, k, carry of the stage before
///   back_first  the same at stage 0: the carry is `pivot_shift` alone
///   precondition_back      p, r, gain -> p of the stage before, k       right side r in s
///   precondition_forward   y, gain, k -> du, y of the next stage, change of s
///
/// H_u is Phi_u (times h, that is). `held` is an input's extra weight: infinity where its limit is active, 0
/// where it is free; `pivot_shift` > 0 says that a pivot was below its floor at some stage so far. du = -(k + K y), each
/// entry in a unit of its own.
struct StagePrograms {
  StageSizes sizes;
  BlockProgram step, back, back_first, precondition_back, precondition_forward;

  std::array<const BlockProgram*, 5> all() const {
    return {&step, &back, &back_first, &precondition_back, &precondition_forward};
  }
};

/// A pivot of the Riccati factorisation below this, per h and with the input in its scale, is not trusted.
inline constexpr double pivot_floor = 1e-3;

/// A cost of the rate of inputs, du/dt' diag(R) du/dt. The inputs of the stage before are states then, the last ones, which
/// become u in a step; Phi has R (u - before)^2 / h besides, or / first at stage 0, whose input was in force `first` before.
struct RateCost {
  std::span<const double> R{};  ///< nu, parameters; empty: none
  double first = 0.0;           ///< [s]
};

/// The first of the programs alone: equal ones belong to equal models.
BlockProgram trace_step(const Model& model, double h, Seen seen);

/// The sum of barriers alone, over (x, u): equal ones belong to equal limits.
Program trace_barriers(const Model& model, std::span<const RelaxedBarrier> barriers);

/// @param scales  of the inputs, in which rho and the least pivot are meant (nu), parameters too; empty: 1
StagePrograms trace_stage(const Model& model, double h, Seen seen,
                          std::span<const RelaxedBarrier> barriers = {}, std::span<const double> scales = {},
                          const RateCost& rates = {});

/// The same for models that differ in the values of their parameters alone.
std::uint64_t structure(const StagePrograms& programs);
/// The sum of all five.
ProgramSize size_of(const StagePrograms& programs);

}  // namespace sightline
