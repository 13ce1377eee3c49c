#include "bridges/dds/fleet/link.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Link, SaysItsKindByTheWordOfTheFile) {
  EXPECT_EQ(Link{}.kind_name(), "px4");
  EXPECT_EQ((Link{.kind = Crazyswarm2Link{}}.kind_name()), "crazyswarm2");
  EXPECT_EQ((Link{.kind = Ros2Link{}}.kind_name()), "ros2");
}

TEST(Link, OfItselfAFleetSpeaksToItsOwnMachineAlone) {
  const FleetNetwork network;
  EXPECT_EQ(network.interfaces, std::vector<std::string>{"lo"});
  EXPECT_EQ(network.peers, std::vector<std::string>{"127.0.0.1"});
  EXPECT_EQ(network.multicast, Multicast::off);
}

}  // namespace
}  // namespace sightline
