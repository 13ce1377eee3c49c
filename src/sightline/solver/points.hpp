/// One potential at many points, one for each stage of each coupling, in packs: [pack][variable][lane].
#pragma once

#include "sightline/formula/interpret.hpp"
#include "sightline/solver/kernel_table.hpp"
#include "sightline/solver/pose_potential.hpp"

namespace sightline {

class Points {
 public:
  static constexpr int W = native_width;

  Points(const PosePotential& potential, KernelChoice choice)
      : potential_(potential), value_(potential.value), derivatives_(potential.derivatives) {
    if (choice == KernelChoice::compiled_if_there) compiled_ = find_formula(potential.derivatives, W);
  }

  void resize(int points) {
    packs_ = (points + W - 1) / W;
    in_ = Rows(1, packs_ * W * inputs());
    out_ = Rows(1, packs_ * W * potential_.derivatives.outputs());
    values_ = Rows(1, packs_ * W);
  }

  double& in(int point, int variable) { return *(in_[0] + place(point, variable, inputs())); }
  const double* out(int point, int output) const {
    return out_[0] + place(point, output, potential_.derivatives.outputs());
  }

  void derive() noexcept {
    const int outputs = potential_.derivatives.outputs();
    if (compiled_ != nullptr) {
      compiled_->run(potential_.derivatives.constants().data(), in_[0], out_[0], packs_);
      return;
    }
    for (int p = 0; p < packs_; ++p) {
      derivatives_.bind_inputs(0, in_[0] + p * W * inputs(), inputs());
      derivatives_.bind_outputs(0, out_[0] + p * W * outputs, outputs);
      derivatives_.run();
    }
  }

  void evaluate() noexcept {
    for (int p = 0; p < packs_; ++p) {
      value_.bind_inputs(0, in_[0] + p * W * inputs(), inputs());
      value_.bind_outputs(0, values_[0] + p * W, 1);
      value_.run();
    }
  }
  double value(int point) const { return values_[0][point]; }

 private:
  int inputs() const { return potential_.derivatives.inputs(); }
  static std::ptrdiff_t place(int point, int row, int rows) {
    return (static_cast<std::ptrdiff_t>(point / W) * rows + row) * W + point % W;
  }

  const PosePotential& potential_;
  PackEvaluation<W> value_, derivatives_;
  const FormulaKernel* compiled_ = nullptr;
  Rows in_, out_, values_;
  int packs_ = 0;
};

}  // namespace sightline
