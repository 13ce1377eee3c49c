#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/world.hpp"
#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;
using Numbers = std::vector<double>;

// A multirotor that flies under inputs that are recorded, and its track.
struct Flight {
  explicit Flight(const TrackLimits& limits = {}, Numbers start = {1, 2, 1, 1, 0, 0.3, 0.1})
      : track(model, 0, limits), x(std::move(start)) {}

  // One period under u, after a look at the state.
  MeasurementFault step(const std::function<void(Numbers&)>& spoil = {}) {
    Numbers seen = x;
    if (spoil) spoil(seen);
    const MeasurementFault fault = track.take(seen, t, t, history);
    track.predict(t, history);
    fly();
    return fault;
  }
  // One period in which nothing comes.
  void blind() {
    track.predict(t, history);
    fly();
  }
  void fly() {
    history.record(t, u);
    Numbers scratch(5 * x.size());
    rk4_step([&](auto z, auto rate) { model.f(z.data(), u.data(), rate.data()); }, x, control_period,
             {scratch});
    EXPECT_TRUE(model.normalise(x.data()));
    t += control_period;
  }
  double error() const {
    double largest = 0;
    for (std::size_t i = 0; i < x.size(); ++i) largest = std::max(largest, std::abs(track.state()[i] - x[i]));
    return largest;
  }

  Model model = Multirotor{};
  Numbers u = {0.4, -0.3, 0.1, 0.2};
  InputHistory history{400, Numbers(4, 0.0)};
  Track track;
  Numbers x;
  double t = 0.0;
};

Numbers list(std::span<const double> values) { return {values.begin(), values.end()}; }

TEST(Track, AMeasurementOfThisVeryMomentIsBelievedBitForBit) {
  Flight flight;
  for (int k = 0; k < 300; ++k) {
    const Numbers x = flight.x;
    ASSERT_EQ(flight.step(), MeasurementFault::none);
    ASSERT_EQ(list(flight.track.state()), x);
    ASSERT_TRUE(flight.track.trusted());
  }
}

TEST(Track, WithoutMeasurementsTheModelUnderTheInputsGivenGoesOn) {
  Flight flight;
  flight.step();
  for (int k = 0; k < 200; ++k) {
    flight.u = {0.5 * std::sin(0.1 * k), 0.4, -0.2, std::cos(0.05 * k)};
    flight.blind();
  }
  flight.track.predict(flight.t, flight.history);
  EXPECT_LT(flight.error(), 1e-9);
  EXPECT_EQ(flight.track.stamp(), 0.0);
}

TEST(Track, ALateMeasurementIsCarriedToThePresent) {
  for (const int late : {1, 7, 20, 150}) {
    Flight flight;
    std::vector<Numbers> past;
    std::vector<double> times;
    for (int k = 0; k < 250; ++k) {
      flight.u = {0.5 * std::sin(0.1 * k), 0.4, -0.2, std::cos(0.05 * k)};
      past.push_back(flight.x);
      times.push_back(flight.t);
      const auto seen = static_cast<std::size_t>(std::max(0, k - late));
      ASSERT_EQ(flight.track.take(past[seen], times[seen], flight.t, flight.history), MeasurementFault::none);
      flight.track.predict(flight.t, flight.history);
      ASSERT_LT(flight.error(), 1e-9) << "late " << late << ", k = " << k;
      flight.fly();
    }
  }
}

TEST(Track, WhatIsOlderThanTheLastMeasurementIsNothingNew) {
  Flight flight;
  for (int k = 0; k < 10; ++k) flight.step();
  const Numbers before = list(flight.track.state());
  EXPECT_EQ(flight.track.take(Numbers(7, 1e9), 0.05, flight.t, flight.history), MeasurementFault::none);
  EXPECT_EQ(flight.track.take(Numbers(7, 1e9), NAN, flight.t, flight.history), MeasurementFault::none);
  EXPECT_EQ(list(flight.track.state()), before);
  EXPECT_TRUE(flight.track.trusted());
}

// Each way of being wrong, and the reason that is told.
struct Spoiled {
  const char* what;
  std::size_t number;
  double value;
  MeasurementFault fault;
};
const Spoiled spoiled[] = {
    {"not a number", 0, NAN, MeasurementFault::not_finite},
    {"not a number", 6, NAN, MeasurementFault::not_finite},
    {"infinite", 2, INFINITY, MeasurementFault::not_finite},
    {"infinite", 4, -INFINITY, MeasurementFault::not_finite},
    {"huge", 1, 1e300, MeasurementFault::world},
    {"huge", 4, 1e300, MeasurementFault::heading},
    {"huge", 5, -1e300, MeasurementFault::speed},
    {"below the world", 2, -101.0, MeasurementFault::world},
    {"no heading", 3, 0.0, MeasurementFault::heading},
    {"a long heading", 3, 2.0, MeasurementFault::heading},
    {"a short heading", 3, 1e-3, MeasurementFault::heading},
    {"a tiny heading", 3, 1e-310, MeasurementFault::heading},
    {"too fast", 5, 5.5, MeasurementFault::speed},
    {"elsewhere", 0, 1.2, MeasurementFault::jump},
    {"turned", 3, -1.0, MeasurementFault::jump},
};

TEST(Track, WhatCannotBeIsRefusedWithItsReasonAndTheModelGoesOn) {
  for (const Spoiled& bad : spoiled) {
    Flight flight;
    flight.u = Numbers(4, 0.0);
    flight.step();
    flight.step();
    ASSERT_EQ(flight.step([&](Numbers& x) { x[bad.number] = bad.value; }), bad.fault)
        << bad.what << " " << bad.number;
    EXPECT_FALSE(flight.track.trusted());
    flight.track.predict(flight.t, flight.history);
    EXPECT_LT(flight.error(), 1e-9) << bad.what << ": the model went on";
    EXPECT_EQ(flight.track.stamp(), control_period);
  }
}

TEST(Track, AMeasurementFromTheFutureIsRefused) {
  Flight flight;
  flight.step();
  EXPECT_EQ(flight.track.take(flight.x, flight.t + 0.1, flight.t, flight.history), MeasurementFault::time);
  EXPECT_EQ(flight.track.take(flight.x, INFINITY, flight.t, flight.history), MeasurementFault::time);
  for (int k = 0; k < 3; ++k) flight.step();
  EXPECT_TRUE(flight.track.trusted());
  EXPECT_EQ(flight.track.take(flight.x, flight.t + 0.03, flight.t, flight.history), MeasurementFault::none);
  EXPECT_EQ(flight.track.stamp(), flight.t) << "as if it were of now";
}

TEST(Track, AMeasurementTooOldToBeCarriedToThePresentIsRefused) {
  for (const double old : {-1e300, -1e9, -2.6}) {
    Flight flight;
    EXPECT_EQ(flight.track.take(flight.x, old, 0.0, flight.history), MeasurementFault::time);
    EXPECT_FALSE(flight.track.known());
  }
  Flight flight;
  EXPECT_EQ(flight.track.take(flight.x, -2.4, 0.0, flight.history), MeasurementFault::none);
}

TEST(Track, AfterAFaultSoManyConsistentMeasurementsInARowAreAskedFor) {
  for (const int accept_after : {1, 3, 8}) {
    Flight flight({.accept_after = accept_after});
    for (int k = 0; k < 5; ++k) flight.step();
    flight.step([](Numbers& x) { x[0] = NAN; });
    for (int good = 1; good <= accept_after + 3; ++good) {
      const double t = flight.t;
      flight.step();
      ASSERT_EQ(flight.track.trusted(), good >= accept_after) << good << " of " << accept_after;
      ASSERT_EQ(flight.track.stamp() == t, good >= accept_after);
    }
  }
}

TEST(Track, AJumpToAnotherPlaceIsBelievedOnceItIsConsistentWithItself) {
  Flight flight;
  for (int k = 0; k < 5; ++k) flight.step();
  const auto moved = [](Numbers& x) { x[0] += 3.0; };
  EXPECT_EQ(flight.step(moved), MeasurementFault::jump);
  EXPECT_EQ(flight.step(moved), MeasurementFault::jump);
  EXPECT_EQ(flight.step(moved), MeasurementFault::none);
  EXPECT_GT(flight.error(), 2.9);
}

TEST(Track, MeasurementsThatJumpToAndFroAreNeverBelieved) {
  Flight flight;
  for (int k = 0; k < 5; ++k) flight.step();
  const double stamp = flight.track.stamp();
  for (int k = 0; k < 200; ++k) {
    flight.step([&](Numbers& x) { x[1] += k % 2 == 0 ? 1.0 : -1.0; });
    ASSERT_EQ(flight.track.stamp(), stamp);
  }
}

TEST(Track, AFrozenMeasurementIsNoticedWithinHalfASecondAndCountsFromItsFirst) {
  RandomStream chance(5, StreamId::gust, 0);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto draw = [&] { return 2.0 * chance.uniform() - 1.0; };
    Flight flight({}, {0, 0, 1, 1, 0, 0, 0});
    flight.u = {draw(), draw(), 0.3 * draw(), draw()};
    for (int k = 0; k < 30; ++k) flight.step();
    const Numbers frozen = flight.x;
    const double since = flight.t;
    MeasurementFault fault = MeasurementFault::none;
    int k = 0;
    for (; k < 51 && fault == MeasurementFault::none; ++k)
      fault = flight.step([&](Numbers& x) { x = frozen; });
    ASSERT_EQ(fault, MeasurementFault::frozen);
    ASSERT_LE(k, 50);
    ASSERT_EQ(flight.track.stamp(), since);
    flight.track.predict(flight.t, flight.history);
    ASSERT_LT(flight.error(), 1e-9) << "the model went on from the first of the equal ones";
    for (int more = 0; more < 100; ++more) flight.step([&](Numbers& x) { x = frozen; });
    ASSERT_EQ(flight.track.stamp(), since);
    for (int more = 0; more < 3; ++more) flight.step();
    ASSERT_TRUE(flight.track.trusted());
  }
}

TEST(Track, ABodyThatRestsIsNotFrozen) {
  Flight flight({}, {1, 2, 1, 1, 0, 0, 0});
  flight.u = Numbers(4, 0.0);
  for (int k = 0; k < 1000; ++k) ASSERT_EQ(flight.step(), MeasurementFault::none);
  EXPECT_EQ(flight.track.stamp(), flight.t - control_period);
}

TEST(Track, NoiseAsLargeAsItIsSaidToBeIsNoFault) {
  for (const double sigma : {0.002, 0.02, 0.2}) {
    Flight flight({.position_sigma = sigma, .heading_sigma = sigma}, {1, 2, 1, 1, 0, 0, 0});
    flight.u = {0.1, 0.0, 0.0, 0.3};
    RandomStream chance(6, StreamId::position_noise, 0);
    int faults = 0;
    for (int k = 0; k < 3000; ++k) {
      const MeasurementFault fault = flight.step([&](Numbers& x) {
        for (std::size_t i = 0; i < 3; ++i) x[i] += sigma * chance.normal();
        const double psi = std::atan2(x[4], x[3]) + sigma * chance.normal();
        x[3] = std::cos(psi);
        x[4] = std::sin(psi);
      });
      faults += fault != MeasurementFault::none ? 1 : 0;
    }
    EXPECT_LE(faults, 6) << sigma;
  }
}

TEST(Track, OfWhatWasNeverSeenTheStateIsFiniteAndNotKnown) {
  Flight flight;
  flight.step([](Numbers& x) { x[0] = 1e160; });
  EXPECT_FALSE(flight.track.known());
  EXPECT_TRUE(all_finite(flight.track.state()));
  for (int k = 0; k < 3; ++k) flight.step();
  EXPECT_TRUE(flight.track.known());
}

}  // namespace
}  // namespace sightline
