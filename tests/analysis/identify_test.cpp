#include "sightline/analysis/identification/identify.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/identified.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::alone;
using test::identified;
using test::number;
using test::uav;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

TEST(Identify, ChoosesTheStructureOfTheRobotThatFlew) {
  const std::string noise(test::usual_noise);
  EXPECT_EQ(identified(alone("robot = \"multirotor\"", 7, noise)).best.structure.name(), "(24)");
  EXPECT_EQ(
      identified(alone("robot = \"multirotor\"", 7, noise + "\ninput_delay = 0.1")).best.structure.name(),
      "(24) + delay");
  EXPECT_EQ(identified(alone("robot = \"hover_multirotor\"", 7, noise)).best.structure.name(),
            "(24) + Coriolis");
  EXPECT_EQ(identified(alone("robot = \"velocity_multirotor\"", 9, noise + "\ninput_delay = 0.1"))
                .best.structure.name(),
            "lags + delay");
  EXPECT_EQ(identified(alone("robot = \"velocity_multirotor\"\nparameters = { frame = \"level\" }", 9, noise))
                .best.structure.name(),
            "lags + Coriolis");
  const Identification rotors = identified(test::vehicle("x500"));
  EXPECT_EQ(rotors.best.structure.name(), "(24) + delay + Coriolis + lags");
  ASSERT_TRUE(rotors.lumped);
  EXPECT_NEAR(number(*rotors.lumped, "delay"), 0.16, 0.02);
  EXPECT_GT(rotors.error().r2, 0.99);
  EXPECT_LT(rotors.error().position, 0.025);
}

TEST(Identify, AVehicleUnderVelocityCommandsHasADelayAndTheCoriolisTerm) {
  const Identification found = identified(alone(
      "robot = \"velocity_multirotor\"", 9, std::string(test::usual_noise), "[world]\nkind = \"rotors\"\n"));
  EXPECT_EQ(found.best.structure.name(), "lags + delay + Coriolis");
  EXPECT_GT(found.error().r2, 0.9);
}

TEST(Identify, TellsWhichInputWasNotMovedEnough) {
  const Scenario scenario = test::vehicle("x500");
  FlownMotion motion = fly_excitation(scenario, uav(scenario));
  for (auto& u : motion.u) u[2] = 0.0;
  EXPECT_THAT(identify(motion).missing, Contains("u_z was not moved enough to know b_z"));
  EXPECT_THAT(identified(scenario, {.kind = ExcitationKind::three_two_one_one}).missing,
              Contains(StartsWith("a 3-2-1-1 alone is too little")));
  EXPECT_THAT(identified(test::vehicle("crazyflie"), {.seconds = 60}).missing, IsEmpty());
}

TEST(Identify, RefusesAFlightThatShowsNothing) {
  const Scenario scenario = test::vehicle("x500");
  FlownMotion motion = fly_excitation(scenario, uav(scenario), {.seconds = 10});
  FlownMotion brief = motion;
  brief.u.resize(320), brief.measured.resize(320), brief.truth.resize(320);
  EXPECT_EQ(refusal_of([&] { identify(brief); }), "uav: 3.2 s of flight, expected at least 5 s");
  FlownMotion still = motion;
  for (auto& u : still.u) u = {};
  EXPECT_THAT(refusal_of([&] { identify(still); }), HasSubstr("the inputs of uav rested"));
  FlownMotion grounded = motion;
  for (auto& m : grounded.measured) m = {};
  EXPECT_THAT(refusal_of([&] { identify(grounded); }), HasSubstr("is it on the ground?"));
  FlownMotion unseen = motion;
  for (std::size_t k = 0; k < unseen.size(); ++k) {
    if (k % 3 > 0) unseen.measured[k].psi = not_a_number;
  }
  EXPECT_THAT(refusal_of([&] { identify(unseen); }), HasSubstr("was seen in 367 of 1100 periods"));
}

}  // namespace
}  // namespace sightline
