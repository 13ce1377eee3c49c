#include "sightline/world.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "sightline/loop.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/seeing_world.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::two_robots;
using test::two_robots_start;

/// Robots of which nobody knows the truth. It writes down what it is asked.
class Outside final : public test::SeeingWorld {
 public:
  explicit Outside(int periods) : SeeingWorld(two_robots(), two_robots_start), left_(periods) {}

  Measured measure(double t) noexcept override {
    Measured measured = SeeingWorld::measure(t);
    measured.truth = {};
    return measured;
  }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override {
    believed_all &= estimated.size() == two_robots_start.size();
    (void)SeeingWorld::apply(t, estimated, u, period, periods);
    received += periods;
    return --left_ > 0;
  }

  bool believed_all = true;
  std::int64_t received = 0;  // periods

 private:
  int left_;
};

struct Kept final : Sink<Sample> {
  explicit Kept(Sample prototype) : sample(std::move(prototype)) {}
  Sample* claim() noexcept override { return &sample; }
  void publish() noexcept override { all.push_back(sample); }
  void close() noexcept override {}
  Sample sample;
  std::vector<Sample> all;
};

TEST(World, WhereNobodyKnowsTheTruthWhatWasMeasuredStandsForItAndTheCommandsAreTheSame) {
  NewtonRiccati known(two_robots(), {}), unknown(two_robots(), {});
  SimulatedClock clock;
  ModelWorld model(two_robots(), two_robots_start);
  Outside outside(1000);
  Kept of_model(sized_sample(two_robots(), {known})), of_outside(sized_sample(outside, {unknown}));
  (void)Loop(model, {known}, clock, of_model, {.duration = 2.0}).run();
  (void)Loop(outside, {unknown}, clock, of_outside, {.duration = 2.0}).run();
  ASSERT_EQ(of_outside.all.size(), of_model.all.size());
  for (std::size_t k = 0; k < of_model.all.size(); ++k) {
    ASSERT_EQ(of_outside.all[k].u, of_model.all[k].u) << k;
    ASSERT_EQ(of_outside.all[k].x, of_outside.all[k].measured) << k;
  }
  EXPECT_TRUE(outside.believed_all);
}

TEST(World, DetectionsComeToTheSampleWithTheirStamps) {
  NewtonRiccati solver(two_robots(), {});
  SimulatedClock clock;
  Outside outside(1000);
  Kept kept(sized_sample(outside, {solver}));
  (void)Loop(outside, {solver}, clock, kept, {.duration = 0.5}).run();
  for (const Sample& sample : kept.all) {
    ASSERT_EQ(sample.detection_count, 1U);
    EXPECT_EQ(sample.detections[0].stamp, sample.time);
    EXPECT_EQ(sample.detections[0].p.x, sample.measured[7] - sample.measured[0]);
    EXPECT_EQ(at(sample.detections[0].target), 1U);
  }
  Kept without(sized_sample(two_robots(), {solver}));
  EXPECT_THROW(Loop(outside, {solver}, clock, without, {}), std::invalid_argument) << "no room for them";
}

TEST(World, EndsTheLoopWhereItCannotGoOn) {
  NewtonRiccati solver(two_robots(), {});
  SimulatedClock clock;
  Outside outside(30);
  Kept kept(sized_sample(outside, {solver}));
  const LoopOutcome outcome = Loop(outside, {solver}, clock, kept, {.duration = 2.0}).run();
  EXPECT_EQ(outcome.updates, 30);
  EXPECT_FALSE(outcome.finite);
}

TEST(World, IsToldEveryPeriodOnceThoughSomeAreMissed) {
  class Stumbling final : public Clock {
    void start(double) noexcept override {}
    std::int64_t wait(std::int64_t k) noexcept override { return k % 10 == 5 ? k + 3 : k; }
    bool waits_for_log() const noexcept override { return true; }
  } clock;
  NewtonRiccati solver(two_robots(), {});
  Outside outside(1000);
  Kept kept(sized_sample(outside, {solver}));
  const LoopOutcome outcome = Loop(outside, {solver}, clock, kept, {.duration = 1.0}).run();
  EXPECT_EQ(outcome.missed, 30);
  EXPECT_EQ(outcome.updates, 70);
  EXPECT_EQ(outside.received, 100);
}

}  // namespace
}  // namespace sightline
