#include <gtest/gtest.h>

#include "cli/allocations.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

const MakeSolver make_part_solver = newton_riccati_of(default_horizon);

std::vector<std::vector<Prediction>> two_parts() {
  const auto of = [](int body) {
    return std::vector{Prediction{.who = {body}, .h = default_horizon.h(), .sights = {{}, {}}}};
  };
  return {of(0), of(1)};
}

/// Sends and receives from the first period on; what of the second part came to the first, by
/// period.
struct Flown {
  std::vector<double> sent_at;  // of what came, by the first part's clock; -1: nothing
  std::vector<bool> received;
};
Flown flown(const ExchangeOptions& options, int periods) {
  const auto said = two_parts();
  SimulatedMessages messages(options, default_horizon, said);
  Flown all;
  for (int k = 0; k < periods; ++k) {
    const double t = k * default_horizon.dt;
    for (int part = 0; part < 2; ++part) messages.receive(part, t);
    const ReceivedMessage news = messages.news(0, 1);
    all.sent_at.push_back(news.message != nullptr ? news.time : -1.0);
    all.received.push_back(messages.receives_from(0, 1));
    for (int part = 0; part < 2; ++part) messages.send(part, t, said[at(part)]);
  }
  return all;
}

TEST(SimulatedMessages, ComeAfterTheDelayAndSayWhenTheyWereSentWhateverTheClocks) {
  for (const double offset : {0.0, 0.015, -0.019}) {
    const Flown messages = flown({.delay = 0.03, .offset = offset}, 60);
    for (int k = 20; k < 60; ++k) {
      ASSERT_TRUE(messages.received[at(k)]) << k;
      EXPECT_NEAR(messages.sent_at[at(k)], (k - 3) * default_horizon.dt, 1e-6) << k;
    }
  }
}

TEST(SimulatedMessages, AreLostAsOftenAsSaidAndTheSameOnesEachTime) {
  const ExchangeOptions lossy{.stale_after = 1.0, .delay = 0.01, .loss = 0.2};
  const Flown messages = flown(lossy, 5000), again = flown(lossy, 5000);
  EXPECT_EQ(messages.sent_at, again.sent_at);
  const auto lost = std::count(messages.sent_at.begin() + 50, messages.sent_at.end(), -1.0);
  EXPECT_NEAR(static_cast<double>(lost) / 4950, 0.2, 0.02);
  ExchangeOptions other = lossy;
  other.seed = 2;
  EXPECT_NE(flown(other, 5000).sent_at, messages.sent_at);
}

TEST(SimulatedMessages, OfThoseThatOvertakeEachOtherTheNewestCounts) {
  const Flown messages = flown({.stale_after = 1.0, .delay = 0.0, .jitter = 0.05}, 2000);
  double newest = -1.0;
  for (const double sent : messages.sent_at) {
    if (sent < 0) continue;
    EXPECT_GT(sent, newest);
    newest = sent;
  }
}

TEST(SimulatedMessages, ClocksTooFarApartOrNothingAtAllIsNotHeard) {
  for (const ExchangeOptions& options :
       {ExchangeOptions{.offset = 0.03}, ExchangeOptions{.loss = 1.0}, ExchangeOptions{.delay = 0.3}}) {
    const Flown messages = flown(options, 100);
    EXPECT_EQ(std::count(messages.received.begin(), messages.received.end(), true), 0);
    EXPECT_EQ(std::count(messages.sent_at.begin(), messages.sent_at.end(), -1.0), 100);
  }
}

TEST(PartsThatTalk, FlyTheSameBitsAgainAndAfterARestart) {
  const Team team = chain(4, paper::Variant::joint);
  const Partition halves = even_parts(team, 2);
  const PartitionOptions options{.order = ExchangeOrder::jacobi,
                                 .messages = ExchangeOptions{.delay = 0.02, .jitter = 0.01, .loss = 0.2}};
  PartitionedSolver one(team, halves, make_part_solver, options),
      two(team, halves, make_part_solver, options);
  const std::vector<double> x = chain_start(4);
  const auto fly = [&](PartitionedSolver& solver) {
    std::vector<double> all;
    for (int k = 0; k < 20; ++k) {
      const Solution solution = solver.solve(0.01 * k, x);
      all.insert(all.end(), solution.u.begin(), solution.u.end());
    }
    return all;
  };
  const std::vector<double> first = fly(one);
  EXPECT_EQ(first, fly(two));
  one.restart();
  EXPECT_EQ(first, fly(one));
}

TEST(PartsThatTalk, HearEachOtherFromTheFirstUpdateOnAndNotWhereNothingComes) {
  const Team team = chain(4, paper::Variant::joint);
  const auto receives_from = [&](const ExchangeOptions& messages) {
    PartitionedSolver solver(team, even_parts(team, 2), make_part_solver,
                             {.order = ExchangeOrder::jacobi, .messages = messages});
    solver.solve(0.0, chain_start(4));
    const Connectivity* const connectivity = solver.connectivity();
    EXPECT_TRUE(connectivity->receives_from(BodyId{0}, BodyId{1})) << "of one part";
    EXPECT_EQ(connectivity->receives_from(BodyId{1}, BodyId{2}), connectivity->is_received(BodyId{2}));
    return connectivity->receives_from(BodyId{1}, BodyId{2});
  };
  EXPECT_TRUE(receives_from({.delay = 0.03, .loss = 0.2}));
  EXPECT_FALSE(receives_from({.loss = 1.0}));
}

TEST(PartsThatTalk, NoUpdateTakesMemory) {
  const Team team = chain(4, paper::Variant::joint);
  PartitionedSolver solver(team, even_parts(team, 4), make_part_solver,
                           {.order = ExchangeOrder::jacobi,
                            .messages = ExchangeOptions{.delay = 0.03, .jitter = 0.02, .loss = 0.3}});
  const std::vector<double> x = chain_start(4);
  solver.solve(0.0, x);
  const std::int64_t before = cli::allocations();
  for (int k = 1; k < 50; ++k) solver.solve(0.01 * k, x);
  EXPECT_EQ(cli::allocations() - before, 0);
}

TEST(PartsThatTalk, SendOnceAnUpdateInJacobiOrder) {
  const Team team = chain(2, paper::Variant::masked);
  const auto make = [&](ExchangeOrder order, int exchanges) {
    return refusal_of([&] {
      PartitionedSolver(team, even_parts(team, 2), make_part_solver,
                        {.order = order, .exchanges = exchanges, .messages = ExchangeOptions{}});
    });
  };
  EXPECT_EQ(make(ExchangeOrder::gauss_seidel, 1),
            "order = gauss_seidel, exchanges = 1, expected jacobi and 1 where messages take time");
  EXPECT_EQ(make(ExchangeOrder::jacobi, 2),
            "order = jacobi, exchanges = 2, expected jacobi and 1 where messages take time");
  EXPECT_EQ(make(ExchangeOrder::jacobi, 1), "");
}

}  // namespace
}  // namespace sightline
