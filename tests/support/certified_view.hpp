/// A scenario that is looked at, with a campaign that certifies it.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/command.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline::test {

/// Writes look.toml, flies its campaign, and has certificate.json in the folder `certified`.
/// @return the scenario's file
inline std::filesystem::path certified_scenario(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "look.toml";
  std::string text = view_scenario;
  text.replace(text.rfind("at = 0.5"), 8, "at = 2.5");
  text.replace(text.rfind("duration = 1.0"), 14, "duration = 3.0");
  text.replace(text.find("[0.9, 0.0, 1.0, 1.0"), 19, "[0.9, 0.0, 0.5, 1.0");  // the target stays in view
  std::ofstream(file) << text << R"toml(
[campaign]
duration = 1.0
view_within = 0.2
[[campaign.draw]]
key = "agent.uav1.start.p[0]"
uniform = [0.8, 1.0]
)toml";
  (void)sightline(
      "campaign " + file.string() + " --runs 5 --certify=200 -o " + (folder / "certified").string(), folder);
  EXPECT_TRUE(std::filesystem::exists(folder / "certified" / "certificate.json"));
  return file;
}

}  // namespace sightline::test
