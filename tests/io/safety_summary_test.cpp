#include "sightline/io/safety_summary.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

Scenario scenario(const std::string& safety) {
  return parse_scenario(R"(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
[agent.b]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0] }
[obstacle.o]
p = [9.0, 0.0, 1.0]
d_hard = 1.2
)" + safety,
                        "a.toml");
}

const std::vector<Presence> there = {Presence::steered, Presence::steered, Presence::hold};

std::vector<Sight<double>> places(double a, double b, double o) {
  std::vector<Sight<double>> sights(3);
  sights[0].p.x = a, sights[1].p.x = b, sights[2].p.x = o;
  return sights;
}

TEST(SafetySummary, KeepsTheLeastOfEachHardDistanceAndItsTime) {
  SafetySummary summary(scenario("[safety]\nbarrier = \"on\"\nd_hard = 0.5\n"));
  const std::vector<BarrierRecord> idle(2);
  summary.add(0.0, places(0, 3, 9), there, idle);
  summary.add(0.1, places(0, 0.6, 9), there, idle);
  summary.add(0.2, places(0, 4, 5.1), there, idle);
  EXPECT_EQ(summary.pairs().size(), 3U);
  const std::vector<std::string> broken = summary.broken();
  ASSERT_EQ(broken.size(), 1U);
  EXPECT_EQ(broken[0], "b came within 1.1 m of o at 0.20 s, d_hard is 1.2 m");
  const auto json = nlohmann::json::parse(summary.json());
  EXPECT_EQ(json.at("barrier"), "on");
  EXPECT_EQ(json.at("hard_distances").at(0).at("b"), "o") << "the worst first";
  EXPECT_NEAR(json.at("hard_distances").at(1).at("least").get<double>(), 0.6, 1e-12);
  EXPECT_EQ(json.at("hard_distances").at(1).at("time"), 0.1);
  const auto lines = safety_lines(summary.json());
  EXPECT_EQ(lines.at(0).second, "b and o: 1.1 m at least, BROKEN, to be 1.2 m");
  EXPECT_EQ(lines.at(1).second, "a and b: 0.6 m at least, kept 0.5 m");
}

TEST(SafetySummary, ADistanceThatIsJustReachedIsKept) {
  SafetySummary summary(scenario("[safety]\nd_hard = 0.5\n"));
  summary.add(0.0, places(0, 0.5, 9), there, {});
  EXPECT_TRUE(summary.broken().empty());
  summary.add(0.0, places(0, 0.4999999, 9), there, {});
  EXPECT_EQ(summary.broken().size(), 1U);
}

TEST(SafetySummary, ABodyThatIsNotThereComesNearNobody) {
  SafetySummary summary(scenario("[safety]\nd_hard = 0.5\n"));
  const std::vector<Presence> alone = {Presence::steered, Presence::absent, Presence::absent};
  summary.add(0.0, places(0, 0.1, 0.2), alone, {});
  EXPECT_TRUE(summary.broken().empty());
  summary.add(0.1, places(0, 0.1, 9), there, {});
  EXPECT_EQ(summary.broken().size(), 1U);
}

TEST(SafetySummary, TellsHowOftenTheBarrierActed) {
  for (const auto& [mode, word] : {std::pair{"on", "acted"}, {"report", "would have acted"}}) {
    SafetySummary summary(scenario("[safety]\nbarrier = \"" + std::string(mode) + "\"\n"));
    std::vector<BarrierRecord> records(2);
    for (int k = 0; k < 8; ++k) {
      records[1] = {.active = k < 2, .conflict = k < 1};
      summary.add(0.1 * k, places(0, 3, 9), there, records);
    }
    const auto lines = safety_lines(summary.json());
    ASSERT_EQ(lines.size(), 5U);
    EXPECT_EQ(lines[3].first, "barrier of a");
    EXPECT_EQ(lines[3].second, std::string(word) + " 0.0 % of the time");
    EXPECT_EQ(lines[4].second, std::string(word) + " 25.0 % of the time, in conflict 12.5 %");
  }
}

TEST(SafetySummary, SaysNothingWhereNobodyAsks) {
  const Scenario free =
      parse_scenario("[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0.0, 0.0, 1.0] }\n", "a");
  EXPECT_EQ(SafetySummary(free).json(), "");
}

}  // namespace
}  // namespace sightline
