/// How long a campaign is: a short form for every change, or the whole of it.
#pragma once

#include <cstdlib>
#include <string_view>

namespace sightline {

/// SIGHTLINE_CAMPAIGN=whole asks for the whole.
inline bool whole_campaign() {
  const char* const form = std::getenv("SIGHTLINE_CAMPAIGN");
  return form != nullptr && std::string_view(form) == "whole";
}

}  // namespace sightline
