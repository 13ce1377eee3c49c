#include "sightline/run/sample.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "sightline/safety/ladder.hpp"
#include "sightline/safety/track.hpp"

namespace sightline {
namespace {

TEST(Sample, EveryKindOfEventHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (int i = 0; i < event_kinds; ++i) {
    const auto kind = static_cast<EventKind>(i);
    EXPECT_FALSE(to_string(kind).empty());
    EXPECT_TRUE(names.insert(to_string(kind)).second) << to_string(kind);
  }
}

TEST(Sample, KindsOfEventsFollowTheLevelsAndTheFaultsInTheirOrder) {
  for (int i = 0; i < fallback_level_count; ++i) {
    EXPECT_EQ(to_string(static_cast<EventKind>(static_cast<int>(EventKind::valid) + i)),
              to_string(static_cast<FallbackLevel>(i)));
  }
  for (int i = 1; i < measurement_fault_count; ++i) {
    EXPECT_EQ(to_string(static_cast<EventKind>(static_cast<int>(EventKind::measurement_not_finite) + i - 1)),
              "measurement_" + std::string(to_string(static_cast<MeasurementFault>(i))));
  }
}

}  // namespace
}  // namespace sightline
