#include "bridges/dds/topics/tag_subscriber.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <filesystem>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/topics/tag_frames.hpp"
#include "sightline/base/now.hpp"
#include "sightline/registry.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/command.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::HasSubstr;
using testing::Le;

Scenario shipped() { return read_scenario(SIGHTLINE_SOURCE_DIR "/fleets/localize.toml", with_links()); }

/// What a camera sees, as apriltag_ros would say it.
struct Pictures {
  explicit Pictures(const Domain& domain)
      : writer(std::make_unique<RawWriter>(domain.participant(), tf2_msgs_msg_dds__TFMessage__desc, "/tf",
                                           Quality{.reliable = true, .depth = 100})) {}

  void add(std::string parent, std::string child, const OpticalPose& tag, Nanoseconds age = 50'000'000) {
    const RosTime stamp = to_ros(realtime_now() - age);
    tags.push_back({{{stamp.sec, stamp.nanosec}, names.emplace_back(std::move(parent)).data()},
                    names.emplace_back(std::move(child)).data(),
                    {{tag.p.x, tag.p.y, tag.p.z}, {tag.q.x, tag.q.y, tag.q.z, tag.q.w}}});
  }
  void send() {
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._buffer = tags.data();
    message.transforms._length = message.transforms._maximum = static_cast<std::uint32_t>(tags.size());
    (void)writer->write(&message);
    tags.clear();
  }

  std::unique_ptr<RawWriter> writer;
  std::deque<std::string> names;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> tags;
};

struct TagSubscriberTest : testing::Test {
  OpticalPose tag(int face) const {
    const RigidPose on_body = tag_on_body(scenario.vision.tags[0].tags, face);
    return in_optical({body.p + body.R.to_G(on_body.p), compose(body.R, on_body.R)});
  }
  std::string child(int face) const { return scenario.vision.tag_frames[0][static_cast<std::size_t>(face)]; }
  std::string counts() const { return subscriber.counts(BodyId{0}); }

  const Scenario scenario = shipped();
  const Domain domain{test::own_network()};
  PoseSubscriber own;
  TagSubscriber subscriber{scenario, {{scenario.vision.cameras[0], &own}}, domain.participant()};
  Pictures pictures{domain};
  const std::string camera = scenario.vision.cameras[0].frame;
  // uav1 turned so that two of its tags are seen.
  const RigidPose body = {{1.5, 0.1, 0.05}, turn_by({0, 0, 2.5})};
};

TEST_F(TagSubscriberTest, TheTagsOfAPictureAreOnePoseWithItsCovariance) {
  const Nanoseconds origin = monotonic_now();
  pictures.add(camera, child(0), tag(0));
  pictures.add(camera, child(1), tag(1));
  pictures.send();
  const auto found = subscriber.take(origin);
  const double end = 1e-9 * static_cast<double>(monotonic_now() - origin);
  ASSERT_EQ(found.size(), 1u) << counts();
  EXPECT_EQ(found[0].observer, scenario.team.find("uav0"));
  EXPECT_EQ(found[0].target, scenario.team.find("uav1"));
  EXPECT_EQ(found[0].tags, 2);
  EXPECT_LT(norm(found[0].p - body.p), 1e-6);
  EXPECT_LT(norm(rotation(found[0].q).x - body.R.x), 1e-6);
  EXPECT_TRUE(Cholesky<6>(found[0].covariance_matrix()).positive);
  // However long writing took; the two clocks are read one after the other.
  EXPECT_THAT(found[0].stamp, AllOf(Ge(-0.051), Le(end - 0.049)));
  EXPECT_THAT(found[0].arrival, AllOf(Ge(0.0), Le(end)));
  EXPECT_TRUE(subscriber.take(origin).empty());
}

TEST_F(TagSubscriberTest, WhatCannotBeMeantIsCountedAndLeftOut) {
  const auto alone = [&](const OpticalPose& pose, const std::string& name, Nanoseconds age = 50'000'000) {
    pictures.add(camera, name, pose, age);
    pictures.send();
  };
  OpticalPose garbled = tag(0);
  garbled.p.y = std::nan("");
  alone(garbled, child(0));
  garbled = tag(0);
  garbled.q = {2 * garbled.q.w, 2 * garbled.q.x, 2 * garbled.q.y, 2 * garbled.q.z};
  alone(garbled, child(0));
  alone(tag(0), "tag36h11:99");
  alone(tag(0), child(0), 1'200'000'000);
  alone(tag(0), child(0), -100'000'000);
  // Two tags of one body that are at no such distance from each other.
  OpticalPose far = tag(1);
  far.p.x += 1.0;
  pictures.add(camera, child(0), tag(0));
  pictures.add(camera, child(1), far);
  pictures.send();
  pictures.add("another_camera", child(0), tag(0));
  pictures.send();
  EXPECT_TRUE(subscriber.take(0).empty());
  EXPECT_EQ(counts(),
            "6 pictures with tags, 2 tags not finite or no poses, 1 of no body, 1 pictures of the future, 1 "
            "too old, 0 repeated, 0 of a second writer, 1 bodies that did not fit, 0 lost");
  Pictures rival(domain);
  rival.add(camera, child(0), tag(0));
  rival.send();
  EXPECT_TRUE(subscriber.take(0).empty());
  EXPECT_THAT(counts(), HasSubstr("1 of a second writer"));
}

TEST_F(TagSubscriberTest, WhatIsTooMuchIsLostAndAPeriodTakesNoMoreThanItSays) {
  for (int k = 0; k < 300; ++k) {
    pictures.add(camera, child(0), tag(0), 10'000'000 + 1000 * k);
    pictures.send();
  }
  EXPECT_EQ(subscriber.take(0).size(), TagSubscriber::most);
  EXPECT_THAT(counts(), HasSubstr("44 lost"));
  subscriber.forget();
  EXPECT_TRUE(subscriber.take(0).empty());
}

TEST_F(TagSubscriberTest, TheFindingsSayWhetherTagsComeAndWhen) {
  const auto findings = [&] {
    FindingList list("uav0");
    subscriber.examine(BodyId{0}, {}, list);
    return list.take();
  };
  ASSERT_EQ(findings().size(), 2u);
  EXPECT_THAT(findings()[0].sentence, HasSubstr("/tf: it has no publisher"));
  EXPECT_EQ(findings()[1].light, Light::unknown);
  for (int k = 0; k < 20; ++k) {
    pictures.add(camera, child(0), tag(0), 50'000'000);
    pictures.send();
  }
  ASSERT_EQ(findings().size(), 1u);
  EXPECT_EQ(findings()[0].aspect, Aspect::camera);
  EXPECT_THAT(findings()[0].sentence,
              testing::ContainsRegex("pictures with tags a second, ([5-9][0-9]|[0-9]{3,}) ms after"));
  pictures.add(camera, child(0), tag(0), -500'000'000);
  pictures.send();
  EXPECT_THAT(findings()[0].sentence, HasSubstr("1 pictures are ahead of our clock by up to 0.5"));
  EXPECT_EQ(findings()[0].light, Light::red);
}

}  // namespace
}  // namespace sightline::dds
