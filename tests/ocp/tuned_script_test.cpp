#include <gtest/gtest.h>

#include <thread>

#include "sightline/events.hpp"

namespace sightline {
namespace {

TeamEvent named(std::string name) { return {.name = std::move(name), .trigger = AtTime{}}; }

TEST(TunedScript, AnEventIsOfTheFlightOnceItHappened) {
  TunedScript tuned;
  const Script script{.events = {named("own")}};
  EXPECT_EQ(flown_event(script, &tuned, 1), nullptr);
  tuned.add(named("first"), "retune = { couple = \"a\", weight = 1.0 }\n");
  EXPECT_TRUE(std::isnan(tuned.at(0)));
  tuned.occur(0, 0.25);
  tuned.ignore(0);
  EXPECT_EQ(tuned.at(0), 0.25);
  EXPECT_TRUE(tuned.is_ignored(0));
  EXPECT_EQ(tuned.text(0, 0.25), "\n[[event]]\nat = 0.25\nretune = { couple = \"a\", weight = 1.0 }\n");
  EXPECT_EQ(flown_event(script, &tuned, 0)->name, "own");
  EXPECT_EQ(flown_event(script, &tuned, 1)->name, "first");
  EXPECT_EQ(flown_event(script, nullptr, 1), nullptr);
}

TEST(TunedScript, WhoReadsSeesWholeEventsWhileOthersAreAdded) {
  TunedScript tuned;
  std::thread reader([&] {
    for (std::size_t seen = 0; seen < TunedScript::room;) {
      seen = tuned.size();
      if (seen == 0) continue;
      EXPECT_EQ(tuned.event(seen - 1).name, std::to_string(seen - 1));
    }
  });
  for (std::size_t i = 0; i < TunedScript::room; ++i) tuned.add(named(std::to_string(i)), "");
  reader.join();
  EXPECT_TRUE(tuned.is_full());
}

}  // namespace
}  // namespace sightline
