#include "sightline/analysis/identification/excitation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/scenario.hpp"
#include "tests/support/identified.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::alone;
using test::uav;
using testing::HasSubstr;

constexpr std::array all_kinds = {ExcitationKind::steps, ExcitationKind::chirp,
                                  ExcitationKind::three_two_one_one, ExcitationKind::bang_bang};

TEST(Excitation, MovesEachInputWithinItsLimits) {
  for (const ExcitationKind kind : all_kinds) {
    ExcitationSignal signal({.kind = kind});
    std::array<double, 4> least{}, most{};
    for (int k = 0; k < 2000; ++k) {
      const std::array<double, 4> u = signal.at(0.01 * k);
      for (std::size_t i = 0; i < 4; ++i)
        least[i] = std::min(least[i], u[i]), most[i] = std::max(most[i], u[i]);
      if (kind == ExcitationKind::three_two_one_one) {
        EXPECT_LE(std::count_if(u.begin(), u.end(), [](double v) { return v != 0; }), 1);
      }
    }
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_GE(least[i], -1.0);
      EXPECT_LE(most[i], 1.0);
      EXPECT_GT(most[i] - least[i], 1.0) << i;
    }
  }
}

TEST(Excitation, IsBroughtBackTowardsItsStart) {
  for (const char* const preset : {"x500", "crazyflie", "ar_drone"}) {
    const Scenario scenario = test::vehicle(preset);
    for (const ExcitationKind kind : all_kinds) {
      for (const double radius : {1.5, 3.0}) {
        const FlownMotion motion =
            fly_excitation(scenario, uav(scenario), {.kind = kind, .seconds = 40, .radius = radius});
        double off = 0.0, over = 0.0;
        for (const SeenMotion& m : motion.truth) {
          off = std::max(off, norm(m.p.x, m.p.y));
          over = std::max(over, std::abs(m.p.z - 3.0));
        }
        EXPECT_LT(off, 1.5 * radius) << preset << " " << excitation_names[static_cast<std::size_t>(kind)];
        EXPECT_LT(over, 1.5) << preset;
        EXPECT_GT(off, 0.2);
      }
    }
  }
}

TEST(Excitation, UnderVelocityCommandsToo) {
  const Scenario scenario = alone("robot = \"velocity_multirotor\"", 9, std::string(test::usual_noise),
                                  "[world]\nkind = \"rotors\"\n");
  const FlownMotion motion = fly_excitation(scenario, uav(scenario), {.seconds = 40});
  double off = 0.0;
  for (const SeenMotion& m : motion.truth) off = std::max(off, norm(m.p.x, m.p.y));
  EXPECT_LT(off, 4.5);
  EXPECT_EQ(motion.commands, Commands::velocity);
  EXPECT_EQ(motion.u_max[0], 3.0);
}

TEST(Excitation, BeginsInTheAirAloneAndAtRest) {
  Scenario scenario = alone("robot = \"multirotor\"", 7, "",
                            "[obstacle.rock]\np = [0.5, 0.0, 2.0]\n[world]\nkind = \"rotors\"\n");
  scenario.x0[2] = 0.1;
  const FlownMotion motion = fly_excitation(scenario, uav(scenario), {.radius = 1.0});
  EXPECT_EQ(motion.truth.front().p.z, 2.0);
  EXPECT_EQ(fly_excitation(scenario, uav(scenario), {.height = 5.0}).truth.front().p.z, 5.0);
  EXPECT_NEAR(motion.seconds(), 21.0, 1e-9);
}

// In a world where it flies already: it stays within the walls and away from bodies, though less
// space is left than asked for.
TEST(Excitation, OfAFlyingRobotStaysWithinTheWalls) {
  const auto flown = [](const std::string& rest, bool stopped = false) {
    const Scenario scenario = alone("robot = \"multirotor\"", 7, "", "[world]\nkind = \"rotors\"\n" + rest);
    const std::unique_ptr<World> world = make_world(scenario);
    SimulatedClock clock;
    const std::atomic<bool> stop{stopped};
    return fly_excitation(scenario, uav(scenario), {.seconds = 20}, *world, clock, stop);
  };
  const FlownMotion motion = flown(
      "[safety]\nfloor = 2.4\nceiling = 4.0\nworld = 1.2\nposition_sigma = 0.01\nheading_sigma = 0.01\n");
  ASSERT_EQ(motion.size(), 2100u);
  for (const SeenMotion& m : motion.truth) {
    EXPECT_LT(std::max(std::abs(m.p.x), std::abs(m.p.y)), 1.2);
    EXPECT_GT(m.p.z, 2.4);
    EXPECT_LT(m.p.z, 4.0);
  }
  EXPECT_THAT(
      refusal_of([&] { flown("[safety]\nceiling = 3.1\nposition_sigma = 0.01\nheading_sigma = 0.01\n"); }),
      HasSubstr("it began at [0.00, 0.00, 3.00] m, expected room of 0.75 m level"));
  const std::string tight =
      "[safety]\nposition_sigma = 0.01\nheading_sigma = 0.01\n[[safety.zone]]\n"
      "polygon = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\nkeep = \"inside\"\n";
  EXPECT_THAT(refusal_of([&] { flown(tight); }), HasSubstr("expected room of 0.75 m level"));
  EXPECT_THAT(refusal_of([&] { flown("[obstacle.rock]\np = [0.0, 3.0, 2.0]\n"); }),
              HasSubstr("rock is 3.00 m from uav, expected more than 4.50 m"));
  EXPECT_THAT(refusal_of([&] { flown("", true); }), HasSubstr("the excitation was ended"));
}

TEST(Excitation, RefusesWhatCannotBeFlown) {
  EXPECT_EQ(refusal_of([] { ExcitationOptions{.seconds = 3}.check(); }),
            "--seconds = 3, expected 5 to 600 s");
  const Scenario scenario =
      alone("robot = \"multirotor\"", 7, "wind = [0.0, 0.0, -8.0]", "[world]\nkind = \"rotors\"\n");
  EXPECT_THAT(refusal_of([&] { fly_excitation(scenario, uav(scenario), {.height = 1.0}); }),
              HasSubstr("uav touched the ground at "));
}

}  // namespace
}  // namespace sightline
