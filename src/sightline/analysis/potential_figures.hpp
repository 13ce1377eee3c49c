/// A potential as pictures, those of Figs. 8 to 16 of the paper for any limit.
#pragma once

#include <vector>

#include "sightline/analysis/verdict.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// What each step of the workflow makes of a limit: unit step, slope, sigmoid at several sharpnesses, in the sensor
/// frame and in the global one, the gradient and the force; all of the potential by itself, without its weight.
std::vector<Drawing> drawings_of(const Potential& potential, const Verdict& verdict);

}  // namespace sightline
