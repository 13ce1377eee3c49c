#include "sightline/analysis/identification/flown_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

Team fleet() {
  Team team;
  team.add(Multirotor{}, {.name = "uav"});
  team.add(OmniRover{}, {.name = "rover"});
  team.add(AngleMultirotor{}, {.name = "scout"});
  team.add(Obstacle{.name = "target"});
  return team;
}

TEST(FlownMotion, IsOfAMultirotorThatIsNamedOrTheOnlyOne) {
  const Team team = fleet();
  EXPECT_EQ(identified_robot(team, "scout").index, 2);
  EXPECT_EQ(refusal_of([&] { identified_robot(team, ""); }),
            "--agent is missing, expected one of uav, scout");
  EXPECT_EQ(refusal_of([&] { identified_robot(team, "uav7"); }),
            "--agent = uav7, expected one of uav, scout");
  EXPECT_THAT(refusal_of([&] { identified_robot(team, "rover"); }),
              HasSubstr("--agent = rover is of the kind omni_rover, expected a multirotor"));
  EXPECT_NE(refusal_of([&] { identified_robot(team, "target"); }), "");
  Team one;
  one.add(OmniRover{}, {.name = "rover"});
  EXPECT_THAT(refusal_of([&] { identified_robot(one, ""); }),
              HasSubstr("--agent is missing and no robot is a multirotor"));
  one.add(Multirotor{}, {.name = "uav"});
  EXPECT_EQ(identified_robot(one, "").index, 1);
}

TEST(FlownMotion, AMeasurementStandsAtTheTimeAtWhichItWasSo) {
  const Team team = fleet();
  const Model& model = team.model(BodyId{0});
  FlownMotion motion = motion_of(team, identified_robot(team, "uav"), 0.01);
  for (int k = 0; k < 10; ++k) {
    const std::array<double, 7> x = {0.1 * (k - 3), 0, 1, 1, 0, 0, 0}, now = {0.1 * k, 0, 1, 1, 0, 0, 0};
    motion.add(model, x.data(), k < 3 ? std::numeric_limits<double>::infinity() : 0.03, now.data(), {});
  }
  for (int k = 0; k < 7; ++k) {
    EXPECT_NEAR(motion.measured[static_cast<std::size_t>(k)].p.x, 0.1 * k, 1e-12);
    EXPECT_NEAR(motion.truth[static_cast<std::size_t>(k)].p.x, 0.1 * k, 1e-12);
  }
  for (std::size_t k = 7; k < 10; ++k) EXPECT_FALSE(is_seen(motion.measured[k]));
  EXPECT_NEAR(motion.seconds(), 0.1, 1e-12);
}

TEST(FlownMotion, AMeasurementBetweenPeriodsStandsInTheNextWithItsTime) {
  const Team team = fleet();
  FlownMotion motion = motion_of(team, identified_robot(team, "uav"), 0.01);
  const std::array<double, 7> x = {0, 0, 1, 1, 0, 0, 0};
  for (int k = 0; k < 5; ++k) motion.add(team.model(BodyId{0}), x.data(), 0.014, nullptr, {});
  EXPECT_FALSE(is_seen(motion.measured[4]));
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(motion.measured[k].before, 0.004, 1e-12);
  EXPECT_TRUE(motion.is_between_periods());
  const SeenMotion middle = between({.psi = 1.0, .v_f = 2.0}, {.psi = 2.0, .v_f = 0.0}, 0.25);
  EXPECT_NEAR(middle.psi, 1.25, 1e-12);
  EXPECT_NEAR(middle.v_f, 1.5, 1e-12);
}

TEST(FlownMotion, TheHeadingGoesOnBeyondPi) {
  const Team team = fleet();
  const Model& model = team.model(BodyId{0});
  FlownMotion motion = motion_of(team, identified_robot(team, "uav"), 0.01);
  for (int k = 0; k < 100; ++k) {
    const double psi = 0.2 * k;
    const std::array<double, 7> x = {0, 0, 1, std::cos(psi), std::sin(psi), 0.4, -0.3};
    motion.add(model, x.data(), 0.0, nullptr, {});
    EXPECT_NEAR(motion.measured.back().psi, psi, 1e-9);
    EXPECT_NEAR(motion.measured.back().v_f, 0.4, 1e-12);
    EXPECT_NEAR(motion.measured.back().v_s, -0.3, 1e-12);
  }
  EXPECT_TRUE(motion.truth.empty());
}

}  // namespace
}  // namespace sightline
