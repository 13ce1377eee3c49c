#include <fmt/format.h>

#include <cassert>
#include <map>
#include <vector>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

class Printer {
 public:
  Printer(const Program& program, std::span<const Block> inputs, std::span<const Block> outputs)
      : program_(program), names_(static_cast<std::size_t>(program.rows())) {
    name_rows(0, inputs);
    name_rows(program.first_output(), outputs);
    for (std::size_t i = 0; i < program.constants().size(); ++i) {
      name(program.first_constant() + static_cast<int>(i)) = fmt::format("L(constants[{}])", i);
    }
    find_stores();
  }

  std::string print(std::string_view function, std::span<const Block> inputs,
                    std::span<const Block> outputs) {
    std::string text = fmt::format(
        "template <class L>\n[[gnu::always_inline]] static inline void {}([[maybe_unused]] const double* "
        "constants",
        function);
    for (const Block& b : inputs) {
      text += fmt::format(", [[maybe_unused]] const double* __restrict {}", b.name);
    }
    for (const Block& b : outputs) text += fmt::format(", double* __restrict {}", b.name);
    text += ") {\n";
    const auto instructions = program_.instructions();
    for (std::size_t i = 0; i < instructions.size(); ++i) {
      const Instruction& q = instructions[i];
      if (q.d >= program_.first_output()) continue;  // stored where it was computed
      text += fmt::format("  const L t{} = {};\n", i, expression(q));
      name(q.d) = fmt::format("t{}", i);
      for (const Instruction* store : stores_[static_cast<int>(i)]) text += stored(*store);
    }
    for (const Instruction* store : stores_[-1]) text += stored(*store);
    return text + "}\n";
  }

 private:
  std::string& name(int row) { return names_[static_cast<std::size_t>(row)]; }

  void name_rows(int row, std::span<const Block> blocks) {
    for (const Block& b : blocks) {
      for (int i = 0; i < b.size; ++i) {
        const bool input = row < program_.inputs();
        name(row++) = input ? fmt::format("L::load({} + {} * L::width)", b.name, i)
                            : fmt::format("{} + {} * L::width", b.name, i);
      }
    }
  }

  /// Outputs are copies at the end of a program; each is stored as soon as its row is computed.
  void find_stores() {
    std::map<int, int> written_by;  // row -> instruction
    const auto instructions = program_.instructions();
    for (std::size_t i = 0; i < instructions.size(); ++i) {
      const Instruction& q = instructions[i];
      if (q.d < program_.first_output()) {
        written_by[q.d] = static_cast<int>(i);
        continue;
      }
      assert((q.code == Code::copy || q.code == Code::negate) && "outputs are copies at the end");
      const auto found = written_by.find(q.a);
      stores_[found == written_by.end() ? -1 : found->second].push_back(&q);
    }
  }

  std::string stored(const Instruction& q) {
    return fmt::format("  ({}{}).store({});\n", q.code == Code::negate ? "-" : "", name(q.a), name(q.d));
  }

  std::string expression(const Instruction& q) {
    const std::string &a = name(q.a), &b = name(q.b), &c = name(q.c);
    switch (q.code) {
      case Code::copy:
        return a;
      case Code::negate:
        return "-" + a;
      case Code::add:
        return a + " + " + b;
      case Code::subtract:
        return a + " - " + b;
      case Code::multiply:
        return a + " * " + b;
      case Code::multiply_add:
        return fmt::format("fma({}, {}, {})", a, b, c);
      case Code::multiply_subtract:
        return fmt::format("multiply_subtract({}, {}, {})", a, b, c);
      case Code::subtract_product:
        return fmt::format("subtract_product({}, {}, {})", a, b, c);
      case Code::reciprocal:
        return "L(1.0) / " + a;
      case Code::square_root:
        return "sqrt(" + a + ")";
      case Code::exponential:
        return "exp(" + a + ")";
      case Code::logistic:
        return "logistic(" + a + ")";
      case Code::relaxed_log:
        return "relaxed_log(" + a + ")";
      case Code::sine:
        return "sin(" + a + ")";
      case Code::cosine:
        return "cos(" + a + ")";
      case Code::maximum:
        return fmt::format("maximum({}, {})", a, b);
      case Code::logarithm:
        return "log(" + a + ")";
      case Code::softplus:
        return "softplus(" + a + ")";
      case Code::angle:
        return fmt::format("atan2({}, {})", a, b);
    }
    return {};
  }

  const Program& program_;
  std::vector<std::string> names_;
  std::map<int, std::vector<const Instruction*>>
      stores_;  // after instruction i; -1: copies of inputs, constants
};

}  // namespace

ProgramSize size_of(const Program& program) {
  return {program.inputs(), program.outputs(), static_cast<int>(program.constants().size()),
          static_cast<int>(program.instructions().size())};
}

std::uint64_t structure(const Program& program) {
  std::uint64_t hash = 14695981039346656037ull;  // FNV-1a
  const auto mix = [&](int value) { hash = (hash ^ static_cast<std::uint32_t>(value)) * 1099511628211ull; };
  mix(program.inputs());
  mix(program.outputs());
  mix(static_cast<int>(program.constants().size()));
  for (const Instruction& q : program.instructions()) {
    for (const int value : {static_cast<int>(q.code), q.d, q.a, q.b, q.c}) mix(value);
  }
  return hash;
}

std::string emit(const Program& program, std::string_view name, std::span<const Block> inputs,
                 std::span<const Block> outputs) {
  return Printer(program, inputs, outputs).print(name, inputs, outputs);
}

}  // namespace sightline
