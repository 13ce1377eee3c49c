#include "bridges/dds/topics/flight_publisher.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "sightline/base/now.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"
#include "tests/support/refusal.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::HasSubstr;
using Pose = geometry_msgs_msg_dds__PoseStamped_;
using Path = nav_msgs_msg_dds__Path_;
using Markers = visualization_msgs_msg_dds__MarkerArray_;
using Transforms = tf2_msgs_msg_dds__TFMessage_;
using Diagnostics = diagnostic_msgs_msg_dds__DiagnosticArray_;
using LogLine = rcl_interfaces_msg_dds__Log_;

/// Reads all topics of a flight of two robots, as another program.
class Onlooker {
 public:
  explicit Onlooker(Domain& domain) : at_(domain.another_participant()), list_(at_) {
    listen<Pose>(geometry_msgs_msg_dds__PoseStamped__desc, "/sightline/uav0/pose", [this](const Pose& m) {
      frames.insert(m.header.frame_id);
      const auto& p = m.pose.position;
      const auto& q = m.pose.orientation;
      finite = finite && std::isfinite(p.x + p.y + p.z) &&
               std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < 1e-6;
      heights.push_back(p.z);
      young = young &&
              std::abs(1e-9 * static_cast<double>(realtime_now() -
                                                  of_ros(m.header.stamp.sec, m.header.stamp.nanosec))) < 0.5;
    });
    listen<Path>(nav_msgs_msg_dds__Path__desc, "/sightline/uav1/path", [this](const Path& m) {
      frames.insert(m.header.frame_id);
      stages = m.poses._length;
      for (std::uint32_t i = 0; i < m.poses._length; ++i) {
        const auto& p = m.poses._buffer[i].pose.position;
        finite = finite && std::isfinite(p.x + p.y + p.z);
      }
      if (stages > 1) {
        const auto time = [&](std::size_t i) {
          const auto& t = m.poses._buffer[i].header.stamp;
          return 1e-9 * static_cast<double>(of_ros(t.sec, t.nanosec));
        };
        path_step = (time(stages - 1) - time(0)) / static_cast<double>(stages - 1);
      }
    });
    listen<Markers>(
        visualization_msgs_msg_dds__MarkerArray__desc, "/sightline/markers", [this](const Markers& m) {
          for (std::uint32_t i = 0; i < m.markers._length; ++i) {
            const auto& one = m.markers._buffer[i];
            groups[one.ns] = std::max<int>(groups[one.ns], one.id + 1);
            frames.insert(one.header.frame_id);
            finite = finite && std::isfinite(one.pose.position.x + one.scale.x) && one.lifetime.nanosec > 0;
            for (std::uint32_t k = 0; k < one.points._length; ++k)
              finite = finite && std::isfinite(one.points._buffer[k].x);
          }
        });
    listen<Transforms>(tf2_msgs_msg_dds__TFMessage__desc, "/tf", [this](const Transforms& m) {
      for (std::uint32_t i = 0; i < m.transforms._length; ++i) {
        frames.insert(m.transforms._buffer[i].header.frame_id);
        children.insert(m.transforms._buffer[i].child_frame_id);
      }
    });
    listen<Diagnostics>(diagnostic_msgs_msg_dds__DiagnosticArray__desc, "/diagnostics",
                        [this](const Diagnostics& m) {
                          for (std::uint32_t i = 0; i < m.status._length; ++i) {
                            const auto& s = m.status._buffer[i];
                            statuses[s.name].insert(s.message);
                            worst[s.name] = s.level;
                          }
                        });
    listen<LogLine>(rcl_interfaces_msg_dds__Log__desc, "/rosout", [this](const LogLine& m) {
      lines.emplace_back(m.msg);
      names.insert(m.name);
    });
  }

  /// Of its topics, whose writers are not this program's, the type and what USER_DATA says.
  std::map<std::string, std::pair<std::string, std::string>> offered() const {
    std::map<std::string, std::pair<std::string, std::string>> found;
    const dds_entity_t reader = dds_create_reader(at_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
    std::array<void*, 256> samples{};
    std::array<dds_sample_info_t, 256> infos{};
    const dds_return_t count = dds_read(reader, samples.data(), infos.data(), 256, 256);
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(0, count)); ++i) {
      const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
      void* data = nullptr;
      std::size_t length = 0;
      if (dds_qget_userdata(endpoint.qos, &data, &length))
        found[endpoint.topic_name] = {endpoint.type_name,
                                      std::string(static_cast<const char*>(data), length)};
      dds_free(data);
    }
    dds_return_loan(reader, samples.data(), count);
    dds_delete(reader);
    return found;
  }

  std::mutex lock;  // of all below
  std::map<std::string, int> messages;
  std::set<std::string> frames, children, names;
  std::map<std::string, std::set<std::string>> statuses;
  std::map<std::string, int> worst, groups;
  std::vector<std::string> lines;
  std::vector<double> heights;
  std::size_t stages = 0;
  double path_step = 0.0;
  bool finite = true, young = true;

 private:
  template <class M>
  void listen(const dds_topic_descriptor_t& type, const std::string& topic,
              std::function<void(const M&)> look) {
    readers_.push_back(std::make_unique<RawReader>(
        at_, type, topic, Quality{.reliable = true, .depth = 100}, std::nullopt, Writers::all,
        [this, topic, look = std::move(look)](const void* m, const Arrival&) {
          const std::scoped_lock held(lock);
          ++messages[topic];
          look(*static_cast<const M*>(m));
        }));
  }

  dds_entity_t at_;
  WriterList list_;
  std::vector<std::unique_ptr<RawReader>> readers_;
};

const std::string coupled =
    "[agent.uav0.sensor]\npitch = 0.1\noffset = 0.1\n[target.box]\np = [9, 9, 1]\n"
    "[[couple]]\npotential = { sensor_cone = { alpha = 0.5 } }\nbetween = [\"uav0\", \"uav1\"]\nfelt_by = "
    "[\"uav0\"]\nweight = 0.01\n";

// A flight from the ground to the ground, looked on by another participant: names, types, hashes,
// frames, numbers and rates.
TEST(FlightPublisher, AFlightIsShownAsRosShowsOne) {
  Rig rig(row_of({"1.16", "1.16"}, 4.0, coupled));
  Onlooker onlooker(*rig.domain);
  const auto began = std::chrono::steady_clock::now();
  const LoopOutcome outcome = rig.fly();
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_EQ(outcome.max_allocations, 0);
  const std::string counted = rig.counted(" messages for others, ");
  EXPECT_NE(counted, "");
  const auto offered = onlooker.offered();
  rig.world.reset();  // what is last is published
  EXPECT_TRUE(test::eventually([&] {
    const std::scoped_lock held(onlooker.lock);
    return std::find(onlooker.lines.begin(), onlooker.lines.end(), "uav1: done") != onlooker.lines.end();
  }));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() + 1.0;

  const auto expect_offered = [&](const std::string& topic, const std::string& type,
                                  const std::string& hash) {
    ASSERT_TRUE(offered.contains(topic)) << topic;
    EXPECT_EQ(offered.at(topic).first, type);
    EXPECT_THAT(offered.at(topic).second, HasSubstr("typehash=RIHS01_" + hash)) << topic;
  };
  expect_offered("rt/sightline/uav0/pose", "geometry_msgs::msg::dds_::PoseStamped_",
                 "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8;");
  expect_offered("rt/sightline/uav0/path", "nav_msgs::msg::dds_::Path_", "");
  expect_offered("rt/sightline/markers", "visualization_msgs::msg::dds_::MarkerArray_", "");
  expect_offered("rt/tf", "tf2_msgs::msg::dds_::TFMessage_", "");
  expect_offered("rt/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_", "");
  expect_offered("rt/rosout", "rcl_interfaces::msg::dds_::Log_", "");
  expect_offered("rr/sightline/landReply", "std_srvs::srv::dds_::Trigger_Response_", "");

  const std::scoped_lock held(onlooker.lock);
  EXPECT_TRUE(onlooker.finite);
  EXPECT_TRUE(onlooker.young);
  EXPECT_EQ(onlooker.frames, std::set<std::string>{"map"});
  EXPECT_EQ(onlooker.children, (std::set<std::string>{"sightline/uav0", "sightline/uav1"}));
  EXPECT_EQ(onlooker.names, std::set<std::string>{"sightline"});
  EXPECT_EQ(onlooker.stages, 21u);
  EXPECT_NEAR(onlooker.path_step, rig.scenario.horizon.h(), 1e-6);
  EXPECT_GT(*std::max_element(onlooker.heights.begin(), onlooker.heights.end()), 0.5);
  EXPECT_EQ(onlooker.groups, (std::map<std::string, int>{{"robots", 2},
                                                         {"bodies", 3},
                                                         {"names", 3},
                                                         {"hard_distances", 3},
                                                         {"views", 1},
                                                         {"links", 1},
                                                         {"distances", 1}}));
  for (const char* name : {"sightline: uav0", "sightline: uav1", "sightline: solver"})
    EXPECT_TRUE(onlooker.statuses.contains(name)) << name;
  EXPECT_TRUE(onlooker.statuses["sightline: uav0"].contains("flying"));
  for (const char* line : {"uav0: ready", "uav1: taking_off", "uav0: flying", "uav1: landing", "uav0: done"})
    EXPECT_THAT(onlooker.lines, Contains(line));

  const auto expect_rate = [&](const std::string& topic, double least, double most) {
    EXPECT_GE(onlooker.messages[topic], least) << topic;
    EXPECT_LE(onlooker.messages[topic], most * seconds + 2) << topic;
  };
  expect_rate("/sightline/uav0/pose", 100, 50);
  expect_rate("/tf", 100, 50);
  expect_rate("/sightline/uav1/path", 20, 10);
  expect_rate("/sightline/markers", 20, 10);
  expect_rate("/diagnostics", 4, 1);
  expect_rate("/rosout", 10, 50);
}

TEST(FlightPublisher, WithoutTopicsNothingIsShownButServicesAreThere) {
  Scenario scenario = row_of({"1.16"}, 1.0);
  own_fleet(scenario).network.topics = false;
  own_fleet(scenario).network.node = "/lab/flyer";
  Rig rig(scenario);
  EXPECT_TRUE(test::eventually([&] {
    bool served = false;
    for (const SeenWriter& w : WriterList(rig.domain->participant()).look()) {
      EXPECT_NE(w.topic, "rt/tf");
      EXPECT_NE(w.topic, "rt/rosout");
      EXPECT_FALSE(w.topic.starts_with("rt/lab/")) << w.topic;
      served = served || w.topic == "rr/lab/flyer/landReply";
    }
    return served;
  }));
}

// More messages and lines than there is room for: the producer is not held up, and what is left out
// is reported.
TEST(FlightPublisher, WhatComesTooFastIsLeftOut) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  const auto domain = std::make_shared<Domain>(fleet_of(scenario).network);
  std::atomic<int> lines{0};
  std::atomic<bool> reported{false};
  const RawReader reader(domain->another_participant(), rcl_interfaces_msg_dds__Log__desc, "/rosout",
                         Quality{.reliable = true, .transient_local = true, .depth = 1000}, std::nullopt,
                         Writers::all, taking<LogLine>([&](const LogLine& m, const Arrival&) {
                           ++lines;
                           reported = reported || std::string(m.msg).find(
                                                      "lines more in the second before") != std::string::npos;
                         }));
  FlightPublisher topics(scenario, domain->participant(), [](std::size_t) { return "none"; });
  Sample sample;
  sample.x = sample.measured = scenario.x0;
  sample.levels = {FallbackLevel::valid};
  sample.event_count = static_cast<int>(sample.events.size());
  for (Event& event : sample.events) event = {0.0, EventKind::hold, 0, 0.0};
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(2500);
  const std::int64_t before = cli::allocations();
  while (std::chrono::steady_clock::now() < end) topics.show(sample);
  EXPECT_EQ(cli::allocations(), before);
  EXPECT_TRUE(reported);
  EXPECT_GE(lines, 50);
  EXPECT_LE(lines, 4 * 51);
  std::atomic<int> late{0};  // who comes later sees them too
  const RawReader later(domain->another_participant(), rcl_interfaces_msg_dds__Log__desc, "/rosout",
                        of_log_lines, std::nullopt, Writers::all,
                        [&](const void*, const Arrival&) { ++late; });
  EXPECT_TRUE(test::eventually([&] { return late >= 50; }, std::chrono::seconds(10)));
}

TEST(FlightPublisher, NamesThatAreNoneOfRosAreMadeToAndMustDiffer) {
  EXPECT_EQ(topic_part("uav-0"), "uav_0");
  EXPECT_EQ(topic_part("7"), "_7");
  std::string text = fmt::format("[fleet]\ndomain = {}\n", test::own_domain());
  for (const char* name : {"uav-0", "uav_0"})
    text += fmt::format(
        "[agent.{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, 0, 1] }}\n[agent.{0}.link]\nkind = "
        "\"px4\"\nrelease = \"1.16\"\nnamespace = \"/px4_{1}\"\norigin = {{ p = [0, 0, 0], heading = 0.0 "
        "}}\n",
        name, name[3] == '-' ? 0 : 3);
  const auto domain = std::make_shared<Domain>(test::own_network());
  const auto refusal = [&](const Scenario& scenario) {
    return refusal_of([&] { FlightPublisher(scenario, domain->participant(), {}); });
  };
  EXPECT_THAT(refusal(test::scenario_of(text)),
              HasSubstr("agent.uav_0 = topics /sightline/uav_0, as of uav-0, expected a name that differs"));
  Scenario own = row_of({"1.16"}, 1.0);
  own_fleet(own).links[0].poses.source = PoseSource::tf;
  own_fleet(own).links[0].poses.name = "sightline/uav0";
  EXPECT_THAT(refusal(own), HasSubstr("agent.uav0.link.pose_name = \"sightline/uav0\", the frame that this"));
}

}  // namespace
}  // namespace sightline::dds
