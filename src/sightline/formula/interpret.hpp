/// Evaluation of a program over rows of numbers, one pack of lanes per operation.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/base/lane.hpp"
#include "sightline/formula/program.hpp"

namespace sightline {

/// Zeroed memory for rows of doubles, aligned to `row_alignment`. Large blocks use pages of 2 MB if
/// the system has them.
class Rows {
 public:
  Rows() = default;
  /// n rows of at least `length` doubles each, every row padded to whole packs.
  Rows(int n, int length);
  /// The same in external memory of room(n, length) doubles, with that alignment; the memory must
  /// outlive this object.
  Rows(int n, int length, double* memory);
  static std::ptrdiff_t room(int n, int length) {
    return static_cast<std::ptrdiff_t>(n) * static_cast<std::ptrdiff_t>(padded(length));
  }

  double* operator[](int row) { return memory_.get() + static_cast<std::ptrdiff_t>(row) * stride_; }
  const double* operator[](int row) const {
    return memory_.get() + static_cast<std::ptrdiff_t>(row) * stride_;
  }
  int count() const { return count_; }
  int stride() const { return stride_; }
  std::span<double> all() { return {memory_.get(), size()}; }
  std::span<const double> all() const { return {memory_.get(), size()}; }

 private:
  struct Free {
    std::size_t alignment;  // 0: external memory
    void operator()(double* memory) const;
  };
  std::size_t size() const { return static_cast<std::size_t>(count_) * static_cast<std::size_t>(stride_); }

  int count_ = 0, stride_ = 0;
  std::unique_ptr<double[], Free> memory_{nullptr, Free{0}};
};

/// A program bound to the rows it reads and writes. Binding allocates, running does not.
///
/// The caller owns the input and output rows. They have one common length and are aligned and
/// padded as `Rows`. Results are written in place, in the padding too.
class Evaluation {
 public:
  Evaluation() = default;
  /// @param program  must outlive the evaluation
  /// @param length   numbers per row: the points at which the formula is evaluated
  Evaluation(const Program& program, int length);
  Evaluation(Program&&, int) = delete;

  void input(int i, const double* row) { at(i) = const_cast<double*>(row); }  // never written
  void output(int i, double* row) { at(program_->first_output() + i) = row; }

  /// Evaluates all points. Every input and output must be bound; outputs must not overlap inputs.
  void run() const noexcept;

 private:
  double*& at(int row) { return rows_[static_cast<std::size_t>(row)]; }

  const Program* program_ = nullptr;
  int packs_ = 0;
  Rows own_;  // constants and scratch
  std::vector<double*> rows_;
};

/// The outputs of a program at one point, for tests and set-up; allocates.
std::vector<double> evaluate(const Program& program, std::span<const double> inputs);

}  // namespace sightline
