/// The functions that were printed and compiled, found by the structure of the programs they come from, a hash, and
/// by their size: two programs of one hash do not take each other's function.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "sightline/solver/newton/group.hpp"

namespace sightline {

/// A model's programs, for groups of one width.
struct StageKernel {
  std::uint64_t structure;
  int width;
  ProgramSize size;
  std::unique_ptr<Group> (*make)(std::shared_ptr<const StagePrograms>, int stages);
};

/// A potential's program, over packs of one width: inputs [pack][input][lane] to outputs
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

/// Those of the library's own models and potentials.
const KernelTable& built_in_kernels();
/// Adds functions to those that are looked for, a user's; before main. @return true
bool register_kernels(KernelTable& table);

/// Whether compiled functions are looked for. Interpreted ones give the same bits, several times slower.
enum class KernelChoice {
  compiled_if_there,
  interpreted,
};

/// A group of that width, compiled where the structure is known.
std::unique_ptr<Group> make_group(std::shared_ptr<const StagePrograms> programs, int stages, int width,
                                  KernelChoice choice);

/// The compiled functions of a model for groups of that width, or none.
const StageKernel* find_stage(const StagePrograms& programs, int width);
/// The compiled function of a program, or none.
const FormulaKernel* find_formula(const Program& program, int width);

template <int W, class F>
std::unique_ptr<Group> make_compiled(std::shared_ptr<const StagePrograms> programs, int stages) {
  return std::make_unique<StageGroup<W, CompiledStage<W, F>>>(std::move(programs), stages);
}

/// F::evaluate over each pack.
template <int W, class F>
[[gnu::flatten]] void run_compiled(const double* constants, const double* in, double* out, int packs) {
  for (int p = 0; p < packs; ++p, in += F::inputs * W, out += F::outputs * W) {
    F::template evaluate<Lane<W>>(constants, in, out);
  }
}

}  // namespace sightline
