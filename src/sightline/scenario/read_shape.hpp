/// Reads shapes of a team, [[shape]]: many couplings in one table.
#pragma once

#include "sightline/scenario.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// Greatest number of couplings that one shape may expand to.
inline constexpr std::size_t shape_couplings_max = 100'000;

/// Expands one [[shape]] to couplings of the team; `nearest` and `best` also add events.
void read_shape(const TomlTable& at, const Observers& observers, ScenarioSpec& scenario);

}  // namespace sightline
