#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "sightline/kernels.hpp"

namespace sightline {
namespace {

constexpr double any_h = 0.05;  // h is a parameter, so its value has no effect

/// Prints a function as a member of the struct opened before it.
std::string member(const BlockProgram& p, std::string_view name) {
  return emit(p.program, name, p.inputs, p.outputs);
}

std::string in_braces(const ProgramSize& n) {
  return fmt::format("{{{}, {}, {}, {}}}", n.inputs, n.outputs, n.constants, n.instructions);
}

/// Prints a constant array: initialised before any table is registered.
std::string list(std::string_view type, std::string_view name, const std::string& rows) {
  return fmt::format("constexpr std::array<{}, {}> {} = {{{{\n{}}}}};\n", type,
                     std::count(rows.begin(), rows.end(), '\n'), name, rows);
}

std::string head() {
  return "// Printed by the generator; not to be edited.\n#include "
         "\"sightline/kernels.hpp\"\n\n"
         "namespace sightline {\n";
}

/// Declaration of the function that prepends a part to the chain of tables.
std::string declaration(std::string_view part) {
  return fmt::format("const KernelTable& {}_kernels(const KernelTable* next)", part);
}

}  // namespace

void Generator::add(const Model& model, Seen seen, const std::vector<RelaxedBarrier>& barriers,
                    const RateCost& rates) {
  const StagePrograms programs = trace_stage(model, any_h, seen, barriers, {}, rates);
  const std::uint64_t key = structure(programs);
  if (!known_.insert(key).second) return;
  const StageSizes& n = programs.sizes;
  const std::string name = fmt::format("Stage_{:016x}", key);
  functions_ += fmt::format("/// {}\nstruct {} {{\nstatic constexpr StageSizes sizes{{{}, {}, {}, {}{}}};\n",
                            model.name(), name, n.nx, n.nu, n.ns, n.stored,
                            n.before > 0 ? fmt::format(", {}", n.before) : "");
  constexpr std::array<std::string_view, 5> names = {"step", "back", "back_first", "precondition_back",
                                                     "precondition_forward"};
  for (std::size_t i = 0; i < names.size(); ++i) functions_ += member(*programs.all()[i], names[i]);
  functions_ += "};\n\n";
  for (const std::string_view width : {"2", "narrow_width", "native_width"}) {
    stage_rows_ += fmt::format("    {{0x{:016x}, {}, {}, make_compiled<{}, {}>}},\n", key, width,
                               in_braces(size_of(programs)), width, name);
  }
}

void Generator::add(const std::vector<Weighted>& terms) {
  std::vector<const Weighted*> pointers;
  for (const Weighted& t : terms) pointers.push_back(&t);
  std::vector<Ends> kinds = {{true, false, true, false}};
  if (terms.at(0).potential.is_pair())
    kinds.insert(kinds.end(), {{}, {.b_feels = false}, {.a_feels = false}});
  for (const Ends& ends : kinds) {
    const PosePotential potential = trace_potential(pointers, any_h, ends, Numbers::parameters);
    for (const Program* program : {&potential.derivatives, &potential.value})
      add(*program, terms[0].potential.name());
  }
}

void Generator::add_slopes(const std::vector<Weighted>& terms) {
  std::vector<const Weighted*> pointers;
  for (const Weighted& t : terms) pointers.push_back(&t);
  for (const Ends& ends : {Ends{}, Ends{.b_feels = false}, Ends{.a_feels = false}})
    add(trace_slopes(pointers, any_h, ends, false).program, terms.at(0).potential.name());
}

void Generator::add_swarm(const Weighted& term) {
  const SwarmPotential swarm = trace_swarm(term, any_h, Numbers::parameters);
  for (const Program* program : {&swarm.value, &swarm.derivatives}) add(*program, term.potential.name());
}

void Generator::add(const Program& program, std::string_view potential_name) {
  const std::uint64_t key = structure(program);
  if (!known_.insert(key).second) return;
  const std::string name = fmt::format("Formula_{:016x}", key);
  functions_ += fmt::format("/// {}\nstruct {} {{\nstatic constexpr int inputs = {}, outputs = {};\n",
                            potential_name, name, program.inputs(), program.outputs());
  const std::array<Block, 1> in = {Block{"in", program.inputs()}}, out = {Block{"out", program.outputs()}};
  functions_ += emit(program, "evaluate", in, out) + "};\n\n";
  for (const std::string_view width : {"narrow_width", "native_width"}) {
    formula_rows_ += fmt::format("    {{0x{:016x}, {}, {}, run_compiled<{}, {}>}},\n", key, width,
                                 in_braces(size_of(program)), width, name);
  }
}

std::string Generator::text() const {
  std::string text = "#include <array>\n\n" + head() + "namespace {\n\n" + functions_ +
                     list("StageKernel", "stage_kernels", stage_rows_) +
                     list("FormulaKernel", "formula_kernels", formula_rows_) + "\n";
  if (part_.empty()) {
    text +=
        "KernelTable table{stage_kernels, formula_kernels};\n"
        "[[maybe_unused]] const bool registered = register_kernels(table);\n\n}  // namespace\n";
  } else {
    text += fmt::format(
        "}}  // namespace\n\n{};\n{} {{\n  static const KernelTable table{{stage_kernels, formula_kernels, "
        "next}};\n  return table;\n}}\n",
        declaration(part_), declaration(part_));
  }
  return text + "}  // namespace sightline\n";
}

std::string Generator::index(std::span<const Generator> parts) {
  std::string text = head(), chain;
  for (const Generator& g : parts) {
    text += declaration(g.part()) + ";\n";
    chain += fmt::format("  first = &{}_kernels(first);\n", g.part());
  }
  return text + "\nconst KernelTable& built_in_kernels() {\n  const KernelTable* first = nullptr;\n" + chain +
         "  return *first;\n}\n\n}  // namespace sightline\n";
}

bool write_text(const std::string& path, std::string_view text) {
  std::ostringstream there;
  there << std::ifstream(path, std::ios::binary).rdbuf();
  if (!text.empty() && there.view() == text) return true;
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  return file.good();
}

}  // namespace sightline
