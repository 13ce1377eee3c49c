#include "bridges/dds/topics/channel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/links/link_telemetry.hpp"
#include "bridges/dds/topics/goal_subscriber.hpp"
#include "bridges/dds/topics/pose_subscriber.hpp"
#include "bridges/dds/topics/services.hpp"
#include "bridges/dds/topics/tag_subscriber.hpp"
#include "sightline/base.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/page_client.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using test::eventually;
constexpr Quality reliable = {.reliable = true, .transient_local = false, .depth = 10};

// What listeners of Cyclone DDS point to stays where it is.
template <class... Owners>
constexpr bool all_stay = ((!std::is_copy_constructible_v<Owners> && !std::is_move_constructible_v<Owners> &&
                            !std::is_copy_assignable_v<Owners> && !std::is_move_assignable_v<Owners>)&&...);
static_assert(
    all_stay<RawReader, RawWriter, GoalSubscriber, PoseSubscriber, TagSubscriber, OperatorServices>);

/// Entities of a participant, those of its writers' publishers included.
int entities(dds_entity_t of) {
  std::vector<dds_entity_t> children(1000);
  const int count = dds_get_children(of, children.data(), children.size());
  int all = count;
  for (int i = 0; i < count; ++i) all += entities(children[static_cast<std::size_t>(i)]);
  return all;
}

TEST(ChannelOwner, WhatIsMadeOfTheDomainGoesWithItsOwner) {
  Domain domain(test::own_network());
  (void)WriterList(domain.participant()).look();
  const int before = entities(domain.participant());
  for (int i = 0; i < 20; ++i) {
    const RawWriter writer(domain.participant(), geometry_msgs_msg_dds__PoseStamped__desc, "/channel_test",
                           reliable);
    const RawReader reader(domain.participant(), geometry_msgs_msg_dds__PoseStamped__desc, "/channel_test",
                           reliable, std::nullopt, Writers::all, [](const void*, const Arrival&) {});
    (void)WriterList(domain.participant()).look();
  }
  EXPECT_LE(entities(domain.participant()),
            before + 2);  // a publisher and a subscriber that all have in common
}

TEST(ChannelOwner, WhatATakerThrowsEndsNothingAndTheNextMessageIsTaken) {
  static std::atomic<int> reports;
  reports = 0;
  report_failures_to([](std::string_view) noexcept { ++reports; });
  Domain domain(test::own_network());
  std::atomic<int> taken = 0;
  {
    RawReader reader(domain.participant(), geometry_msgs_msg_dds__PoseStamped__desc, "/channel_test",
                     reliable, std::nullopt, Writers::all, [&](const void*, const Arrival&) {
                       if (++taken < 3) throw std::runtime_error("no place for it");
                     });
    RawWriter writer(domain.participant(), geometry_msgs_msg_dds__PoseStamped__desc, "/channel_test",
                     reliable);
    ASSERT_TRUE(eventually([&] { return writer.matched() > 0 && reader.matched() > 0; }));
    std::string frame = "map";
    geometry_msgs_msg_dds__PoseStamped_ message{};
    message.header.frame_id = frame.data();
    for (int i = 1; i <= 4; ++i) {
      EXPECT_TRUE(writer.write(&message));
      EXPECT_TRUE(eventually([&] { return taken >= i; }));
    }
    EXPECT_EQ(reader.counts().received, 4);
  }
  report_failures_to(nullptr);
  EXPECT_EQ(reports, 1);  // of all that it threw
}

TEST(ChannelOwner, ATextThatIsNotThereIsEmpty) {
  EXPECT_EQ(text_in(nullptr), "");
  EXPECT_EQ(text_in("map"), "map");
}

}  // namespace
}  // namespace sightline::dds
