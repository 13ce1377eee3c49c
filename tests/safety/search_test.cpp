#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/robots.hpp"
#include "sightline/supervisor.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;

constexpr double search_period = 0.01;

Team observer_and_target() {
  Team team;
  team.add(Multirotor{}, {.name = "observer"});
  team.add(Obstacle{.name = "target"});
  return team;
}

/// An observer that is where it believes to be, 1.5 m beside a target at rest.
struct Searching {
  explicit Searching(const SearchOptions& options = {}) : search(team, std::vector{BodyId{0}}, options) {
    view.robot = BodyId{0}, view.target = BodyId{1};
    view.localized = true;
    view.position_sigma = 0.6;
    view.accepted = view.sighted = 0.0;
  }
  /// Looks and flies on for some seconds; it sees the target all the time, or never.
  void fly(double seconds, bool sees, FallbackLevel level = FallbackLevel::valid) {
    const std::vector<FallbackLevel> levels(2, level);
    for (int k = 0; k < std::lround(seconds / search_period); ++k) {
      if (sees) view.accepted = view.sighted = t;
      search.look(t, std::span(&view, 1), x);
      Numbers u(4, 0.5);
      search.command(t, x, levels, Numbers(4), u);
      changed = u != Numbers(4, 0.5);
      team.model(BodyId{0}).step(x.data(), u.data(),
                                 search.phase(0) == SearchPhase::none ? 0.0 : search_period);
      const double now = std::atan2(x[4], x[3]);
      turned += std::remainder(now - heading, 2 * std::numbers::pi);
      least = std::min(least, turned), most = std::max(most, turned);
      heading = now;
      t += search_period;
    }
  }
  double distance() const { return std::hypot(x[0] - x[7], x[1] - x[8], x[2] - x[9]); }

  Team team = observer_and_target();
  Search search;
  View view{};
  Numbers x = {0, 0, 1, 1, 0, 0, 0, /**/ 1.5, 0, 1, 0, 0, 0};
  double t = 0.0, heading = 0.0, turned = 0.0, least = 0.0, most = 0.0;
  bool changed = false;
};

TEST(Search, WhileTheTargetIsSeenOrWasShortlyBeforeThePlanStays) {
  Searching flight;
  flight.fly(3.0, true);
  EXPECT_FALSE(flight.changed);
  flight.fly(2.9, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::none);
  EXPECT_FALSE(flight.changed);
  flight.fly(0.2, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::sweep);
  EXPECT_TRUE(flight.changed);
}

TEST(Search, ItBacksOffAndLooksWhereTheTargetShouldBe) {
  Searching flight;
  flight.view.bearing_sigma = 0.1;
  flight.fly(20.0, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::sweep);
  EXPECT_NEAR(flight.distance(), 2.2, 0.02);
  EXPECT_LT(std::max(-flight.least, flight.most), 0.02);
}

TEST(Search, ItsSensorLooksWhereTheTargetShouldBe) {
  Searching flight;
  flight.view.bearing_sigma = 0.1;
  flight.view.azimuth = std::numbers::pi / 2;
  flight.fly(20.0, false);
  EXPECT_NEAR(flight.heading, -std::numbers::pi / 2, 0.02);
  EXPECT_NEAR(flight.distance(), 2.2, 0.02);
}

TEST(Search, ItBacksOffNoFartherThanItsUncertaintyCallsFor) {
  for (const auto& [sigma, far] : {std::pair{0.2, 1.5}, {0.4, 2.0}, {2.0, 2.2}}) {
    Searching flight;
    flight.view.position_sigma = sigma;
    flight.fly(15.0, false);
    EXPECT_NEAR(flight.distance(), far, 0.02);
  }
}

TEST(Search, WhereTheDirectionIsUncertainItSweepsOverTwoDeviationsAndThenTurnsRound) {
  Searching flight;
  flight.view.bearing_sigma = 0.5;
  flight.fly(3.0 + 6.0, false);
  EXPECT_NEAR(flight.most, 1.0, 0.35);
  EXPECT_NEAR(flight.least, -1.0, 0.35);
  flight.fly(2.0 + 6.3, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::round);
  EXPECT_GT(flight.most - flight.least, 6.0);
}

TEST(Search, OneThatSeesItAgainFliesByItsPlanAtOnce) {
  Searching flight;
  flight.fly(8.0, false);
  ASSERT_EQ(flight.search.phase(0), SearchPhase::sweep);
  flight.fly(search_period, true);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::none);
  EXPECT_FALSE(flight.changed);
}

TEST(Search, WithoutAPositionItTurnsWhereItStandsUntilItSees) {
  Searching flight;
  flight.view.localized = false;
  flight.view.accepted = flight.view.sighted = View::never;
  flight.fly(3.0, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::turn);
  EXPECT_NEAR(flight.turned, 3.0 - Search::in_view, 0.05);
  EXPECT_LT(std::hypot(flight.x[0], flight.x[1]), 1e-3);
  flight.view.sighted = flight.t;
  flight.fly(0.2, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::stand);
  EXPECT_NEAR(flight.turned, 3.0 - Search::in_view, 0.05);
  flight.fly(1.0, false);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::turn) << "it was nothing";
}

TEST(Search, WhereSightingsContradictTheEstimateItStandsAndThenTurnsBackToThem) {
  for (const double way : {1.0, -1.0}) {
    Searching flight;
    flight.fly(1.0, true);
    // What it sees now is refused, and the plan turns it away.
    for (int k = 0; k < 30; ++k) {
      flight.view.sighted = flight.t;
      const double psi = flight.heading + way * 0.02;
      if (flight.search.phase(0) == SearchPhase::none)
        flight.x[3] = std::cos(psi), flight.x[4] = std::sin(psi);
      flight.fly(search_period, false);
    }
    EXPECT_EQ(flight.search.phase(0), SearchPhase::stand);
    const double before = flight.turned;
    flight.fly(1.0, false);
    EXPECT_EQ(flight.search.phase(0), SearchPhase::turn);
    EXPECT_GT(way * before, 0.3);
    EXPECT_LT(way * (flight.turned - before), -0.5);
    // The filter begins anew.
    flight.fly(search_period, true);
    EXPECT_EQ(flight.search.phase(0), SearchPhase::none);
  }
}

TEST(Search, OutliersAreNoContradiction) {
  Searching flight;
  for (int k = 0; k < 300; ++k) {
    flight.view.sighted = flight.t;
    if (k % 15 == 0) flight.view.accepted = flight.t;
    flight.fly(search_period, false);
    ASSERT_EQ(flight.search.phase(0), SearchPhase::none);
  }
}

TEST(Search, OneThatHoldsTurnsWhereItIsAndOneThatLandsIsLeftAlone) {
  Searching flight;
  flight.view.bearing_sigma = 1.0;
  flight.fly(10.0, false, FallbackLevel::hold);
  EXPECT_TRUE(flight.changed);
  EXPECT_LT(std::hypot(flight.x[0], flight.x[1]), 1e-3);
  EXPECT_GT(flight.most - flight.least, 1.5);
  for (const FallbackLevel level : {FallbackLevel::land, FallbackLevel::grounded}) {
    flight.fly(search_period, false, level);
    EXPECT_FALSE(flight.changed);
  }
}

TEST(Search, OfOneThatIsAbsentNothingIsAskedAndOneThatComesBeginsAnew) {
  Searching flight;
  flight.fly(7.0, false);
  Membership now = ActiveTeam(flight.team).membership();
  now.presence[0] = Presence::absent;
  flight.search.follow(now);
  flight.fly(search_period, false);
  EXPECT_FALSE(flight.changed);
  now.presence[0] = Presence::steered;
  flight.search.follow(now);
  EXPECT_EQ(flight.search.phase(0), SearchPhase::none);
}

TEST(Search, WhoCannotTurnWhereItStandsIsRefused) {
  const auto refused = [](const auto& model) {
    Team team;
    team.add(model, {.name = "a"});
    return refusal_of([&] { Search(team, std::vector{BodyId{0}}, {}); });
  };
  EXPECT_EQ(
      refused(PointMass{}),
      "\"a\" is localized by vision, but its model \"point_mass\" does not turn where it stands by 1 rad/s, "
      "expected one that does: it could not find what it observes");
  EXPECT_EQ(refused(Unicycle{}), "");
  EXPECT_EQ(refused(OmniRover{}), "");
  EXPECT_NO_THROW(Search(observer_and_target(), std::vector{BodyId{0}}, {}));
  EXPECT_EQ(refusal_of([] { Search(observer_and_target(), std::vector{BodyId{1}}, {}); }),
            "a robot that searches has the number 1, expected a robot of the team");
  EXPECT_EQ(refusal_of([] { Search(observer_and_target(), std::vector{BodyId{0}}, {.rate = 0.0}); }),
            "search.rate = 0, expected 0.05 to 10 rad/s");
}

}  // namespace
}  // namespace sightline
