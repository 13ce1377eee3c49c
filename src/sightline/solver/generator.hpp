/// Collects models and potentials and prints their compiled functions as one C++ file, for `KernelTable`.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/solver/pose_potential.hpp"
#include "sightline/solver/stage.hpp"

namespace sightline {

class Generator {
 public:
  /// What the file is for.
  enum class For {
    library,  ///< the library's own functions
    user,     ///< functions that join them before main
  };
  explicit Generator(For whom) : for_library_(whom == For::library) {}

  /// The stage programs of a model with these barriers, in this order.
  void add(const Model& model, Seen seen, const std::vector<RelaxedBarrier>& barriers = {});
  /// The sum of potentials between two bodies, or of one robot, whatever their numbers and their order; felt by
  /// both ends, by either, and where the second is not controlled.
  void add(const std::vector<Weighted>& terms);

  /// The file.
  std::string text() const;
  /// @return whether the file could be written
  [[nodiscard]] bool write(const char* path) const;

 private:
  void add(const PosePotential& potential, std::string_view name);

  bool for_library_;
  std::set<std::uint64_t> known_;
  std::string functions_, stage_rows_, formula_rows_;
};

}  // namespace sightline
