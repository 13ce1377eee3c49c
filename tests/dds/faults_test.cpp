#include "bridges/dds/simulators/faults.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "bridges/dds/domain.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

using Odometry = px4_msgs_msg_dds__VehicleOdometry_;
using Kind = LinkFaultKind;

/// A faulty writer, and what comes of its messages, whose stamps count them.
struct Way {
  explicit Way(std::uint64_t seed) : faults(seed) {
    while (writer_side.matched() == 0 || reader.matched() < 2)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  void write(std::uint64_t number) {
    Odometry m{};
    m.timestamp = number;
    writer.write(&m);
  }

  Domain domain{test::own_network()};
  Faults faults;
  std::atomic<int> came{0};
  std::atomic<std::uint64_t> last{0};
  std::atomic<int> backwards{0};
  RawReader reader{domain.another_participant(),
                   px4_msgs_msg_dds__VehicleOdometry__desc,
                   "/faulty",
                   {.reliable = true, .depth = 10'000},
                   std::nullopt,
                   Writers::all,
                   [this](const void* m, const Arrival&) {
                     const std::uint64_t number = static_cast<const Odometry*>(m)->timestamp;
                     ++came;
                     if (number < last.exchange(number)) ++backwards;
                   }};
  FaultyWriter writer{domain.participant(),
                      px4_msgs_msg_dds__VehicleOdometry__desc,
                      "/faulty",
                      {.reliable = true, .depth = 10'000},
                      faults};
  RawWriter writer_side{domain.participant(),
                        px4_msgs_msg_dds__VehicleOdometry__desc,
                        "/faulty",
                        {.reliable = true, .depth = 1}};
};

TEST(Faults, TheSameSeedAndMessagesGiveTheSameCounts) {
  std::array<FaultCounts, 3> counts;
  for (std::size_t run = 0; run < 3; ++run) {
    Way way(run == 2 ? 8 : 7);
    for (const Kind kind : {Kind::drop, Kind::duplicate, Kind::reorder}) way.faults.begin(kind);
    for (std::uint64_t i = 1; i <= 1000; ++i) way.write(i), way.faults.pass_on();
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    way.faults.pass_on();
    counts[run] = way.faults.counts();
    const FaultCounts& n = counts[run];
    EXPECT_NEAR(static_cast<double>(n.dropped), 200, 60);
    EXPECT_NEAR(static_cast<double>(n.duplicated), 80, 40);
    EXPECT_NEAR(static_cast<double>(n.reordered), 80, 40);
    const int sent = static_cast<int>(1000 - n.dropped + n.duplicated);
    EXPECT_TRUE(test::eventually([&] { return way.came == sent; }, std::chrono::seconds(5)))
        << way.came << " of " << sent;
    EXPECT_GT(way.backwards, 0);
  }
  EXPECT_EQ(counts[0], counts[1]);
  EXPECT_NE(counts[0], counts[2]);
}

TEST(Faults, AWriterWithoutFaultsSendsAllAtOnceAndASilentOneNothing) {
  Way way(1);
  for (std::uint64_t i = 1; i <= 100; ++i) way.write(i);
  EXPECT_TRUE(test::eventually([&] { return way.came == 100; }, std::chrono::seconds(5)));
  way.faults.begin(Kind::silent);
  for (std::uint64_t i = 1; i <= 100; ++i) way.write(i);
  way.faults.end(Kind::silent);
  way.write(500);
  EXPECT_TRUE(test::eventually([&] { return way.last == 500; }, std::chrono::seconds(5)));
  EXPECT_EQ(way.came, 101);
  EXPECT_EQ(way.backwards, 0);
  EXPECT_EQ(describe(way.faults.counts()), "");
}

TEST(Faults, WhatIsLateComesAfterItsDelay) {
  Way way(1);
  way.faults.begin(Kind::delay, 0.06);
  const auto written = std::chrono::steady_clock::now();
  way.write(1);
  const auto came = [&] {
    way.faults.pass_on();
    return way.came == 1;
  };
  EXPECT_TRUE(test::eventually(came, std::chrono::seconds(5)));
  EXPECT_GE(std::chrono::steady_clock::now() - written, std::chrono::milliseconds(60));
}

TEST(Faults, PosesFreezeJumpAndCeaseToBeNumbers) {
  Faults faults(3);
  const Motion a = {.p = {1, 2, 3}}, b = {.p = {4, 5, 6}};
  EXPECT_EQ(faults.distorted(a).p.x, 1);
  faults.begin(Kind::frozen);
  EXPECT_EQ(faults.distorted(a).p.y, 2);
  EXPECT_EQ(faults.distorted(b).p.y, 2);
  faults.end(Kind::frozen);
  EXPECT_EQ(faults.distorted(b).p.y, 5);
  faults.begin(Kind::jump, 0.5);
  EXPECT_EQ(faults.distorted(b).p.x, 4.5);
  EXPECT_EQ(faults.resets(), 0);
  faults.begin(Kind::jump_reported, -1.0);
  EXPECT_EQ(faults.distorted(b).p.x, 3.5);
  EXPECT_EQ(faults.resets(), 1);
  faults.end(Kind::jump), faults.end(Kind::jump_reported);
  EXPECT_EQ(faults.distorted(b).p.x, 4.0);
  EXPECT_EQ(faults.resets(), 2);
  faults.begin(Kind::not_finite, 0.25);
  int none = 0;
  for (int k = 0; k < 400; ++k) none += std::isnan(faults.distorted(b).p.x) ? 1 : 0;
  EXPECT_NEAR(none, 100, 40);
  EXPECT_EQ(faults.counts().not_finite, none);
}

TEST(Faults, ChangesAreReportedOnce) {
  Faults faults(1);
  EXPECT_FALSE(faults.changed(Kind::pilot));
  faults.begin(Kind::pilot);
  EXPECT_TRUE(faults.changed(Kind::pilot));
  EXPECT_FALSE(faults.changed(Kind::pilot));
  EXPECT_TRUE(faults.on(Kind::pilot));
  faults.end(Kind::pilot);
  EXPECT_TRUE(faults.changed(Kind::pilot));
  EXPECT_FALSE(faults.on(Kind::pilot));
}

}  // namespace
}  // namespace sightline::dds
