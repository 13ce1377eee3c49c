#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"

namespace sightline {
namespace {

TEST(CampaignPlan, NamesStandInTheOrderOfTheDraws) {
  CampaignPlan plan;
  plan.starts = {{.agent = "a", .around = "b", .range = {}, .bearing = {}, .height = {}},
                 {.agent = "c",
                  .around = "b",
                  .range = {},
                  .bearing = {},
                  .height = {},
                  .heading = Distribution{},
                  .velocity = Distribution{}}};
  plan.draws = {{"couple[0].weight", {}}};
  EXPECT_THAT(drawn_names(plan),
              testing::ElementsAre("a.range", "a.bearing", "a.height", "c.range", "c.bearing", "c.height",
                                   "c.heading", "c.v_f", "c.v_s", "couple[0].weight"));
  EXPECT_THAT(drawn_names({}), testing::IsEmpty());
}

}  // namespace
}  // namespace sightline
