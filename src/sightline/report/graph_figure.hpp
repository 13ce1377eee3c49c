/// Who observes whom and who influences whom, as pictures of a run's page.
#pragma once

#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Most bodies that a graph is drawn of.
inline constexpr std::size_t graph_bodies_max = 64;

/// The observations and the influences of a run, as its log tells them; a graph without an arrow, or of too many
/// bodies, is left out.
std::vector<Figure> graph_figures(const Recording& recording);

/// "a cascade of depth 3": how the robots influence each other, as the solver sees it.
std::string influence_words(const Recording& recording);

}  // namespace sightline
