#include "sightline/formula/interpret.hpp"

#include <algorithm>
#include <cassert>
#include <new>

#include "sightline/math/elementary.hpp"

namespace sightline {

Rows::Rows(int n, int length) : count_(n), stride_(padded(length)) {
  memory_.reset(static_cast<double*>(
      ::operator new[](std::max<std::size_t>(size(), 1) * sizeof(double), std::align_val_t(row_alignment))));
  std::fill_n(memory_.get(), size(), 0.0);
}

void Rows::Free::operator()(double* memory) const {
  ::operator delete[](memory, std::align_val_t(row_alignment));
}

Evaluation::Evaluation(const Program& program, int length)
    : program_(&program), packs_(padded(length) / native_width) {
  // Scratch is kept for one pass over at most `row_quantum` packs, so it stays in the first cache.
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

/// Where the rows of one pass begin.
struct PassRows {
  double* const* rows;
  int inputs, first_output;
  std::ptrdiff_t offset;  // into the caller's rows

  double* operator()(int r) const { return rows[r] + (r < inputs || r >= first_output ? offset : 0); }
};

/// All instructions, each over `packs` packs; `Packs` > 0 fixes their number at compile time.
/// @param row  the beginning of a row
template <class L, int Packs, class Row>
void execute(std::span<const Instruction> instructions, const Row& row, int count) {
  const int packs = Packs > 0 ? Packs : count;
  for (const Instruction& q : instructions) {
    double* const d = row(q.d);
    const double* const a = row(q.a);
    const auto each = [&](auto&& f) {
      for (int p = 0; p < packs; ++p) f(p * L::width).store(d + p * L::width);
    };
    const auto unary = [&](auto&& f) { each([&](int i) { return f(L::load(a + i)); }); };
    const auto binary = [&](auto&& f) {
      const double* const b = row(q.b);
      each([&](int i) { return f(L::load(a + i), L::load(b + i)); });
    };
    const auto ternary = [&](auto&& f) {
      const double* const b = row(q.b);
      const double* const c = row(q.c);
      each([&](int i) { return f(L::load(a + i), L::load(b + i), L::load(c + i)); });
    };
    switch (q.code) {
      case Code::copy:
        unary([](L x) { return x; });
        break;
      case Code::negate:
        unary([](L x) { return -x; });
        break;
      case Code::add:
        binary([](L x, L y) { return x + y; });
        break;
      case Code::subtract:
        binary([](L x, L y) { return x - y; });
        break;
      case Code::multiply:
        binary([](L x, L y) { return x * y; });
        break;
      case Code::multiply_add:
        ternary([](L x, L y, L z) { return fma(x, y, z); });
        break;
      case Code::multiply_subtract:
        ternary([](L x, L y, L z) { return multiply_subtract(x, y, z); });
        break;
      case Code::subtract_product:
        ternary([](L x, L y, L z) { return subtract_product(x, y, z); });
        break;
      case Code::reciprocal:
        unary([](L x) { return L(1.0) / x; });
        break;
      case Code::square_root:
        unary([](L x) { return sqrt(x); });
        break;
      case Code::exponential:
        unary([](L x) { return exp(x); });
        break;
      case Code::logistic:
        unary([](L x) { return logistic(x); });
        break;
      case Code::relaxed_log:
        unary([](L x) { return relaxed_log(x); });
        break;
      case Code::sine:
        unary([](L x) { return sin(x); });
        break;
      case Code::cosine:
        unary([](L x) { return cos(x); });
        break;
      case Code::maximum:
        binary([](L x, L y) { return maximum(x, y); });
        break;
      case Code::logarithm:
        unary([](L x) { return log(x); });
        break;
      case Code::softplus:
        unary([](L x) { return softplus(x); });
        break;
      case Code::angle:
        binary([](L y, L x) { return atan2(y, x); });
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
