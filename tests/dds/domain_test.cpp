#include "bridges/dds/domain.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <thread>

#include "bridges/dds/links/px4_release.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "cli/allocations.hpp"
#include "sightline/base/now.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/child.hpp"
#include "tests/support/refusal.hpp"

extern "C" {
#include "px4.h"
#include "ros.h"
}

namespace sightline::dds {
namespace {

using test::eventually;
using test::own_network;
using testing::HasSubstr;
using testing::Not;
using Odometry = px4_msgs_msg_dds__VehicleOdometry_;
using Status16 = px4_msgs_msg_dds__VehicleStatus_16_;
using Status14 = px4_msgs_msg_dds__VehicleStatus_14_;

TEST(Domain, ByDefaultItIsLoopbackAndUnicast) {
  const std::string xml = domain_xml({});
  EXPECT_THAT(xml, HasSubstr(R"(<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>)"));
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>false</AllowMulticast>"));
  EXPECT_THAT(xml, HasSubstr(R"(<Peers><Peer Address="127.0.0.1"/></Peers>)"));
  EXPECT_THAT(xml, Not(HasSubstr("realtime")));
  EXPECT_THAT(domain_xml({}, 15), HasSubstr("<Class>realtime</Class><Priority>15</Priority>"));
}

TEST(Domain, MulticastIsOnWhereItIsAskedForAlone) {
  FleetNetwork network;
  network.interfaces = {"eth0", "lo"};
  network.peers = {"192.168.1.4", "192.168.1.5"};
  EXPECT_THAT(domain_xml(network), HasSubstr(R"(name="eth0" multicast="false")"));
  network.multicast = Multicast::on;
  EXPECT_THAT(domain_xml(network), HasSubstr(R"(name="eth0" multicast="default")"));
  EXPECT_THAT(domain_xml(network), HasSubstr(R"(name="lo" multicast="false")"));
  EXPECT_THAT(domain_xml(network), HasSubstr("<AllowMulticast>true</AllowMulticast>"));
  EXPECT_THAT(domain_xml(network),
              HasSubstr(R"(<Peer Address="192.168.1.4"/><Peer Address="192.168.1.5"/>)"));
}

// rmw_fastrtps_cpp under ROS_LOCALHOST_ONLY announces itself by multicast alone, which is off here:
// it learns of us from our announcements. While these came each 8 s it was discovered 0.2 to 7.9 s
// after its start.
TEST(Domain, ItAnnouncesItselfEachTwoSecondsToThoseWhoOnlyListen) {
  const FleetNetwork network = own_network(1);
  const int other = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  at.sin_port =
      htons(static_cast<std::uint16_t>(7400 + 250 * network.domain + 10 + 2 * 20));  // participant 20
  ASSERT_EQ(::bind(other, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
  const timeval patience = {.tv_sec = 4, .tv_usec = 0};
  ASSERT_EQ(::setsockopt(other, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
  const Domain domain(network);
  std::array<char, 4> begin{};
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(::recv(other, begin.data(), begin.size(), 0), 4) << "announcement " << k;
    EXPECT_EQ(std::string(begin.data(), 4), "RTPS");
  }
  ::close(other);
}

// A participant would still be made, and multicast on all interfaces.
TEST(Domain, AnInterfaceThatIsNotThereIsRefused) {
  FleetNetwork network = own_network(1);
  network.interfaces = {"nowhere0"};
  EXPECT_THAT(refusal_of<std::runtime_error>([&] { Domain domain(network); }),
              HasSubstr(fmt::format("fleet.domain = {} on nowhere0: ", test::own_domain(1))));
  Domain domain(own_network(1));  // and nothing of it is left
  EXPECT_THAT(refusal_of<std::runtime_error>([&] { Domain again(own_network(1)); }),
              HasSubstr(fmt::format("fleet.domain = {}", test::own_domain(1))));
}

class Channel : public testing::Test {
 protected:
  RawReader reader(const dds_topic_descriptor_t& type, const std::string& topic, std::size_t payload,
                   Writers writers, RawReader::Take take) {
    return {domain.participant(), type, topic, of_sensors, payload, writers, std::move(take)};
  }
  Domain domain{own_network()};
  dds_entity_t other = domain.another_participant();
};

TEST_F(Channel, AMessageArrivesWholeAndStamped) {
  Mailbox<Odometry> box;
  std::atomic<std::int64_t> arrived{0};
  const RawReader in = reader(px4_msgs_msg_dds__VehicleOdometry__desc, "/a/odometry",
                              *payload_size(px4_type("VehicleOdometry", 16)), Writers::first,
                              taking<Odometry>([&](const Odometry& m, const Arrival& a) {
                                box.put(m);
                                arrived = a.monotonic;
                              }));
  Writer<Odometry> out(other, px4_msgs_msg_dds__VehicleOdometry__desc, "/a/odometry", of_px4_output);
  ASSERT_TRUE(eventually([&] { return out.matched() == 1 && in.matched() == 1; }));
  Odometry sent{};
  sent.timestamp = 7, sent.position[2] = -1.5F, sent.quality = -3;
  const std::int64_t before = monotonic_now();
  ASSERT_TRUE(out(sent));
  ASSERT_TRUE(eventually([&] { return box.count() == 1; }));
  Odometry got{};
  ASSERT_TRUE(box.look(got));
  EXPECT_EQ(got.timestamp, 7u);
  EXPECT_EQ(got.position[2], -1.5F);
  EXPECT_EQ(got.quality, -3);
  EXPECT_GE(arrived, before);
  EXPECT_EQ(in.topic(), "rt/a/odometry");
}

// 1.14 on a topic of 1.16 and the other way round: neither is taken for the other, and both are
// counted or dropped.
TEST_F(Channel, AMessageOfAnotherReleaseIsRefusedAndCounted) {
  std::atomic<int> taken{0};
  const RawReader in = reader(px4_msgs_msg_dds__VehicleStatus_14__desc, "/b/status",
                              *payload_size(px4_type("VehicleStatus", 14)), Writers::all,
                              [&](const void*, const Arrival&) { ++taken; });
  Writer<Status16> longer(other, px4_msgs_msg_dds__VehicleStatus_16__desc, "/b/status", of_px4_output);
  ASSERT_TRUE(eventually([&] { return longer.matched() == 1; }));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(longer(Status16{}));
  EXPECT_TRUE(eventually([&] { return in.counts().too_long == 5; }));
  EXPECT_EQ(in.counts().wrong_size, 80u);
  Writer<Status14> right(other, px4_msgs_msg_dds__VehicleStatus_14__desc, "/b/status", of_px4_output);
  ASSERT_TRUE(eventually([&] { return right.matched() == 1; }));
  ASSERT_TRUE(right(Status14{}));
  EXPECT_TRUE(eventually([&] { return taken == 1; }));

  const std::int64_t before = complaints();
  const RawReader newer = reader(px4_msgs_msg_dds__VehicleStatus_16__desc, "/c/status",
                                 *payload_size(px4_type("VehicleStatus", 16)), Writers::all,
                                 [&](const void*, const Arrival&) { ++taken; });
  Writer<Status14> shorter(other, px4_msgs_msg_dds__VehicleStatus_14__desc, "/c/status", of_px4_output);
  ASSERT_TRUE(eventually([&] { return shorter.matched() == 1; }));
  ASSERT_TRUE(shorter(Status14{}));
  EXPECT_TRUE(eventually([&] { return complaints() > before || newer.counts().too_short == 1; }));
  EXPECT_EQ(taken, 1);
}

TEST_F(Channel, OfTwoWritersTheFirstIsKept) {
  Mailbox<Odometry> box;
  const RawReader in = reader(px4_msgs_msg_dds__VehicleOdometry__desc, "/d/odometry", 114, Writers::first,
                              taking<Odometry>([&](const Odometry& m, const Arrival&) { box.put(m); }));
  Writer<Odometry> first(other, px4_msgs_msg_dds__VehicleOdometry__desc, "/d/odometry", of_px4_output);
  ASSERT_TRUE(eventually([&] { return first.matched() == 1; }));
  Odometry m{};
  m.timestamp = 1;
  first(m);
  ASSERT_TRUE(eventually([&] { return box.count() == 1; }));
  Writer<Odometry> second(domain.another_participant(), px4_msgs_msg_dds__VehicleOdometry__desc,
                          "/d/odometry", of_px4_output);
  ASSERT_TRUE(eventually([&] { return second.matched() == 1; }));
  EXPECT_EQ(first.rivals(WriterList(other).look()), 1);
  m.timestamp = 2;
  for (int k = 0; k < 10; ++k) second(m);
  EXPECT_TRUE(eventually([&] { return in.counts().foreign == 10; }));
  box.look(m);
  EXPECT_EQ(m.timestamp, 1u);
}

TEST_F(Channel, WritingASmallMessageAllocatesNothing) {
  Writer<Odometry> out(other, px4_msgs_msg_dds__VehicleOdometry__desc, "/e/odometry", of_sensors);
  const RawReader in = reader(px4_msgs_msg_dds__VehicleOdometry__desc, "/e/odometry", 114, Writers::all,
                              [](const void*, const Arrival&) {});
  ASSERT_TRUE(eventually([&] { return out.matched() == 1; }));
  std::int64_t before = 0;
  for (int k = 0; k < 400; ++k) {
    if (k == 200) before = cli::allocations();
    out(Odometry{});
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(cli::allocations(), before);
}

TEST_F(Channel, WhoWritesIsKnownByTopicAndType) {
  Writer<Status16> out(other, px4_msgs_msg_dds__VehicleStatus_16__desc, "/f/status_v1", of_px4_output);
  WriterList list(domain.participant());
  EXPECT_TRUE(eventually([&] {
    const auto writers = list.look();
    return std::any_of(writers.begin(), writers.end(), [](const SeenWriter& w) {
      return w.topic == "rt/f/status_v1" && w.type == "px4_msgs::msg::dds_::VehicleStatus_";
    });
  }));
}

}  // namespace
}  // namespace sightline::dds
