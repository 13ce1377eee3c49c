#include "sightline/analysis/identification/prediction_error.hpp"

#include <gtest/gtest.h>

#include "tests/support/identified.hpp"

namespace sightline {
namespace {

const std::string crazyflie = "robot = \"hover_multirotor\"\nparameters = { preset = \"crazyflie\" }";
constexpr ModelStructure structure{Commands::tilt, false, true, false};
ModelNumbers numbers() {
  const HoverMultirotor m = HoverMultirotor::crazyflie();
  return {.b_z = m.b_z, .b_psi = m.b_psi, .a_f = m.a_f, .b_f = m.b_f, .a_s = m.a_s, .b_s = m.b_s};
}

FlownMotion flight(std::string_view disturbance) {
  const Scenario scenario = test::alone(crazyflie, 7, std::string(disturbance));
  return fly_excitation(scenario, test::uav(scenario));
}

TEST(PredictionError, OfTheRobotItselfIsNothing) {
  const FlownMotion motion = flight("");
  const PredictionError e = prediction_error(motion, {0, motion.size()}, structure, numbers());
  EXPECT_GT(e.predictions, 500U);
  EXPECT_TRUE(e.of_truth);
  EXPECT_GT(e.r2, 0.99999);
  EXPECT_LT(e.position, 1e-3);
  EXPECT_LT(e.acceleration, 0.05);
}

TEST(PredictionError, OfAModelThatStandsStillIsTheWholeChange) {
  const FlownMotion motion = flight("");
  ModelNumbers still = numbers();
  still.b_f = still.b_s = still.a_f = still.a_s = still.b_psi = 0.0;
  const PredictionError e = prediction_error(motion, {0, motion.size()}, structure, still);
  EXPECT_LT(e.r2, 0.5);
  EXPECT_GT(e.position, 0.1);
}

TEST(PredictionError, WhereTheTruthIsNotKnownNoiseCountsAndAStartIsEstimated) {
  FlownMotion motion = flight(test::usual_noise);
  motion.truth.clear();
  const PredictionError e = prediction_error(motion, {0, motion.size()}, structure, numbers());
  EXPECT_FALSE(e.of_truth);
  EXPECT_GT(e.r2, 0.98);
  EXPECT_LT(e.position, 0.03);
  EXPECT_GT(e.velocity, 0.03);
}

}  // namespace
}  // namespace sightline
