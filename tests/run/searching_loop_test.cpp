/// The loop of a robot that is localized by vision: what it asks of guard, search and localizer.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sightline/loop.hpp"
#include "tests/support/sample_sink.hpp"
#include "tests/support/searching_flight.hpp"

namespace sightline {
namespace {

using test::SearchingFlight;

struct SearchSamples final : test::SampleSink {
  using SampleSink::SampleSink;
  void publish() noexcept override {
    for (int i = 0; i < sample_.event_count; ++i)
      events.push_back(sample_.events[static_cast<std::size_t>(i)]);
    known.push_back(sample_.estimates[0].known);
    if (!known.back()) highest = std::max({highest, sample_.levels[0], sample_.levels[1]});
    last = sample_.levels[0];
  }

  std::vector<Event> events;
  std::vector<bool> known;
  FallbackLevel highest{}, last{};
};

TEST(SearchingLoop, ARobotWithoutAPositionTurnsUntilItSeesAndMeanwhileAllHold) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SearchingFlight flight({.seed = seed, .starts_anywhere = true});
    NewtonRiccati solver(Ocp(flight.world().team(), {.T = 1.0, .N = 20, .dt = SearchingFlight::period}));
    SearchSamples samples(sized_sample(flight.world(), {solver}));
    Guard guard(flight.world().team(), flight.guard_options());
    SimulatedClock clock;
    (void)Loop(flight.world(), {solver}, clock, samples,
               {.duration = 12.0, .guard = &guard, .localizer = &flight.localizer()})
        .run();
    EXPECT_FALSE(samples.known.front());
    EXPECT_TRUE(samples.known.back()) << seed;
    EXPECT_LE(samples.highest, FallbackLevel::hold);
    EXPECT_EQ(samples.last, FallbackLevel::valid);
    std::vector<EventKind> kinds;
    for (const Event& event : samples.events)
      if (event.kind == EventKind::search || event.kind == EventKind::found) kinds.push_back(event.kind);
    EXPECT_EQ(kinds.size() % 2, 0U) << "each search ends";
    for (std::size_t i = 0; i < kinds.size(); ++i)
      EXPECT_EQ(kinds[i], i % 2 == 0 ? EventKind::search : EventKind::found);
  }
}

}  // namespace
}  // namespace sightline
