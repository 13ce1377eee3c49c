/// One potential at many points, one for each stage of each coupling, in packs: [pack][variable][lane].
#pragma once

#include <array>

#include "sightline/formula/threaded.hpp"
#include "sightline/solver/kernel_table.hpp"
#include "sightline/solver/pose_potential.hpp"

namespace sightline {

class Points {
 public:
  static constexpr int W = native_width;

  Points(const PosePotential& potential, KernelChoice choice)
      : potential_(potential), value_(blocks(potential.value)), derivatives_(blocks(potential.derivatives)) {
    const auto compiled = [&](const Program& p) {
      return choice == KernelChoice::compiled_if_there ? find_formula(p, W) : nullptr;
    };
    compiled_ = compiled(potential.derivatives);
    for (const Program& p : potential.others) others_.push_back({p, blocks(p), compiled(p)});
  }

  void resize(int points) {
    packs_ = (points + W - 1) / W;
    in_ = Rows(1, packs_ * W * inputs());
    out_ = Rows(1, packs_ * W * potential_.derivatives.outputs());
    values_ = Rows(1, packs_ * W);
    if (!others_.empty()) more_ = Rows(1, packs_ * W * potential_.derivatives.outputs());
  }

  double& in(int point, int variable) { return *(in_[0] + place(point, variable, inputs())); }
  const double* out(int point, int output) const {
    return out_[0] + place(point, output, potential_.derivatives.outputs());
  }

  void derive() noexcept {
    run(potential_.derivatives, derivatives_, compiled_, out_[0]);
    for (Other& other : others_) {
      run(other.program, other.evaluation, other.compiled, more_[0]);
      for (std::size_t i = 0; i < out_.all().size(); i += W)
        (Lane<W>::load(&out_.all()[i]) + Lane<W>::load(&more_.all()[i])).store(&out_.all()[i]);
    }
  }

  void evaluate() noexcept {
    for (int p = 0; p < packs_; ++p) {
      value_.run({in_[0] + p * W * inputs()}, {values_[0] + p * W});
    }
  }
  double value(int point) const { return values_[0][point]; }

 private:
  struct Other {
    const Program& program;
    Threaded<W> evaluation;
    const FormulaKernel* compiled;
  };

  void run(const Program& program, Threaded<W>& evaluation, const FormulaKernel* compiled,
           double* out) noexcept {
    if (compiled != nullptr) {
      compiled->run(program.constants().data(), in_[0], out, packs_);
      return;
    }
    for (int p = 0; p < packs_; ++p) {
      evaluation.run({in_[0] + p * W * program.inputs()}, {out + p * W * program.outputs()});
    }
  }

  static Threaded<W> blocks(const Program& p) {
    return Threaded<W>(p, std::array{p.inputs()}, std::array{p.outputs()});
  }
  int inputs() const { return potential_.derivatives.inputs(); }
  static std::ptrdiff_t place(int point, int row, int rows) {
    return (static_cast<std::ptrdiff_t>(point / W) * rows + row) * W + point % W;
  }

  const PosePotential& potential_;
  Threaded<W> value_, derivatives_;
  const FormulaKernel* compiled_ = nullptr;
  std::vector<Other> others_;
  Rows in_, out_, more_, values_;
  int packs_ = 0;
};

}  // namespace sightline
