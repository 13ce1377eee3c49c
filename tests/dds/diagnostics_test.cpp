#include "bridges/dds/topics/diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Pair;

RobotShown in_flight() {
  RobotShown shown = {.seen = true, .state = LinkState::flying};
  shown.facts = {.there = true, .armed = true, .airborne = true, .mode = AutopilotMode::offboard};
  return shown;
}

TEST(Diagnostics, ALinkIsAsGoodAsWhatIsKnownOfIt) {
  const auto of = [](const RobotShown& shown, double age = 0.01, FallbackLevel level = FallbackLevel::valid) {
    return diagnose_link("uav0", shown, age, 0.05, level, "7 poses");
  };
  const Diagnosis good = of(in_flight());
  EXPECT_EQ(good.level, Health::ok);
  EXPECT_EQ(good.name, "sightline: uav0");
  EXPECT_EQ(good.message, "flying");
  EXPECT_THAT(good.values, Contains(Pair("age of the pose [ms]", "10.0")));
  EXPECT_THAT(good.values, Contains(Pair("mode", "offboard")));
  EXPECT_THAT(good.values, Contains(Pair("messages", "7 poses")));

  EXPECT_EQ(of(in_flight(), 0.06).level, Health::warn);
  EXPECT_EQ(of(in_flight(), 0.01, FallbackLevel::slowed).level, Health::warn);
  RobotShown shown = in_flight();
  shown.facts.there = false;
  EXPECT_EQ(of(shown, 1.2).level, Health::stale);
  EXPECT_THAT(of(shown, 1.2).message, HasSubstr("1.2 s old"));
  shown.state = LinkState::pilot, shown.reason = LinkReason::pilot;
  EXPECT_EQ(of(shown).level, Health::error);
  EXPECT_EQ(of(shown).message, "pilot: a pilot has it");
  const Diagnosis stale = of({});
  EXPECT_EQ(stale.level, Health::stale);
  EXPECT_THAT(stale.values, Contains(Pair("age of the pose [ms]", "none")));
}

TEST(Diagnostics, ASolverIsAsGoodAsItsLastPlan) {
  LoopShown loop;
  EXPECT_EQ(diagnose_solver("newton_riccati", loop).level, Health::ok);
  EXPECT_EQ(diagnose_solver("newton_riccati", loop).message, "no task yet");
  loop = {.begun = true, .last = {.status = Status::converged}, .solve_us_most = 412.4, .periods = 100};
  EXPECT_EQ(diagnose_solver("newton_riccati", loop).level, Health::ok);
  EXPECT_THAT(diagnose_solver("newton_riccati", loop).values,
              Contains(Pair("longest solve time [us]", "412")));
  loop.missed = 3;
  EXPECT_EQ(diagnose_solver("newton_riccati", loop).level, Health::warn);
  EXPECT_THAT(diagnose_solver("newton_riccati", loop).message, HasSubstr("3 periods missed"));
  loop.last.status = Status::not_finite;
  EXPECT_EQ(diagnose_solver("newton_riccati", loop).level, Health::error);
}

}  // namespace
}  // namespace sightline::dds
