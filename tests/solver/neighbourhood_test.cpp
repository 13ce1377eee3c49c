#include "sightline/solver/newton/neighbourhood.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "cli/allocations.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solver/newton/coupling.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

constexpr Horizon half_horizon{.T = 0.5, .N = 10, .dt = 0.01};

struct Options {
  int agents = 20;
  double radius = 2.5;
  int capacity = 1000;
  Weighted term = 2.0 * PassRight{.d_min = 1.2, .delta = 0.3};
};

/// A swarm, or the same potential between all its pairs by name, and random plans.
struct SwarmField {
  enum class Made { of_a_swarm, of_pairs };

  Ocp ocp;
  std::vector<BodyPotential> potentials = trace_potentials(ocp);
  std::vector<SwarmPotential> swarms = trace_swarms(ocp);
  Groups groups;
  Rows s, c, z, y;

  explicit SwarmField(const Options& o, Made made = Made::of_a_swarm)
      : ocp(team(o, made), half_horizon),
        groups(ocp, potentials, KernelChoice::compiled_if_there),
        s(1, layout().s_length),
        c(1, layout().c_length),
        z(1, layout().s_length),
        y(1, layout().s_length) {}

  static Team team(const Options& o, Made made) {
    Team team;
    std::vector<AgentId> robots;
    for (int i = 0; i < o.agents; ++i) robots.push_back(team.add(Multirotor{}));
    if (made == Made::of_a_swarm) {
      team.keep_apart(o.term, robots, o.radius, o.capacity);
      return team;
    }
    for (std::size_t i = 0; i < robots.size(); ++i) {
      for (std::size_t j = i + 1; j < robots.size(); ++j) team.couple(o.term, {robots[i], robots[j]});
    }
    return team;
  }

  const Layout& layout() const { return groups.layout(); }
  std::unique_ptr<Couplings> couplings() const {
    return make_couplings(potentials, layout(), ocp.team().bodies(), KernelChoice::compiled_if_there, swarms);
  }

  /// Robots within `wide` that move by up to `move` along the horizon; stage 0 of z is at rest, as
  /// steps are.
  void draw(Random& random, double wide, double move) {
    for (int a = 0; a < static_cast<int>(layout().agents.size()); ++a) {
      const Vec3<double> p = random_point(random, wide), v = random_point(random, move);
      for (int k = 0; k < layout().stages; ++k) {
        const double w = static_cast<double>(k) / layout().stages;
        const std::array<double, 5> pose = {p.x + w * v.x, p.y + w * v.y, p.z + w * v.z, std::cos(p.x),
                                            std::sin(p.x)};
        for (int i = 0; i < 5; ++i) {
          s[0][layout().s(a)(k, i)] = pose[static_cast<std::size_t>(i)];
          z[0][layout().s(a)(k, i)] = k == 0 ? 0.0 : uniform(random, -1, 1);
        }
      }
    }
  }
  Vec3<double> position(int a, int k) const {
    const Layout::View at = layout().s(a);
    return {s[0][at(k, 0)], s[0][at(k, 1)], s[0][at(k, 2)]};
  }
  double least_distance(int a, int b) const {
    double least = 1e9;
    for (int k = 0; k < layout().stages; ++k) least = std::fmin(least, norm(position(a, k) - position(b, k)));
    return least;
  }
};

using Named = std::vector<std::pair<int, int>>;

Named names(const Neighbourhood& near) {
  Named list;
  for (const Neighbourhood::Pair& p : near.pairs()) list.emplace_back(p.a, p.b);
  return list;
}

TEST(Neighbourhood, AllPairsWhosePlansComeNearAreFoundAndNoOthers) {
  Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    SwarmField field({.agents = 2 + static_cast<int>(random() % 40)});
    field.draw(random, std::exp(uniform(random, 0.0, 5.0)), std::exp(uniform(random, -3.0, 3.0)));
    Neighbourhood near(field.swarms[0], field.layout(), KernelChoice::compiled_if_there);
    near.find(field.s[0]);
    Named expected;
    for (int a = 0; a < static_cast<int>(field.layout().agents.size()); ++a) {
      for (int b = a + 1; b < static_cast<int>(field.layout().agents.size()); ++b) {
        if (field.least_distance(a, b) < 2.5) expected.emplace_back(a, b);
      }
    }
    EXPECT_EQ(names(near), expected) << trial;
    EXPECT_EQ(near.left_out(), 0);
  }
}

TEST(Neighbourhood, OfMorePairsThanThereIsRoomForTheNearestCountAndTheOthersAreCounted) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const int capacity = 1 + static_cast<int>(random() % 60);
    SwarmField all({}), some({.capacity = capacity});
    all.draw(random, 3.0, 1.0);
    std::copy_n(all.s[0], all.layout().s_length, some.s[0]);
    Neighbourhood near_all(all.swarms[0], all.layout(), KernelChoice::compiled_if_there);
    Neighbourhood near_some(some.swarms[0], some.layout(), KernelChoice::compiled_if_there);
    near_all.find(all.s[0]);
    near_some.find(some.s[0]);
    std::vector<Neighbourhood::Pair> nearest(near_all.pairs().begin(), near_all.pairs().end());
    std::stable_sort(nearest.begin(), nearest.end(),
                     [](const auto& p, const auto& q) { return p.distance_2 < q.distance_2; });
    const std::size_t kept = std::min(nearest.size(), static_cast<std::size_t>(capacity));
    EXPECT_EQ(near_some.left_out(), static_cast<int>(nearest.size() - kept));
    Named expected;
    for (std::size_t i = 0; i < kept; ++i) expected.emplace_back(nearest[i].a, nearest[i].b);
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(names(near_some), expected) << trial;
  }
}

TEST(Neighbourhood, ASwarmIsWhatItsPairsAreOneByOne) {
  Random random(3);
  for (int trial = 0; trial < 12; ++trial) {
    Options o{.agents = 2 + static_cast<int>(random() % 12), .radius = 6.0};
    if (trial % 3 == 0) o.term = 2.0 * KeepOut{};
    if (trial % 3 == 1) o.term = 2.0 * TooNear{};
    SwarmField swarm(o), pairs(o, SwarmField::Made::of_pairs);
    swarm.draw(random, 1.5, 0.5);
    const Layout& layout = swarm.layout();
    ASSERT_EQ(layout.s_length, pairs.layout().s_length);
    std::copy_n(swarm.s[0], layout.s_length, pairs.s[0]);
    std::copy_n(swarm.z[0], layout.s_length, pairs.z[0]);
    const auto of_swarm = swarm.couplings(), of_pairs = pairs.couplings();
    of_swarm->find_neighbours(swarm.s[0]);
    for (SwarmField* f : {&swarm, &pairs}) {
      Couplings& couplings = f == &swarm ? *of_swarm : *of_pairs;
      couplings.evaluate(f->s[0], f->c[0]);
      couplings.product(f->z[0], f->y[0]);
    }
    for (int a = 0; a < o.agents; ++a) {
      for (int k = 1; k < layout.stages; ++k) {
        for (int i = 0; i < 20; ++i) {
          const std::ptrdiff_t at = layout.c(a)(k, i);
          EXPECT_NEAR(swarm.c[0][at], pairs.c[0][at], 1e-11) << trial;
        }
        for (int i = 0; i < 5; ++i) {
          const std::ptrdiff_t at = layout.s(a)(k, i);
          EXPECT_NEAR(swarm.y[0][at], pairs.y[0][at], 1e-11) << trial;
        }
      }
    }
    std::vector<double> each(pairs.potentials.size()), none(0), of_agents(static_cast<std::size_t>(o.agents));
    of_pairs->values(pairs.s[0], each);
    of_swarm->values(swarm.s[0], none);
    of_swarm->swarm_values(swarm.s[0], of_agents);
    EXPECT_NEAR(std::accumulate(of_agents.begin(), of_agents.end(), 0.0),
                2.0 * std::accumulate(each.begin(), each.end(), 0.0), 1e-10);
  }
}

TEST(Neighbourhood, APairThatComesOrGoesMakesNoStep) {
  SwarmField field({.agents = 2});
  Neighbourhood near(field.swarms[0], field.layout(), KernelChoice::compiled_if_there);
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    field.draw(random, 1.0, 0.0);
    const Vec3<double> r = field.position(1, 0) - field.position(0, 0);
    double before = -1.0;
    for (const double distance : {2.5 + 1e-9, 2.5 - 1e-9}) {
      for (int k = 0; k < field.layout().stages; ++k) {
        const Vec3<double> p = field.position(0, k) + (distance / norm(r)) * r;
        const Layout::View at = field.layout().s(1);
        field.s[0][at(k, 0)] = p.x, field.s[0][at(k, 1)] = p.y, field.s[0][at(k, 2)] = p.z;
      }
      near.find(field.s[0]);
      std::fill(field.c.all().begin(), field.c.all().end(), 0.0);
      near.evaluate(field.s[0], field.c[0]);
      double slope = 0.0;
      for (const double c : field.c.all()) slope = std::fmax(slope, std::fabs(c) / half_horizon.h());
      EXPECT_EQ(near.pairs().size(), distance < 2.5 ? 1U : 0U);
      if (before >= 0.0) {
        EXPECT_NEAR(slope, before, 0.02);  // curvature, kappa times the slope, is in it
      }
      before = slope;
    }
  }
}

}  // namespace
}  // namespace sightline
