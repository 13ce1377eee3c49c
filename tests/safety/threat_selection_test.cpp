// Who of many presses on a robot, and who does not count in a period.
#include "sightline/safety/threat_selection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "cli/allocations.hpp"
#include "sightline/base.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;
using test::highest;
using test::lowest;
using test::State;
using test::VehicleInput;

Vec3<double> drawn(Random& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -1, 1)};
}

TEST(ThreatSelection, TheChosenHaveTheLeastKeysTheLeastFirstAndWhoIsNowhereIsTold) {
  constexpr int bodies = 100, most = 16, self = 7;
  Random random(1);
  ThreatSelection threats(bodies);
  ThreatSelection::Requester requester(bodies);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<ThreatSelection::Body> all;
    threats.clear();
    for (int i = 0; i < bodies; ++i) {
      if (trial % 3 == 0 && i % 4 == 1) continue;  // absent
      all.push_back({i, drawn(random, 20), drawn(random, 2), uniform(random, 0.4, 1), uniform(random, 0, 2)});
      if (trial % 5 == 0 && i == 50) all.back().p.x = no_value;
      threats.add(all.back());
    }
    std::vector<double> cooperative, keys;
    for (const ThreatSelection::Body& body : all) {
      const bool member = random() % 2 == 0;
      requester.cooperative[cooperative.size()] = member ? 1.0 : 0.0;
      cooperative.push_back(member);
      const Vec3<double> v = {0.5, -0.5, 0.0};
      keys.push_back(nearest_threats_key(Vec3<double>{} - body.p, member ? v - body.v : v, body.d_hard,
                                         member ? 0.0 : body.speed_max));
    }
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0U);
    std::erase_if(order, [&](std::size_t i) { return all[i].id == self || !std::isfinite(keys[i]); });
    std::stable_sort(order.begin(), order.end(), [&](auto i, auto j) { return keys[i] < keys[j]; });
    order.resize(most);
    std::vector<int> expected;
    for (const std::size_t i : order) expected.push_back(all[i].id);
    if (trial % 5 == 0) expected.push_back(50);
    const std::int64_t before = cli::allocations();
    const std::span<const int> chosen = threats.nearest_threats(self, {}, {0.5, -0.5, 0.0}, most, requester);
    EXPECT_EQ(cli::allocations(), before);
    EXPECT_EQ(std::vector<int>(chosen.begin(), chosen.end()), expected) << trial;
  }
}

// Two bodies far off that do not give way have the barrier reckon with everybody.
TEST(ThreatSelection, MembersThatNothingCanBringTooNearChangeNeitherCommandNorReserve) {
  const Barrier filter(Multirotor{}, lowest, highest, control_period, {.floor = 0.3});
  Random random(2);
  int active = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const double psi = uniform(random, -3.1, 3.1), fast = trial % 2 == 0 ? 0.3 : 1.5;
    const State x = {
        0, 0, 1.5, std::cos(psi), std::sin(psi), uniform(random, -fast, fast), uniform(random, -fast, fast)};
    std::vector<Neighbour> near;
    for (int i = 0; i < 14; ++i) {
      const Vec3<double> way = test::any_direction(random, trial % 4 == 0);
      near.push_back({.p = Vec3<double>{0, 0, 1.5} + uniform(random, 0.9, 5.0) * way,
                      .v = {uniform(random, -fast, fast), uniform(random, -fast, fast), 0},
                      .d_hard = 0.6,
                      .behavior = Behavior::cooperative});
    }
    std::vector<Neighbour> watched = near;
    for (const double side : {-1.0, 1.0})
      watched.push_back({.p = {side * 500, 0, 1.5}, .d_hard = 0.6, .speed_max = 0.0});
    const VehicleInput wanted = uniform_array<4>(random, -1, 1);
    VehicleInput u = wanted, of_all = wanted;
    const BarrierResult one = filter.filter(x, near, lowest, highest, u);
    const BarrierResult all = filter.filter(x, watched, lowest, highest, of_all);
    EXPECT_EQ(u, of_all) << trial;
    EXPECT_EQ(one.reserve, all.reserve) << trial;
    EXPECT_EQ(one.conflict, all.conflict) << trial;
    active += one.active;
  }
  EXPECT_GE(active, 200);
}

}  // namespace
}  // namespace sightline
