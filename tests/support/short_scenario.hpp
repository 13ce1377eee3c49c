/// Shipped scenarios with another duration.
#pragma once

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "tests/support/command.hpp"

namespace sightline::test {

/// A shipped scenario of 60 s with another duration [s], in a file of its name in `folder`.
inline std::filesystem::path short_scenario(const std::filesystem::path& folder, const std::string& name,
                                            const std::string& duration) {
  std::filesystem::path file = folder / (name + ".toml");
  std::ofstream(file) << std::regex_replace(read_file(SIGHTLINE_SOURCE_DIR "/scenarios/" + name + ".toml"),
                                            std::regex("duration = 60.0"), "duration = " + duration);
  return file;
}

}  // namespace sightline::test
