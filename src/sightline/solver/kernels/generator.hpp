/// Collects models and potentials and prints their compiled functions as a C++ file, for `KernelTable`.
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
  /// Functions that join the library's before main.
  Generator() = default;
  /// A part of the library's own functions, which `index` names.
  explicit Generator(std::string part) : part_(std::move(part)) {}

  /// The file that makes one table of the library's parts, built_in_kernels().
  static std::string index(std::span<const Generator> parts);

  /// The stage programs of a model with these barriers, in this order; with a cost of its inputs' rates, whatever its numbers.
  void add(const Model& model, Seen seen, const std::vector<RelaxedBarrier>& barriers = {},
           const RateCost& rates = {});
  /// The sum of potentials between two bodies, or of one robot, whatever their numbers and their order; felt by
  /// both ends, by either, and where the second is not controlled.
  void add(const std::vector<Weighted>& terms);
  /// A swarm's potential, whatever its numbers.
  void add_swarm(const Weighted& term);

  /// The file.
  std::string text() const;
  const std::string& part() const { return part_; }

 private:
  void add(const Program& program, std::string_view potential_name);

  std::string part_;  // none: a user's
  std::set<std::uint64_t> known_;
  std::string functions_, stage_rows_, formula_rows_;
};

/// Writes a file unless it holds this text already, so that nothing is built again for it.
/// @return whether it holds it now
[[nodiscard]] bool write_text(const std::string& path, std::string_view text);

}  // namespace sightline
