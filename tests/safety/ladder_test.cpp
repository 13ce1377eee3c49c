#include "sightline/safety/ladder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "sightline/world/disturbance.hpp"

namespace sightline {
namespace {

using enum Rung;

constexpr LadderTimes times{};
constexpr Rung all[] = {valid, predicted, slowed, hold, land, grounded};

// An age that asks for a rung.
double age_for(Rung rung) {
  switch (rung) {
    case valid:
      return 0.0;
    case predicted:
      return 0.1;
    case slowed:
      return 0.4;
    case hold:
      return 1.0;
    default:
      return 3.0;
  }
}

// The table of ladder.hpp.
const std::set<std::pair<Rung, Rung>> edges = {
    {valid, predicted},  {valid, slowed},   {valid, hold},     {valid, land},     {predicted, valid},
    {predicted, slowed}, {predicted, hold}, {predicted, land}, {slowed, valid},   {slowed, predicted},
    {slowed, hold},      {slowed, land},    {hold, valid},     {hold, predicted}, {hold, slowed},
    {hold, land},        {land, grounded}};

TEST(Ladder, EachEdgeOfTheTableIsTakenWhenTheAgesAskForItAndNoOtherIs) {
  for (const Rung from : all) {
    for (const Rung asked : all) {
      if (asked == grounded) continue;
      const Rung to = next_rung(from, times, {.own = age_for(asked)}, false);
      const bool edge = edges.contains({from, asked});
      EXPECT_EQ(to, edge ? asked : from) << to_string(from) << " asked for " << to_string(asked);
    }
  }
  EXPECT_EQ(next_rung(land, times, {.own = 3.0}, true), grounded);
}

TEST(Ladder, NoSequenceOfAgesTakesAnEdgeThatIsNotInTheTable) {
  RandomStream chance(7, Chance::gust, 0);
  std::set<std::pair<Rung, Rung>> seen;
  for (int flight = 0; flight < 3000; ++flight) {
    Rung rung = valid;
    for (int k = 0; k < 40; ++k) {
      const auto age = [&] {
        const double draw = chance.uniform();
        return draw > 0.99 ? std::numeric_limits<double>::infinity() : 3.0 * std::pow(draw, 12);
      };
      const Ages ages{age(), age(), age()};
      const Rung next = next_rung(rung, times, ages, chance.uniform() < 0.3);
      if (next != rung) {
        ASSERT_TRUE(edges.contains({rung, next})) << to_string(rung) << " to " << to_string(next);
        seen.insert({rung, next});
      }
      rung = next;
    }
  }
  EXPECT_EQ(seen, edges) << "each edge is met";
}

TEST(Ladder, TheLimitsThemselvesStillBelongToTheBetterRung) {
  EXPECT_EQ(rung_at(times, times.fresh), valid);
  EXPECT_EQ(rung_at(times, times.slow_after), predicted);
  EXPECT_EQ(rung_at(times, times.hold_after), slowed);
  EXPECT_EQ(rung_at(times, times.land_after), hold);
  for (const auto& [age, rung] :
       {std::pair{0.021, predicted}, {0.201, slowed}, {0.501, hold}, {2.001, land}}) {
    EXPECT_EQ(rung_at(times, age), rung) << age;
  }
}

TEST(Ladder, TheWorstReasonDecides) {
  for (const Rung own : all) {
    for (const Rung partners : all) {
      for (const Rung plan : all) {
        const Rung next = next_rung(valid, times, {age_for(own), age_for(partners), age_for(plan)}, false);
        const auto of = [](Rung rung) { return rung == grounded ? land : rung; };
        EXPECT_EQ(next, std::max({of(own), std::min(of(partners), hold), of(plan)}));
      }
    }
  }
}

TEST(Ladder, ARobotDoesNotLandBecauseOfItsPartners) {
  EXPECT_EQ(next_rung(valid, times, {.partners = std::numeric_limits<double>::infinity()}, false), hold);
  EXPECT_EQ(next_rung(hold, times, {.partners = 1e9}, true), hold);
}

TEST(Ladder, BlindForTooLongARobotLandsWhateverComesThen) {
  for (const Rung from : {land, grounded}) {
    EXPECT_EQ(next_rung(from, times, {}, false), from);
  }
  EXPECT_EQ(next_rung(grounded, times, {}, true), grounded);
}

TEST(Ladder, AnAgeThatIsNoNumberIsTheWorst) {
  EXPECT_EQ(next_rung(valid, times, {.own = std::numeric_limits<double>::quiet_NaN()}, false), land);
}

}  // namespace
}  // namespace sightline
