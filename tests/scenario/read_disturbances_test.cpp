#include "sightline/scenario/read_disturbances.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

Disturbances of(const std::string& text) {
  const TomlDocument document = parse_toml("[d]\n" + text, "a");
  return read_disturbances(TomlTable(document).table("d"));
}
std::string refused(const std::string& text) {
  return refusal_of<ScenarioError>([&] { of(text); });
}

TEST(ReadDisturbances, WindIsAVectorOrASizeAndADirection) {
  const Disturbances vector = of("wind = [0.1, -0.2, 0.3]\n");
  EXPECT_EQ(vector.wind.x, 0.1);
  EXPECT_EQ(vector.wind.z, 0.3);
  for (double direction = -7.0; direction < 7.0; direction += 0.1) {
    const Disturbances d = of(fmt::format("wind = {{ size = 0.5, direction = {} }}\n", direction));
    EXPECT_NEAR(d.wind.x, 0.5 * std::cos(direction), 1e-12);
    EXPECT_NEAR(d.wind.y, 0.5 * std::sin(direction), 1e-12);
    EXPECT_EQ(d.wind.z, 0.0);
  }
  EXPECT_EQ(of("wind.size = 0.5\n").wind.x, 0.5) << "without a direction along x";
  EXPECT_EQ(norm(of("wind.direction = 0.5\n").wind), 0.0);
}

TEST(ReadDisturbances, WhatIsNoWindIsRefused) {
  EXPECT_EQ(refused("wind = { size = -1.0, direction = 0.0 }\n"),
            "a:2: d.wind.size = -1, expected >= 0 m/s^2");
  EXPECT_EQ(refused("wind = { size = 1.0, towards = 0.0 }\n"),
            "a:2: d.wind.towards = 0, expected a known key: size, direction");
  EXPECT_EQ(refused("wind = 1.0\n"), "a:2: d.wind = 1, expected an array of 3 numbers");
}

}  // namespace
}  // namespace sightline
