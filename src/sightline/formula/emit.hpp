/// Prints a program as straight-line C++ over any lane.
///
/// The numbers of the program are not printed: they come in an array, so that one function serves every value
/// of a model's parameters, as long as the same operations remain.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sightline/formula/program.hpp"

namespace sightline {

/// A run of a program's inputs or outputs.
struct Block {
  std::string_view name;
  int size = 0;

  bool operator==(const Block&) const = default;
};

/// The same for programs that differ in the values of their constants alone.
std::uint64_t structure(const Program& program);

/// What a printed function counts on besides its structure, which is a hash.
struct ProgramSize {
  int inputs = 0, outputs = 0, constants = 0, instructions = 0;

  bool operator==(const ProgramSize&) const = default;
};
ProgramSize size_of(const Program& program);

/// The program as a function template over the lane L, in the order of its instructions:
///
///   template <class L> static void name(const double* constants, const double* in..., double* out...)
///
/// with one argument for each block; packs of a block stand side by side. The same bits as the interpreter's.
std::string emit(const Program& program, std::string_view name, std::span<const Block> inputs,
                 std::span<const Block> outputs);

}  // namespace sightline
