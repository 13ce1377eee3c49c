#include "sightline/kernels.hpp"

namespace sightline {
namespace {

const KernelTable*& tables() {
  static const KernelTable* first = &built_in_kernels();
  return first;
}

template <class Kernel, class Programs>
bool is_of(const Kernel& kernel, const Programs& programs, std::uint64_t hash, int width) {
  return kernel.structure == hash && kernel.width == width && kernel.size == size_of(programs);
}

template <int W>
std::unique_ptr<Group> make_interpreted(std::shared_ptr<const StagePrograms> programs, int stages) {
  return std::make_unique<StageGroup<W, InterpretedStage<W>>>(std::move(programs), stages);
}

}  // namespace

bool register_kernels(KernelTable& table) {
  table.next = tables();
  tables() = &table;
  return true;
}

std::unique_ptr<Group> make_group(std::shared_ptr<const StagePrograms> programs, int stages, int width,
                                  KernelChoice choice) {
  if (choice == KernelChoice::compiled_if_there) {
    const StageKernel* const kernel = find_stage(*programs, width);
    if (kernel != nullptr) return kernel->make(std::move(programs), stages);
  }
  if (width == native_width) return make_interpreted<native_width>(std::move(programs), stages);
  if (width == narrow_width) return make_interpreted<narrow_width>(std::move(programs), stages);
  return make_interpreted<2>(std::move(programs), stages);
}

const StageKernel* find_stage(const StagePrograms& programs, int width) {
  const std::uint64_t wanted = structure(programs);
  for (const KernelTable* table = tables(); table != nullptr; table = table->next) {
    for (const StageKernel& kernel : table->stages) {
      if (is_of(kernel, programs, wanted, width)) return &kernel;
    }
  }
  return nullptr;
}

const FormulaKernel* find_formula(const Program& program, int width) {
  const std::uint64_t wanted = structure(program);
  for (const KernelTable* table = tables(); table != nullptr; table = table->next) {
    for (const FormulaKernel& kernel : table->formulas) {
      if (is_of(kernel, program, wanted, width)) return &kernel;
    }
  }
  return nullptr;
}

}  // namespace sightline
