// What becomes of a flight whose log is stuck, has died, or has gone.
#include <gtest/gtest.h>
#include <time.h>

#include "sightline/loop.hpp"
#include "sightline/model.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/gradient_planner.hpp"

namespace sightline {
namespace {

Team robot_alone() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  return team;
}

/// A robot whose samples nobody takes.
struct UnreadFlight {
  Team team = robot_alone();
  GradientPlanner planner{team, {.T = 0.5, .N = 5, .dt = 0.01}};
  ModelWorld world{team, std::vector<double>{-0.6, -0.3, 0.6, 1, 0, 0, 0}};
  SimulatedClock clock;
  SpscQueue<Sample> ring{4, sized_sample(team, {planner})};

  LoopOutcome fly(const LoopOptions& options) { return Loop(world, {planner}, clock, ring, options).run(); }
};

double cpu_of_this_thread() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

TEST(LoopSink, PastItsPatienceTheFlightGoesOnWithoutAStuckLog) {
  UnreadFlight flight;
  const double before = cpu_of_this_thread();
  const LoopOutcome outcome = flight.fly({.duration = 1.0, .log_patience = 0.3});
  EXPECT_EQ(outcome.updates, 100);
  EXPECT_EQ(outcome.dropped, 96);
  EXPECT_LT(cpu_of_this_thread() - before, 0.25);  // it sleeps meanwhile
}

TEST(LoopSink, ADeadLogIsNotWaitedFor) {
  UnreadFlight flight;
  flight.ring.abandon();
  const LoopOutcome outcome = flight.fly({.duration = 1.0, .log_patience = 1e6});
  EXPECT_EQ(outcome.updates, 100);
  EXPECT_EQ(outcome.dropped, 96);
}

TEST(LoopSink, ASampleWithoutRoomIsStillActedOnByWhoLooksOn) {
  struct Onlooker final : Sink<Sample> {
    explicit Onlooker(const Sample& sized) : sample(sized) {}
    Sample* claim() noexcept override { return published < 3 ? &sample : nullptr; }
    void publish() noexcept override { ++published; }
    void drop(const Sample& one) noexcept override { last = one.time, ++dropped; }
    void close() noexcept override {}
    bool is_abandoned() const noexcept override { return true; }
    Sample sample;
    int published = 0, dropped = 0;
    double last = 0.0;
  };
  UnreadFlight flight;
  Onlooker sink(sized_sample(flight.team, {flight.planner}));
  Loop(flight.world, {flight.planner}, flight.clock, sink, {.duration = 0.1}).run();
  EXPECT_EQ(sink.published, 3);
  EXPECT_EQ(sink.dropped, 7);
  EXPECT_DOUBLE_EQ(sink.last, 0.09);
}

}  // namespace
}  // namespace sightline
