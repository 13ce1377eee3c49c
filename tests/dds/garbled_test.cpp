// Messages that are not what they should be, by the readers' own way: none is taken for another,
// each is counted. Commands stay finite and within their limits. The whole of it is 100 000 of each
// type.
#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "bridges/dds/links/px4_layout.hpp"
#include "bridges/dds/topics/service.hpp"
#include "sightline/base.hpp"
#include "tests/dds/garbler.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/campaign.hpp"

extern "C" {
#include "crazyflie.h"
#include "ros.h"
}

namespace sightline::dds {
namespace {

/// What comes from others, or goes to stand-ins.
const std::vector<const dds_topic_descriptor_t*>& types_read() {
  static const std::vector<const dds_topic_descriptor_t*> all = [] {
    std::vector<const dds_topic_descriptor_t*> types = {
        &nav_msgs_msg_dds__Odometry__desc,
        &nav_msgs_msg_dds__Path__desc,
        &geometry_msgs_msg_dds__PoseStamped__desc,
        &geometry_msgs_msg_dds__Twist__desc,
        &geometry_msgs_msg_dds__TwistStamped__desc,
        &motion_capture_tracking_interfaces_msg_dds__NamedPoseArray__desc,
        &tf2_msgs_msg_dds__TFMessage__desc,
        &std_srvs_srv_dds__Trigger_Request__desc,
        &crazyflie_interfaces_msg_dds__Status__desc,
        &crazyflie_interfaces_msg_dds__LogDataGeneric__desc,
        &crazyflie_interfaces_msg_dds__FullState__desc,
        &crazyflie_interfaces_msg_dds__VelocityWorld__desc,
        &crazyflie_interfaces_srv_dds__Takeoff_Request__desc,
        &crazyflie_interfaces_srv_dds__Land_Request__desc,
        &crazyflie_interfaces_srv_dds__Arm_Request__desc};
    // Replies come as one vendor and as the other sends them.
    for (const ServiceType* service : {&takeoff_service, &land_service, &arm_service, &setpoints_stop_service,
                                       &empty_service, &trigger_service})
      types.insert(types.end(), {&service->response, &service->called_response});
    const auto px4 = px4_descriptors();
    types.insert(types.end(), px4.begin(), px4.end());
    return types;
  }();
  return all;
}

std::int64_t garbled_each() { return whole_campaign() ? 100'000 : 1'000; }

TEST(Garbled, OfEachTypeOnlyWholeMessagesAreTakenAndAllOthersAreCounted) {
  const Domain domain(test::own_network());
  std::int64_t all = 0, unread = 0, refused = 0;
  for (const dds_topic_descriptor_t* type : types_read()) {
    const MessageType& message = message_type(type->m_typename);
    const std::optional<std::size_t> size = payload_size(message);
    std::int64_t taken = 0;
    const RawReader in(domain.participant(), *type, "/garbled", of_services, size, Writers::all,
                       [&](const void*, const Arrival&) { ++taken; });
    PayloadWriter out(domain.another_participant(), *type, in.topic());
    Payloads payloads(7);
    const ReaderCounts& n = in.counts();
    const std::int64_t zeros = n.received;
    std::int64_t handed = 0, wrong = 0, count = garbled_each();
    for (std::int64_t k = 0; k < count; ++k) {
      const Bytes whole = payloads.whole(message), changed = payloads.changed(whole);
      const bool known = out.send(changed);
      handed += known ? 1 : 0;
      const bool fits =
          !size || changed.size() - cdr_header == *size || changed.size() - cdr_header == (*size + 3) / 4 * 4;
      wrong += known && !fits ? 1 : 0;
      // And a good one is received as if nothing had been.
      if (k % 100 == 99) {
        const std::int64_t before = taken;
        ASSERT_TRUE(out.send(whole)) << message.name;
        ASSERT_EQ(taken, before + 1) << message.name << " " << k;
        ++handed;
      }
    }
    EXPECT_EQ(n.received, taken);
    EXPECT_EQ(n.too_long + n.too_short, wrong) << message.name;
    EXPECT_EQ(n.received - zeros + n.unreadable + wrong, handed) << message.name;
    all += count, unread += count - (handed - count / 100), refused += wrong + n.unreadable;
  }
  fmt::print("{} types, {} messages: {} not read by Cyclone DDS, {} refused by ours\n", types_read().size(),
             all, unread, refused);
}

// What grows with a message is bounded before it is unpacked.
TEST(Garbled, AMessageLargerThanAnyThatIsMeantWellIsRefusedAndCounted) {
  const Domain domain(test::own_network());
  const auto& type = motion_capture_tracking_interfaces_msg_dds__NamedPoseArray__desc;
  std::int64_t taken = 0;
  const RawReader in(domain.participant(), type, "/large", of_services, std::nullopt, Writers::all,
                     [&](const void*, const Arrival&) { ++taken; });
  PayloadWriter out(domain.another_participant(), type, in.topic());
  const auto poses = [](std::uint32_t n) {
    Bytes bytes = {0, 1, 0, 0, /*stamp*/ 0, 0, 0, 0, 0, 0, 0, 0, /*frame*/ 1, 0, 0, 0, 0, 0, 0, 0};
    const auto raw = std::bit_cast<std::array<unsigned char, 4>>(n);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
    // Each: a name of one byte, then from a multiple of 8 on seven numbers.
    for (std::uint32_t i = 0; i < n; ++i) {
      bytes.insert(bytes.end(), {1, 0, 0, 0, 0});
      while ((bytes.size() - cdr_header) % 8 != 0) bytes.push_back(0);
      bytes.resize(bytes.size() + 56);
    }
    return bytes;
  };
  const std::int64_t before = taken;
  EXPECT_TRUE(out.send(poses(1000)));
  EXPECT_EQ(taken, before + 1);
  EXPECT_TRUE(out.send(poses(20'000)));
  EXPECT_EQ(taken, before + 1);
  EXPECT_EQ(in.counts().too_long, 1);
}

/// A fleet on its links whose topics are garbled in each period.
class GarbledWorld final : public World {
 public:
  GarbledWorld(const Scenario& scenario, const std::shared_ptr<Domain>& domain, int per_period)
      : world_(scenario, domain), per_period_(per_period), payloads_(11) {
    const dds_entity_t participant = domain->participant();
    const dds_entity_t subscriptions =
        dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr);
    std::array<void*, 256> samples{};
    std::array<dds_sample_info_t, 256> infos{};
    const int n = dds_read(subscriptions, samples.data(), infos.data(), samples.size(), samples.size());
    std::map<std::string, std::string> read;
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(0, n)); ++i) {
      const auto& one = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      if (infos[i].valid_data && !std::string_view(one.topic_name).starts_with("DCPS"))
        read.emplace(one.topic_name, one.type_name);
    }
    if (n > 0) dds_return_loan(subscriptions, samples.data(), n);
    // Layouts of other releases come by writers of their own.
    const dds_entity_t other = domain->another_participant();
    std::set<std::string_view> known;
    for (const dds_topic_descriptor_t* type : types_read()) {
      for (const auto& [topic, wire] : read) {
        if (wire_type(type->m_typename) != wire) continue;
        known.insert(topic);
        topics_.push_back(
            {topic, std::make_unique<PayloadWriter>(other, *type, topic), &message_type(type->m_typename)});
      }
    }
    for (const Link& link : fleet_of(scenario).links)
      robots_.push_back({RobotState(team().model(link.robot)), size(team().state_offset(link.robot)),
                         size(team().input_offset(link.robot))});
    for (const auto& [topic, wire] : read)
      if (known.count(topic) == 0) unknown_.push_back(topic);
  }

  const Team& team() const noexcept override { return world_.team(); }
  std::span<const double> start() const noexcept override { return world_.start(); }
  void set_presence(std::span<const Presence> presence) noexcept override { world_.set_presence(presence); }
  Measured measure(double t) noexcept override {
    for (int k = 0; k < per_period_; ++k) {
      const Topic& topic = topics_[payloads_.below(topics_.size())];
      Bytes payload = payloads_.whole(*topic.type);
      if (payloads_.below(4) != 0) payload = payloads_.changed(std::move(payload));
      topic.writer->send(payload);
      ++sent_;
    }
    const Measured seen = world_.measure(t);
    for (const double x : seen.measured) finite_ = finite_ && std::isfinite(x);
    seen_.resize(seen.stamps.size());
    std::transform(seen.stamps.begin(), seen.stamps.end(), seen_.begin(),
                   [](double s) { return std::isfinite(s); });
    return seen;
  }
  bool apply(double t, std::span<const double> estimated, const sightline::Command& u, double period,
             std::int64_t periods) noexcept override {
    for (const double x : estimated) finite_ = finite_ && std::isfinite(x);
    for (const double x : u) greatest_ = std::isfinite(x) ? std::max(greatest_, std::abs(x)) : 1e300;
    for (Robot& robot : robots_) {
      const Command c = robot.state.command(&estimated[robot.x], u.data() + robot.u, period);
      for (const double v : {norm(c.lead.v), norm(c.lead.a), norm(c.v_end), std::abs(c.r)})
        fastest_ = std::isfinite(v) ? std::max(fastest_, v) : 1e300;
    }
    (void)world_.apply(t, estimated, u, period, periods);
    return true;
  }

  bool finite() const { return finite_; }
  double greatest() const { return greatest_; }
  double fastest() const { return fastest_; }
  bool has_seen(std::size_t body) const { return seen_.at(body); }
  std::int64_t sent() const { return sent_; }
  std::set<std::string> topics() const {
    std::set<std::string> names;
    for (const Topic& topic : topics_) names.insert(topic.name);
    return names;
  }
  const DdsWorld& world() const { return world_; }
  /// What is read and is not among types_read().
  const std::vector<std::string>& unknown() const { return unknown_; }

 private:
  struct Topic {
    std::string name;
    std::unique_ptr<PayloadWriter> writer;
    const MessageType* type;
  };

  struct Robot {
    RobotState state;
    std::size_t x, u;
  };

  DdsWorld world_;
  std::vector<Robot> robots_;
  int per_period_;
  Payloads payloads_;
  std::vector<Topic> topics_;
  std::vector<std::string> unknown_;
  bool finite_ = true;
  double greatest_ = 0, fastest_ = 0;
  std::vector<bool> seen_;
  std::int64_t sent_ = 0;
};

// A rover; Crazyflies by their own poses, by motion capture and by transforms; a body that others
// see.
const std::string garbled_more =
    "[agent.rover]\nrobot = \"unicycle\"\nstart = { p = [0.0, 9.0, 0.0], heading = 0.5 }\n"
    "Q = [2, 2, 0, 0, 0, 0]\n[agent.rover.link]\nkind = \"ros2\"\nodometry = \"/rover/odom\"\n"
    "cmd_vel = \"/rover/cmd_vel\"\n"
    "[agent.cf0]\nrobot = \"multirotor\"\nstart = { p = [3.0, 9.0, 0.6] }\nQ = [1, 1, 1, 0, 0, 0, 0]\n"
    "[agent.cf0.link]\nkind = \"crazyswarm2\"\n"
    "[agent.cf1]\nrobot = \"multirotor\"\nstart = { p = [6.0, 9.0, 0.6] }\nQ = [1, 1, 1, 0, 0, 0, 0]\n"
    "[agent.cf1.link]\nkind = \"crazyswarm2\"\nposes = \"mocap\"\npose_topic = \"/poses\"\npose_name = "
    "\"cf1\"\n"
    "[agent.cf2]\nrobot = \"multirotor\"\nstart = { p = [9.0, 9.0, 0.6] }\nQ = [1, 1, 1, 0, 0, 0, 0]\n"
    "[agent.cf2.link]\nkind = \"crazyswarm2\"\nposes = \"tf\"\npose_name = \"cf2\"\n"
    "[obstacle.box]\np = [12.0, 9.0, 1.0]\n[obstacle.box.link]\nposes = \"mocap\"\npose_topic = "
    "\"/box/pose\"\n";

TEST(Garbled, WhatIsBelievedAndCommandedStaysFiniteAndWithinItsLimits) {
  Scenario scenario = row_of({"1.14", "1.15", "1.16", "1.17", "1.18"}, whole_campaign() ? 30.0 : 3.0,
                             garbled_more, "model", "off");
  GarbledWorld world(scenario, std::make_shared<Domain>(fleet_of(scenario).network), 40);
  EXPECT_THAT(world.unknown(), testing::IsEmpty());
  EXPECT_GE(world.topics().size(), 40U) << fmt::format("{}", fmt::join(world.topics(), "\n"));
  const Controls controls(scenario);
  SteadyClock clock;
  NullSink sink(sized_sample(world, controls.controllers()));
  ClosedLoop loop(scenario, world, controls.controllers(), clock, sink);
  const LoopOutcome outcome = loop.fly();
  EXPECT_TRUE(outcome.finite);
  EXPECT_TRUE(world.finite());
  EXPECT_LE(world.greatest(), 1.0);
  EXPECT_GT(world.sent(), 5'000);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_TRUE(world.has_seen(i)) << i;  // by frame and name
  EXPECT_LE(world.fastest(), 10.0);
  for (int i = 0; i < 9; ++i)  // nobody was ready
    EXPECT_THAT(world.world().state(BodyId{i}), testing::AnyOf(LinkState::waiting, LinkState::done));
  fmt::print("{} messages, commands of at most {:.3g} m/s\n{}\n", world.sent(), world.fastest(),
             fmt::join(world.world().counts(), "\n"));
}

}  // namespace
}  // namespace sightline::dds
