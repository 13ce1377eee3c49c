/// One potential at many points, one per stage of each coupling, in packs: [pack][variable][lane].
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "sightline/formula.hpp"
#include "sightline/kernels.hpp"

namespace sightline {

/// Formula over packs of W points, compiled if the kernel table has it, else interpreted.
template <int W>
class PackFormula {
 public:
  /// @param program  must outlive the object
  PackFormula(const Program& program, KernelChoice choice)
      : program_(&program),
        compiled_(choice == KernelChoice::compiled_if_there ? find_formula(program, W) : nullptr) {
    if (compiled_ == nullptr) {
      interpreted_ =
          std::make_unique<Threaded<W>>(program, std::array{program.inputs()}, std::array{program.outputs()});
    }
  }

  /// in [pack][input][lane], out [pack][output][lane]; they do not overlap.
  void run(const double* in, double* out, int packs = 1) noexcept {
    if (compiled_ != nullptr) return compiled_->run(program_->constants().data(), in, out, packs);
    for (int p = 0; p < packs; ++p) {
      interpreted_->run({in + p * W * program_->inputs()}, {out + p * W * program_->outputs()});
    }
  }

 private:
  const Program* program_;
  const FormulaKernel* compiled_;
  std::unique_ptr<Threaded<W>> interpreted_;
};

class Points {
 public:
  static constexpr int W = native_width;

  Points(const PosePotential& potential, KernelChoice choice)
      : potential_(potential), value_(potential.value, choice), derivatives_(potential.derivatives, choice) {
    for (const Program& p : potential.others) others_.emplace_back(p, choice);
  }

  void resize(int points) {
    packs_ = (points + W - 1) / W;
    in_ = Rows(1, packs_ * W * inputs());
    out_ = Rows(1, packs_ * W * outputs());
    values_ = Rows(1, packs_ * W);
    if (!others_.empty()) more_ = Rows(1, packs_ * W * outputs());
  }

  double& in(int point, int variable) { return *(in_[0] + place(point, variable, inputs())); }
  const double* out(int point, int output) const { return out_[0] + place(point, output, outputs()); }

  /// use(k, number) for `count` points from `first` on: a writable input, or an output.
  template <class Use>
  void each_in(int first, int count, int variable, Use&& use) noexcept {
    each(in_[0] + place(first, variable, inputs()), first, count, inputs(), use);
  }
  template <class Use>
  void each_out(int first, int count, int output, Use&& use) const noexcept {
    each(out_[0] + place(first, output, outputs()), first, count, outputs(), use);
  }

  void derive() noexcept {
    derivatives_.run(in_[0], out_[0], packs_);
    for (PackFormula<W>& other : others_) {
      other.run(in_[0], more_[0], packs_);
      for (std::size_t i = 0; i < out_.all().size(); i += W)
        (Lane<W>::load(&out_.all()[i]) + Lane<W>::load(&more_.all()[i])).store(&out_.all()[i]);
    }
    if (part_ == 1.0) return;
    for (std::size_t i = 0; i < out_.all().size(); i += W)
      (Lane<W>(part_) * Lane<W>::load(&out_.all()[i])).store(&out_.all()[i]);
  }

  /// Evaluates the first `points` points.
  void evaluate(int points) noexcept { value_.run(in_[0], values_[0], (points + W - 1) / W); }
  double value(int point) const { return part_ * values_[0][point]; }

  /// Sets the active fraction of the weights.
  void set_part(double part) noexcept { part_ = part; }
  double part() const noexcept { return part_; }

 private:
  int inputs() const { return potential_.derivatives.inputs(); }
  int outputs() const { return potential_.derivatives.outputs(); }
  template <class Number, class Use>
  static void each(Number* at, int first, int count, int rows, Use&& use) noexcept {
    int lane = first % W;
    for (int k = 0; k < count;) {
      const int end = std::min(k + W - lane, count);
      for (; k < end; ++k) use(k, *at++);
      lane = 0, at += static_cast<std::ptrdiff_t>(rows - 1) * W;
    }
  }
  static std::ptrdiff_t place(int point, int row, int rows) {
    return (static_cast<std::ptrdiff_t>(point / W) * rows + row) * W + point % W;
  }

  const PosePotential& potential_;
  PackFormula<W> value_, derivatives_;
  std::vector<PackFormula<W>> others_;  // their derivatives are added
  Rows in_, out_, more_, values_;
  int packs_ = 0;
  double part_ = 1.0;
};

}  // namespace sightline
