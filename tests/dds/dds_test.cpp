#include "sightline/dds.hpp"

#include <gtest/gtest.h>

#include "bridges/dds/fleet/bridge.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(Dds, IsTheBridgeOfThePartsThatItIsAddedToOnce) {
  Registry registry;
  add_dds(registry);
  EXPECT_NE(registry.bridge, nullptr);
  EXPECT_EQ(refusal_of([&] { add_dds(registry); }), "there is a bridge already, expected one");
}

}  // namespace
}  // namespace sightline
