/// Prints a program as straight-line C++ over any lane.
///
/// The numbers of the program are not printed but passed in an array. One function therefore serves
/// all parameter values of a model, as long as the operations stay the same.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "sightline/formula/program.hpp"

namespace sightline {

/// A named contiguous range of a program's inputs or outputs.
struct Block {
  std::string_view name;
  int size = 0;

  bool operator==(const Block&) const = default;
};

/// Hash of a program's structure; equal for programs that differ only in the values of their
/// constants.
std::uint64_t structure(const Program& program);

/// The counts a printed function relies on, besides its structure, which is a hash.
struct ProgramSize {
  int inputs = 0, outputs = 0, constants = 0, instructions = 0;

  bool operator==(const ProgramSize&) const = default;
};
ProgramSize size_of(const Program& program);

/// The program as a function template over the lane L, in the order of its instructions:
///
///   template <class L> static void name(const double* constants, const double* in..., double* out...)
///
/// with one argument per block; the packs of a block are contiguous. Its bits equal the
/// interpreter's.
std::string emit(const Program& program, std::string_view name, std::span<const Block> inputs,
                 std::span<const Block> outputs);

}  // namespace sightline
