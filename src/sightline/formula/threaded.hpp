/// Runs a program over one pack of lanes, fast: in an order in which results are there when they are needed; each
/// function does a short chain of instructions with its running result in a register, and ends in a jump to the
/// next.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "sightline/formula/interpret.hpp"

namespace sightline {

/// A program over W points side by side, its inputs and outputs in blocks of packs. Running does not allocate.
template <int W>
class Threaded {
 public:
  /// @param inputs, outputs  rows of each block, in the program's order
  Threaded(const Program& program, std::span<const int> inputs, std::span<const int> outputs);

  /// One pointer for each block. Outputs are written before all inputs are read: they must not overlap.
  void run(std::initializer_list<const double*> inputs, std::initializer_list<double*> outputs) noexcept;

 private:
  using L = Lane<W>;
  using Vector = typename L::Vector;
  /// A row: its block above, and where it begins there, read in one go.
  using Place = std::uint32_t;
  /// One function, where its result goes, and the operands of each of its instructions. The result is handed on.
  struct Step {
    void (*run)(Vector before, const Step* step, double* const* blocks) = nullptr;
    Place d = 0;
    std::array<Place, 7> operands{};
  };

  static constexpr int number_bits = 20;
  static Place place(std::size_t block, int row);
  static double* address(Place place, double* const* blocks) {
    return blocks[place >> number_bits] + (place & ((1u << number_bits) - 1));
  }
  template <int shape>
  static void run_chain(Vector before, const Step* step, double* const* blocks);
  template <Code code>
  static void run_alone(Vector before, const Step* step, double* const* blocks);
  static void finish(Vector, const Step*, double* const*) {}

  Rows own_;                     // block 0: constants and scratch
  std::vector<double*> blocks_;  // then the caller's
  std::vector<Step> steps_;
};

}  // namespace sightline
