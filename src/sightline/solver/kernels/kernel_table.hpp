/// Table of compiled functions, looked up by the structure hash and the size of their programs: the
/// size guards against hash collisions.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "sightline/solver/newton/group.hpp"

namespace sightline {

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
