// Packets that Cyclone DDS did not write, in the midst of a flight: nothing crashes and commands
// keep to their limits. Each vehicle is flown on or given up with a sentence. The whole of it is 10
// 000 packets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/dds/fly.hpp"
#include "tests/dds/forger.hpp"
#include "tests/support/campaign.hpp"

namespace sightline::dds {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

class Forged : public FlyTest {
 protected:
  /// Packets in a flight of 60 s that a person then ends.
  void fly_among(long packets, double rate) {
    const Flying one = in_task("desk", {});
    const std::vector<test::Packet> models = test::overheard(600, std::chrono::seconds(3));
    ASSERT_GT(models.size(), 300U);
    EXPECT_GT(test::forge(models, packets, rate), packets * 9 / 10);
    std::this_thread::sleep_for(std::chrono::seconds(3));  // as long as silence needs to be noticed
    if (!one.flyer->ended()) ::kill(one.flyer->pid(), SIGINT);
    if (!test::eventually([&] { return one.flyer->ended(); }, std::chrono::seconds(30))) {
      ::kill(one.flyer->pid(), SIGINT);
      EXPECT_TRUE(test::eventually([&] { return one.flyer->ended(); }, std::chrono::seconds(10)));
    }
    one.vehicles->end(SIGINT);
    fmt::print("{} packets: exit code {}\n{}{}", packets, one.flyer->code(), printed("fly.err"),
               printed("vehicles.out"));
    // Signals and sanitizers end it by other codes.
    EXPECT_THAT(one.flyer->code(), AnyOf(0, 1));
    EXPECT_EQ(one.vehicles->code(), 0);
    EXPECT_THAT(printed("vehicles.out"), HasSubstr("uav1: "));
    // A vehicle's count of bad set-points has those that were forged in the flyer's name, too.
    const auto summary = nlohmann::json::parse(printed("flown/summary.json"));
    EXPECT_EQ(summary.at("not_finite"), 0);
    EXPECT_EQ(summary.at("input_violations"), 0);
    EXPECT_THAT(printed("vehicles.out"), Not(testing::ContainsRegex(" [2-9] requests to arm")));
    // A robot that does not land as requested is reported with a reason.
    if (one.flyer->code() == 0) {
      for (const char* uav : {"uav0: done\n", "uav1: done\n"})
        EXPECT_THAT(printed("fly.err"), HasSubstr(uav));
    } else {
      EXPECT_THAT(printed("fly.err"), testing::ContainsRegex("uav[01]: (landing|done|pilot), "));
    }
    EXPECT_THAT(printed("fly.err"), HasSubstr("packets that could not be read"));
    expect_replayed("flown");
  }
};

TEST_F(Forged, PacketsInFlightCrashNothingAndSilenceIsReported) {
  const long packets = whole_campaign() ? 10'000 : 2'000;
  test::in_own_network([&] { fly_among(packets, 1000.0); });
}

}  // namespace
}  // namespace sightline::dds
