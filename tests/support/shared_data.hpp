/// Recordings that are no part of the repository; scripts/fetch_data.md has their sources.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

namespace sightline::test {

/// A recording of the data sets; empty, with a line on stdout, where it is not there.
inline std::filesystem::path of_data(const std::string& name) {
  std::filesystem::path place = std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "../shared/data" / name;
  if (std::filesystem::exists(place)) return place;
  std::printf("data not there: %s\n", place.c_str());
  return {};
}

}  // namespace sightline::test
