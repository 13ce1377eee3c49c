/// The control problems that `sightline bench` flies.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/kernels.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// The cases:
///
///   pair, pair_masked        the two robots of the paper; couplings in the cost of both, or of
///                            the observer alone
///   chain_M, chain_M_masked  M robots in a row, M = 2, 4, 8, 16, 32, 64: each observes the next,
///                            the last flies the circle
///   chain_8_interpreted      chain_8 without compiled functions
///   ring_mixed               eight robots of four models, of 4 to 12 states, in a ring
///   saturating               pair, from 4 m away: inputs reach their limits
///   cascade_M                scenarios/chain8.toml with M robots, couplings in the cost of the
///                            observer; M = 8 to 1024
///   strong_chain_M           cascade_M, and robots two apart keep their distance, in both costs
///   mutual_chain_M           strong_chain_M, with all couplings in both costs
///   grid_M                   rows of four, neighbours keep apart, in both costs
///
/// chain_M also accepts all M up to 1024. By default, the benchmark flies the listed chains, and
/// each of the last four families with 8 and with 64 robots.
struct BenchCase {
  std::string name;
  Team team{};
  std::vector<double> x0{};  ///< states of all robots at the start (nx)
  bool masked = false;
  KernelChoice kernels = KernelChoice::compiled_if_there;
};

inline constexpr Horizon bench_horizon{.T = 1.0, .N = 20, .dt = 0.01};

/// The names of the cases flown by default, in the order of the table.
std::vector<std::string> bench_case_names();

/// The names of the cases that are paced by default: one in and three beyond the nearest caches.
std::vector<std::string> paced_case_names();

/// M of "FAMILY_M", 8 to 1024; none for another name.
std::optional<int> team_size(std::string_view name, std::string_view family);

/// @throws std::invalid_argument for an unknown name, listing the known names
BenchCase bench_case(std::string_view name);

}  // namespace sightline
