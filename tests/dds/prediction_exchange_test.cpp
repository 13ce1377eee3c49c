#include "bridges/dds/topics/prediction_exchange.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "bridges/dds/domain.hpp"
#include "sightline/base/now.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/child.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/scenario_text.hpp"

extern "C" {
#include "parts.h"
}

namespace sightline::dds {
namespace {

using testing::HasSubstr;

Scenario part_of_pair(const std::string& part, const std::string& more = "") {
  return test::scenario_of(fmt::format(R"([agent.a]
robot = "multirotor"
start.p = [0, 0, 1]
[agent.b]
robot = "multirotor"
start.p = [2, 0, 1]
[[couple]]
potential = {{ too_near = {{ d_min = 1.0 }} }}
between = ["a", "b"]
[partition]
left = ["a"]
right = ["b"]
part = "{}"
[partition.exchange]
{}
)",
                                       part, more));
}

/// One part in a participant of its own, that says each 10 ms where it stands or flies.
struct Computer {
  explicit Computer(const std::string& part, const std::string& more = "", Domain* in = nullptr)
      : scenario(part_of_pair(part, more)), own(in), talk(scenario, own->another_participant()) {
    talk.begin(monotonic_now());
  }
  void stand() { talk.stand(PartPhase::holding, scenario.x0); }
  void fly(double x) {
    Prediction prediction{.who = {0}, .h = scenario.horizon.h()};
    Sight<double> there;
    there.p = {x, 0, 1};
    prediction.sights.assign(size(scenario.horizon.N + 1), there);
    talk.send(0.0, std::vector{prediction});
  }
  bool receives_from() const { return talk.is_received(BodyId{1}); }

  Scenario scenario;
  Domain* own;
  PredictionExchange talk;
};

void pass_period() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }

struct TwoComputers : testing::Test {
  Domain domain{test::own_network()};
};

TEST_F(TwoComputers, HearEachOtherOnceTheyFlyAndNotAnyLongerThanThey) {
  Computer left("left", "", &domain);
  auto right = std::make_unique<Computer>("right", "", &domain);
  EXPECT_FALSE(left.receives_from());
  ASSERT_TRUE(test::eventually([&] {
    left.stand(), right->stand(), pass_period();
    return !left.talk.news().empty();
  }));
  EXPECT_FALSE(left.receives_from()) << "it stands, and does not give way";
  EXPECT_TRUE(left.talk.all_hold());
  ASSERT_TRUE(test::eventually([&] {
    left.fly(0.0), right->fly(2.0), left.stand(), pass_period();
    return left.receives_from();
  }));
  EXPECT_THAT(left.talk.news(),
              testing::ElementsAre(HasSubstr("part right: its messages arrive, its robots fly")));
  right.reset();
  ASSERT_TRUE(test::eventually([&] {
    left.stand(), pass_period();
    return !left.receives_from();
  }));
  EXPECT_THAT(left.talk.news(), testing::ElementsAre("part right: its messages do not arrive"));
  EXPECT_THAT(left.talk.counts().back(), HasSubstr("part right: "));
}

TEST_F(TwoComputers, ThoseThatHoldBeginInTheSamePeriodThoughMessagesAreLostAndLate) {
  const std::string network = R"(delay = 0.03
loss = 0.3
flown_by = "simulation")";
  Computer left("left", network, &domain), right("right", network, &domain);
  const auto begun = [](const Computer& c) { return c.talk.begins() && monotonic_now() > *c.talk.begins(); };
  left.stand();
  EXPECT_TRUE(left.talk.begins()) << "it hears nobody";
  ASSERT_TRUE(test::eventually([&] {
    left.talk.stand(PartPhase::rising, left.scenario.x0), right.stand(), pass_period();
    return !right.talk.all_hold();
  }));
  EXPECT_FALSE(left.talk.begins()) << "it does not hold";
  ASSERT_TRUE(test::eventually([&] {
    left.stand(), right.stand(), pass_period();
    return begun(left) && begun(right);
  }));
  EXPECT_LT(std::abs(*left.talk.begins() - *right.talk.begins()), 5'000'000) << "[ns]";
}

TEST_F(TwoComputers, OneThatFliesSaysNoMoreWhenItBegins) {
  using Message = sightline_msgs_msg_dds__Prediction_;
  Computer left("left", "", &domain);
  std::atomic<int> held{0}, flown{0}, wrong{0};
  const RawReader listener(domain.another_participant(), sightline_msgs_msg_dds__Prediction__desc,
                           prediction_topic(left.scenario.name, "left"), of_sensors, std::nullopt,
                           Writers::all, taking<Message>([&](const Message& m, const Arrival&) {
                             ++(m.steers ? flown : held);
                             wrong += (m.begins != 0) == m.steers;
                           }));
  const auto until = [](const std::atomic<int>& some, auto&& say) {
    return test::eventually([&] { return say(), pass_period(), some > 5; });
  };
  EXPECT_TRUE(until(held, [&] { left.stand(); }));
  EXPECT_TRUE(until(flown, [&] { left.fly(0.0); }));
  EXPECT_EQ(wrong, 0);
}

TEST_F(TwoComputers, WhatIsPredictedElsewhereIsPlannedWith) {
  Computer left("left", "", &domain), right("right", "", &domain);
  struct Planner final : PartExchange {
    void receive(double, Subteam&) noexcept override {}
    void send(double, std::span<const Prediction>) noexcept override {}
    bool receives_from(BodyId, BodyId) const noexcept override { return true; }
    bool is_received(BodyId) const noexcept override { return true; }
  };
  const auto make = [&](const Team& team) {
    return make_solver(left.scenario.solver, team, left.scenario.horizon);
  };
  const Team& team = left.scenario.team;
  Subteam with(team, std::vector{AgentId{{0}}}, make, Others::all),
      without(team, std::vector{AgentId{{0}}}, make, Others::all);
  ASSERT_TRUE(test::eventually([&] {
    right.stand(), right.fly(1.2), left.stand(), pass_period();
    return left.receives_from();
  }));
  left.talk.begin(monotonic_now());
  left.talk.receive(0.0, with);
  const Solution planned = with.solve(0.0, left.scenario.x0), alone = without.solve(0.0, left.scenario.x0);
  EXPECT_NE(std::vector<double>(planned.u.begin(), planned.u.end()),
            std::vector<double>(alone.u.begin(), alone.u.end()))
      << "b is seen at 2 m, and says that it is at 1.2 m";
}

TEST_F(TwoComputers, MessagesOfAnotherShapeAreCountedAndDropped) {
  Computer left("left", "", &domain);
  Writer<sightline_msgs_msg_dds__Prediction_> forger(
      domain.another_participant(), sightline_msgs_msg_dds__Prediction__desc,
      prediction_topic(left.scenario.name, "right"), of_sensors);
  std::string part = "right", robot = "b";
  const std::size_t stages = size(left.scenario.horizon.N + 1);
  std::uint64_t number = 0;
  const auto forge = [&](auto&& spoil) {
    std::vector<double> numbers(10 * stages, 0.5);
    sightline_msgs_msg_dds__RobotPrediction_ one{robot.data(), {}};
    one.sights._buffer = numbers.data();
    one.sights._length = one.sights._maximum = static_cast<std::uint32_t>(numbers.size());
    sightline_msgs_msg_dds__Prediction_ message{};
    message.part = part.data();
    message.session = 1;
    message.number = ++number;
    message.stamp = realtime_now();
    message.step = left.scenario.horizon.h();
    message.robots._buffer = &one;
    message.robots._length = message.robots._maximum = 1;
    spoil(message, one, numbers);
    forger(message);
  };
  std::string nobody = "nobody";
  const auto unreadable = [&] {
    const std::string line = left.talk.counts().back();
    const auto at = line.find(" late, ");
    return std::stoi(line.substr(at + 7));
  };
  ASSERT_TRUE(test::eventually([&] { return forger.matched() > 0; }));
  using Message = sightline_msgs_msg_dds__Prediction_;
  using Robot = sightline_msgs_msg_dds__RobotPrediction_;
  using Numbers = std::vector<double>;
  const std::vector<std::function<void(Message&, Robot&, Numbers&)>> wrong = {
      [&](Message& m, Robot&, Numbers&) { m.part = nobody.data(); },
      [&](Message& m, Robot&, Numbers&) { m.step *= 2; },
      [&](Message& m, Robot&, Numbers&) { m.stamp = -5; },
      [&](Message& m, Robot&, Numbers&) { m.phase = 200; },
      [&](Message& m, Robot&, Numbers&) { m.begins = m.stamp + 60'000'000'000; },
      [&](Message& m, Robot&, Numbers&) { m.begins = std::numeric_limits<std::int64_t>::min(); },
      [&](Message& m, Robot&, Numbers&) { m.robots._length = 0; },
      [&](Message&, Robot& r, Numbers&) { r.robot = nobody.data(); },
      [&](Message&, Robot& r, Numbers&) { r.sights._length -= 1; },
      [&](Message&, Robot&, Numbers& n) { n[3] = std::numeric_limits<double>::quiet_NaN(); }};
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    forge(wrong[i]);
    EXPECT_TRUE(test::eventually([&] { return unreadable() == static_cast<int>(i) + 1; }))
        << i << ": " << left.talk.counts().back();
  }
  left.stand();
  EXPECT_THAT(left.talk.counts().back(), HasSubstr("part right: 0 predictions"));
  forge([](Message&, Robot&, Numbers&) {});
  EXPECT_TRUE(test::eventually([&] {
    left.stand();
    return left.talk.counts().back().starts_with("part right: 1 predictions");
  }));
}

TEST_F(TwoComputers, ASimulatedNetworkLosesWhatItSaysAndDelaysTheRest) {
  const std::string lossy = "loss = 1.0\nflown_by = \"simulation\"";
  Computer left("left", lossy, &domain), right("right", "", &domain);
  for (int k = 0; k < 50; ++k) left.stand(), right.fly(2.0), pass_period();
  EXPECT_FALSE(left.receives_from());
  EXPECT_THAT(left.talk.counts().back(), HasSubstr("part right: 0 predictions"));
}

}  // namespace
}  // namespace sightline::dds
