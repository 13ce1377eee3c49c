#include "sightline/judge/input_record.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;

/// Robots a and b; a's limits narrow at 1 s, and the events that a test lets happen retune it, and
/// hold b.
class InputFlight {
 public:
  InputFlight()
      : scenario_(parse_scenario(R"toml(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
R = [1.0, 2.0, 3.0, 4.0]
limits = { times = [0.0, 1.0], u_min = [[-1.0, -1.0, -1.0, -1.0], [-0.5, -1.0, -1.0, -1.0]], u_max = [[1.0, 1.0, 1.0, 1.0], [0.5, 1.0, 1.0, 1.0]] }
[agent.b]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0] }
R = [10.0, 10.0, 10.0, 10.0]
rate_max = [2.0, 4.0, 4.0, 4.0]
[[event]]
at = 1.0
retune = { agent = "a", R = [100.0, 2.0, 3.0, 4.0], u_min = [-0.25, -1.0, -1.0, -1.0], u_max = [0.25, 1.0, 1.0, 1.0] }
[[event]]
at = 1.0
remove = { agent = "b", then = "hold" }
)toml",
                                 "inputs.toml")),
        present_(scenario_),
        record_(scenario_) {
    sample_.x.resize(static_cast<std::size_t>(scenario_.team.nx()));
    sample_.u.resize(8);
    sample_.raw_u.resize(8);
    sample_.presence.assign(2, Presence::steered);
  }

  /// An update with these first inputs of a and b. @param event  that comes into force; -1: none
  void fly(double time, double a, double b = 0.0, int event = -1) {
    sample_.time = time;
    sample_.u[0] = a, sample_.u[4] = b;
    sample_.event_count = event < 0 ? 0 : 1;
    sample_.events[0] = {time, EventKind::event_in_force, 0, static_cast<double>(event)};
    (void)present_.follow(sample_);
    record_.add(sample_, present_);
  }
  /// States that no update follows.
  void miss(double time) {
    sample_.time = time;
    sample_.of = Sample::Of::states;
    record_.add_states(sample_, present_);
    sample_.of = Sample::Of::update;
  }
  Sample& sample() { return sample_; }
  const InputRecord* operator->() const { return &record_; }

 private:
  Scenario scenario_;
  PresentTeam present_;
  InputRecord record_;
  Sample sample_{};
};

TEST(InputRecord, EnergyIsThatOfRobotsThatAreSteeredByTheWeightsInForce) {
  InputFlight flown;
  flown.fly(0.0, 0.5, 0.1);
  EXPECT_NEAR(flown->robots()[0].energy, control_period * 0.25, 1e-15);
  EXPECT_NEAR(flown->robots()[1].energy, control_period * 0.1, 1e-15);
  flown.fly(0.01, 0.2, 0.1, 0);
  EXPECT_NEAR(flown->robots()[0].energy, control_period * (0.25 + 4.0), 1e-15) << "100 instead of 1";
  flown.fly(0.02, 0.0, 0.1, 1);
  EXPECT_NEAR(flown->robots()[1].energy, control_period * 0.2, 1e-15) << "on hold";
  flown.sample().presence[0] = Presence::absent;
  flown.fly(0.03, 0.2);
  EXPECT_NEAR(flown->robots()[0].energy, control_period * (0.25 + 4.0), 1e-15) << "absent";
  EXPECT_EQ(flown->energy(), flown->robots()[0].energy + flown->robots()[1].energy);
}

TEST(InputRecord, InputsAreHeldThroughMissedPeriodsAndJudgedByTheLimitsThere) {
  InputFlight flown;
  flown.fly(0.98, 0.8);
  flown.miss(0.99);
  EXPECT_EQ(flown->beyond(), 0);
  flown.miss(1.0);
  flown.miss(1.01);
  EXPECT_EQ(flown->beyond(), 1)
      << "what was held from 1 s on is known to have been, not yet what from 1.01 s on";
  flown.fly(1.02, 0.3);
  EXPECT_EQ(flown->beyond(), 2);
  flown.fly(1.03, 0.3);
  flown.sample().u[0] = 0.8;
  flown.miss(1.04);
  EXPECT_EQ(flown->beyond(), 2) << "after the last command nothing is applied";
}

TEST(InputRecord, InputsAreWithinTheLimitsInForceAtTheirTimeToRounding) {
  InputFlight flown;
  flown.fly(0.0, 1.0 + 1e-10);
  EXPECT_TRUE(flown->within());
  flown.fly(0.99, -1.0);
  EXPECT_TRUE(flown->within());
  flown.fly(1.0, 0.75);
  EXPECT_FALSE(flown->within()) << "they narrowed to 0.5";
  flown.fly(1.01, -0.5);
  EXPECT_TRUE(flown->within());
  flown.fly(1.02, -0.5, 0.0, 0);
  EXPECT_FALSE(flown->within()) << "an event narrowed them to 0.25";
  flown.fly(1.03, 0.25 + 1e-8);
  EXPECT_FALSE(flown->within());
  EXPECT_EQ(flown->beyond(), 3);
  flown.fly(1.04, 0.2, -1.5);
  EXPECT_FALSE(flown->within()) << "of the other robot";
  for (const double wrong : {std::nan(""), -std::numeric_limits<double>::infinity()}) {
    flown.fly(1.05, wrong);
    EXPECT_FALSE(flown->within());
  }
  EXPECT_EQ(flown->beyond(), 6);
  EXPECT_EQ(flown->raw_beyond(), 0);
  flown.sample().presence[0] = Presence::absent;
  flown.fly(1.06, 7.0);
  EXPECT_TRUE(flown->within()) << "absent";
}

TEST(InputRecord, RawInputsAreCountedApart) {
  InputFlight flown;
  flown.sample().raw_u = {1.5, -2.5, 1.0, 0.0, 0.0, 0.0, std::nan(""), 1.0 + 1e-10};
  flown.fly(0.0, 0.5);
  EXPECT_TRUE(flown->within());
  EXPECT_EQ(flown->beyond(), 0);
  EXPECT_EQ(flown->raw_beyond(), 3);
  EXPECT_EQ(flown->largest_raw(), 2.5);
}

TEST(InputRecord, TheLargestRateCountsAgainstRateMax) {
  InputFlight flown;
  flown.fly(0.0, 0.0, 0.5);
  EXPECT_EQ(flown->robots()[1].rate_ratio, 0.0);
  flown.fly(0.01, 1.0, 0.51);
  flown.fly(0.03, -1.0, 0.45);
  flown.fly(0.04, -1.0, 0.46);
  EXPECT_NEAR(flown->robots()[1].rate_ratio, 1.5, 1e-12) << "0.06 in 0.02 s, of 2 a second";
  EXPECT_EQ(flown->robots()[0].rate_ratio, 0.0) << "it has no rate_max";
}

TEST(InputRecord, AnInputChattersByTheRangeOfItsLimits) {
  InputFlight wide, narrow;
  for (int k = 0; k < 200; ++k) {
    wide.fly(control_period * k, k % 2 == 0 ? 0.015 : 0.0);
    narrow.fly(control_period * k, k % 2 == 0 ? 0.015 : 0.0, 0.0, k == 0 ? 0 : -1);
  }
  EXPECT_GT(wide->chatter().worst_share(), 0.4) << "1.5 % of 1 from 1 s on, and less of 2 before";
  EXPECT_LT(wide->chatter().worst_share(), 0.6);
  EXPECT_EQ(narrow->chatter().worst_share(), 1.0) << "3 % of 0.5";
}

TEST(InputRecord, ASampleIsFiniteWhereEachOfItsNumbersIs) {
  InputFlight flown;
  EXPECT_TRUE(all_finite(flown.sample()));
  for (std::vector<double> Sample::*const of : {&Sample::x, &Sample::u, &Sample::raw_u}) {
    Sample sample = flown.sample();
    (sample.*of)[3] = std::nan("");
    EXPECT_FALSE(all_finite(sample));
    sample.of = Sample::Of::states;
    EXPECT_EQ(all_finite(sample), of != &Sample::x) << "no update has inputs";
  }
}

}  // namespace
}  // namespace sightline
