#include "sightline/report/scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "sightline/report.hpp"
#include "sightline/safety/zone.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using Bodies = std::vector<std::optional<Sight<double>>>;

const std::string team_to_draw =
    "[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.sensor]\nMOUNT\nframe = "
    "\"FRAME\"\n"
    "[agent.b]\nrobot = \"multirotor\"\nstart = { p = [2, 0, 1] }\n[target.t]\np = [4, 0, 1]\n"
    "[[couple]]\npotential = { sensor_cone = { alpha = 0.5 } }\nbetween = [\"a\", \"b\"]\nfelt_by = [\"a\"]\n"
    "[[couple]]\npotential = { keep_out = { d_min = 1.0 } }\nbetween = [\"b\", \"a\"]\nfelt_by = [\"b\"]\n"
    "[[couple]]\npotential = { keep_out = { d_min = 1.0 } }\nbetween = [\"b\", \"t\"]\nfelt_by = [\"b\"]\n"
    "[safety]\nbarrier = \"on\"\nd_hard = 0.7\n";

constexpr std::string_view mounted_ahead = "pitch = 0.4\noffset = 0.2",
                           mounted_aside = "yaw = 1.57\npitch = 0.4\nroll = -0.5\noffset = [0.1, -0.2, 0.05]";

Scenario scene_of(const std::string& frame, std::string_view mount = mounted_ahead,
                  std::string_view rest = "") {
  std::string text = team_to_draw;
  text.replace(text.find("FRAME"), 5, frame);
  text.replace(text.find("MOUNT"), 5, mount);
  return test::scenario_of(text.append(rest));
}

std::vector<Drawn> in_group(const std::vector<Drawn>& all, std::string_view group) {
  std::vector<Drawn> some;
  std::copy_if(all.begin(), all.end(), std::back_inserter(some),
               [&](const Drawn& d) { return d.group == group; });
  return some;
}

bool is_colour(const Colour& c, std::string_view hex) {
  const auto part = [&](std::size_t at) {
    return static_cast<float>(std::stoi(std::string(hex.substr(at, 2)), nullptr, 16)) / 255.0F;
  };
  return c.r == part(1) && c.g == part(3) && c.b == part(5);
}

// Its rim is at the limit of the view angle, by the function that judges flights; green and red are
// as judged.
TEST(Scene, TheConeOfAViewIsThatOfItsLimit) {
  std::mt19937_64 random(1);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  for (const auto& [frame, mount] : {std::pair{"level", mounted_ahead},
                                     {"body", mounted_ahead},
                                     {"level", mounted_aside},
                                     {"body", mounted_aside}}) {
    const Scenario scenario = scene_of(frame, mount);
    const Scene scene(scenario);
    ASSERT_EQ(scene.pairs().size(), 2u);
    int green = 0;
    for (int k = 0; k < 500; ++k) {
      Bodies bodies(3);
      for (auto& body : bodies) {
        const double psi = draw(-3, 3);
        body = Sight<double>{{{draw(-3, 3), draw(-3, 3), draw(0, 3)}, {std::cos(psi), std::sin(psi)}},
                             {},
                             {draw(-0.4, 0.4), draw(-0.4, 0.4)}};
      }
      const Observation& view = *scene.pairs()[0].view;
      const std::vector<Drawn> all = scene.draw(bodies, 0.0), cones = in_group(all, "views"),
                               links = in_group(all, "links");
      ASSERT_EQ(cones.size(), 1u);
      ASSERT_EQ(cones[0].points.size() % 3, 0u);
      for (std::size_t i = 0; i < cones[0].points.size(); ++i) {
        if (i % 3 == 0)
          EXPECT_NEAR(norm(view.mount(*bodies[0], cones[0].points[i])), 0.0, 1e-9) << frame;
        else
          EXPECT_NEAR(view_angle(view.mount, *bodies[0], cones[0].points[i]), 0.5, 1e-9) << frame;
      }
      const bool seen = view_angle(view.mount, *bodies[0], bodies[1]->p) <= 0.5;
      green += seen ? 1 : 0;
      EXPECT_TRUE(is_colour(cones[0].colour, seen ? palette_green : palette_red));
      EXPECT_TRUE(is_colour(links[0].colour, seen ? palette_green : palette_red));
      EXPECT_TRUE(is_colour(links[1].colour, palette_grey));  // nobody is to see
    }
    EXPECT_GT(green, 5);
    EXPECT_LT(green, 400);
  }
}

TEST(Scene, EachZoneIsDrawnByTheWallsOnItsBoundary) {
  const Scenario scenario = scene_of("level", mounted_ahead, R"(
[[safety.zone]]
polygon = [[-9, -9], [9, -9], [9, 9], [6, 9], [6, 3], [-9, 3]]
from = 0.5
to = 2.0
keep = "inside"
[[safety.zone]]
polygon = [[5, 5], [6, 5], [6, 6]]
to = 1.0
keep = "outside"
)");
  const Scene scene(scenario);
  const std::vector<Drawn> drawn = in_group(scene.draw(Bodies(3), 0.0), "zones");
  const std::vector<Zone>& zones = scenario.safety->barrier_options.zones;
  ASSERT_EQ(drawn.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(drawn[k].form, Drawn::triangles);
    EXPECT_EQ(drawn[k].id, static_cast<int>(k));
    ASSERT_EQ(drawn[k].points.size(), 6 * zones[k].polygon.size());
    // The middle of each triangle is on the boundary too, and their areas add up to the walls.
    double area = 0.0, around = 0.0;
    for (std::size_t i = 0; i < drawn[k].points.size(); i += 3) {
      const Vec3<double>&a = drawn[k].points[i], &b = drawn[k].points[i + 1], &c = drawn[k].points[i + 2];
      EXPECT_NEAR(zone_reserve(zones[k], (1.0 / 3) * (a + b + c)), 0.0, 1e-9);
      const Vec3<double> u = b - a, v = c - a;
      area += 0.5 * std::sqrt(dot(u, u) * dot(v, v) - dot(u, v) * dot(u, v));
    }
    for (std::size_t i = 0, n = zones[k].polygon.size(); i < n; ++i) {
      const Vec2<double>&a = zones[k].polygon[i], &b = zones[k].polygon[(i + 1) % n];
      around += std::hypot(b.x - a.x, b.y - a.y);
    }
    EXPECT_NEAR(area, around * (k == 0 ? 1.5 : 3.0), 1e-9);
  }
  EXPECT_TRUE(is_colour(drawn[0].colour, palette_grey));
  EXPECT_TRUE(is_colour(drawn[1].colour, palette_red));
}

TEST(Scene, EachBodyAndEachPairIsDrawnOnceAndOnlyWhatIsKnown) {
  const Scene scene(scene_of("level"));
  const Bodies bodies = {Sight<double>{{{0, 0, 1}, {1, 0}}, {}}, Sight<double>{{{3, 0, 1}, {0, 1}}, {}},
                         Sight<double>{{{3, 4, 1}, {1, 0}}, {}}};
  const std::vector<Drawn> all = scene.draw(bodies, 0.0);
  std::set<std::pair<std::string_view, int>> names;
  for (const Drawn& d : all) EXPECT_TRUE(names.insert({d.group, d.id}).second) << d.group << d.id;
  EXPECT_EQ(in_group(all, "robots").size(), 2u);
  EXPECT_EQ(in_group(all, "bodies").size(), 1u);
  EXPECT_EQ(in_group(all, "names")[2].words, "t");
  const auto hard = in_group(all, "hard_distances");
  ASSERT_EQ(hard.size(), 1u);
  EXPECT_EQ(hard[0].size.x, 1.4);  // the diameter
  EXPECT_EQ(hard[0].p.y, 4.0);
  const auto distances = in_group(all, "distances");
  ASSERT_EQ(distances.size(), 2u);
  EXPECT_EQ(distances[0].words, "3.00 m");
  EXPECT_EQ(distances[1].words, "4.00 m");
  EXPECT_EQ(distances[1].p.y, 2.0);

  const std::vector<Drawn> some = scene.draw(Bodies{bodies[0], std::nullopt, bodies[2]}, 0.0);
  EXPECT_EQ(in_group(some, "robots").size(), 1u);
  EXPECT_TRUE(in_group(some, "links").empty());
  EXPECT_TRUE(scene.draw(Bodies(3), 0.0).empty());
}

}  // namespace
}  // namespace sightline
