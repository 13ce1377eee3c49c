#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

const Coupling* coupling_of(const Team& team, std::string_view name) {
  for (const Coupling& c : team.couplings()) {
    if (c.name == name) return &c;
  }
  return nullptr;
}

TEST(RetuneTerm, ARetunedWeightGoesOverWithoutAStep) {
  ActiveTeam active_team(event_team(2));
  EXPECT_THAT(active_team.apply(RetuneTerm{.name = "sees1", .weight = 1.2}, 5.0, 2.0), IsEmpty());
  for (const double t : {5.0, 5.5, 6.0, 6.999}) {
    double weight = 0.0;
    const Team team = active_team.team(t);
    for (const Coupling& c : team.couplings()) {
      if (c.term.potential.as<SensorCone>() != nullptr) weight += c.term.weight * c.ramp.at(t);
    }
    EXPECT_NEAR(weight, (Ramp{5.0, 2.0, 0.4, 1.2}.at(t)), 1e-12) << t;
  }
  const Team after = active_team.team(7.0);
  EXPECT_EQ(after.couplings().size(), 3U);
  ASSERT_NE(coupling_of(after, "sees1"), nullptr);
  EXPECT_EQ(coupling_of(after, "sees1")->term.weight, 1.2);
  EXPECT_EQ(coupling_of(after, "sees1")->ramp, Ramp{});
}

TEST(RetuneTerm, AWeightThatIsRetunedOnItsWayGoesOnFromWhereItIs) {
  ActiveTeam active_team(event_team(2));
  EXPECT_THAT(active_team.apply(RetuneTerm{.name = "sees1", .weight = 0.0}, 0.0, 1.0), IsEmpty());
  EXPECT_THAT(active_team.apply(RetuneTerm{.name = "sees1", .weight = 0.4}, 0.5, 1.0), IsEmpty());
  double weight = 0.0;
  const Team team = active_team.team(0.5);
  for (const Coupling& c : team.couplings()) {
    if (c.term.potential.as<SensorCone>() != nullptr) weight += c.term.weight * c.ramp.at(0.5);
  }
  EXPECT_NEAR(weight, 0.2, 1e-12);
}

}  // namespace
}  // namespace sightline
