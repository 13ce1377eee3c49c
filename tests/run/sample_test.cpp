#include "sightline/run/sample.hpp"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

TEST(Sample, EveryKindOfEventHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (const EventKind kind : {EventKind::missed_period, EventKind::solver_status, EventKind::input_refused,
                               EventKind::samples_dropped}) {
    EXPECT_FALSE(to_string(kind).empty());
    EXPECT_TRUE(names.insert(to_string(kind)).second) << to_string(kind);
  }
}

}  // namespace
}  // namespace sightline
