#include "sightline/judge/tracking_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/model.hpp"

namespace sightline {
namespace {

Agent agent_of(std::array<double, 7> Q, double heading = 0.0) {
  Team team;
  const auto place = [heading](double t) {
    return Pose<double>{{t, 0, 1}, {std::cos(heading), std::sin(heading)}};
  };
  return team.agent(team.add(Multirotor{}, {.Q = Q, .x_ref = place}));
}

Sight<double> seen_at(const Vec3<double>& p, double heading = 0.0) {
  Sight<double> seen;
  seen.p = p;
  seen.d = {std::cos(heading), std::sin(heading)};
  return seen;
}

TEST(TrackingError, HasASteadyPartAndARestWhoseSquaresAreThatOfTheWhole) {
  const Agent agent = agent_of({1, 1, 1, 0, 0, 0, 0});
  TrackingError error(agent.model, 0.5);
  error.add(agent, 0.4, seen_at({9, 9, 9}));
  for (int k = 0; k < 100; ++k) {
    const double t = 0.5 + 0.01 * k;
    error.add(agent, t, seen_at({t + (k % 2 == 0 ? 0.3 : -0.4), 0, 1}));
  }
  EXPECT_NEAR(error.rms_position(), std::sqrt(0.125), 1e-12);
  EXPECT_NEAR(error.offset(), 0.05, 1e-12);
  EXPECT_NEAR(error.rms_rest(), 0.35, 1e-12);
  EXPECT_TRUE(std::isnan(error.rms_heading())) << "Q asks for no heading";
}

TEST(TrackingError, OfAHeadingIsTheShortWayRound) {
  const Agent agent = agent_of({0, 0, 0, 1, 1, 0, 0}, 3.0);
  TrackingError error(agent.model, 0.0);
  error.add(agent, 0.0, seen_at({5, 0, 1}, -3.0));
  EXPECT_NEAR(error.rms_heading(), 2 * std::numbers::pi - 6.0, 1e-12);
  error.add(agent, 0.0, seen_at({5, 0, 1}, 3.0));
  EXPECT_NEAR(error.rms_heading(), (2 * std::numbers::pi - 6.0) / std::sqrt(2.0), 1e-12);
  for (const double none : {error.rms_position(), error.offset(), error.rms_rest()})
    EXPECT_TRUE(std::isnan(none)) << "Q asks for no place";
}

TEST(TrackingError, CountsWhatIsAskedAtTheTimeAlone) {
  const Agent place = agent_of({1, 0, 0, 0, 0, 0, 0}), heading = agent_of({0, 0, 0, 1, 0, 0, 0}),
              nothing = agent_of({0, 0, 0, 0, 0, 1, 1});
  TrackingError error(place.model, 0.0);
  error.add(nothing, 0.0, seen_at({9, 0, 1}, 1.0));
  EXPECT_TRUE(std::isnan(error.rms_position()));
  error.add(place, 0.0, seen_at({0.5, 0, 1}, 1.0));
  error.add(heading, 0.0, seen_at({9, 0, 1}, 0.25));
  EXPECT_NEAR(error.rms_position(), 0.5, 1e-12);
  EXPECT_NEAR(error.rms_heading(), 0.25, 1e-12);
}

}  // namespace
}  // namespace sightline
