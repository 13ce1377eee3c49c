#include "sightline/record/log_topics.hpp"

#include <gtest/gtest.h>

#include <span>

#include "sightline/record/log.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/keeping_sink.hpp"
#include "tests/support/passing_sink.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using test::KeepingSink;
using test::kept_bytes;
using test::KeptMessage;

TEST(LogTopics, WhoeverIsToldTheSamplesOfALogGetsItsMessagesByteForByte) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const auto folder = test::fresh_folder();
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  SpscQueue<Sample> ring(64, sized_sample(*world, controls.controllers(), controls.team_switcher()));
  std::vector<Sample> samples;
  test::PassingSink kept(ring, [&](Sample& sample) { samples.push_back(sample); });
  SimulatedClock clock;
  Log log(scenario, folder, controls.controllers(), ring);
  log.start();
  (void)ClosedLoop(scenario, *world, controls.controllers(), clock, kept, nullptr, controls.team_switcher())
      .fly();
  log.finish();
  ASSERT_EQ(log.error(), "");

  KeepingSink sink;
  LogTopics topics(scenario, controls.controllers().size(), sink);
  PresentTeam present(scenario);
  for (const Sample& sample : samples) {
    (void)present.follow(sample);
    (void)topics.add(sample, present, present.cost(sample));
  }

  McapReader reader(folder / "run.mcap");
  const std::vector<McapReader::Topic> logged = reader.topics();
  ASSERT_EQ(logged.size(), sink.channels.size());
  for (std::size_t i = 0; i < logged.size(); ++i) {
    EXPECT_EQ(logged[i].topic, sink.channels[i].topic);
    EXPECT_EQ(logged[i].encoding, sink.channels[i].encoding);
    EXPECT_EQ(logged[i].schema, sink.schemas[sink.channels[i].schema].name);
    EXPECT_EQ(logged[i].schema_text, sink.schemas[sink.channels[i].schema].text);
    EXPECT_EQ(logged[i].schema_encoding, logged[i].encoding == "cdr" ? "ros2msg" : "jsonschema");
  }
  std::size_t count = 0;
  reader.visit([&](const McapMessage& message) {
    const KeptMessage read{std::string(message.topic), std::string(message.encoding),
                           std::string(message.schema), message.log_time, kept_bytes(message.bytes)};
    ASSERT_LT(count, sink.messages.size());
    EXPECT_EQ(read, sink.messages[count]) << read.topic << " at " << 1e-9 * static_cast<double>(read.time);
    ++count;
  });
  EXPECT_TRUE(reader.ok()) << reader.error();
  EXPECT_EQ(count, sink.messages.size());
  EXPECT_GT(count, 1000U);
}

TEST(LogTopics, TheFirstSampleOfEachTenthOfASecondIsTold) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  Sample sample = sized_sample(*world, controls.controllers(), controls.team_switcher());
  KeepingSink sink;
  LogTopics topics(scenario, controls.controllers().size(), sink);
  PresentTeam present(scenario);
  int first = 0;
  for (int k = 0; k < 100; ++k) {
    sample.time = 0.01 * k;
    if (topics.add(sample, present, 0.0)) ++first;
  }
  EXPECT_EQ(first, 10);
}

}  // namespace
}  // namespace sightline
