/// What printed functions of models and potentials include, and the generator that prints them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/model.hpp"
#include "sightline/potential.hpp"
#include "sightline/team.hpp"

namespace sightline {

// One stage of the Newton step, traced once from a model: five short scalar programs without
// matrices.
//
// The Riccati stage (solver/kernels/riccati.hpp) is written once, as dense loops over any scalar. On the
// recording scalar, zeros of A, B, J fold; the result is the sparse code of one model. The model's
// numbers and h are parameters: except for zeros, no value changes the programs. Derivation:
// docs/equations.md, 11.

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

// Potentials between two bodies in the solver's form: gradient and Hessian over the Sights of both
// bodies.

/// Which of the two bodies are controlled, and on which the potentials act.
struct Ends {
  bool a_is_agent = true, b_is_agent = true;
  bool a_feels = true, b_feels = true;
};

/// h times a weighted sum of potentials over the Sights of a and b.
///
/// Relative form (frequent): the potential depends on r = p_a - p_b and the heading of a alone.
/// Then the variables are (r, d_a), 5 numbers; `derivatives` gives the gradient (5) and the upper
/// triangle of the Hessian (15); the entry lists are empty. Otherwise the variables are those of
/// (s_a, s_b, t, uncertainty of a, position of the third body) that occur.
struct PosePotential {
  static constexpr int relative_size = 5;
  /// s_a is 0 .. 9, s_b 10 .. 19; then variables independent of the inputs of a and b: the time,
  /// the uncertainty of a, the position of the third body.
  static constexpr int time_variable = 2 * sight_size, uncertainty_variable = time_variable + 1,
                       third_variable = uncertainty_variable + 1, variable_count = third_variable + 3;

  struct First {
    int variable, output;
    bool negative;
  };
  struct Second {
    int row, column, output;
    bool negative;
  };

  bool relative = false;
  std::vector<int>
      variables;        ///< of (s_a, s_b, t, uncertainty, third), inputs of both programs in this order
  Program value;        ///< one output
  Program derivatives;  ///< every entry of the lists below, once up to sign
  std::vector<Program> others;     ///< relative form: derivatives to be added, compiled separately
  std::vector<std::string> names;  ///< of the potentials in `derivatives`, then of each of `others`
  std::vector<First> gradient;     ///< for the bodies it acts on
  std::vector<Second> own;         ///< Hessian within a body it acts on, row <= column
  std::vector<Second> cross;       ///< Hessian between a (row) and b (column), if both are agents

  /// Components of the Sight of a or b that the potential depends on, including all preceding ones.
  Seen sees(bool of_b) const;
};

/// Treatment of a formula's numbers while it is traced.
enum class Numbers {
  known,       ///< folded as constants: shortest program, valid for these numbers only
  parameters,  ///< kept as parameters: one program for all numbers
};

/// @param terms  potentials between the same bodies, acting on the same agents; or of one robot
///   alone, a. Their order does not matter.
PosePotential trace_potential(std::span<const Weighted* const> terms, double h, const Ends& ends,
                              Numbers numbers = Numbers::known);

/// Change of the gradient of potentials along a step ds of the bodies that feel them, by what it
/// depends on: derivatives of D = h (l_a' ds_a + l_b' ds_b), l the weighted sum.
struct PotentialSlopes {
  /// Whether l = l(p_a - p_b, d_a); then the variables and the step are those of this argument.
  bool relative = false;
  /// Inputs: of (s_a, s_b, t, uncertainty, third) as in PosePotential, then entries of the step.
  std::vector<int> variables, along;
  /// Outputs: for each term, in this order, by its weight and by each of Potential::numbers(); then
  /// by these variables, which are of uncontrolled bodies.
  std::vector<std::size_t> order;
  std::vector<int> uncontrolled;
  Program program;
};

/// @param terms  potentials between the same bodies, felt by the same; or of one robot alone, a
PotentialSlopes trace_slopes(std::span<const Weighted* const> terms, double h, const Ends& ends,
                             bool third_is_agent);

/// Whether a program was printed and compiled.
using IsCompiled = std::function<bool(const Program&)>;

/// Potential between two bodies, given by index in the team.
struct BodyPotential {
  int a = -1, b = -1;  ///< agents; -1: not controlled
  int body_a = -1, body_b = -1;
  int third = -1, third_body = -1;  ///< as a and body_a; -1: none
  Ends ends;
  PosePotential potential;
  Ramp ramp{};
};

/// The potentials of a team, pair by pair and robot by robot. The terms of a pair form one program
/// if it was compiled; else they split into compiled programs and a remainder with folded numbers.
std::vector<BodyPotential> trace_potentials(const Ocp& ocp, const IsCompiled& is_compiled = {});

/// h times the weighted potential of a swarm, over the difference of two poses (p_a - p_b, d_a -
/// d_b), 5 numbers. `derivatives` gives the gradient (5) and the upper triangle of the Hessian (15)
/// for a. For b the gradient is negated and the Hessian equal; the block between a and b is the
/// negated Hessian.
struct SwarmPotential {
  std::vector<int> agents;  ///< in the order of the team's agents
  double radius = 0.0;
  int capacity = 0;
  bool sees_headings = false;
  std::string name;
  Program value, derivatives;
};

SwarmPotential trace_swarm(const Weighted& term, double h, Numbers numbers);
std::vector<SwarmPotential> trace_swarms(const Ocp& ocp, const IsCompiled& is_compiled = {});

// Generator of a C++ file with the compiled functions of models and potentials, for `KernelTable`.

class Generator {
 public:
  /// Generates user functions, which register with the library's before main.
  Generator() = default;
  /// Generates one part of the library's own functions, to be listed by `index`.
  explicit Generator(std::string part) : part_(std::move(part)) {}

  /// Text of the file that chains the library's parts to one table, built_in_kernels().
  static std::string index(std::span<const Generator> parts);

  /// Adds the stage programs of a model with these barriers, in this order, and with a cost of
  /// input rates; independent of their numbers.
  void add(const Model& model, Seen seen, const std::vector<RelaxedBarrier>& barriers = {},
           const RateCost& rates = {});
  /// Adds the sum of potentials between two bodies, or of one robot, independent of their numbers
  /// and order: acting on both bodies, on either, and with an uncontrolled second body.
  void add(const std::vector<Weighted>& terms);
  /// Adds their PotentialSlopes between two robots.
  void add_slopes(const std::vector<Weighted>& terms);
  /// Adds the potential of a swarm, independent of its numbers.
  void add_swarm(const Weighted& term);

  /// Text of the generated file.
  std::string text() const;
  const std::string& part() const { return part_; }

 private:
  void add(const Program& program, std::string_view potential_name);

  std::string part_;  // empty: user functions
  std::set<std::uint64_t> known_;
  std::string functions_, stage_rows_, formula_rows_;
};

/// Writes a file unless it already holds this text, so that no rebuild is triggered.
/// @return whether the file holds the text
[[nodiscard]] bool write_text(const std::string& path, std::string_view text);

// The five stage functions of a model, either printed at build time or interpreted. Both give the
// same bits.
//
// Blocks are arrays of packs, [entry][lane]; StagePrograms documents their contents.

/// Values that a sweep carries from stage to stage. Each pack is set separately, so that the
/// compiler can keep it in a register.
template <int W, int n>
class PacksInRegisters {
 public:
  explicit PacksInRegisters(const double* from) {
    each([&](std::size_t i) { packs_[i] = Lane<W>::load(from + i * W); });
  }
  double* numbers() { return reinterpret_cast<double*>(packs_); }
  void store(double* to, int) {
    each([&](std::size_t i) { packs_[i].store(to + i * W); });
  }
  void take(PacksInRegisters& next) {
    each([&](std::size_t i) { packs_[i] = next.packs_[i]; });
  }

 private:
  template <class Set>
  [[gnu::always_inline]] static void each(Set&& set) {
    [&]<std::size_t... i>(std::index_sequence<i...>) { (set(i), ...); }
    (std::make_index_sequence<n>());
  }
  Lane<W> packs_[n];
};

class PacksInMemory {
 public:
  explicit PacksInMemory(double* memory) : numbers_(memory) {}
  double* numbers() { return numbers_; }
  void store(double* to, int numbers) { std::copy_n(numbers_, numbers, to); }
  void take(PacksInMemory& next) { std::swap(numbers_, next.numbers_); }

 private:
  double* numbers_;
};

/// Functions printed by `emit`, as static members of F, with the constants of one model.
template <int W, class F>
class CompiledStage {
 public:
  static constexpr StageSizes sizes() { return F::sizes; }

  using State = PacksInRegisters<W, F::sizes.nx>;
  /// Far more packs than a machine's 32 registers stay in memory: they would be copied at each stage.
  using Carry =
      std::conditional_t<(F::sizes.carry() > 36), PacksInMemory, PacksInRegisters<W, F::sizes.carry()>>;

  explicit CompiledStage(const StagePrograms& programs) : programs_(programs) {}

  void step(const double* x, const double* u, double* x_next, double* s) {
    F::template step<Lane<W>>(constants(programs_.step), x, u, x_next, s);
  }
  [[gnu::always_inline]] void back(const double* x, const double* u, const double* x_ref, const double* held,
                                   const double* weights, const double* coupling, const double* carry,
                                   double* H_u, double* gain, double* k, double* carry_out) {
    F::template back<Lane<W>>(constants(programs_.back), x, u, x_ref, held, weights, coupling, carry, H_u,
                              gain, k, carry_out);
  }
  void back_first(const double* x, const double* u, const double* x_ref, const double* held,
                  const double* weights, const double* coupling, const double* carry, double* H_u,
                  double* gain, double* k, double* carry_out) {
    F::template back_first<Lane<W>>(constants(programs_.back_first), x, u, x_ref, held, weights, coupling,
                                    carry, H_u, gain, k, carry_out);
  }
  void precondition_back(const double* p, const double* r, const double* gain, double* p_out, double* k) {
    F::template precondition_back<Lane<W>>(constants(programs_.precondition_back), p, r, gain, p_out, k);
  }
  /// k and du may share memory.
  void precondition_forward(const double* y, const double* gain, const double* k, double* du, double* y_out,
                            double* ds) {
    PacksInRegisters<W, F::sizes.nu> its(k);
    F::template precondition_forward<Lane<W>>(constants(programs_.precondition_forward), y, gain,
                                              its.numbers(), du, y_out, ds);
  }

 private:
  static const double* constants(const BlockProgram& p) { return p.program.constants().data(); }

  const StagePrograms& programs_;
};

/// Interpreter of a block program.
template <int W>
class InterpretedBlocks : public Threaded<W> {
 public:
  explicit InterpretedBlocks(const BlockProgram& p)
      : Threaded<W>(p.program, sizes(p.inputs), sizes(p.outputs)) {}

 private:
  static std::vector<int> sizes(const std::vector<Block>& blocks) {
    std::vector<int> list;
    for (const Block& b : blocks) list.push_back(b.size);
    return list;
  }
};

template <int W>
class InterpretedStage {
 public:
  StageSizes sizes() const { return sizes_; }

  using State = PacksInMemory;
  using Carry = PacksInMemory;

  explicit InterpretedStage(const StagePrograms& p)
      : sizes_(p.sizes),
        step_(p.step),
        back_(p.back),
        back_first_(p.back_first),
        precondition_back_(p.precondition_back),
        precondition_forward_(p.precondition_forward),
        k_(1, p.sizes.nu * W) {}

  void step(const double* x, const double* u, double* x_next, double* s) { step_.run({x, u}, {x_next, s}); }
  void back(const double* x, const double* u, const double* x_ref, const double* held, const double* weights,
            const double* coupling, const double* carry, double* H_u, double* gain, double* k,
            double* carry_out) {
    back_.run({x, u, x_ref, held, weights, coupling, carry}, {H_u, gain, k, carry_out});
  }
  void back_first(const double* x, const double* u, const double* x_ref, const double* held,
                  const double* weights, const double* coupling, const double* carry, double* H_u,
                  double* gain, double* k, double* carry_out) {
    back_first_.run({x, u, x_ref, held, weights, coupling, carry}, {H_u, gain, k, carry_out});
  }
  void precondition_back(const double* p, const double* r, const double* gain, double* p_out, double* k) {
    precondition_back_.run({p, r, gain}, {p_out, k});
  }
  void precondition_forward(const double* y, const double* gain, const double* k, double* du, double* y_out,
                            double* ds) {
    std::copy_n(k, sizes_.nu * W, k_[0]);
    precondition_forward_.run({y, gain, k_[0]}, {du, y_out, ds});
  }

 private:
  StageSizes sizes_;
  InterpretedBlocks<W> step_, back_, back_first_, precondition_back_, precondition_forward_;
  Rows k_;
};

// Agents of one model side by side in lanes: roll-out, Riccati factorisation and solves with it.
//
// Trajectories are [stage][entry][lane]. The coupled Sight components (s) and the coupling
// derivatives (c) are one array of the team; each group owns a part.

class Group {
 public:
  Group(std::shared_ptr<const StagePrograms> programs, int stages, int width)
      : programs_(std::move(programs)), sizes_(programs_->sizes), stages_(stages), width_(width) {}
  virtual ~Group() = default;
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;

  const StageSizes& sizes() const { return sizes_; }

  /// Assigns memory: `room()` doubles, aligned as Rows; must outlive the object. Call first.
  void settle(double* memory) noexcept {
    each_row([&](Rows& rows, int n, int packs) {
      rows = Rows(n, packs * width_, memory);
      memory += Rows::room(n, packs * width_);
    });
  }
  std::ptrdiff_t room() noexcept {
    std::ptrdiff_t sum = 0;
    each_row([&](Rows&, int n, int packs) { sum += Rows::room(n, packs * width_); });
    return sum;
  }

  /// One number of one agent: state of stage k; reference of stage k; 2 h Q, 2 h R, u*, rho; Q_f.
  double x(int k, int i, int lane) const { return *(x_[0] + at(k, sizes_.nx, i, lane)); }
  double& x(int k, int i, int lane) { return *(x_[0] + at(k, sizes_.nx, i, lane)); }
  double& x_ref(int k, int i, int lane) { return *(x_ref_[0] + at(k, sizes_.nx, i, lane)); }
  /// Whether all its agents use the reference of stage 0 at all stages; the others are then not
  /// read.
  void hold_reference(bool holds) { ref_stage_ = holds ? 0 : sizes_.nx * width_; }
  double& weight(int i, int lane) { return *(weights_[0] + at(0, 0, i, lane)); }
  double& Q_f(int i, int lane) { return *(Q_f_[0] + at(0, 0, i, lane)); }
  double& rho(int lane) { return weight(sizes_.nx + 2 * sizes_.nu, lane); }

  /// Copies the states of all stages of the agents in lanes 0 .. n - 1, each stage by stage.
  virtual void copy_states(double* const* to, std::ptrdiff_t stage, int n) const noexcept = 0;

  /// Tracking cost of each lane's agent along the trajectory, times h; the x_0 part is constant.
  virtual void tracking_costs(const double* u, double* of_lanes) const noexcept = 0;

  /// x of all stages from x of stage 0 under u; s of all stages but the last.
  virtual void roll_out(const double* u, double* s) noexcept = 0;
  /// Backward sweep at the trajectory of the last roll-out, with the couplings' gradients and
  /// Hessians c.
  /// @param H_u  h times the gradient of the Hamiltonian of all stages
  /// @param k    of the step du = -(k + K y), input of forward()
  /// @return whether all pivots reached their floor; pivots_shifted() identifies the other lanes
  virtual bool backward(const double* u, const double* held, const double* c, double* H_u,
                        double* k) noexcept = 0;
  bool pivots_shifted(int lane) const { return !(pivot_shift_[0][lane] <= 0.0); }
  /// Writes du over k of the backward sweep, and the change of s along the horizon.
  virtual void forward(double* du, double* ds) noexcept = 0;
  /// Solves with the last factorisation for the right side r in s.
  virtual void precondition(const double* r, double* du, double* ds) noexcept = 0;

  /// Solves with the last factorisation for the right side r in s and g in the inputs of stage 0.
  /// @param g  (nu packs)
  /// @param r  null: zero
  /// @param y  change of the states along the horizon  (N+1 x nx packs)
  /// @param p  costate of stage 0: the derivative, by x_0, of du' times the gradient of the
  ///   Lagrangian  (nx packs)
  virtual void adjoint(const double* g, const double* r, double* du, double* ds, double* y,
                       double* p) noexcept = 0;
  /// Derivatives of du' times the gradient of the Lagrangian at the last roll-out, under u, by a
  /// shift of x* at all stages (nx), u* (nu), Q (nx), R (nu), Q_f (nx), R_rate (before), in packs.
  /// @param first  time for which the previous input was in force [s]; h [s] of the horizon
  virtual void own_slopes(const double* u, const double* du, const double* y, double h, double first,
                          double* slopes) const noexcept = 0;
  int slopes() const { return 3 * sizes_.nx + 2 * sizes_.nu + sizes_.before; }

 protected:
  std::ptrdiff_t at(int k, int n, int i, int lane) const {
    return (static_cast<std::ptrdiff_t>(k) * n + i) * width_ + lane;
  }

  std::shared_ptr<const StagePrograms> programs_;
  StageSizes sizes_;
  int stages_, width_;
  std::ptrdiff_t ref_stage_ = sizes_.nx * width_;  // stride of the reference between stages
  Rows x_, x_ref_, weights_, Q_f_, gain_, carry_, pivot_shift_;

 private:
  /// f(rows, number of rows, packs per row)
  template <class F>
  void each_row(F&& f) {
    f(x_, 1, (stages_ + 1) * sizes_.nx);
    f(x_ref_, 1, (stages_ + 1) * sizes_.nx);
    f(weights_, 1, sizes_.weights());
    f(Q_f_, 1, sizes_.nx);
    f(gain_, 1, stages_ * sizes_.gain());
    f(carry_, 2, sizes_.carry());
    f(pivot_shift_, 1, 1);
  }
};

/// Group that calls the functions of a kernel.
template <int W, class Kernel>
class StageGroup final : public Group {
 public:
  StageGroup(std::shared_ptr<const StagePrograms> programs, int stages)
      : Group(std::move(programs), stages, W), kernel_(*programs_) {}

  void roll_out(const double* u, double* s) noexcept override {
    const StageSizes n = kernel_.sizes();
    double* x = x_[0];
    std::copy_n(x, n.nx * W, carry_[0]);
    typename Kernel::State now(carry_[0]), next(carry_[1]);
    for (int k = 0; k < stages_; ++k, u += n.nu * W, s += n.ns * W) {
      x += n.nx * W;
      kernel_.step(now.numbers(), u, next.numbers(), s);
      next.store(x, n.nx * W);
      now.take(next);
    }
  }

  void copy_states(double* const* to, std::ptrdiff_t stage, int n) const noexcept override {
    const int nx = kernel_.sizes().nx, own = nx - kernel_.sizes().before;
    const double* from = x_[0];
    for (int k = 0; k <= stages_; ++k, from += nx * W) {
      if constexpr (W < 8) {  // too few lanes for a transposition
        for (int lane = 0; lane < n; ++lane)
          for (int i = 0; i < own; ++i) to[lane][k * stage + i] = from[i * W + lane];
      } else {
        for (int first = 0; first < own; first += W) {
          const int count = std::min(W, own - first);
          std::array<Lane<W>, static_cast<std::size_t>(W)> of{};
          for (int i = 0; i < count; ++i)
            of[static_cast<std::size_t>(i)] = Lane<W>::load(from + (first + i) * W);
          transpose(of);
          for (int lane = 0; lane < n; ++lane)
            store_first(of[static_cast<std::size_t>(lane)], count, to[lane] + k * stage + first);
        }
      }
    }
  }

  void tracking_costs(const double* u, double* of_lanes) const noexcept override {
    using L = Lane<W>;
    const StageSizes n = kernel_.sizes();
    const auto squares = [](const double* weights, const double* a, const double* b, int count, L sum) {
      for (int i = 0; i < count * W; i += W) {
        const L e = L::load(a + i) - L::load(b + i);
        sum += L::load(weights + i) * e * e;
      }
      return sum;
    };
    const double *const Q = weights_[0], *const R = Q + n.nx * W, *const u_ref = R + n.nu * W;
    const double *x = x_[0], *x_ref = x_ref_[0];
    L running = 0.0;
    for (int k = 0; k < stages_; ++k, x += n.nx * W, x_ref += ref_stage_, u += n.nu * W) {
      running = squares(Q, x, x_ref, n.nx, running);
      running = squares(R, u, u_ref, n.nu, running);
    }
    (L(0.5) * running + squares(Q_f_[0], x, x_ref, n.nx, 0.0)).store(of_lanes);
  }

  bool backward(const double* u, const double* held, const double* c, double* H_u,
                double* k_rows) noexcept override {
    const StageSizes n = kernel_.sizes();
    start_carry(carry_[0]);
    typename Kernel::Carry carry(carry_[0]), next(carry_[1]);
    for (int k = stages_ - 1; k > 0; --k) {
      // Gains are most of what an update writes; no processor foresees writes that go back stage by stage.
      const double* const next_gain = gain_[0] + (k - 1) * n.gain() * W;
      for (int i = 0; i < n.gain() * W; i += row_quantum) __builtin_prefetch(next_gain + i, 1);
      kernel_.back(x_[0] + k * n.nx * W, u + k * n.nu * W, x_ref_[0] + k * ref_stage_, held + k * n.nu * W,
                   weights_[0], c + k * n.coupling() * W, carry.numbers(), H_u + k * n.nu * W,
                   gain_[0] + k * n.gain() * W, k_rows + k * n.nu * W, next.numbers());
      carry.take(next);
    }
    kernel_.back_first(x_[0], u, x_ref_[0], held, weights_[0], c, carry.numbers(), H_u, gain_[0], k_rows,
                       pivot_shift_[0]);
    bool sound = true;
    for (int l = 0; l < W; ++l) sound &= pivot_shift_[0][l] <= 0.0;
    return sound;
  }

  void forward(double* du, double* ds) noexcept override {
    const StageSizes n = kernel_.sizes();
    std::fill_n(carry_[0], n.nx * W, 0.0);
    typename Kernel::State y(carry_[0]), next(carry_[1]);
    for (int k = 0; k < stages_; ++k, du += n.nu * W) {
      kernel_.precondition_forward(y.numbers(), gain_[0] + k * n.gain() * W, du, du, next.numbers(),
                                   ds + k * n.ns * W);
      y.take(next);
    }
  }

  void precondition(const double* r, double* du, double* ds) noexcept override {
    const StageSizes n = kernel_.sizes();
    std::fill_n(carry_[0], n.nx * W, 0.0);
    typename Kernel::State p(carry_[0]), next(carry_[1]);
    for (int k = stages_ - 1; k >= 0; --k) {
      kernel_.precondition_back(p.numbers(), r + k * n.ns * W, gain_[0] + k * n.gain() * W, next.numbers(),
                                du + k * n.nu * W);
      p.take(next);
    }
    forward(du, ds);
  }

  void adjoint(const double* g, const double* r, double* du, double* ds, double* y,
               double* p_first) noexcept override {
    const StageSizes n = kernel_.sizes();
    double *now = carry_[0], *next = carry_[1];
    std::fill_n(now, n.nx * W, 0.0);
    if (r == nullptr) std::fill_n(du, stages_ * n.nu * W, 0.0);
    for (int k = stages_ - 1; k >= 0 && r != nullptr; --k, std::swap(now, next)) {
      kernel_.precondition_back(now, r + k * n.ns * W, gain_[0] + k * n.gain() * W, next, du + k * n.nu * W);
    }
    std::copy_n(now, n.nx * W, p_first);
    std::fill_n(y, n.nx * W, 0.0);
    double* const units = carry_[0];  // a step from rest with k = 1 has du = -unit
    std::fill_n(units, n.nu * W, 1.0);
    kernel_.precondition_forward(y, gain_[0], units, units, y + n.nx * W, ds);
    add_first(units, g, du, p_first);
    for (int k = 0; k < stages_; ++k, y += n.nx * W) {
      double* const of_k = du + k * n.nu * W;
      kernel_.precondition_forward(y, gain_[0] + k * n.gain() * W, of_k, of_k, y + n.nx * W,
                                   ds + k * n.ns * W);
    }
  }

  void own_slopes(const double* u, const double* du, const double* y, double h, double first,
                  double* slopes) const noexcept override {
    using L = Lane<W>;
    const StageSizes n = kernel_.sizes();
    const int own = n.nx - n.before;
    double* next = slopes;
    const auto block = [&](int count) { return std::exchange(next, next + count * W); };
    double *const of_x_ref = block(n.nx), *const of_u_ref = block(n.nu), *const of_Q = block(n.nx);
    double *const of_R = block(n.nu), *const of_Q_f = block(n.nx), *const of_R_rate = block(n.before);
    const double *const Q = weights_[0], *const R = Q + n.nx * W, *const u_ref = R + n.nu * W;
    const double* const x_end = x_[0] + stages_ * n.nx * W;
    const double* const x_ref_end = x_ref_[0] + stages_ * ref_stage_;
    const double* const y_end = y + stages_ * n.nx * W;
    const L twice_h = 2.0 * h;
    for (int i = 0; i < n.nx * W; i += W) {
      L along = 0.0, sum = 0.0;
      for (int k = 0; k < stages_; ++k) {
        const L y_k = L::load(y + k * n.nx * W + i);
        along = fma(L::load(x_[0] + k * n.nx * W + i) - L::load(x_ref_[0] + k * ref_stage_ + i), y_k, along);
        sum += y_k;
      }
      const L end = L(2.0) * L::load(y_end + i);
      (twice_h * along).store(of_Q + i);
      (end * (L::load(x_end + i) - L::load(x_ref_end + i))).store(of_Q_f + i);
      (-(L::load(Q + i) * sum + L::load(Q_f_[0] + i) * end)).store(of_x_ref + i);
    }
    for (int i = 0; i < n.nu * W; i += W) {
      L along = 0.0, sum = 0.0;
      for (int k = 0; k < stages_; ++k) {
        const L du_k = L::load(du + k * n.nu * W + i);
        along = fma(L::load(u + k * n.nu * W + i) - L::load(u_ref + i), du_k, along);
        sum += du_k;
      }
      (twice_h * along).store(of_R + i);
      (-(L::load(R + i) * sum)).store(of_u_ref + i);
    }
    for (int i = 0; i < n.before * W; i += W) {
      L sum = 0.0;
      for (int k = 0; k < stages_; ++k) {
        const std::ptrdiff_t of_u = k * n.nu * W + i, of_x = (k * n.nx + own) * W + i;
        const L change = L::load(u + of_u) - L::load(x_[0] + of_x);
        sum += L(2.0 / (k > 0 ? h : first)) * change * (L::load(du + of_u) - L::load(y + of_x));
      }
      sum.store(of_R_rate + i);
    }
  }

 private:
  /// Adds the right side g in the inputs of stage 0: to k (R + B'PB)^-1 w with w = -unit g, to its
  /// costate -K' w.
  /// @param w_0  -unit (nu packs), overwritten
  void add_first(double* w_0, const double* g, double* k, double* p) noexcept {
    using L = Lane<W>;
    const StageSizes n = kernel_.sizes();
    const double *const inverse_D = gain_[0], *const lower = inverse_D + n.nu * W;
    const double* const K = lower + n.nu * (n.nu - 1) / 2 * W;
    const auto below = [&](int a, int b) { return L::load(lower + (a * (a - 1) / 2 + b) * W); };
    const auto w = [&](int a) { return w_0 + a * W; };
    for (int a = 0; a < n.nu; ++a) (L::load(w(a)) * L::load(g + a * W)).store(w(a));
    for (int j = 0; j < n.nx; ++j) {
      L sum = L::load(p + j * W);
      for (int a = 0; a < n.nu; ++a) sum -= L::load(K + (j * n.nu + a) * W) * L::load(w(a));
      sum.store(p + j * W);
    }
    for (int a = 0; a < n.nu; ++a) {
      L sum = L::load(w(a));
      for (int b = 0; b < a; ++b) sum -= below(a, b) * L::load(w(b));
      sum.store(w(a));
    }
    for (int a = n.nu - 1; a >= 0; --a) {
      L sum = L::load(inverse_D + a * W) * L::load(w(a));
      for (int b = a + 1; b < n.nu; ++b) sum -= below(b, a) * L::load(w(b));
      sum.store(w(a));
    }
    for (int a = 0; a < n.nu; ++a) (L::load(k + a * W) + L::load(w(a))).store(k + a * W);
  }

  /// Terminal values: lambda = 2 Q_f (x - x*), e = 0, P = 2 Q_f.
  void start_carry(double* carry) noexcept {
    const StageSizes n = kernel_.sizes();
    using L = Lane<W>;
    std::fill_n(carry, n.carry() * W, 0.0);
    double *const lambda = carry + W, *const P = carry + (1 + 2 * n.nx) * W;
    const double *const x = x_[0] + stages_ * n.nx * W, *const x_ref = x_ref_[0] + stages_ * ref_stage_;
    for (int i = 0; i < n.nx; ++i) {
      const L curvature = L(2.0) * L::load(Q_f_[0] + i * W);
      (curvature * (L::load(x + i * W) - L::load(x_ref + i * W))).store(lambda + i * W);
      curvature.store(P + upper_index(i, i, n.nx) * W);
    }
  }

  Kernel kernel_;
};

// Table of compiled functions, looked up by the structure hash and the size of their programs: the
// size guards against hash collisions.

/// Stage functions of one model, for groups of one width.
struct StageKernel {
  std::uint64_t structure;
  int width;
  ProgramSize size;
  std::unique_ptr<Group> (*make)(std::shared_ptr<const StagePrograms>, int stages);
};

/// Function of one potential, over packs of one width: inputs [pack][input][lane] to outputs
/// [pack][output][lane].
struct FormulaKernel {
  std::uint64_t structure;
  int width;
  ProgramSize size;
  void (*run)(const double* constants, const double* in, double* out, int packs);
};

struct KernelTable {
  std::span<const StageKernel> stages;
  std::span<const FormulaKernel> formulas;
  const KernelTable* next = nullptr;
};

/// Functions of the library's own models and potentials.
const KernelTable& built_in_kernels();
/// Adds a user's functions to the lookup; before main. @return true
bool register_kernels(KernelTable& table);

/// Whether compiled functions are used. Interpreted ones give the same bits, several times slower.
enum class KernelChoice {
  compiled_if_there,
  interpreted,
};

/// Makes a group of this width, compiled if the table has its functions.
std::unique_ptr<Group> make_group(std::shared_ptr<const StagePrograms> programs, int stages, int width,
                                  KernelChoice choice);

/// Compiled functions of a model for groups of this width, or null.
const StageKernel* find_stage(const StagePrograms& programs, int width);
/// Compiled function of a program, or null.
const FormulaKernel* find_formula(const Program& program, int width);

template <int W, class F>
std::unique_ptr<Group> make_compiled(std::shared_ptr<const StagePrograms> programs, int stages) {
  return std::make_unique<StageGroup<W, CompiledStage<W, F>>>(std::move(programs), stages);
}

/// Calls F::evaluate for each pack.
template <int W, class F>
[[gnu::flatten]] void run_compiled(const double* constants, const double* in, double* out, int packs) {
  for (int p = 0; p < packs; ++p, in += F::inputs * W, out += F::outputs * W) {
    F::template evaluate<Lane<W>>(constants, in, out);
  }
}

}  // namespace sightline
