#include "sightline/judge/event_description.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "sightline/loop.hpp"

namespace sightline {
namespace {

std::string describe(EventKind kind, double value) {
  return event_words(to_string(kind), value,
                     {.of_body = [](int body) { return fmt::format("uav{}", body); },
                      .of_event = [](int event) { return fmt::format("e{}", event); }});
}

TEST(EventWords, WhatHappensToABodyNamesIt) {
  EXPECT_EQ(describe(EventKind::hold, 0), "uav0: hold");
  EXPECT_EQ(describe(EventKind::measurement_not_finite, 1), "uav1: measurement refused, not_finite");
  EXPECT_EQ(describe(EventKind::input_refused, 3), "input_refused uav3");
  EXPECT_EQ(describe(EventKind::view_uncertified, 0), "uav0: view not certified");
}

TEST(EventWords, WhatTheScriptDoesNamesTheEvent) {
  EXPECT_EQ(describe(EventKind::event_occurred, 0), "event \"e0\" happens");
  EXPECT_EQ(describe(EventKind::event_ignored, 1), "event \"e1\" ignored: it cannot be");
}

TEST(EventWords, WhatHappensToNoBodyHasItsNumber) {
  EXPECT_EQ(describe(EventKind::missed_period, 3), "missed_period 3");
  EXPECT_EQ(describe(EventKind::pairs_left_out, 4), "4 near pairs more than there is room for");
}

TEST(EventWords, ANumberThatIsNoBodyIsToldAsItIs) {
  EXPECT_EQ(describe(EventKind::hold, -1), "hold -1");
  EXPECT_EQ(describe(EventKind::hold, std::nan("")), "hold nan");
}

TEST(EventWords, NoTwoKindsReadTheSame) {
  std::set<std::string> all;
  for (int i = 0; i < event_kinds; ++i)
    EXPECT_TRUE(all.insert(describe(static_cast<EventKind>(i), 1)).second) << i;
}

}  // namespace
}  // namespace sightline
