// What leaves the machine: two programs in a network of their own, whose second interface counts
// what passes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/dds/fly.hpp"

namespace sightline::dds {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

// A cable, v0 to v1, by which all would go that is not for this machine, multicast included.
const std::string cable = R"(set -e
ip link set lo up
ip link add v0 type veth peer name v1
for v in v0 v1; do
  if [ -e /proc/sys/net/ipv6/conf/$v ]; then echo 1 >/proc/sys/net/ipv6/conf/$v/disable_ipv6; fi
  ip link set $v up
done
ip addr add 10.213.0.1/24 dev v0
ip route add default via 10.213.0.2 dev v0
ip neigh add 10.213.0.2 lladdr 02:00:00:00:00:02 dev v0
ip neigh add 10.213.0.3 lladdr 02:00:00:00:00:03 dev v0
)";

class Network : public FlyTest {
 protected:
  /// What a script says in such a network. Machines on which none can be made fail.
  test::CommandResult in_own_network(const std::string& script) const {
    std::ofstream(folder / "script") << cable << script;
    const std::string apart = ::geteuid() == 0 ? "unshare -n" : "unshare -rn";
    const auto probe = test::shell(apart + " true", folder);
    EXPECT_EQ(probe.code, 0) << "no network of its own can be made on this machine: " << probe.err
                             << "expected root, or a kernel that lets users have namespaces";
    return test::shell(apart + " bash '" + (folder / "script").string() + "'", folder);
  }
  /// Packets that passed the second interface, both ways and multicast, while `commands` ran.
  long passed(const std::string& commands, std::string* printed = nullptr) const {
    const auto done = in_own_network(
        "packets() { awk '/v[01]:/ { n += $3 + $9 + $11 } END { print n }' /proc/self/net/dev; }\n"
        "before=$(packets)\n" +
        commands + "\necho \"passed $(($(packets) - before))\"\n");
    EXPECT_EQ(done.code, 0) << done.out << done.err;
    if (printed != nullptr) *printed = done.out + done.err;
    const std::size_t at = done.out.rfind("passed ");
    if (at == std::string::npos) return -1;
    return std::atol(done.out.c_str() + at + 7);
  }
  /// The shipped fleet with these lines in the place of its network.
  std::string fleet(const std::string& name, const std::string& network) const {
    std::string text = test::read_file(desk("1.0"));
    const std::size_t begin = text.find("\ninterfaces = "), end = text.find("\n[horizon]");
    text.replace(begin, end - begin, "\n" + network);
    const fs::path file = folder / (name + ".toml");
    std::ofstream(file) << text;
    return "'" + file.string() + "'";
  }
  std::string flown(const std::string& file, const std::string& options = "") const {
    return "cd '" SIGHTLINE_SOURCE_DIR "'\n'" SIGHTLINE_BINARY "' vehicles " + file +
           " >/dev/null & vehicles=$!\n'" SIGHTLINE_BINARY "' fly " + options + " " + file + " -o '" +
           (folder / "flown").string() + "'\nkill -INT $vehicles; wait $vehicles";
  }
};

TEST_F(Network, OfAFlightByDefaultNothingLeavesTheMachine) {
  std::string printed;
  EXPECT_EQ(passed(flown(fleet("default", "")), &printed), 0);
  EXPECT_THAT(printed, HasSubstr("uav0: done"));
}

TEST_F(Network, OnLoopbackByNameNothingLeavesTheMachineWithMulticastAskedForToo) {
  std::string printed;
  EXPECT_EQ(passed(flown(fleet("lo", "interfaces = [\"lo\"]"), "--dry-run"), &printed), 0);
  EXPECT_THAT(printed, HasSubstr("all are ready, none is armed: a dry run"));
  const std::string multicast =
      "interfaces = [\"lo\"]\ndiscovery = { multicast = true, peers = [\"127.0.0.1\"] }";
  EXPECT_EQ(passed(flown(fleet("multicast", multicast), "--dry-run"), &printed), 0);
  EXPECT_THAT(printed, HasSubstr("all are ready, none is armed: a dry run"));
}

// That the count is not zero whatever passes.
TEST_F(Network, WhereTheOtherInterfaceIsNamedItsPacketsAreCounted) {
  const std::string vehicles = "'" SIGHTLINE_BINARY "' vehicles --seconds 2 ";
  EXPECT_GT(
      passed(vehicles + fleet("peer", "interfaces = [\"v0\"]\ndiscovery = { peers = [\"10.213.0.3\"] }")), 5);
  EXPECT_GT(passed(vehicles + fleet("all", "interfaces = [\"v0\"]\ndiscovery = { multicast = true }")), 5);
}

TEST_F(Network, ADomainThatCannotBeHadStopsTheProgramAndSendsNothing) {
  const std::string file =
      fleet("nowhere", "interfaces = [\"v7\"]\ndiscovery = { peers = [\"10.213.0.3\"] }");
  std::string printed;
  for (const std::string command : {"fly", "vehicles"}) {
    EXPECT_EQ(
        passed(fmt::format("'" SIGHTLINE_BINARY "' {} {} || echo \"code $?\"", command, file), &printed), 0);
    EXPECT_THAT(printed, HasSubstr("code 2"));
    EXPECT_THAT(printed, HasSubstr(" on v7: "));
    EXPECT_THAT(printed, HasSubstr("expected interfaces of this machine"));
  }
}

}  // namespace
}  // namespace sightline::dds
