#include "sightline/server/scene_topics.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "sightline/readers/cdr.hpp"
#include "tests/support/keeping_sink.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

/// What /tf says: places by name.
std::map<std::string, Vec3<double>> transforms_in(const test::KeptMessage& message) {
  CdrDecoder from(std::as_bytes(std::span(message.bytes)));
  std::map<std::string, Vec3<double>> places;
  const std::size_t count = from.length(1);
  for (std::size_t i = 0; i < count; ++i) {
    (void)from.number<std::int32_t>(), (void)from.number<std::uint32_t>();
    EXPECT_EQ(from.string(), "map");
    const std::string name(from.string());
    Vec3<double>& p = places[name];
    p.x = from.number<double>(), p.y = from.number<double>(), p.z = from.number<double>();
    double length = 0.0;
    for (int k = 0; k < 4; ++k) {
      const auto part = from.number<double>();
      length += part * part;
    }
    EXPECT_NEAR(length, 1.0, 1e-12);
  }
  EXPECT_TRUE(from.finished());
  return places;
}

TEST(SceneTopics, EachStateHasItsTransformsAndEachTenthOfASecondItsSceneAndDiagnoses) {
  test::KeepingSink sink;
  SceneTopics topics(test::scenario_of(test::view_scenario), sink);
  ShownState state;
  state.status = "stepped";
  for (int k = 0; k < 30; ++k) {
    state.time = k / 30.0;
    const double x = 0.1 * k;
    state.seen = {Sight<double>{{{x, 0, 1}, {1, 0}}, {}}, Sight<double>{{{2, 0, 1}, {0, 1}}, {}},
                  std::nullopt};
    topics.add(state);
  }
  std::map<std::string, int> counts;
  for (const test::KeptMessage& one : sink.messages) ++counts[one.topic];
  EXPECT_EQ(counts["/tf"], 30);
  EXPECT_EQ(counts["/scene"], 10);
  EXPECT_EQ(counts["/diagnostics"], 10);
}

TEST(SceneTopics, WhatIsNotThereOrNotFiniteHasNoTransform) {
  test::KeepingSink sink;
  SceneTopics topics(test::scenario_of(test::view_scenario), sink);
  ShownState state;
  state.seen = {Sight<double>{{{1, 2, 3}, {1, 0}}, {}},
                Sight<double>{{{std::numeric_limits<double>::quiet_NaN(), 0, 1}, {0, 1}}, {}}, std::nullopt};
  topics.add(state);
  ASSERT_FALSE(sink.messages.empty());
  const auto places = transforms_in(sink.messages.front());
  ASSERT_EQ(places.size(), 1U);
  EXPECT_EQ(places.at("uav0").y, 2.0);
}

}  // namespace
}  // namespace sightline
