/// Figures of a potential, those of Figs. 8 to 16 of the paper for any limit.
#pragma once

#include <vector>

#include "sightline/analysis/verdict.hpp"
#include "sightline/report.hpp"

namespace sightline {

/// Figures of each step of the workflow: unit step, slope, sigmoid at several sharpnesses, in the
/// sensor frame and in the global one, the gradient and the force. All show the potential alone,
/// without its weight.
/// @param set  a limit whose boundary the first figure shows too, or nullptr
std::vector<Drawing> drawings_of(const Potential& potential, const Verdict& verdict, const Potential* set);

}  // namespace sightline
