/// gnuplot, as a function of its script.
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// What gnuplot writes to its standard output. No file has a name: whatever ends this process leaves none behind.
/// @throws std::runtime_error where gnuplot is missing or fails, with what it says
std::string run_gnuplot(std::string_view script);

}  // namespace sightline
