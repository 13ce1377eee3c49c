#include "bridges/dds/topics/seen_poses.hpp"

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/base/now.hpp"
#include "tests/dds/rig.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// An intake, and one who writes poses to it.
struct Seeing {
  Seeing(const Domain& on, const PosesFrom& poses_from, Attitude attitude = Attitude::needed)
      : from(poses_from), domain(on) {
    read_seen_poses(subscriber, domain.participant(), from, attitude);
  }
  std::unique_ptr<RawWriter> writer() const {
    const dds_topic_descriptor_t& type =
        from.name.empty() ? geometry_msgs_msg_dds__PoseStamped__desc
                          : motion_capture_tracking_interfaces_msg_dds__NamedPoseArray__desc;
    return std::make_unique<RawWriter>(domain.participant(), type, from.topic,
                                       Quality{.reliable = true, .depth = 1});
  }
  /// The stamp is 10 ms times k after `begin`: how long a test takes to write does not matter.
  std_msgs_msg_dds__Header_ header(std::string& frame, int k) const {
    const RosTime time = to_ros(begin + 10'000'000 * k);
    return {{time.sec, time.nanosec}, frame.data()};
  }
  void send(RawWriter& to, std::string frame, const Vec3<double>& p, const Quaternion& q, int k) const {
    const geometry_msgs_msg_dds__PoseStamped_ m = {header(frame, k), {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}}};
    (void)to.write(&m);
  }
  void send_named(RawWriter& to, std::string frame, std::string name, const Vec3<double>& p, int k) const {
    motion_capture_tracking_interfaces_msg_dds__NamedPose_ body = {name.data(),
                                                                   {{p.x, p.y, p.z}, {0, 0, 0, 1}}};
    motion_capture_tracking_interfaces_msg_dds__NamedPoseArray_ m{};
    m.header = header(frame, k);
    m.poses._length = m.poses._maximum = 1;
    m.poses._buffer = &body;
    (void)to.write(&m);
  }
  /// What is red.
  std::vector<std::string> red_findings() const {
    FindingList findings("");
    subscriber.examine("the frame that is G", other_frames_than(from), findings);
    std::vector<std::string> sentences;
    for (const Finding& finding : findings.take())
      if (finding.light == Light::red) sentences.push_back(finding.sentence);
    return sentences;
  }

  PosesFrom from;
  const Domain& domain;
  const Nanoseconds begin = realtime_now();
  PoseSubscriber subscriber;
};

const PosesFrom by_stamped = {PoseSource::mocap, "/body/pose", "", "world"},
                by_named = {PoseSource::mocap, "/poses", "cf1", "world"},
                by_tf = {PoseSource::tf, "", "base", "world"};
const Quaternion level_east = {1, 0, 0, 0};

TEST(SeenPoses, APoseOfMotionCaptureHasItsVelocity) {
  const Domain domain{test::own_network()};
  Seeing one(domain, by_stamped), other(domain, by_named);
  const auto writer = one.writer(), array = other.writer();
  for (int k = 0; k < 20; ++k) {
    one.send(*writer, "world", {0.01 * k, 0, 1}, level_east, k);
    other.send_named(*array, "world", "cf1", {0, 0.02 * k, 1}, k);
    other.send_named(*array, "world", "cf2", {9, 9, 9}, k);
  }
  SeenMotion seen;
  ASSERT_TRUE(one.subscriber.look(seen)) << fmt::format("{}", one.red_findings());
  EXPECT_EQ(seen.motion.p.x, 0.19);
  EXPECT_NEAR(seen.motion.v.x, 1.0, 0.1);
  ASSERT_TRUE(other.subscriber.look(seen)) << fmt::format("{}", other.red_findings());
  EXPECT_NEAR(seen.motion.v.y, 2.0, 0.2);
  EXPECT_THAT(one.red_findings(), IsEmpty());
  EXPECT_THAT(other.red_findings(), IsEmpty());
}

TEST(SeenPoses, WhatDoesNotHoldHasASentence) {
  const Domain domain{test::own_network()};
  Seeing one(domain, by_stamped);
  EXPECT_THAT(one.red_findings(), ElementsAre("rt/body/pose: no message"));
  const auto writer = one.writer();
  one.send(*writer, "world", {0, 0, 1}, {std::nan(""), 0, 0, 0}, 0);
  EXPECT_THAT(one.red_findings(), ElementsAre("rt/body/pose: 1 poses that are not finite"));
  one.send(*writer, "map", {0, 0, 1}, level_east, 0);
  EXPECT_THAT(one.red_findings(),
              Contains("rt/body/pose: 1 poses in a frame that is not pose_frame, \"world\""));
  EXPECT_TRUE(one.subscriber.in_other_frames());
  const auto rival = one.writer();
  one.send(*rival, "world", {0, 0, 1}, level_east, 0);
  EXPECT_THAT(
      one.red_findings(),
      Contains(HasSubstr("rt/body/pose: 1 messages of a second writer; if the first one was restarted")));

  Seeing other(domain, by_named);
  const auto array = other.writer();
  other.send_named(*array, "world", "cf3", {}, 0);
  other.send_named(*array, "world", "cf2", {}, 0);
  EXPECT_THAT(other.red_findings(), ElementsAre("rt/poses: no body \"cf1\", there is cf2, cf3"));
  other.send_named(*array, "world", "cf1", {}, 0);
  EXPECT_THAT(other.red_findings(), ElementsAre("rt/poses: never four poses within 0.4 s"));

  Seeing unstamped(domain, {PoseSource::mocap, "/other/pose", "", "world"});
  const auto without = unstamped.writer();
  for (int k = 0; k < 5; ++k) {
    std::string frame = "world";
    const geometry_msgs_msg_dds__PoseStamped_ m = {{{5, 0}, frame.data()}, {{0, 0, 1}, {0, 0, 0, 1}}};
    (void)without->write(&m);
  }
  EXPECT_THAT(unstamped.red_findings(), ElementsAre("rt/other/pose: 4 poses whose stamps do not rise"));
}

TEST(SeenPoses, ASingleMarkerIsEnoughForABodyWithoutAHeading) {
  const Domain domain{test::own_network()};
  Seeing one(domain, by_stamped, Attitude::ignored);
  const auto writer = one.writer();
  for (int k = 0; k < 5; ++k)
    one.send(*writer, "world", {0, 0, 1}, {std::nan(""), std::nan(""), std::nan(""), std::nan("")}, k);
  SeenMotion seen;
  EXPECT_TRUE(one.subscriber.look(seen));
}

TEST(SeenPoses, TransformsLeadFromTheBodyToTheWorldOrTheSentenceSaysWhereTheyEnd) {
  const Domain domain{test::own_network()};
  Seeing one(domain, by_tf);
  EXPECT_THAT(one.red_findings(), ElementsAre("rt/tf: no message"));
  const auto writer = [&](const std::string& topic, Quality quality) {
    return std::make_unique<RawWriter>(one.domain.participant(), tf2_msgs_msg_dds__TFMessage__desc, topic,
                                       quality);
  };
  const auto tf = writer("/tf", {.reliable = true, .depth = 100}),
             fixed = writer("/tf_static", {true, true, 100}),
             rival = writer("/tf", {.reliable = true, .depth = 100});
  const auto send = [&](RawWriter& to, std::string parent, std::string child, double x, int k) {
    geometry_msgs_msg_dds__TransformStamped_ t = {
        one.header(parent, k), child.data(), {{x, 0, 0}, {0, 0, 0, 1}}};
    tf2_msgs_msg_dds__TFMessage_ m{};
    m.transforms._length = m.transforms._maximum = 1;
    m.transforms._buffer = &t;
    (void)to.write(&m);
  };
  send(*tf, "odom", "other", 0, 0);
  EXPECT_THAT(one.red_findings(), ElementsAre("rt/tf: no transform of \"base\""));
  send(*tf, "odom", "base", 0, 0);
  EXPECT_THAT(one.red_findings(),
              ElementsAre("rt/tf: the parents of \"base\" end at \"odom\", expected pose_frame, \"world\""));
  send(*fixed, "world", "odom", 5, 0);
  for (int k = 1; k < 9; ++k) send(*tf, "odom", "base", 0.01 * k, k);
  SeenMotion seen;
  ASSERT_TRUE(one.subscriber.look(seen)) << fmt::format("{}", one.red_findings());
  EXPECT_NEAR(seen.motion.p.x, 5.08, 1e-12);
  EXPECT_NEAR(seen.motion.v.x, 1.0, 0.1);
  EXPECT_THAT(one.red_findings(), IsEmpty());
  send(*rival, "odom", "base", 3, 9);
  EXPECT_THAT(one.red_findings(),
              ElementsAre(HasSubstr("rt/tf: 1 messages of a second writer; if the first one was restarted")));
}

/// A row of vehicles, seen by others in place of their odometry.
Scenario seen_row(const std::vector<std::string>& links, double duration, const std::string& more = "") {
  Scenario scenario = row_of(Fields(links.size(), "1.16"), duration, more);
  std::string text = scenario.text;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const std::string of = fmt::format("namespace = \"/px4_{}\"\n", i);
    text.insert(text.find(of), links[i]);
  }
  return test::scenario_of(text);
}

// uav0 by motion capture; uav1 by transforms. A lamp on a circle and a box that rests are seen too.
TEST(SeenPoses, AFleetFliesByWhatOthersSeeOfItAndOfOtherBodies) {
  Rig rig(
      seen_row({"poses = \"mocap\"\npose_topic = \"/poses\"\npose_name = \"a\"\n",
                "poses = \"tf\"\npose_name = \"b\"\n"},
               3.5,
               "[target.lamp]\nmotion = { circle = { centre = [1.5, 3.0, 1.0], radius = 0.5, rate = 1.0 } }\n"
               "[target.lamp.link]\nposes = \"mocap\"\npose_topic = \"/lamp/pose\"\n"
               "[obstacle.box]\np = [1.5, -3.0, 1.0]\n"
               "[obstacle.box.link]\nposes = \"tf\"\npose_name = \"box\"\n"));
  const LoopOutcome outcome = rig.fly();
  EXPECT_GE(outcome.updates + outcome.missed, 350) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 2; ++i) {
    const Motion m = rig.vehicle(i).motion();
    EXPECT_NEAR(norm(m.p.x - 3.0 * static_cast<double>(i), m.p.y), 0.3, 0.2) << i;
  }
  expect_well_treated(rig);
  EXPECT_THAT(rig.world->counts(), Contains(HasSubstr("lamp: ")));
  const Measured seen = rig.world->measure(100.0);
  const std::size_t lamp = static_cast<std::size_t>(rig.scenario.team.state_offset(rig.scenario.targets[0]));
  EXPECT_NEAR(norm(seen.measured[lamp] - 1.5, seen.measured[lamp + 1] - 3.0), 0.5, 0.01);
  EXPECT_NEAR(norm(seen.measured[lamp + 3], seen.measured[lamp + 4]), 0.5, 0.05);
}

TEST(SeenPoses, ABodyThatNobodySeesAWrongFrameAndATurnedEstimatorKeepAFleetOnTheGround) {
  const std::string mocap = "poses = \"mocap\"\npose_topic = \"/p0\"\n";
  const std::string lamp =
      "[target.lamp]\np = [0, 3, 1]\n[target.lamp.link]\nposes = \"mocap\"\npose_topic = \"/lamp\"\n";
  const Scenario flown =
      seen_row({mocap + "pose_frame = \"map\"\n", "poses = \"tf\"\npose_name = \"b\"\n"}, 1.0, lamp);
  // The vehicles' world has no lamp, uav0's frame is another, and uav1's estimator stands
  // otherwise.
  std::string text = seen_row({mocap, "poses = \"tf\"\npose_name = \"b\"\n"}, 1.0).text;
  const std::size_t heading = text.rfind("heading = 0.4");
  text.replace(heading, 13, "heading = 1.4");
  Rig rig(flown, test::scenario_of(text), {.ready = 1.5});
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.reported, Contains(HasSubstr("lamp: rt/lamp: no message")));
  EXPECT_THAT(rig.reported,
              Contains(testing::AllOf(HasSubstr("uav0: rt/p0: "),
                                      HasSubstr(" poses in a frame that is not pose_frame, \"map\""))));
  EXPECT_THAT(rig.reported,
              Contains(HasSubstr("uav1: its estimator's heading is -1.00 rad from the one that is seen")))
      << fmt::format("{}", fmt::join(rig.reported, "\n"));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(rig.counts_of(i).arm_requests, 0);
}

}  // namespace
}  // namespace sightline::dds
