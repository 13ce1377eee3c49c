/// Runs gnuplot on a script.
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// Standard output of gnuplot. Its files have no names, so that an aborted process leaves none
/// behind.
/// @throws std::runtime_error with gnuplot's message, if gnuplot is missing or fails
std::string run_gnuplot(std::string_view script);

}  // namespace sightline
