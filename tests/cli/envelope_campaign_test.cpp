// How fast a target may circle and stay in view.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/campaign.hpp"
#include "tests/support/command.hpp"
#include "tests/support/evasion.hpp"

namespace sightline {
namespace {

void put(std::string& text, std::string_view from, std::string_view to) {
  if (const std::size_t at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
}

/// The observer of a scenario beside a target on a circle of 1 m, in place of the robot it
/// observes. Its potentials are judged, so no barrier keeps it away from what it does not know.
Scenario watching_a_circle(const std::string& name, double speed, double phase, SeenVelocity velocity) {
  std::string text =
      test::read_file(std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "scenarios" / (name + ".toml"));
  text.erase(std::min(text.find("\n[campaign"), text.size()));  // it draws what is replaced
  put(text, "barrier = \"on\"", "barrier = \"off\"");
  const std::size_t begin = text.find("[agent.uav1]"), end = text.find("[[couple]]");
  text.replace(
      begin, end - begin,
      fmt::format("[target.uav1]\nmotion = {{ circle = {{ centre = [0.0, 0.0, 1.0], radius = 1.0, rate "
                  "= {}, phase = {} }} }}\nvelocity = \"{}\"\n\n",
                  speed, phase, velocity == SeenVelocity::measured ? "measured" : "unknown"));
  return parse_scenario(std::move(text), "envelope.toml");
}

struct View {
  double share = 0.0, angle_max = 0.0;  // of the time after 10 s; [rad]
};

View view_of(const Scenario& scenario) {
  const EvasionPlan plan{.agent = "uav0", .target = "uav1", .obstacle = "uav1", .from = 10.0};
  const EvasionTrace trace = evade(scenario, plan);
  const EvasionSeries& series = trace.series();
  std::size_t seen = 0, all = 0;
  for (std::size_t k = 0; k < series.time.size(); ++k) {
    if (series.time[k] < 10) continue;
    ++all;
    seen += series.angle[k] <= 0.5;
  }
  return {static_cast<double>(seen) / static_cast<double>(all), trace.row().max_angle};
}

std::vector<double> phases() {
  if (!whole_campaign()) return {0.0, 2.0};
  std::vector<double> all;
  for (int i = 0; i < 24; ++i) all.push_back(i * std::numbers::pi / 12);
  return all;
}

class Envelope : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Speeds, Envelope, testing::Values(0.3, 0.5, 0.75, 1.0));

TEST_P(Envelope, ATargetOnACircleOfAMetreStaysInView) {
  for (const double phase : phases()) {
    for (const SeenVelocity velocity : {SeenVelocity::measured, SeenVelocity::unknown}) {
      const View view = view_of(watching_a_circle("cooperative_localization", GetParam(), phase, velocity));
      EXPECT_EQ(view.share, 1.0) << phase;
      EXPECT_LE(view.angle_max, velocity == SeenVelocity::measured ? 0.15 : 0.5) << phase;
    }
  }
}

TEST_P(Envelope, ARobotOnACircleOfAMetreStaysInViewUnderTheBarrier) {
  std::string text = test::read_file(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml");
  ASSERT_NE(text.find("barrier = \"on\""), std::string::npos);
  put(text, "radius = 0.5, rate = 0.3", fmt::format("radius = 1.0, rate = {}", GetParam()));
  const View view = view_of(parse_scenario(std::move(text), "envelope.toml"));
  EXPECT_EQ(view.share, 1.0);
  EXPECT_LE(view.angle_max, 0.1);
}

TEST_P(Envelope, WithThePapersPotentialsItIsLostForMuchOfTheTime) {
  for (const double phase : phases()) {
    const View view = view_of(watching_a_circle("paper_7_1", GetParam(), phase, SeenVelocity::measured));
    EXPECT_LT(view.share, 0.8) << phase;
  }
}

}  // namespace
}  // namespace sightline
