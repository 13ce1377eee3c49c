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

/// So many runs, or in the short form one of `part`.
inline int runs(int whole, int part) { return whole_campaign() ? whole : whole / part; }

}  // namespace sightline
