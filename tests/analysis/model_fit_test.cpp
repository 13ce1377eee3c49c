#include "sightline/analysis/identification/model_fit.hpp"

#include <gtest/gtest.h>

#include "tests/support/identified.hpp"

namespace sightline {
namespace {

using test::alone;
using test::number;
using test::uav;

const std::string drawn_numbers =
    "robot = \"hover_multirotor\"\nparameters = { b_z = 1.2, b_psi = 1.3, a_f = -0.4, b_f = 1.8, a_s = -0.5, "
    "b_s = 1.6, tau = 0.11, tau_z = 0.3, tau_psi = 0.2 }";
constexpr ModelStructure whole{Commands::tilt, true, true, true};
constexpr const char* delayed = "input_delay = 0.073";

FlownMotion excited(const std::string& disturbance, const ExcitationOptions& options = {}) {
  const Scenario scenario = alone(drawn_numbers, 11, disturbance);
  return fly_excitation(scenario, uav(scenario), options);
}
FittedModel fitted(const FlownMotion& motion) { return fit_model(motion, {0, motion.size()}, whole); }

TEST(ModelFit, WithoutNoiseFindsTheNumbersOfTheRobot) {
  const FlownMotion motion = excited(delayed);
  const FittedModel model = fitted(motion);
  for (const auto& [key, value] :
       {std::pair{"b_z", 1.2}, std::pair{"b_psi", 1.3}, std::pair{"a_f", -0.4}, std::pair{"b_f", 1.8},
        std::pair{"a_s", -0.5}, std::pair{"b_s", 1.6}, std::pair{"tau", 0.11}, std::pair{"tau_z", 0.3},
        std::pair{"tau_psi", 0.2}, std::pair{"delay", 0.073}})
    EXPECT_NEAR(number(model, key), value, 2e-3 * std::abs(value) + 2e-4) << key;
  for (const FoundNumber& one : model.found) EXPECT_TRUE(one.known()) << one.number.key;
}

// As a vehicle with periods of its own is seen: each measurement 4 ms before the period in which it
// is there.
TEST(ModelFit, MeasurementsBetweenPeriodsCountAtTheirTimes) {
  FlownMotion motion = excited(delayed);
  EXPECT_FALSE(motion.is_between_periods());
  for (std::size_t k = motion.size() - 1; k > 0; --k) {
    motion.measured[k] = between(motion.measured[k], motion.measured[k - 1], 0.4);
    motion.measured[k].before = 0.4 * motion.period;
  }
  EXPECT_TRUE(motion.is_between_periods());
  const FittedModel model = fitted(motion);
  for (const auto& [key, value] : {std::pair{"b_z", 1.2}, std::pair{"tau", 0.11}, std::pair{"tau_z", 0.3},
                                   std::pair{"tau_psi", 0.2}, std::pair{"delay", 0.073}})
    EXPECT_NEAR(number(model, key), value, 2e-3 * std::abs(value) + 5e-4) << key;
}

TEST(ModelFit, ASteadyWindIsFoundBesideTheNumbersOfTheVehicle) {
  const FlownMotion motion = excited("input_delay = 0.073\nwind = [0.5, -0.3, 0.0]");
  const FittedModel model = fitted(motion);
  EXPECT_NEAR(number(model, "w_x"), 0.5, 2e-3);
  EXPECT_NEAR(number(model, "w_y"), -0.3, 2e-3);
  EXPECT_NEAR(number(model, "b_f"), 1.8, 5e-3);
  EXPECT_NEAR(number(model, "a_s"), -0.5, 2e-3);
}

TEST(ModelFit, ItsIntervalsShrinkWithTheRootOfTheTime) {
  const FlownMotion motion = excited(std::string(test::usual_noise), {.seconds = 80});
  const FittedModel some = fit_model(motion, {0, motion.size() / 4}, whole),
                    all = fit_model(motion, {0, motion.size()}, whole);
  for (std::size_t i = 0; i < all.found.size(); ++i) {
    EXPECT_LT(all.found[i].interval, 0.8 * some.found[i].interval) << all.found[i].number.key;
    EXPECT_GT(all.found[i].interval, 0.15 * some.found[i].interval) << all.found[i].number.key;
  }
}

TEST(ModelFit, OfAnInputThatRestsNothingIsFound) {
  FlownMotion motion = excited("");
  for (auto& u : motion.u) u[2] = 0.2;
  const FittedModel model = fitted(motion);
  EXPECT_EQ(inputs_moved(motion, {0, motion.size()}), (std::array<bool, 4>{true, true, false, true}));
  for (const FoundNumber& one : model.found) {
    const bool of_climb = one.number.key == "b_z" || one.number.key == "tau_z";
    EXPECT_EQ(one.moved, !of_climb) << one.number.key;
    EXPECT_TRUE(one.moved || !one.known());
  }
}

TEST(ModelFit, MeasurementsThatAreMissingAreSteppedOver) {
  FlownMotion motion = excited(delayed);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    if (k % 7 < 3) motion.measured[k].psi = std::numeric_limits<double>::quiet_NaN();
  }
  const FittedModel model = fitted(motion);
  EXPECT_NEAR(number(model, "b_f"), 1.8, 5e-3);
  EXPECT_NEAR(number(model, "delay"), 0.073, 1e-3);
}

TEST(ModelFit, TheLumpedDelayIsAboutTheDelayAndTheLagOfTheTilt) {
  const FlownMotion motion = excited(delayed);
  const Stretch all{0, motion.size()};
  const FittedModel with = fit_model(motion, all, whole), lumped = fit_lumped(motion, all, with);
  EXPECT_NEAR(number(lumped, "delay"), 0.073 + 0.11, 0.03);
  EXPECT_EQ(number(lumped, "b_f"), number(with, "b_f"));
  EXPECT_FALSE(lumped.structure.lags);
}

TEST(ModelFit, AStartIsFoundFromTheMeasurementsAfterIt) {
  const FlownMotion motion = excited(std::string(test::usual_noise));
  const MotionPrediction prediction(motion, whole,
                                    {.b_z = 1.2,
                                     .b_psi = 1.3,
                                     .a_f = -0.4,
                                     .b_f = 1.8,
                                     .a_s = -0.5,
                                     .b_s = 1.6,
                                     .tau = 0.11,
                                     .tau_z = 0.3,
                                     .tau_psi = 0.2});
  for (const std::size_t k : {100U, 500U, 1200U}) {
    const SeenMotion found = fitted_start(motion, prediction, k, 100), truth = motion.truth[k];
    EXPECT_LE(norm(found.p - truth.p), 0.01);
    EXPECT_NEAR(found.psi, truth.psi, 0.01);
    EXPECT_NEAR(found.v_f, truth.v_f, 0.03);
    EXPECT_NEAR(found.v_s, truth.v_s, 0.03);
  }
}

}  // namespace
}  // namespace sightline
