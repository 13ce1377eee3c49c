/// Outputs of `sightline potential`: index.html and verdict.json for the couplings of a team.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/analysis/verdict.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// A judged coupling. Couplings with the same formula, numbers and name are judged once.
struct JudgedCoupling {
  std::size_t coupling;                ///< in the order of the file
  std::optional<std::size_t> same_as;  ///< an earlier coupling with the same potential
  Verdict verdict;
};

/// @param only  index of one coupling; empty: all
/// @param x0  states of all bodies at the start (team.nx()); empty: all are at the origin. A
///   potential that depends on the bodies' places in G is judged around the start of its first
///   body.
std::vector<JudgedCoupling> judge_couplings(const Team& team, std::optional<std::size_t> only = {},
                                            const VerdictOptions& options = {},
                                            std::span<const double> x0 = {});

/// "couple[0] sensor_cone of uav0 and uav1".
std::string title_of(const Team& team, std::size_t coupling);

/// HTML page with the figures, one section for each different potential.
std::string potential_html(const Scenario& scenario, const std::vector<JudgedCoupling>& judged);
/// JSON text: {"scenario", "couplings": [{"couple", "potential", "between", "weight", "same_as" or
/// "verdict"}]}.
std::string verdict_json(const Scenario& scenario, const std::vector<JudgedCoupling>& judged);

}  // namespace sightline
