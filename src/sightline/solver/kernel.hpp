/// The five functions of a model that a group of agents calls, from either of two sources: printed at build
/// time, or interpreted. Both give the same bits.
///
/// Blocks are arrays of packs, [entry][lane]; what they hold is said at StagePrograms.
#pragma once

#include <memory>

#include "sightline/formula/interpret.hpp"
#include "sightline/solver/stage.hpp"

namespace sightline {

/// Functions printed by `emit`, as static members of F, with the constants of one model.
template <int W, class F>
class CompiledStage {
 public:
  static constexpr StageSizes sizes() { return F::sizes; }

  explicit CompiledStage(const StagePrograms& programs) : programs_(programs) {}

  void step(const double* x, const double* u, double* x_next, double* s) {
    F::template step<Lane<W>>(constants(programs_.step), x, u, x_next, s);
  }
  void back(const double* x, const double* u, const double* x_ref, const double* active,
            const double* weights, const double* coupling, const double* carry, double* H_u, double* gain,
            double* k, double* carry_out) {
    F::template back<Lane<W>>(constants(programs_.back), x, u, x_ref, active, weights, coupling, carry, H_u,
                              gain, k, carry_out);
  }
  void back_first(const double* x, const double* u, const double* x_ref, const double* active,
                  const double* weights, const double* coupling, const double* carry, double* H_u,
                  double* gain, double* k, double* carry_out) {
    F::template back_first<Lane<W>>(constants(programs_.back_first), x, u, x_ref, active, weights, coupling,
                                    carry, H_u, gain, k, carry_out);
  }
  void precondition_back(const double* p, const double* r, const double* gain, double* p_out, double* k) {
    F::template precondition_back<Lane<W>>(constants(programs_.precondition_back), p, r, gain, p_out, k);
  }
  void precondition_forward(const double* y, const double* gain, const double* k, double* du, double* y_out,
                            double* ds) {
    F::template precondition_forward<Lane<W>>(constants(programs_.precondition_forward), y, gain, k, du,
                                              y_out, ds);
  }

 private:
  static const double* constants(const BlockProgram& p) { return p.program.constants().data(); }

  const StagePrograms& programs_;
};

/// A block program, interpreted.
template <int W>
class InterpretedBlocks {
 public:
  explicit InterpretedBlocks(const BlockProgram& program) : program_(program), evaluation_(program.program) {}

  /// @param in, out  one pointer for each block
  void operator()(std::initializer_list<const double*> in, std::initializer_list<double*> out) {
    int row = 0, output = 0;
    auto block = program_.inputs.begin();
    for (const double* b : in) {
      evaluation_.bind_inputs(row, b, block->size);
      row += block++->size;
    }
    block = program_.outputs.begin();
    for (double* b : out) {
      evaluation_.bind_outputs(output, b, block->size);
      output += block++->size;
    }
    evaluation_.run();
  }

 private:
  const BlockProgram& program_;
  PackEvaluation<W> evaluation_;
};

template <int W>
class InterpretedStage {
 public:
  StageSizes sizes() const { return sizes_; }

  explicit InterpretedStage(const StagePrograms& p)
      : sizes_(p.sizes),
        step_(p.step),
        back_(p.back),
        back_first_(p.back_first),
        precondition_back_(p.precondition_back),
        precondition_forward_(p.precondition_forward) {}

  void step(const double* x, const double* u, double* x_next, double* s) { step_({x, u}, {x_next, s}); }
  void back(const double* x, const double* u, const double* x_ref, const double* active,
            const double* weights, const double* coupling, const double* carry, double* H_u, double* gain,
            double* k, double* carry_out) {
    back_({x, u, x_ref, active, weights, coupling, carry}, {H_u, gain, k, carry_out});
  }
  void back_first(const double* x, const double* u, const double* x_ref, const double* active,
                  const double* weights, const double* coupling, const double* carry, double* H_u,
                  double* gain, double* k, double* carry_out) {
    back_first_({x, u, x_ref, active, weights, coupling, carry}, {H_u, gain, k, carry_out});
  }
  void precondition_back(const double* p, const double* r, const double* gain, double* p_out, double* k) {
    precondition_back_({p, r, gain}, {p_out, k});
  }
  void precondition_forward(const double* y, const double* gain, const double* k, double* du, double* y_out,
                            double* ds) {
    precondition_forward_({y, gain, k}, {du, y_out, ds});
  }

 private:
  StageSizes sizes_;
  InterpretedBlocks<W> step_, back_, back_first_, precondition_back_, precondition_forward_;
};

}  // namespace sightline
