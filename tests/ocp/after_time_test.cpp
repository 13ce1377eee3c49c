#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/monitored_line.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(AfterTime, CountsFromWhereItsStageBegan) {
  TeamEvent later = when(AfterTime{0.2});
  later.stage = "later";
  MonitoredLine line({{.name = "", .trigger = AtTime{0.3}, .enter = "later"}, later, when(AfterTime{0.1})});
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(2U)) << "of all stages: from the beginning of the run";
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U));
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(1U)) << "0.5 s";
}

}  // namespace
}  // namespace sightline
