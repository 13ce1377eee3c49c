#include "bridges/dds/fleet/link.hpp"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

TEST(LinkFault, EachKindHasAKeyOfItsOwnAndASizeWithinItsBounds) {
  std::set<char> keys;
  std::set<std::string_view> names;
  for (const LinkFaultText& text : link_faults) {
    keys.insert(text.key), names.insert(text.name);
    EXPECT_NE(text.key, 'h') << "it asks for help";
    EXPECT_TRUE(can_have({.has_camera = true}, static_cast<LinkFaultKind>(names.size() - 1))) << text.name;
    EXPECT_FALSE(text.meaning.empty());
    EXPECT_TRUE(text.size.empty() || text.bounds.hold(text.fallback)) << text.name;
  }
  EXPECT_EQ(keys.size(), link_faults.size());
  EXPECT_EQ(names.size(), link_faults.size());
  EXPECT_EQ(text_of(LinkFaultKind::wrong_release).name, "wrong_release");
  EXPECT_EQ(text_of(LinkFaultKind::drop).name, "drop");
}

TEST(LinkFault, SaysInWordsWhatHappensAndWhen) {
  EXPECT_EQ(describe(LinkFault{.kind = LinkFaultKind::drop, .at = 5.0, .duration = 2.0, .size = 0.2}),
            "drop 0.2 for 2 s, 5 s after the start");
  EXPECT_EQ(describe(LinkFault{.kind = LinkFaultKind::pilot, .since = FaultClock::flight, .at = 1.5}),
            "pilot, 1.5 s after it is first steered");
  EXPECT_EQ(describe(LinkFault{.kind = LinkFaultKind::jump, .at = 0.0, .size = -1.0}),
            "jump -1 m, 0 s after the start");
}

}  // namespace
}  // namespace sightline
