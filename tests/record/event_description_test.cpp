#include "sightline/record/event_words.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "sightline/run/sample.hpp"

namespace sightline {
namespace {

std::string words(EventKind kind, double value) {
  return event_words(to_string(kind), value,
                     {.of_body = [](int body) { return fmt::format("uav{}", body); },
                      .of_event = [](int event) { return fmt::format("e{}", event); }});
}

TEST(EventWords, WhatHappensToABodyNamesIt) {
  EXPECT_EQ(words(EventKind::hold, 0), "uav0: hold");
  EXPECT_EQ(words(EventKind::grounded, 12), "uav12: grounded");
  EXPECT_EQ(words(EventKind::measurement_not_finite, 1), "uav1: measurement refused, not_finite");
  EXPECT_EQ(words(EventKind::barrier_conflict, 2), "uav2: barrier conflict");
  EXPECT_EQ(words(EventKind::search, 1), "uav1: searches for what it watches");
  EXPECT_EQ(words(EventKind::found, 1), "uav1: has found it");
  EXPECT_EQ(words(EventKind::unheard, 1), "uav1: its part is not heard");
  EXPECT_EQ(words(EventKind::heard, 1), "uav1: its part is heard again");
  EXPECT_EQ(words(EventKind::input_refused, 3), "input_refused uav3");
}

TEST(EventWords, WhatTheScriptDoesNamesTheEvent) {
  EXPECT_EQ(words(EventKind::event_happened, 0), "event \"e0\" happens");
  EXPECT_EQ(words(EventKind::event_in_force, 3), "event \"e3\" in force");
  EXPECT_EQ(words(EventKind::event_ignored, 1), "event \"e1\" ignored: it cannot be");
}

TEST(EventWords, WhatHappensToNoBodyHasItsNumber) {
  EXPECT_EQ(words(EventKind::missed_period, 3), "missed_period 3");
  EXPECT_EQ(words(EventKind::samples_dropped, 7), "samples_dropped 7");
  EXPECT_EQ(words(EventKind::pairs_left_out, 4), "4 near pairs more than there is room for");
}

TEST(EventWords, ANumberThatIsNoBodyIsToldAsItIs) {
  EXPECT_EQ(words(EventKind::hold, -1), "hold -1");
  EXPECT_EQ(words(EventKind::hold, std::nan("")), "hold nan");
}

TEST(EventWords, NoTwoKindsReadTheSame) {
  std::set<std::string> all;
  for (int i = 0; i < event_kinds; ++i)
    EXPECT_TRUE(all.insert(words(static_cast<EventKind>(i), 1)).second) << i;
}

}  // namespace
}  // namespace sightline
