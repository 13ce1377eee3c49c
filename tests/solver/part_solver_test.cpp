#include "sightline/solver/distributed/part_solver.hpp"

#include <gtest/gtest.h>

#include "tests/support/chain_team.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/newton_riccati_of.hpp"

namespace sightline {
namespace {

const MakeSolver make_own_solver = newton_riccati_of(default_horizon);

/// Keeps what is sent, and says that the first body outside comes nearer.
struct Messages final : PartExchange {
  void receive(double t, Subteam& receiver) noexcept override {
    ++received;
    if (!tells) return;
    Prediction prediction{.who = {1}, .time = t, .h = default_horizon.h()};
    for (int k = 0; k <= default_horizon.N; ++k) {
      Sight<double> there;
      there.p = {-0.02 * k, 0, 0.5};
      prediction.sights.push_back(there);
    }
    receiver.receive(prediction);
  }
  void send(double t, std::span<const Prediction> predictions) noexcept override {
    sent.assign(predictions.begin(), predictions.end());
    at = t;
  }
  bool receives_from(BodyId, BodyId) const noexcept override { return true; }
  bool is_received(BodyId) const noexcept override { return true; }

  bool tells = false;
  int received = 0;
  double at = -1.0;
  std::vector<Prediction> sent;
};

// uav1, which observes uav0 of another part.
Team follower_alone() {
  const Team whole = chain(2, paper::Variant::masked);
  return subteam_of(whole, std::vector{AgentId{whole.find("uav1")}}, Others::all);
}
const std::vector<double> follower_start = {-1.5, 0, 0.875, 1, 0, 0, 0, /**/ 0, 0, 0.5, 0, 0, 0};

TEST(PartSolver, IsTheSolverOfItsTeamWhereNothingComesAndSaysWhereItsRobotsWillBe) {
  Messages messages;
  PartSolver part(follower_alone(), make_own_solver, messages);
  const auto alone = make_own_solver(follower_alone());
  EXPECT_EQ(part.name(), alone->name());
  EXPECT_EQ(part.connectivity(), &messages);
  EXPECT_EQ(part.ocp().team().bodies(), 2);
  for (int k = 0; k < 5; ++k) {
    const Solution one = part.solve(0.01 * k, follower_start), other = alone->solve(0.01 * k, follower_start);
    EXPECT_TRUE(std::equal(one.u.begin(), one.u.end(), other.u.begin(), other.u.end())) << k;
    EXPECT_EQ(messages.received, k + 1);
    EXPECT_EQ(messages.at, 0.01 * k);
  }
  ASSERT_EQ(messages.sent.size(), 1u);
  EXPECT_EQ(messages.sent[0].who, BodyId{0});
  ASSERT_EQ(static_cast<int>(messages.sent[0].sights.size()), default_horizon.N + 1);
  EXPECT_EQ(messages.sent[0].sights[0].p.x, -1.5);
}

TEST(PartSolver, PlansWithWhatComesAndSendsNothingOfAStateThatIsRefused) {
  Messages reported, silent;
  reported.tells = true;
  PartSolver one(follower_alone(), make_own_solver, reported),
      other(follower_alone(), make_own_solver, silent);
  const Solution with = one.solve(0.0, follower_start), without = other.solve(0.0, follower_start);
  EXPECT_FALSE(std::equal(with.u.begin(), with.u.end(), without.u.begin(), without.u.end()));
  silent.at = -1.0;
  std::vector<double> wild = follower_start;
  wild[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(other.solve(0.01, wild).status, Status::invalid_state);
  EXPECT_EQ(silent.at, -1.0);
}

}  // namespace
}  // namespace sightline
