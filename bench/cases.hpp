/// The control problems that `sightline bench` flies.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/kernel_table.hpp"

namespace sightline {

/// One of:
///
///   pair, pair_masked        the two robots of the paper; both feel the couplings, or the observer alone
///   chain_M, chain_M_masked  M robots in a row, M = 2, 4, 8, 16, 32, 64: each watches the next, the last
///                            flies the circle
///   chain_8_interpreted      chain_8 without compiled functions
///   ring_mixed               eight robots of four models, of 4 to 12 states, in a ring
///   saturating               pair, from 4 m away: inputs run into their limits
///   cascade_M                scenarios/chain8.toml with M robots, each feels what it watches; M = 8 to 1024
///   strong_chain_M           so, and robots two apart keep their distance, which both feel
///   mutual_chain_M           so, and all is felt by both
///   grid_M                   rows of four, each keeps apart from its neighbours, which both feel
///
/// chain_M goes on to 1024 as well, with all numbers between. Of these, those of 8 and 64 robots are flown unasked.
struct BenchCase {
  std::string name;
  Team team{};
  std::vector<double> x0{};  ///< states of all robots at the start (nx)
  bool masked = false;
  KernelChoice kernels = KernelChoice::compiled_if_there;
};

inline constexpr Horizon bench_horizon{.T = 1.0, .N = 20, .dt = 0.01};

/// The names of those that are flown unasked, in the order of the table.
std::vector<std::string> bench_case_names();

/// M of "FAMILY_M", 8 to 1024; none where the name is another.
std::optional<int> team_size(std::string_view name, std::string_view family);

/// @throws std::invalid_argument for a name that is none, with the names there are
BenchCase bench_case(std::string_view name);

}  // namespace sightline
