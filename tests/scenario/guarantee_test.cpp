#include "sightline/scenario/guarantee.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "tests/support/scenario_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string with_barrier = "[safety]\nbarrier = \"on\"\nd_hard = 0.5\n";
const std::string away_from_walls = "if no wall is within the robot's plan";

std::string agent_text(const std::string& name, const std::string& model, const std::string& p) {
  return "[agent." + name + "]\nrobot = \"" + model + "\"\nstart = { p = [" + p + "] }\n";
}
std::string obstacle_text(const std::string& name, const std::string& p, const std::string& more) {
  return "[obstacle." + name + "]\np = [" + p + "]\n" + more + "\n";
}

/// For each pair "", or why not.
std::vector<std::string> reasons_of_pairs(const std::string& text) {
  std::vector<std::string> all;
  for (const PairGuarantee& pair : distance_guarantees(test::scenario_of(text))) all.push_back(pair.why_not);
  return all;
}

const std::string one_rover = agent_text("a", "unicycle", "0, 0, 0.2"),
                  other_rover = agent_text("b", "unicycle", "3, 0, 0.2"),
                  one_uav = agent_text("u", "multirotor", "0, 4, 1");

TEST(Guarantee, HoldsForRobotsThatDriveAmongOthersAndBodiesAtRest) {
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_rover + other_rover +
                               obstacle_text("rock", "0, 2, 0.2", "speed_max = 0.0")),
              ElementsAre("", "", ""));
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_rover + obstacle_text("rock", "0, 2, 0.2", "")),
              ElementsAre(""))
      << "it is at rest, whatever the barrier assumes";
  for (const PairGuarantee& pair :
       distance_guarantees(test::scenario_of(with_barrier + one_rover + other_rover)))
    EXPECT_EQ(pair.condition, "");
}

TEST(Guarantee, DoesNotHoldForARobotThatDrivesAndABodyThatMoves) {
  const std::string motion = "motion = { adversary = { agent = \"a\", speed = 0.4 } }\n";
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_rover + obstacle_text("foe", "0, 2, 0.2", motion)),
              ElementsAre("a robot that drives along its heading stands and cannot flee"));
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_rover +
                               obstacle_text("foe", "0, 2, 0.2", motion + "speed_max = 0.1")),
              ElementsAre("a body is up to 0.4 m/s fast, but the barriers assume 0.1 m/s"));
}

TEST(Guarantee, OfARoverAndAMultirotorIsTheMultirotors) {
  const std::vector<PairGuarantee> pairs =
      distance_guarantees(test::scenario_of(with_barrier + one_rover + one_uav));
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_TRUE(pairs[0].holds());
  EXPECT_EQ(pairs[0].condition, away_from_walls);
  const std::string fast = one_rover + "parameters = { b_f = 10.0, a_f = -2.5 }\n";
  EXPECT_THAT(
      reasons_of_pairs(with_barrier + fast + one_uav),
      ElementsAre("a robot that drives along its heading stands and cannot flee, and a body is up to 4 m/s "
                  "fast, beyond 2.5 m/s"));
}

TEST(Guarantee, OfMultirotorsIsThatOfTwoAlike) {
  const std::string second = agent_text("v", "multirotor", "0, 8, 1"),
                    third = agent_text("w", "multirotor", "0, 12, 1");
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_uav + second), ElementsAre(""));
  const std::string several = "a robot that flies has more than one neighbour";
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_uav + second + third),
              ElementsAre(several, several, several));
  EXPECT_THAT(reasons_of_pairs(with_barrier + one_uav + second +
                               "[[safety.zone]]\npolygon = [[20, 0], [30, 0], [30, 9]]\nkeep = "
                               "\"outside\"\n"),
              ElementsAre("zones may stop a plan"));
  const auto px4 = [](const std::string& name, const std::string& p) {
    return agent_text(name, "velocity_multirotor", p) + "parameters = { preset = \"px4\" }\n";
  };
  EXPECT_THAT(reasons_of_pairs(with_barrier + px4("a", "0, 0, 1") + px4("b", "9, 0, 1")),
              ElementsAre(HasSubstr("fast, but the barriers assume 1.5 m/s")));
}

TEST(Guarantee, NeedsModelsMeasurementsAndStartsThatTheProofHas) {
  const std::string both = with_barrier + one_rover + other_rover;
  EXPECT_THAT(reasons_of_pairs(both + "[simulation.disturbance]\nwind = [0.1, 0, 0]\n"),
              ElementsAre("simulation.disturbance moves the robots otherwise than their models"));
  EXPECT_THAT(reasons_of_pairs(both + "[simulation.disturbance]\ninput_delay = 0.1\n"),
              ElementsAre("commands do not act after the command_delay that the barrier predicts"));
  EXPECT_THAT(reasons_of_pairs(both + "[simulation.disturbance]\nnoise = { position = 0.01 }\n"),
              ElementsAre("the measurements are disturbed"));
  EXPECT_THAT(reasons_of_pairs(both + "[[event]]\nat = 1.0\nremove = \"b\"\n"),
              ElementsAre("events change the team"));
  EXPECT_THAT(reasons_of_pairs(with_barrier + "start_outside = true\n" + one_rover +
                               agent_text("b", "unicycle", "0.3, 0, 0.2")),
              ElementsAre("the start leaves no plan"));
  for (const char* mode : {"off", "report"})
    EXPECT_THAT(
        reasons_of_pairs("[safety]\nbarrier = \"" + std::string(mode) + "\"\n" + one_rover + other_rover),
        IsEmpty());
  EXPECT_THAT(reasons_of_pairs(one_rover + other_rover), IsEmpty());
}

TEST(Guarantee, HoldsUnderAWindWithinTheResidualAcceleration) {
  const auto both = [](const std::string& bound, const std::string& wind, const std::string& second) {
    return with_barrier + "residual_acceleration = " + bound + "\n[simulation.disturbance]\nwind = [" + wind +
           "]\n" + one_uav + second;
  };
  const std::string second = agent_text("v", "multirotor", "0, 9, 1");
  EXPECT_THAT(reasons_of_pairs(both("0.2", "0.1, 0.1, 0", second)), ElementsAre(""));
  for (const char* wind : {"0.2, 0.1, 0", "0, 0, 0.01"})
    EXPECT_THAT(reasons_of_pairs(both("0.2", wind, second)),
                ElementsAre(HasSubstr("simulation.disturbance moves")));
  EXPECT_THAT(reasons_of_pairs(both("0.6", "0, 0, 0", obstacle_text("foe", "0, 30, 1", "speed_max = 1.5"))),
              ElementsAre(HasSubstr("a body is up to 1.5 m/s fast, beyond")));
  EXPECT_THAT(reasons_of_pairs(both("0.1", "0, 0, 0", agent_text("o", "omni_rover", "0, 30, 0.2"))),
              ElementsAre("the residual acceleration of a robot that moves by another law is not counted"));
}

/// Least distance of the first robot from a rock at (0, 0, 1).
double nearest_to_rock(const Scenario& scenario) {
  double least = infinity;
  for (const FlownPeriod& period : fly_scenario(scenario).flown)
    least = std::min(least, norm(Vec3<double>{period.x[0], period.x[1], period.x[2] - 1.0}));
  return least;
}

TEST(Guarantee, OfLateCommandsInAWindIsKeptInFlight) {
  // A robot is sent through a rock, towards which the wind blows.
  const auto text = [](const std::string& bound, const std::string& delay) {
    return "[simulation]\nduration = 6.0\n[simulation.disturbance]\ninput_delay = 0.2\nwind = [0.5, 0.0, "
           "0.0]\n" +
           with_barrier + "residual_acceleration = " + bound + "\n" +
           agent_text("a", "multirotor", "-5, 0.02, 1") + "command_delay = " + delay +
           "\nQ = [4.0, 4.0, 4.0, 0.0, 0.0, 0.0, 0.0]\nreference = { constant = { p = [9, 0, 1] } }\n" +
           obstacle_text("rock", "0, 0, 1", "speed_max = 0.0");
  };
  EXPECT_THAT(reasons_of_pairs(text("0.5", "0.2")), ElementsAre(""));
  EXPECT_GE(nearest_to_rock(test::scenario_of(text("0.5", "0.2"))), 0.5);
  EXPECT_THAT(reasons_of_pairs(text("0.0", "0.0")), ElementsAre(HasSubstr("simulation.disturbance moves")));
  EXPECT_LT(nearest_to_rock(test::scenario_of(text("0.0", "0.0"))), 0.5);
}

TEST(Guarantee, CountsTheFlightUntilTheFirstCommandActs) {
  const auto late = [](const std::string& delay, const std::string& agents) {
    const std::string every = "command_delay = " + delay + "\n";
    std::string text = with_barrier + agents + "[simulation.disturbance]\ninput_delay = " + delay;
    for (std::size_t place; (place = text.find("LATE\n")) != std::string::npos;)
      text.replace(place, 5, every);
    return reasons_of_pairs(text);
  };
  const auto flying = [](const std::string& name, const std::string& state) {
    return "[agent." + name + "]\nrobot = \"multirotor\"\nstart = { state = [" + state + "] }\nLATE\n";
  };
  const std::string hovering = flying("a", "0, 0, 1, 1, 0, 0, 0"),
                    foe = obstacle_text("foe", "0, 1.45, 1", "speed_max = 1.5");
  const auto guaranteed = ElementsAre(""), without_plan = ElementsAre("the start leaves no plan");
  EXPECT_THAT(late("0.0", hovering + foe), guaranteed);
  EXPECT_THAT(late("0.5", hovering + foe), without_plan) << "the foe moves meanwhile";
  // Both fly towards each other meanwhile.
  const std::string pair = flying("a", "0, 0, 1, 1, 0, 1.4, 0") + flying("b", "2.05, 0, 1, -1, 0, 1.4, 0");
  EXPECT_THAT(late("0.0", pair), guaranteed);
  EXPECT_THAT(late("0.3", pair), without_plan);
  // A rover rolls on meanwhile.
  const auto rover = [](const std::string& p_x) {
    return "[agent.a]\nrobot = \"unicycle\"\nstart = { state = [0, 0, 0.2, 1, 0, 1.2] }\nLATE\n" +
           obstacle_text("rock", p_x + ", 0, 0.2", "speed_max = 0.0");
  };
  EXPECT_THAT(late("0.0", rover("0.83")), guaranteed);
  EXPECT_THAT(late("0.5", rover("0.83")), without_plan);
  EXPECT_THAT(late("0.5", rover("0.9")), guaranteed);
  // A robot passes a rock meanwhile, and is far from it when its command acts.
  const std::string passing = flying("a", "-0.4, 0.3, 1, 1, 0, 2.0, 0") +
                              obstacle_text("rock", "0, 0, 1", "speed_max = 0.0\nd_hard = 0.4");
  EXPECT_THAT(late("0.5", passing), without_plan);
}

TEST(Guarantee, CountsTheErrorOfMeasuredPositions) {
  const std::string near =
      agent_text("a", "multirotor", "0, 0, 1") + obstacle_text("rock", "0, 0.6, 1", "speed_max = 0.0");
  EXPECT_THAT(reasons_of_pairs(with_barrier + near), ElementsAre(""));
  EXPECT_THAT(reasons_of_pairs(with_barrier + "position_sigma = 0.03\n" + near),
              ElementsAre("the start leaves no plan"));
}

TEST(Guarantee, DoesNotHoldForARobotThatABodyOutruns) {
  const auto with = [](const std::string& most) {
    return with_barrier + one_uav + "u_min = [-" + most + ", -" + most + ", -1, -1]\nu_max = [" + most +
           ", " + most + ", 1, 1]\n" + obstacle_text("foe", "0, 19, 1", "speed_max = 1.5");
  };
  EXPECT_THAT(reasons_of_pairs(with("1")), ElementsAre(""));
  EXPECT_THAT(reasons_of_pairs(with("0.2")), ElementsAre(HasSubstr("a body is up to 1.5 m/s fast, beyond")));
}

const std::string tilts_late = "parameters = { preset = \"x500\", tau = 0.121, tau_z = 0.231, tau_psi = 0.16";

TEST(Guarantee, OfARobotThatTiltsLateIsThatOfItsLawAgainstOneBody) {
  const auto with = [](const std::string& more, const std::string& second) {
    return with_barrier + agent_text("a", "hover_multirotor", "0, 0, 1") + tilts_late + more + " }\n" +
           second;
  };
  const std::string foe = obstacle_text("foe", "0, 9, 1", "speed_max = 1.5");
  EXPECT_THAT(reasons_of_pairs(with("", foe)), ElementsAre(""));
  EXPECT_THAT(reasons_of_pairs(with(", a_s = -0.2", foe)),
              ElementsAre("the drag of a robot that tilts late depends on the direction"));
  EXPECT_THAT(reasons_of_pairs(with("", obstacle_text("foe", "0, 0.8, 1", "speed_max = 1.5"))),
              ElementsAre("the start leaves no plan"));
  EXPECT_THAT(
      reasons_of_pairs(with("", agent_text("b", "hover_multirotor", "0, 9, 1") + tilts_late + " }\n")),
      ElementsAre(HasSubstr("fast, but the barriers assume 1.5 m/s")));
  EXPECT_THAT(reasons_of_pairs("[horizon]\nperiod = 0.02\n" + with("", foe)),
              ElementsAre("plans are exact for periods of up to 0.01 s only"));
}

TEST(Guarantee, OfARobotThatTiltsLateIsKeptInFlight) {
  // A robot is sent into a rock.
  const auto text = [](const std::string& barrier) {
    return "[simulation]\nduration = 12.0\n[safety]\nbarrier = \"" + barrier + "\"\nd_hard = 0.5\n" +
           agent_text("a", "hover_multirotor", "-5, 0.02, 1") + tilts_late +
           " }\nQ = [1, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0]\nreference = { constant = { p = [0, 0, 1] } }\n" +
           obstacle_text("rock", "0, 0, 1", "speed_max = 0.0");
  };
  EXPECT_THAT(reasons_of_pairs(text("on")), ElementsAre(""));
  EXPECT_GE(nearest_to_rock(test::scenario_of(text("on"))), 0.5);
  EXPECT_LT(nearest_to_rock(test::scenario_of(text("off"))), 0.5);
}

TEST(Guarantee, IsALineForEachVerdict) {
  const Scenario scenario = test::scenario_of(with_barrier + one_rover + other_rover +
                                              agent_text("c", "unicycle", "6, 0, 0.2") + one_uav);
  const std::vector<PairGuarantee> pairs = distance_guarantees(scenario);
  EXPECT_EQ(
      describe(pairs, scenario.team, 2),
      "distance    guaranteed: a and b, a and c, and 1 more\n"
      "distance    not guaranteed, a robot that drives along its heading stands and cannot flee, and a robot "
      "that flies has more than one neighbour: a and u, b and u, and 1 more\n");
  EXPECT_THAT(describe(pairs, scenario.team, std::numeric_limits<std::size_t>::max()),
              HasSubstr("a and b, a and c, b and c\n"));
}

}  // namespace
}  // namespace sightline
