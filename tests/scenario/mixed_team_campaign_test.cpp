// Twenty rovers and multirotors among rocks and adversaries: what `check` calls guaranteed is kept.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "sightline/scenario/guarantee.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/scenario_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

constexpr int rovers = 10, multirotors = 10, rocks = 3, adversaries = 4;

/// All robots are sent to random places, twice.
Scenario mixed_team(std::uint64_t seed, bool filtered) {
  Random random(seed);
  std::vector<Vec2<double>> taken;
  const auto place = [&] {
    for (;;) {
      const Vec2<double> p = {uniform(random, -5, 5), uniform(random, -5, 5)};
      const auto is_far = [&](const Vec2<double>& q) { return norm(p.x - q.x, p.y - q.y) > 0.9; };
      if (!std::all_of(taken.begin(), taken.end(), is_far)) continue;
      taken.push_back(p);
      return p;
    }
  };
  std::string text = fmt::format("[simulation]\nduration = 8.0\nseed = {}\n", seed);
  text += fmt::format("[safety]\nd_hard = 0.5\nfloor = 0.1\nbarrier = \"{}\"\n", filtered ? "on" : "off");
  for (int i = 0; i < rovers + multirotors; ++i) {
    const bool drives = i < rovers;
    const double z = drives ? 0.2 : uniform(random, 0.8, 2.0);
    const Vec2<double> p = place();
    text += fmt::format("[agent.{}{}]\nrobot = \"{}\"\n", drives ? "rover" : "uav", drives ? i : i - rovers,
                        drives ? "unicycle" : "multirotor");
    text +=
        fmt::format("start = {{ p = [{}, {}, {}], heading = {} }}\n", p.x, p.y, z, uniform(random, -3, 3));
    text += drives ? "Q = [2.0, 2.0, 0.0, 0.0, 0.0, 0.0]\n" : "Q = [2.0, 2.0, 2.0, 0.0, 0.0, 0.2, 0.2]\n";
    text += fmt::format(
        "reference = {{ steps = {{ times = [0.0, 4.0], p = [[{}, {}, {}], [{}, {}, {}]] }} }}\n",
        uniform(random, -4, 4), uniform(random, -4, 4), z, uniform(random, -4, 4), uniform(random, -4, 4), z);
  }
  for (int i = 0; i < rocks; ++i) {
    const Vec2<double> p = place();
    text += fmt::format("[obstacle.rock{}]\np = [{}, {}, 0.2]\nspeed_max = 0.0\n", i, p.x, p.y);
  }
  for (int i = 0; i < adversaries; ++i) {
    const Vec2<double> p = place();
    const bool of_rover = i % 2 == 0;
    text += fmt::format("[obstacle.adversary{}]\np = [{}, {}, {}]\nspeed_max = 1.5\n", i, p.x, p.y,
                        of_rover ? 0.2 : 1.5);
    text +=
        fmt::format("motion = {{ adversary = {{ agent = \"{}{}\", speed = {}, every = 0.5, aim = 0.8 }} }}\n",
                    of_rover ? "rover" : "uav", i, uniform(random, 0.3, 1.5));
  }
  return test::scenario_of(text);
}

std::string kind(const std::string& name) { return name.substr(0, name.find_first_of("0123456789")); }

TEST(MixedTeamCampaign, TheRoverAndMultirotorsOfGroundAndAirFlyWithABarrier) {
  std::string text = read_text(std::string(SIGHTLINE_SOURCE_DIR) + "/scenarios/ground_and_air.toml");
  text.replace(text.find("duration = 50.0"), 15, "duration = 10.0");
  const Scenario scenario = test::scenario_of(text + "\n[safety]\nbarrier = \"on\"\nd_hard = 0.6\n");
  const TeamFlight flight = fly_scenario(scenario);
  EXPECT_TRUE(flight.outcome.finite);
  EXPECT_EQ(flight.flown.size(), 1000u);
  for (const FlownPeriod& period : flight.flown) {
    const auto place = [&](int body) {
      const double* x = period.x.data() + scenario.team.state_offset(BodyId{body});
      return Vec3<double>{x[0], x[1], x[2]};
    };
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
      EXPECT_GE(norm(place(a) - place(b)), 0.6);
  }
}

TEST(MixedTeamCampaign, NoGuaranteedDistanceIsBrokenAndNoRoverMovesWithABodyWithinIt) {
  constexpr double hard = 0.5;
  struct Least {
    double on = infinity, off = infinity;
    int below = 0, guaranteed = 0, pairs = 0;
  };
  std::map<std::string, Least> least;
  const int count = runs(600, 150);
  double fastest = 0.0, driven = 0.0;
  for (int run = 0; run < count; ++run) {
    for (const bool filtered : {true, false}) {
      const Scenario scenario = mixed_team(static_cast<std::uint64_t>(run), filtered);
      const Team& team = scenario.team;
      const std::vector<PairGuarantee> pairs =
          distance_guarantees(mixed_team(static_cast<std::uint64_t>(run), true));
      ASSERT_EQ(pairs.size(), 20u * 19u / 2u + 20u * 7u);
      const TeamFlight flight = fly_scenario(scenario);
      ASSERT_TRUE(flight.outcome.finite);
      std::vector<double> nearest(pairs.size(), infinity);
      for (const FlownPeriod& period : flight.flown) {
        const auto sight = [&](BodyId body) {
          const std::vector<double> none(static_cast<std::size_t>(team.nu()));
          return team.model(body).sight(period.x.data() + team.state_offset(body), none.data());
        };
        std::vector<Sight<double>> seen;
        for (int i = 0; i < team.bodies(); ++i) seen.push_back(sight(BodyId{i}));
        for (std::size_t k = 0; k < pairs.size(); ++k) {
          const auto a = static_cast<std::size_t>(pairs[k].first.index),
                     b = static_cast<std::size_t>(pairs[k].second.index);
          const double distance = norm(seen[a].p - seen[b].p);
          nearest[k] = std::min(nearest[k], distance);
          for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)}) {
            if (filtered && one < rovers && other >= rovers && distance < hard)
              fastest = std::max(fastest, norm(seen[one].v));
          }
        }
        for (std::size_t i = 0; filtered && i < rovers; ++i)
          driven += scenario.horizon.dt * norm(seen[i].v) / (rovers * count);
      }
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        const std::string names =
            fmt::format("{} and {}", team.name(pairs[k].first), team.name(pairs[k].second));
        Least& of = least[kind(std::string(team.name(pairs[k].first))) + " and " +
                          kind(std::string(team.name(pairs[k].second)))];
        double& worst = filtered ? of.on : of.off;
        worst = std::min(worst, nearest[k]);
        if (!filtered) continue;
        ++of.pairs, of.guaranteed += pairs[k].holds();
        of.below += nearest[k] < hard;
        if (pairs[k].holds()) {
          EXPECT_GE(nearest[k], hard) << names << ", run " << run;
        }
      }
    }
  }
  for (const auto& [names, of] : least)
    std::printf("%-22s pairs %5d, guaranteed %5d, below %3d, nearest %.4f m (off: %.4f m)\n", names.c_str(),
                of.pairs, of.guaranteed, of.below, of.on, of.off);
  std::printf("speed of a rover with a body within d_hard %.1e m/s, driven %.1f m\n", fastest, driven);
  EXPECT_EQ(least["rover and rover"].guaranteed, 45 * count);
  EXPECT_EQ(least["rover and rock"].guaranteed, 30 * count);
  EXPECT_EQ(least["rover and adversary"].guaranteed, 0);
  EXPECT_LE(2000 * least["uav and uav"].below, least["uav and uav"].pairs);
  EXPECT_LE(fastest, 1e-5);
  EXPECT_GT(driven, 0.5);
}

}  // namespace
}  // namespace sightline
