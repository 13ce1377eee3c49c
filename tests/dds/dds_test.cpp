#include "sightline/dds.hpp"

#include <gtest/gtest.h>

#include "sightline/scenario/bridge.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(Dds, IsTheBridgeOfThePartsThatItIsAddedToOnce) {
  Parts parts;
  add_dds(parts);
  EXPECT_NE(parts.bridge, nullptr);
  EXPECT_EQ(refusal_of([&] { add_dds(parts); }), "there is a bridge already, expected one");
}

}  // namespace
}  // namespace sightline
