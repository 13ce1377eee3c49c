#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/allocations.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/error.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/random_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

const MakeSolver make_newton = newton_riccati_of(default_horizon);
constexpr ExchangeOrder orders[] = {ExchangeOrder::jacobi, ExchangeOrder::gauss_seidel};

TEST(Partition, IsReadByTheNamesOfRobots) {
  const Team team = chain(4, paper::Variant::masked);
  const Partition two = read_partition(" uav0 ,uav2|uav1,  uav3 ", team);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0], (std::vector{AgentId{{0}}, AgentId{{2}}}));
  EXPECT_EQ(two[1], (std::vector{AgentId{{1}}, AgentId{{3}}}));
  EXPECT_EQ(read_partition("uav0,uav1,uav2,uav3", team).size(), 1u);
  EXPECT_EQ(read_partition("front: uav0, uav2 | uav1,uav3", team), two);
  const std::vector<PartSpec> words = parse_parts("front: uav0 ,uav2|uav1");
  ASSERT_EQ(words.size(), 2u);
  EXPECT_EQ(words[0].name, "front");
  EXPECT_EQ(words[0].robots, (std::vector<std::string>{"uav0", "uav2"}));
  EXPECT_EQ(words[1].name, "");
  EXPECT_EQ(refusal_of([] { (void)parse_parts("a: uav0 | a: uav1"); }),
            "partition = \"a: uav0 | a: uav1\" has part \"a\" twice, expected each name once");
}

TEST(Partition, ARobotTwiceNoRobotAndAnEmptyPartAreRefused) {
  Team team = chain(3, paper::Variant::masked);
  team.add(Obstacle{.name = "tree"});
  const auto refusal = [&](const char* text) {
    return refusal_of([&] { (void)read_partition(text, team); });
  };
  EXPECT_THAT(refusal("uav0, uav2 | uav1, uav2"), testing::HasSubstr("\"uav2\" twice"));
  EXPECT_THAT(refusal("uav0, tree | uav1, uav2"), testing::HasSubstr("\"tree\" is no robot of the team"));
  EXPECT_THAT(refusal("uav0 | | uav1, uav2"), testing::HasSubstr("a part without robots"));
  EXPECT_NE(refusal("uav0,,uav1,uav2"), "");
}

TEST(Partition, OptionsOutOfRangeAreRefusedInWords) {
  const Team team = chain(2, paper::Variant::masked);
  const Partition all = {{AgentId{{0}}, AgentId{{1}}}};
  const auto make = [&](const Partition& partition, int exchanges) {
    return refusal_of([&] { PartitionedSolver(team, partition, make_newton, {.exchanges = exchanges}); });
  };
  EXPECT_EQ(make(all, 1), "");
  EXPECT_EQ(make(all, 0), "exchanges = 0, expected 1 to 1000");
  EXPECT_EQ(make(all, 1001), "exchanges = 1001, expected 1 to 1000");
  EXPECT_EQ(make({}, 1), "the partition has no part, expected at least one");
  EXPECT_EQ(make({{AgentId{{0}}}, {}}, 1),
            "the partition has a part without robots, expected at least one in each");
  EXPECT_EQ(make({{AgentId{{2}}}}, 1), "the partition names body 2, expected a robot of the team");
  const auto threads = [&](int number, ExchangeOrder order) {
    return refusal_of(
        [&] { PartitionedSolver(team, all, make_newton, {.order = order, .threads = number}); });
  };
  EXPECT_EQ(threads(0, ExchangeOrder::jacobi), "threads = 0, expected 1 to 64");
  EXPECT_EQ(threads(65, ExchangeOrder::jacobi), "threads = 65, expected 1 to 64");
  EXPECT_EQ(threads(2, ExchangeOrder::jacobi), "");
  EXPECT_THAT(threads(2, ExchangeOrder::gauss_seidel),
              testing::HasSubstr("expected 1 in gauss_seidel order"));
  EXPECT_EQ(refusal_of([] { (void)exchange_order("gauss"); }),
            "order = \"gauss\", expected jacobi or gauss_seidel");
  for (const ExchangeOrder order : orders) EXPECT_EQ(exchange_order(to_string(order)), order);
}

TEST(Partition, ATeamInOnePartFliesTheSameBitsAsUndivided) {
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    const Team team = chain(5, variant);
    NewtonRiccati whole(team, default_horizon);
    PartitionedSolver one(team, even_parts(team, 1), make_newton);
    fly(whole, chain_start(5), 200, [&](double t, const std::vector<double>& x, const Solution& s) {
      const Solution part = one.solve(t, x);
      for (std::size_t i = 0; i < s.u.size(); ++i) ASSERT_TRUE(same_bits(part.u[i], s.u[i])) << t;
      EXPECT_EQ(part.iterations, s.iterations);
    });
  }
}

TEST(Partition, ItsResidualIsThatOfTheWholeTeam) {
  const Team team = chain(4, paper::Variant::joint);
  PartitionedSolver parts(team, even_parts(team, 2), make_newton);
  NewtonRiccati whole(team, default_horizon);
  std::vector<double> u(16);
  fly(parts, chain_start(4), 30, [&](double t, const std::vector<double>& x, const Solution& s) {
    for (int k = 0; k < default_horizon.N; ++k) {
      parts.plan(k, u);
      whole.set_plan(k, u);
    }
    EXPECT_EQ(s.residual, whole.kkt(t, x));
    EXPECT_EQ(s.residual, parts.kkt(t, x));
    EXPECT_EQ(s.status, s.residual <= 1e-6 ? Status::converged : Status::stepped);
  });
}

TEST(Partition, AMaskedChainSolvedFromItsHeadTakesOneExchangeToBeTheCascade) {
  const Team team = chain(6, paper::Variant::masked);
  PartitionedSolver parts(team, even_parts(team, 6), make_newton);
  NewtonRiccati whole(team, default_horizon);
  double worst = 0.0;
  fly(whole, chain_start(6), 300, [&](double t, const std::vector<double>& x, const Solution& s) {
    const std::vector<double> expected(s.u.begin(), s.u.end());
    const Solution part = parts.solve(t, x);
    for (std::size_t i = 0; t > 1.0 && i < expected.size(); ++i)
      worst = std::max(worst, std::fabs(part.u[i] - expected[i]));
  });
  EXPECT_LE(worst, 1e-4);
}

TEST(Partition, APlanPutInIsThePlanAndTheNextUpdateBeginsThere) {
  const Team team = chain(4, paper::Variant::joint);
  NewtonRiccati whole(team, default_horizon,
                      {.max_newton_steps = 50, .tolerance = 1e-9, .max_krylov = 100, .krylov_stop = 0});
  const std::vector<double> x = chain_start(4);
  ASSERT_EQ(whole.solve(0.0, x).status, Status::converged);
  PartitionedSolver parts(team, even_parts(team, 2), make_newton);
  std::vector<double> u(16), v(16);
  for (int k = 0; k < default_horizon.N; ++k) {
    whole.plan(k, u);
    parts.set_plan(k, u);
  }
  for (int k = 0; k < default_horizon.N; ++k) {
    whole.plan(k, u);
    parts.plan(k, v);
    EXPECT_EQ(u, v);
  }
  EXPECT_LE(parts.kkt(0.0, x), 1e-8);
  parts.send_all(0.0, x);
  EXPECT_LE(parts.solve(0.0, x).residual, 1e-8) << "nothing is left to better";
}

TEST(Partition, OfPartsOfAnySizeTheBitsAreTheSameWhateverTheNumberOfThreads) {
  const Team team = chain(8, paper::Variant::joint);
  const std::vector<double> x = chain_start(8);
  for (const std::optional<ExchangeOptions>& messages :
       {std::optional<ExchangeOptions>(), std::optional(ExchangeOptions{.delay = 0.02, .loss = 0.2})}) {
    for (const int parts : {8, 4, 2, 1}) {
      std::vector<std::vector<double>> flown;
      for (const int number : {1, 2, 3, 8}) {
        PartitionedSolver solver(team, even_parts(team, parts), make_newton,
                                 {.order = ExchangeOrder::jacobi,
                                  .exchanges = messages ? 1 : 2,
                                  .messages = messages,
                                  .threads = number});
        std::vector<double>& u = flown.emplace_back();
        for (int k = 0; k < 12; ++k) {
          const Solution solution = solver.solve(0.01 * k, x);
          u.insert(u.end(), solution.u.begin(), solution.u.end());
        }
        EXPECT_EQ(u, flown.front()) << parts << " parts, " << number << " threads";
      }
    }
  }
}

}  // namespace
}  // namespace sightline
