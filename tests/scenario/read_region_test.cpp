#include "sightline/scenario/read_region.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>

#include "sightline/potential/finite.hpp"
#include "sightline/scenario.hpp"
#include "sightline/vehicle.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/formula_text.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/tree.hpp"

namespace sightline {
namespace {

using test::tree;
namespace fs = std::filesystem;

constexpr std::string_view seeing_robots =
    "[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\nsensor = { pitch = 0.3, offset = 0.1 }\n"
    "[agent.b]\nrobot = \"multirotor\"\nstart = { p = [2, 0, 1] }\n";

Scenario scenario_with(std::string_view potential, const fs::path& file = "a.toml",
                       std::string_view more = "") {
  return parse_scenario(fmt::format("{}[[couple]]\nbetween = [\"a\", \"b\"]\npotential = {{ {} }}\n{}",
                                    seeing_robots, potential, more),
                        file);
}

std::string region_refusal(std::string_view potential, const fs::path& file = "a.toml") {
  return refusal_of<ScenarioError>([&] { scenario_with(potential, file); });
}

const Region& region_of(const Scenario& s) { return *s.team.couplings().at(0).term.potential.as<Region>(); }

TEST(ReadRegion, DeepAndLongFormulasAreRefusedAtOnce) {
  const auto inside = [](const std::string& text) {
    return region_refusal("region = { inside = \"" + text + "\" }");
  };
  const std::string place = "a.toml:10:", at = "couple[0].potential.region.inside = ";
  const std::clock_t begin = std::clock();
  const std::string deep =
      inside(fmt::format("{}x{} > 0", std::string(10'000, '('), std::string(10'000, ')')));
  EXPECT_TRUE(deep.starts_with(place + "136: " + at)) << deep;
  EXPECT_NE(deep.find("nested deeper than 100"), std::string::npos);
  const std::string roots = inside(fmt::format(
      "{0:s}x{1:s} > 0",
      [] {
        std::string open;
        for (int i = 0; i < 10'000; ++i) open += "sqrt(";
        return open;
      }(),
      std::string(10'000, ')')));
  EXPECT_NE(roots.find("nested deeper than 100"), std::string::npos) << roots;
  const std::string lengthy = inside(fmt::format("x > 0 + {}", std::string(1'000'000, '1')));
  EXPECT_TRUE(lengthy.starts_with(place + "36: " + at)) << lengthy;
  EXPECT_NE(lengthy.find("has 1000008 bytes, expected at most 100000"), std::string::npos) << lengthy;
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 1.0);
}

TEST(ReadRegion, ARegionIsReadAsItIsWritten) {
  const Scenario s = scenario_with(
      "region = { inside = { all_of = [\"x > 0 m\", { not = \"range > far\" }] }, kappa_A = 3, smooth = 1e-2,"
      " parameters = { far = { value = 400, unit = \"cm\", range = [100, 500] } },"
      " slope = { softplus = { kappa_G = 0.5, kappa_H = 0.25 } } }");
  const Region same = Region(all_of({"x > 0 m", !Limits("range > 4 m")}))
                          .slope(Softplus{.kappa_G = 0.5, .kappa_H = 0.25})
                          .sigmoid(3)
                          .smoothed_over(1e-2)
                          .seen_from({0.3, 0.1});
  EXPECT_EQ(region_of(s).kappa_A(), 3.0);
  EXPECT_EQ(region_of(s).width(), 1e-2);
  EXPECT_EQ(region_of(s).mount().pitch, 0.3);
  EXPECT_EQ(region_of(s).name(), "region");
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const Sight<double> a = random_sight(random, 4), b = random_sight(random, 4);
    EXPECT_EQ(region_of(s)(a, b, 0), same(a, b, 0));
  }
}

TEST(ReadRegion, ASensorSFileIsFoundBesideTheScenarioAndItsNumbersMayBeReplaced) {
  const fs::path folder = test::fresh_folder();
  fs::create_directory(folder / "sensors");
  std::ofstream(folder / "sensors/eye.toml") << "inside = \"range < far\"\nkappa_A = 2.0\n[parameters]\nfar "
                                                "= { value = \"4 m\", range = [\"1 m\", \"5 m\"] }\n";
  const fs::path file = folder / "s.toml";
  const auto at_3_m = [&](std::string_view potential) {
    const Scenario s = scenario_with(potential, file);
    EXPECT_EQ(region_of(s).name(), "eye");
    Sight<double> a, b;
    a.d = {1, 0};
    b.p = {3, 0, 0};
    return region_of(s).seen_from({0, 0}).violation(a, b, 0);
  };
  EXPECT_DOUBLE_EQ(at_3_m("sensor = { file = \"sensors/eye.toml\" }"), -1.0);
  EXPECT_DOUBLE_EQ(at_3_m("sensor = { file = \"sensors/eye.toml\", parameters = { far = \"2 m\" } }"), 1.0);
  EXPECT_EQ(region_of(scenario_with("sensor = { file = \"sensors/eye.toml\", kappa_A = 9 }", file)).kappa_A(),
            9);

  const std::string scenario = file.native() + ":10:";
  EXPECT_EQ(region_refusal("sensor = { file = \"sensors/eye.toml\", parameters = { far = \"9 m\" } }", file),
            scenario +
                "75: couple[0].potential.sensor.parameters.far = \"9 m\", it is 9 in SI units, expected 1 m "
                "to 5 m");
  EXPECT_EQ(region_refusal("sensor = { file = \"sensors/eye.toml\", parameters = { fat = \"2 m\" } }", file),
            scenario +
                " couple[0].potential.sensor.parameters.fat = \"2 m\", expected a known key, the nearest is "
                "\"far\"");
  EXPECT_NE(
      region_refusal("sensor = { file = \"nowhere.toml\" }", file).find("expected the file of a region"),
      std::string::npos);
  std::ofstream(folder / "sensors/bad.toml") << "# é\ninside = \"range < rang\"\n";
  EXPECT_EQ(region_refusal("sensor = { file = \"sensors/bad.toml\" }", file),
            (folder / "sensors/bad.toml").native() +
                ":2:19: inside = \"range < rang\", \"rang\" is unknown, expected a known name, the nearest "
                "is \"range\"");
}

TEST(ReadRegion, EachShippedSensorAndObstacleIsReadAndFiniteAndHasAnInside) {
  int files = 0;
  Random random(2);
  std::vector<fs::directory_entry> entries;
  for (const char* folder : {"scenarios/sensors", "scenarios/obstacles"}) {
    for (const auto& entry : fs::directory_iterator(tree / folder)) entries.push_back(entry);
  }
  for (const auto& entry : entries) {
    const bool looks_past = test::read_file(entry.path()).find("third.") != std::string::npos;
    const Scenario s =
        scenario_with(fmt::format("sensor = {{ file = \"{}\" }}", entry.path().native()), "a.toml",
                      looks_past ? "third = \"c\"\n[obstacle.c]\np = [1, 1, 1]\n" : "");
    const Region& region = region_of(s);
    EXPECT_EQ(region.sees_third(), looks_past) << entry.path();
    EXPECT_FALSE(not_finite_at(region)) << entry.path();
    int inside = 0;
    for (int k = 0; k < 5000; ++k) {
      Sight<double> observer = random_sight(random, 3);
      if (looks_past) observer.third = random_sight(random, 3).p;
      inside += region.unit_step(observer, random_sight(random, 3), 0) == 0.0;
    }
    EXPECT_GT(inside, 10) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 8);
}

TEST(ReadRegion, TheDownwashThatAPlanAvoidsIsThatOfTheWorld) {
  const Scenario s = scenario_with(
      fmt::format("region = {{ file = \"{}\" }}", (tree / "scenarios/obstacles/downwash.toml").native()));
  const Vehicle vehicle = Vehicle::crazyflie();
  constexpr double scale = 0.88, most = 0.5;
  Random random(3);
  int outside = 0;
  for (int k = 0; k < 5000; ++k) {
    Sight<double> below, above;
    above.p = {uniform(random, -0.2, 0.2), uniform(random, -0.2, 0.2), uniform(random, 0.02, 2.0)};
    above.v = random_point(random, 0.8);
    const Jet jet{.p = above.p,
                  .thrust = vehicle.weight(),
                  .radius2 = 4 * square(vehicle.rotor_radius),
                  .v = {above.v.x, above.v.y, 0}};
    const double push = -scale * vehicle.drag.z / vehicle.mass * jet.air({}).z,
                 violation = region_of(s).violation(below, above, 0);
    EXPECT_NEAR(violation, push - most, 2e-3 * (1 + push)) << above.p.x << ' ' << above.p.z;
    outside += violation > 0;
    above.p.z = -above.p.z;
    EXPECT_LE(region_of(s).violation(below, above, 0), 3.0 - most) << "little air is sucked from above";
    above.p.z -= 0.1;
    EXPECT_LT(region_of(s).violation(below, above, 0), 0.0);
  }
  EXPECT_GT(outside, 300);
  const std::string file = (tree / "scenarios/obstacles/downwash.toml").native();
  for (const auto& [key, value] : {std::pair{"downwash", "3"}, {"most", "0"}, {"disc", "0"}, {"lift", "-1"}})
    EXPECT_NE(region_refusal(
                  fmt::format("region = {{ file = \"{}\", parameters = {{ {} = {} }} }}", file, key, value))
                  .find(fmt::format("region.parameters.{} = {}, it is {} in SI units, expected", key, value,
                                    value)),
              std::string::npos)
        << key;
}

TEST(ReadRegion, AViewNeedsASensorAndADistanceNone) {
  const auto from_b = [](std::string_view limit) {
    return fmt::format(
        "{}[[couple]]\nbetween = [\"b\", \"a\"]\npotential = {{ region = {{ inside = \"{}\" }} }}\n",
        seeing_robots, limit);
  };
  EXPECT_NO_THROW(parse_scenario(from_b("distance < 3 m"), "a.toml"));
  EXPECT_THROW(parse_scenario(from_b("range < 3 m"), "a.toml"), ScenarioError);
}

TEST(ReadRegion, WhatIsNoRegionIsRefusedWithWhatWasExpected) {
  const std::string at = "a.toml:10: couple[0].potential.region";
  EXPECT_EQ(region_refusal("region = {}"), at + ".inside is missing, expected the limits of the region");
  EXPECT_EQ(
      region_refusal("region = { inside = 4 }"),
      at + ".inside = 4, expected a comparison in quotes, or a table with limit, all_of, any_of or not");
  EXPECT_EQ(region_refusal("region = { inside = { all_of = [] } }"),
            at + ".inside.all_of = [], expected an array of one or more limits");
  EXPECT_EQ(region_refusal("region = { inside = \"x > 0\", kappa = 3 }"),
            at + ".kappa = 3, expected a known key, the nearest is \"kappa_A\"");
  EXPECT_EQ(region_refusal("region = { inside = \"x > 0\", slope = { steep = {} } }"),
            at + ".slope.steep = {}, expected a known key: none, quadratic, softplus");
  EXPECT_EQ(region_refusal("region = { inside = \"x > 0\", parameters = { a = true } }"),
            at + ".parameters.a = true, expected a number, a formula in quotes, or a table with value");
}

}  // namespace
}  // namespace sightline
