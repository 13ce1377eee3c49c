#include "sightline/formula.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <algorithm>
#include <cassert>
#include <new>

#include "sightline/formula/operation.hpp"

namespace sightline {

namespace {

constexpr std::size_t large_page = std::size_t{2} << 20;

/// Each update reads and writes all memory of a large team.
void request_large_pages([[maybe_unused]] double* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  madvise(memory, bytes, MADV_HUGEPAGE);  // a hint that the kernel may ignore
#endif
}

}  // namespace

Rows::Rows(int n, int length) : count_(n), stride_(padded(length)) {
  const std::size_t bytes = std::max<std::size_t>(size(), 1) * sizeof(double);
  const bool is_large = bytes >= large_page;
  const std::size_t alignment = is_large ? large_page : row_alignment;
  memory_ = {static_cast<double*>(::operator new[](bytes, std::align_val_t(alignment))), Free{alignment}};
  if (is_large) request_large_pages(memory_.get(), bytes);
  std::fill_n(memory_.get(), size(), 0.0);
}

Rows::Rows(int n, int length, double* memory) : count_(n), stride_(padded(length)), memory_(memory, Free{0}) {
  std::fill_n(memory, size(), 0.0);
}

void Rows::Free::operator()(double* memory) const {
  if (alignment > 0) ::operator delete[](memory, std::align_val_t(alignment));
}

Evaluation::Evaluation(const Program& program, int length)
    : program_(&program), packs_(padded(length) / native_width) {
  // Scratch holds one pass over at most `row_quantum` packs, so it stays in the first-level cache.
  const int pass = std::min(padded(length), row_quantum * native_width);
  own_ = Rows(program.first_output() - program.first_constant(), pass);
  rows_.assign(static_cast<std::size_t>(program.rows()), nullptr);
  for (int r = program.first_constant(); r < program.first_output(); ++r)
    at(r) = own_[r - program.first_constant()];
  for (std::size_t i = 0; i < program.constants().size(); ++i) {
    std::fill_n(own_[static_cast<int>(i)], own_.stride(), program.constants()[i]);
  }
}

namespace {

/// Start of the rows of one pass.
struct PassRows {
  double* const* rows;
  int inputs, first_output;
  std::ptrdiff_t offset;  // into the caller's rows

  double* operator()(int r) const { return rows[r] + (r < inputs || r >= first_output ? offset : 0); }
};

/// All instructions, each over `packs` packs; `Packs` > 0 fixes their number at compile time.
/// @param row  returns the start of a row
template <class L, int Packs, class Row>
void execute(std::span<const Instruction> instructions, const Row& row, int count) {
  const int packs = Packs > 0 ? Packs : count;
  for (const Instruction& q : instructions) {
    double* const d = row(q.d);
    const double* const a = row(q.a);
    const auto each = [&](auto&& f) {
      for (int p = 0; p < packs; ++p) f(p * L::width).store(d + p * L::width);
    };
    const auto run = [&]<Code code>() {
      constexpr int operands = operand_count(code);
      const double* const b = operands > 1 ? row(q.b) : a;
      const double* const c = operands > 2 ? row(q.c) : a;
      each([&](int i) { return operation<code>(L::load(a + i), L::load(b + i), L::load(c + i)); });
    };
    switch (q.code) {
      case Code::copy:
        run.template operator()<Code::copy>();
        break;
      case Code::negate:
        run.template operator()<Code::negate>();
        break;
      case Code::add:
        run.template operator()<Code::add>();
        break;
      case Code::subtract:
        run.template operator()<Code::subtract>();
        break;
      case Code::multiply:
        run.template operator()<Code::multiply>();
        break;
      case Code::multiply_add:
        run.template operator()<Code::multiply_add>();
        break;
      case Code::multiply_subtract:
        run.template operator()<Code::multiply_subtract>();
        break;
      case Code::subtract_product:
        run.template operator()<Code::subtract_product>();
        break;
      case Code::reciprocal:
        run.template operator()<Code::reciprocal>();
        break;
      case Code::square_root:
        run.template operator()<Code::square_root>();
        break;
      case Code::exponential:
        run.template operator()<Code::exponential>();
        break;
      case Code::logistic:
        run.template operator()<Code::logistic>();
        break;
      case Code::relaxed_log:
        run.template operator()<Code::relaxed_log>();
        break;
      case Code::sine:
        run.template operator()<Code::sine>();
        break;
      case Code::cosine:
        run.template operator()<Code::cosine>();
        break;
      case Code::maximum:
        run.template operator()<Code::maximum>();
        break;
      case Code::logarithm:
        run.template operator()<Code::logarithm>();
        break;
      case Code::softplus:
        run.template operator()<Code::softplus>();
        break;
      case Code::angle:
        run.template operator()<Code::angle>();
        break;
    }
  }
}

}  // namespace

void Evaluation::run() const noexcept {
  const auto instructions = program_->instructions();
  const int inputs = program_->inputs(), first_output = program_->first_output();
  for (int done = 0; done < packs_; done += row_quantum) {
    const int packs = std::min(packs_ - done, row_quantum);
    const PassRows rows{rows_.data(), inputs, first_output, static_cast<std::ptrdiff_t>(done) * native_width};
    switch (packs) {
      case 1:
        execute<NativeLane, 1>(instructions, rows, packs);
        break;
      case 3:  // 20 stages in packs of 8
        execute<NativeLane, 3>(instructions, rows, packs);
        break;
      case row_quantum:
        execute<NativeLane, row_quantum>(instructions, rows, packs);
        break;
      default:
        execute<NativeLane, 0>(instructions, rows, packs);
    }
  }
}

std::vector<double> evaluate(const Program& program, std::span<const double> inputs) {
  assert(static_cast<int>(inputs.size()) == program.inputs() && "one number for each input of the program");
  Rows in(program.inputs(), 1), out(program.outputs(), 1);
  Evaluation evaluation(program, 1);
  for (int i = 0; i < program.inputs(); ++i) {
    std::fill_n(in[i], in.stride(), inputs[static_cast<std::size_t>(i)]);
    evaluation.input(i, in[i]);
  }
  std::vector<double> results;
  for (int i = 0; i < program.outputs(); ++i) evaluation.output(i, out[i]);
  evaluation.run();
  for (int i = 0; i < program.outputs(); ++i) results.push_back(*out[i]);
  return results;
}

}  // namespace sightline
