/// The components of the library that this build has.
#pragma once

#include <string>
#include <string_view>

namespace sightline::cli {

/// @param component  campaign, analysis or server
constexpr bool has(std::string_view component) {
  return std::string_view(SIGHTLINE_COMPONENTS).find(component) != std::string_view::npos;
}

/// A sentence: this build lacks `what`, and how to build it.
std::string left_out(std::string_view what, std::string_view component);

}  // namespace sightline::cli
