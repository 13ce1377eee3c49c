/// Graphs of observation and influence, as figures of a run's page.
#pragma once

#include <vector>

#include "sightline/log.hpp"
#include "sightline/report.hpp"

namespace sightline {

/// Most bodies of a graph.
inline constexpr std::size_t graph_bodies_max = 64;

/// Graphs of the observations and the influences in a run's log. Omits a graph without an arrow, or
/// with more than graph_bodies_max bodies.
std::vector<Figure> graph_figures(const Recording& recording);

/// "a cascade of depth 3": the structure of the robots' influences for the solver.
std::string influence_words(const Recording& recording);

}  // namespace sightline
