/// A limit as text keeps the line of sight past what goes round the target: in
/// scenarios/line_of_sight.toml a pillar, in scenarios/third_robot.toml another robot.
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "sightline/scenario/read_camera.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline {
namespace {

/// What a flight shows of the line of sight from 4 s on.
class SightWatch final : public test::SampleSink {
 public:
  SightWatch(const Scenario& scenario, Sample sample, std::string_view hides)
      : SampleSink(std::move(sample)), scenario_(scenario), hides_(hides) {}
  void publish() noexcept override {
    constexpr double begun = 4.0;
    if (sample_.time < begun) return;
    const auto place = [&](std::string_view name) {
      const BodyId body = scenario_.team.find(name);
      const auto x = static_cast<std::size_t>(scenario_.team.state_offset(body));
      return Vec3<double>{sample_.x[x], sample_.x[x + 1], sample_.x[x + 2]};
    };
    const bool hidden = scenario_.vision.hulls[0].hull.hides(place(hides_), place("uav0"), place("uav1"));
    ++periods;
    in_sight += hidden ? 0 : 1;
    detections += static_cast<int>(sample_.detection_count);
    for (std::size_t i = 0; i < sample_.detection_count; ++i) {
      longest_gap = std::max(longest_gap, sample_.detections[i].stamp - last_);
      last_ = sample_.detections[i].stamp;
    }
  }

  int periods = 0, in_sight = 0, detections = 0;
  double longest_gap = 0.0;  // without a picture that shows the target [s]

 private:
  const Scenario& scenario_;
  std::string_view hides_;
  double last_ = 4.0;
};

SightWatch flown(const std::string& name, std::string_view hides, const std::vector<std::string>& set) {
  const Scenario scenario =
      read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/" + name, built_in_registry(), set);
  Controls controls(scenario);
  SimulatedClock clock;
  const Controllers controllers = controls.controllers();
  const auto world = make_world(scenario);
  SightWatch watch(scenario, sized_sample(*world, controllers), hides);
  EXPECT_TRUE(ClosedLoop(scenario, *world, controllers, clock, watch).fly().finite);
  return watch;
}

class LineOfSight : public testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(LineOfSight, IsKeptByALimitAndWithoutItDetectionsStop) {
  const auto& [name, hides] = GetParam();
  const SightWatch kept = flown(name, hides, {}), free = flown(name, hides, {"couple[4].weight=0.0"});
  EXPECT_GT(kept.in_sight, 0.95 * kept.periods);
  EXPECT_LT(kept.longest_gap, 0.15);
  EXPECT_LT(free.in_sight, 0.95 * free.periods);
  EXPECT_GT(free.longest_gap, 0.25);
  EXPECT_GT(kept.detections, free.detections);
}

INSTANTIATE_TEST_SUITE_P(, LineOfSight,
                         testing::Values(std::pair("line_of_sight.toml", "pillar"),
                                         std::pair("third_robot.toml", "uav2")));

}  // namespace
}  // namespace sightline
