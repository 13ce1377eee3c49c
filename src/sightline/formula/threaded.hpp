/// Fast evaluation of a program over one pack of lanes, as threaded code. The schedule places
/// instructions where their operands are ready. Each function runs a short chain of instructions
/// with its running result in a register, then jumps to the next function.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "sightline/formula/interpret.hpp"

namespace sightline {

/// A program over W points side by side, with its inputs and outputs in blocks of packs. Running
/// does not allocate.
template <int W>
class Threaded {
 public:
  /// @param inputs, outputs  rows of each block, in the program's order
  Threaded(const Program& program, std::span<const int> inputs, std::span<const int> outputs);

  /// Takes one pointer per block. Outputs must not overlap inputs, because run() writes outputs
  /// before it has read all inputs.
  void run(std::initializer_list<const double*> inputs, std::initializer_list<double*> outputs) noexcept;

 private:
  using L = Lane<W>;
  using Vector = typename L::Vector;
  /// A row: its block above, its offset there below, read as one word.
  using Place = std::uint32_t;
  /// One function, the place of its result, and the operands of each of its instructions. The
  /// result passes on in a register.
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
  std::vector<double*> blocks_;  // followed by the caller's blocks
  std::vector<Step> steps_;
};

}  // namespace sightline
