#include "bridges/dds/simulators/simulated_radio.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sightline::dds {
namespace {

using testing::ElementsAre;

constexpr std::int64_t radio_ms = 1'000'000;

TEST(SimulatedRadio, ALowerPortGoesFirstAndPacketsOfAPortInOrder) {
  SimulatedRadio radio(0, 10 * radio_ms);
  std::vector<int> arrived;
  for (const auto& [port, number] : {std::pair{RadioPort::commander, 1},
                                     {RadioPort::setpoints, 2},
                                     {RadioPort::setpoints, 3},
                                     {RadioPort::emergency, 4}})
    radio.send(port, [&arrived, n = number] { arrived.push_back(n); });
  radio.run(9 * radio_ms);
  EXPECT_THAT(arrived, ElementsAre());
  radio.run(20 * radio_ms);
  EXPECT_THAT(arrived, ElementsAre(4, 2));
  radio.run(100 * radio_ms);
  EXPECT_THAT(arrived, ElementsAre(4, 2, 3, 1));
  EXPECT_EQ(radio.sent(), 10) << "with the empty ones";
}

// Measured with the server's queue: the end of set-points arrived 0.3 s before the last of them.
TEST(SimulatedRadio, OnAFullRadioPacketsOfAPortOvertakeEachOther) {
  SimulatedRadio radio(0, 10 * radio_ms);
  std::vector<int> arrived;
  int number = 0;
  const auto send = [&] {
    radio.send(RadioPort::setpoints, [&arrived, n = number++] { arrived.push_back(n); });
  };
  for (int i = 0; i < 20; ++i) send();
  for (std::int64_t i = 1; i <= 100; ++i) {
    send();
    radio.run(i * 10 * radio_ms);
  }
  radio.run(5000 * radio_ms);
  EXPECT_EQ(arrived.size(), 120);
  EXPECT_FALSE(std::is_sorted(arrived.begin(), arrived.end()));
}

TEST(SimulatedRadio, APacketThatIsLostIsSentAgain) {
  SimulatedRadio radio(0, 10 * radio_ms, 0.5);
  int arrived = 0;
  for (int i = 0; i < 10; ++i) radio.send(RadioPort::setpoints, [&] { ++arrived; });
  radio.run(100 * radio_ms);
  EXPECT_EQ(arrived, 5);
  EXPECT_EQ(radio.sent(), 10);
  EXPECT_EQ(radio.received(), 5);
  radio.run(200 * radio_ms);
  EXPECT_EQ(arrived, 10);
}

/// Delay of the last log [radio_ms] after so long, if it logs at 110 Hz.
double delay_of_logs(SimulatedRadio& radio, double seconds) {
  double delay = 0;
  for (std::int64_t i = 1; i <= static_cast<std::int64_t>(110 * seconds); ++i) {
    const std::int64_t made = i * 1'000'000'000 / 110;
    radio.log([&delay, &radio, made] { delay = static_cast<double>(radio.now() - made) / radio_ms; });
    radio.run(made);
  }
  return delay;
}

// The firmware holds 200 logs. Measured with 110 logs: at 100 packets a second poses come 2 s late
// after 20 s. At 75 they are lost; at 250 they come at once. The latency stays at its last value
// below 1 s.
TEST(SimulatedRadio, LogsThatAreMoreThanThePacketsComeSecondsLate) {
  SimulatedRadio fast(0, 4 * radio_ms), full(0, 10 * radio_ms), slow(0, 13'333'333);
  EXPECT_LT(delay_of_logs(fast, 20), 10);
  EXPECT_NEAR(delay_of_logs(full, 30), 2000, 50);
  EXPECT_NEAR(delay_of_logs(slow, 30), 200 * 13.3, 100);
  EXPECT_EQ(fast.logs_lost(), 0);
  EXPECT_GT(slow.logs_lost(), 500);
  EXPECT_LE(fast.latency(), 10);
  EXPECT_GT(full.latency(), 500);
  EXPECT_LE(full.latency(), 1000);
}

// With set-points alone on the radio nothing else leaves: the server's echo and requests wait
// behind them.
TEST(SimulatedRadio, ARequestWaitsForAsLongAsSetpointsFillTheRadio) {
  SimulatedRadio radio(0, 10 * radio_ms);
  bool landed = false;
  radio.send(RadioPort::commander, [&] { landed = true; });
  for (std::int64_t i = 1; i <= 500; ++i) {
    radio.send(RadioPort::setpoints, [] {});
    radio.run(i * 10 * radio_ms);
  }
  EXPECT_FALSE(landed);
  radio.run(5020 * radio_ms);
  EXPECT_TRUE(landed);
}

}  // namespace
}  // namespace sightline::dds
