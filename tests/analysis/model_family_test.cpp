#include "sightline/analysis/identification/model_family.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sightline/robots.hpp"

namespace sightline {
namespace {

TEST(ModelFamily, EachStructureIsThereOnceThePlainOneFirst) {
  const auto tilt = model_structures(Commands::tilt), velocity = model_structures(Commands::velocity);
  ASSERT_EQ(tilt.size(), 8U);
  ASSERT_EQ(velocity.size(), 4U);
  EXPECT_EQ(tilt.front().name(), "(24)");
  EXPECT_EQ(tilt.back().name(), "(24) + delay + Coriolis + lags");
  EXPECT_EQ(velocity.back().name(), "lags + delay + Coriolis");
  for (const auto& all : {tilt, velocity}) {
    for (const ModelStructure& one : all) EXPECT_EQ(std::count(all.begin(), all.end(), one), 1);
  }
}

/// Whether each number but the delay is a parameter of the robot, with its unit.
template <class Robot>
void expect_parameters(const ModelStructure& structure, const Robot& robot) {
  const std::vector<ParameterText> parameters = parameter_texts(robot);
  for (const FittedNumber& number : fitted_numbers(structure)) {
    if (number.key == "delay" || number.of_flight) continue;
    const auto same = [&](const ParameterText& p) { return p.key == number.key && p.unit == number.unit; };
    EXPECT_TRUE(std::any_of(parameters.begin(), parameters.end(), same)) << number.key;
  }
}

TEST(ModelFamily, WhatIsFittedAreTheParametersOfTheRobotsThatHaveTheStructures) {
  for (const ModelStructure& one : model_structures(Commands::tilt))
    expect_parameters(one, LaggingHoverMultirotor{});
  for (const ModelStructure& one : model_structures(Commands::velocity))
    expect_parameters(one, VelocityMultirotor{});
  EXPECT_EQ(fitted_numbers(model_structures(Commands::tilt).back()).size(), 12U);
}

}  // namespace
}  // namespace sightline
