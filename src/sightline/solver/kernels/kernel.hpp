/// The five stage functions of a model, either printed at build time or interpreted. Both give the
/// same bits.
///
/// Blocks are arrays of packs, [entry][lane]; StagePrograms documents their contents.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "sightline/formula/threaded.hpp"
#include "sightline/solver/kernels/stage.hpp"

namespace sightline {

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
  using Carry = PacksInRegisters<W, F::sizes.carry()>;

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

}  // namespace sightline
