#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/formula/operation.hpp"

namespace sightline {
namespace {

/// An instruction and what it reads. A value is an input or a constant, by its row, or the result of
/// instruction i: first_scratch + i.
struct Line {
  const Instruction* instruction = nullptr;
  std::array<int, 3> operands{-1, -1, -1};
  std::vector<int> readers{};                // lines, each once
  std::vector<const Instruction*> stores{};  // copies of its result to outputs
  int waits_for = 0, reads_left = 0;         // lines
  double height = 0.0;                       // cycles from its start to the end
};

/// Approximate time until the result of an instruction can be read, in cycles.
double latency(Code code) { return code == Code::reciprocal || code == Code::square_root ? 14.0 : 4.0; }

class Printer {
 public:
  Printer(const Program& program, std::span<const Block> inputs, std::span<const Block> outputs)
      : program_(program), names_(at(program.rows())) {
    name_rows(0, inputs);
    name_rows(program.first_output(), outputs);
    for (std::size_t i = 0; i < program.constants().size(); ++i) {
      name(program.first_constant() + static_cast<int>(i)) = fmt::format("L(constants[{}])", i);
    }
    find_lines();
    find_readers();
    find_heights(inputs, outputs);
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
    for (const int i : in_order()) {
      text += fmt::format("  const L t{} = {};\n", i, expression(lines_[at(i)]));
      for (const Instruction* store : lines_[at(i)].stores) text += stored(*store, fmt::format("t{}", i));
    }
    for (const Instruction* store : copies_) text += stored(*store, name(store->a));
    return text + "}\n";
  }

 private:
  std::string& name(int row) { return names_[at(row)]; }
  int base() const { return program_.first_scratch(); }
  /// The line that computes a value, or -1.
  int line_of(int value) const { return value < base() ? -1 : value - base(); }

  void name_rows(int row, std::span<const Block> blocks) {
    for (const Block& b : blocks) {
      for (int i = 0; i < b.size; ++i) {
        const bool input = row < program_.inputs();
        name(row++) = input ? fmt::format("L::load({} + {} * L::width)", b.name, i)
                            : fmt::format("{} + {} * L::width", b.name, i);
      }
    }
  }

  /// Outputs are copies at the end of a program; each is stored as soon as its value is computed.
  void find_lines() {
    std::vector<int> in_row(at(program_.rows()));
    for (int r = 0; r < base(); ++r) in_row[at(r)] = r;
    for (const Instruction& q : program_.instructions()) {
      if (q.d >= program_.first_output()) {
        assert((q.code == Code::copy || q.code == Code::negate) && "outputs are copies at the end");
        const int of = line_of(in_row[at(q.a)]);
        (of < 0 ? copies_ : lines_[at(of)].stores).push_back(&q);
        continue;
      }
      Line& line = lines_.emplace_back();
      line.instruction = &q;
      const std::array<int, 3> rows = {q.a, q.b, q.c};
      for (int o = 0; o < operand_count(q.code); ++o) line.operands[at(o)] = in_row[at(rows[at(o)])];
      in_row[at(q.d)] = base() + static_cast<int>(lines_.size()) - 1;
    }
  }

  /// use(line) for each line that a line reads, once.
  template <class Use>
  void each_read(const Line& line, Use&& use) {
    for (auto v = line.operands.begin(); v != line.operands.end(); ++v) {
      if (*v >= base() && std::find(line.operands.begin(), v, *v) == v) use(lines_[at(line_of(*v))]);
    }
  }

  void find_readers() {
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      each_read(lines_[i], [&](Line& read) {
        read.readers.push_back(static_cast<int>(i));
        ++read.reads_left;
        ++lines_[i].waits_for;
      });
    }
  }

  /// An output block NAME_out is the block NAME of the next call: its path goes on there.
  void find_heights(std::span<const Block> inputs, std::span<const Block> outputs) {
    constexpr int calls = 4;
    std::vector<int> next_row(at(program_.rows()), -1);  // of outputs
    int to = program_.first_output();
    for (const Block& out : outputs) {
      int from = 0;
      for (const Block& in : inputs) {
        for (int i = 0; out.name == fmt::format("{}_out", in.name) && i < std::min(in.size, out.size); ++i)
          next_row[at(to + i)] = from + i;
        from += in.size;
      }
      to += out.size;
    }
    std::vector<double> of_input(at(program_.inputs()));
    for (int call = 0; call < calls; ++call) {
      for (auto line = lines_.rbegin(); line != lines_.rend(); ++line) {
        line->height = 0.0;
        for (const Instruction* store : line->stores) {
          const int row = next_row[at(store->d)];
          if (row >= 0) line->height = std::max(line->height, of_input[at(row)]);
        }
        for (const int r : line->readers) line->height = std::max(line->height, lines_[at(r)].height);
        line->height += latency(line->instruction->code);
      }
      for (const Line& line : lines_) {
        for (const int v : line.operands)
          if (v >= 0 && v < program_.inputs()) of_input[at(v)] = std::max(of_input[at(v)], line.height);
      }
    }
  }

  /// Compilers keep this order, and a processor overlaps instructions only if few others are between
  /// them. Of those whose operands are there, the one with the longest path to the end comes first; a
  /// register that it occupies, or releases, counts as `of_register` cycles.
  std::vector<int> in_order() {
    constexpr double of_register = 8.0;
    std::vector<int> order, open;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (lines_[i].waits_for == 0) open.push_back(static_cast<int>(i));
    }
    const auto urgency = [&](int i) {
      const Line& line = lines_[at(i)];
      int occupied = line.readers.empty() ? 0 : 1;
      each_read(line, [&](const Line& read) { occupied -= read.reads_left == 1; });
      return line.height - of_register * occupied;
    };
    while (!open.empty()) {
      std::pair best{urgency(open[0]), -open[0]};
      for (const int i : open) best = std::max(best, {urgency(i), -i});
      const int i = -best.second;
      order.push_back(i);
      open.erase(std::find(open.begin(), open.end(), i));
      each_read(lines_[at(i)], [](Line& read) { --read.reads_left; });
      for (const int r : lines_[at(i)].readers) {
        if (--lines_[at(r)].waits_for == 0) open.push_back(r);
      }
    }
    return order;
  }

  std::string stored(const Instruction& q, const std::string& value) {
    return fmt::format("  ({}{}).store({});\n", q.code == Code::negate ? "-" : "", value, name(q.d));
  }

  std::string expression(const Line& line) {
    std::array<std::string, 3> of;
    for (std::size_t o = 0; o < of.size(); ++o) {
      const int v = line.operands[o];
      if (v >= 0) of[o] = v < base() ? name(v) : fmt::format("t{}", line_of(v));
    }
    const auto& [a, b, c] = of;
    switch (line.instruction->code) {
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
  std::vector<std::string> names_;  // of inputs, constants and outputs, by row
  std::vector<Line> lines_;
  std::vector<const Instruction*> copies_;  // of inputs and constants to outputs
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
