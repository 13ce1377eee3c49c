#include "sightline/judge/plan_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

Scenario alone() {
  Scenario scenario;
  scenario.team.add(Multirotor{}, {.name = "a"});
  return scenario;
}

Sample sample_at(int k, std::vector<Status> statuses) {
  Sample sample;
  sample.time = 0.01 * k;
  sample.solvers.resize(statuses.size());
  for (std::size_t c = 0; c < statuses.size(); ++c) sample.solvers[c].status = statuses[c];
  return sample;
}

TEST(PlanSummary, AFailureThatLastsLongerThanHoldAfterIsSaid) {
  Scenario slow = alone();
  slow.safety = Safety{.supervisor = SupervisorOptions{.times = {.hold_after = 1.0}}};
  for (const Scenario& scenario : {alone(), slow}) {
    const int most = scenario.safety ? 100 : 50;
    PlanSummary plans(scenario, 1);
    for (int k = 0; k < 10; ++k) plans.add(sample_at(k, {Status::stepped}));
    for (int k = 10; k < 10 + most; ++k) plans.add(sample_at(k, {Status::not_finite}));
    EXPECT_TRUE(plans.failures().empty()) << most;
    plans.add(sample_at(10 + most, {Status::not_finite}));
    ASSERT_EQ(plans.failures().size(), 1U);
    EXPECT_THAT(plans.failures()[0],
                testing::HasSubstr("s from 0.10 s on (not_finite), expected one within "));
  }
}

TEST(PlanSummary, OfSeveralSolversTheOneThatFailedIsNamed) {
  PlanSummary plans(alone(), 2);
  for (int k = 0; k < 100; ++k) plans.add(sample_at(k, {Status::deadline, Status::invalid_state}));
  EXPECT_THAT(plans.failures(),
              testing::ElementsAre(testing::HasSubstr("the solver of controller 1 gave no")));
  EXPECT_EQ(plans.longest().status, Status::invalid_state);
}

TEST(PlanSummary, InJsonAndInWordsItIsThereWhereThereWasNoPlan) {
  PlanSummary plans(alone(), 1);
  plans.add(sample_at(0, {Status::converged}));
  EXPECT_EQ(plans.json(), R"({"longest":0.0,"from":null,"status":null})");
  EXPECT_EQ(describe_without_plan(plans.json()), "");
  for (int k = 1; k < 21; ++k) plans.add(sample_at(k, {Status::invalid_state}));
  const auto json = nlohmann::json::parse(plans.json());
  EXPECT_NEAR(json.at("longest").get<double>(), 0.2, 1e-12);
  EXPECT_EQ(json.at("status"), "invalid_state");
  EXPECT_EQ(describe_without_plan(plans.json()), "at most 0.20 s on end, from 0.01 s on (invalid_state)");
}

}  // namespace
}  // namespace sightline
