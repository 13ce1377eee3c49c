/// Generator of a C++ file with the compiled functions of models and potentials, for `KernelTable`.
#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/solver/kernels/pose_potential.hpp"
#include "sightline/solver/kernels/stage.hpp"

namespace sightline {

class Generator {
 public:
  /// Generates user functions, which register with the library's before main.
  Generator() = default;
  /// Generates one part of the library's own functions, to be listed by `index`.
  explicit Generator(std::string part) : part_(std::move(part)) {}

  /// Text of the file that chains the library's parts to one table, built_in_kernels().
  static std::string index(std::span<const Generator> parts);

  /// Adds the stage programs of a model with these barriers, in this order, and with a cost of
  /// input rates; independent of their numbers.
  void add(const Model& model, Seen seen, const std::vector<RelaxedBarrier>& barriers = {},
           const RateCost& rates = {});
  /// Adds the sum of potentials between two bodies, or of one robot, independent of their numbers
  /// and order: acting on both bodies, on either, and with an uncontrolled second body.
  void add(const std::vector<Weighted>& terms);
  /// Adds the potential of a swarm, independent of its numbers.
  void add_swarm(const Weighted& term);

  /// Text of the generated file.
  std::string text() const;
  const std::string& part() const { return part_; }

 private:
  void add(const Program& program, std::string_view potential_name);

  std::string part_;  // empty: user functions
  std::set<std::uint64_t> known_;
  std::string functions_, stage_rows_, formula_rows_;
};

/// Writes a file unless it already holds this text, so that no rebuild is triggered.
/// @return whether the file holds the text
[[nodiscard]] bool write_text(const std::string& path, std::string_view text);

}  // namespace sightline
