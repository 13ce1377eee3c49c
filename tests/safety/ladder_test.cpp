#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "sightline/supervisor.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

using enum FallbackLevel;

constexpr LadderTimes ladder_times{};
constexpr FallbackLevel all_levels[] = {valid, predicted, slowed, hold, land, grounded};

TEST(Ladder, ADeviationAllowsThePlanOrHoldingOrLandingAlone) {
  const LadderSigmas sigmas{.hold = 0.5, .land = 1.5};
  EXPECT_EQ(level_at(sigmas, 0.0), valid);
  EXPECT_EQ(level_at(sigmas, 0.5), valid);
  EXPECT_EQ(level_at(sigmas, 0.51), hold);
  EXPECT_EQ(level_at(sigmas, 1.51), land);
  EXPECT_EQ(level_at(sigmas, std::nan("")), land);
  EXPECT_EQ(level_at(sigmas, std::numeric_limits<double>::infinity()), hold)
      << "there is none: its age decides";
  EXPECT_EQ(next_level(slowed, ladder_times, {.own = 0.4}, false, hold), hold);
  EXPECT_EQ(next_level(valid, ladder_times, {.own = 3.0}, false, hold), land);
  EXPECT_EQ(next_level(land, ladder_times, {}, false, valid), land);
}

// An age that asks for a level.
double age_for(FallbackLevel level) {
  switch (level) {
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
const std::set<std::pair<FallbackLevel, FallbackLevel>> edges = {
    {valid, predicted},  {valid, slowed},   {valid, hold},     {valid, land},     {predicted, valid},
    {predicted, slowed}, {predicted, hold}, {predicted, land}, {slowed, valid},   {slowed, predicted},
    {slowed, hold},      {slowed, land},    {hold, valid},     {hold, predicted}, {hold, slowed},
    {hold, land},        {land, grounded}};

TEST(Ladder, EachEdgeOfTheTableIsTakenWhenTheAgesAskForItAndNoOtherIs) {
  for (const FallbackLevel from : all_levels) {
    for (const FallbackLevel requested : all_levels) {
      if (requested == grounded) continue;
      const FallbackLevel to = next_level(from, ladder_times, {.own = age_for(requested)}, false);
      const bool edge = edges.contains({from, requested});
      EXPECT_EQ(to, edge ? requested : from) << to_string(from) << " asked for " << to_string(requested);
    }
  }
  EXPECT_EQ(next_level(land, ladder_times, {.own = 3.0}, true), grounded);
}

TEST(Ladder, NoSequenceOfAgesTakesAnEdgeThatIsNotInTheTable) {
  RandomStream chance(7, StreamId::gust, 0);
  std::set<std::pair<FallbackLevel, FallbackLevel>> seen;
  for (int flight = 0; flight < 3000; ++flight) {
    FallbackLevel level = valid;
    for (int k = 0; k < 40; ++k) {
      const auto age = [&] {
        const double draw = chance.uniform();
        return draw > 0.99 ? std::numeric_limits<double>::infinity() : 3.0 * std::pow(draw, 12);
      };
      const Ages ages{age(), age(), age()};
      const FallbackLevel next = next_level(level, ladder_times, ages, chance.uniform() < 0.3);
      if (next != level) {
        ASSERT_TRUE(edges.contains({level, next})) << to_string(level) << " to " << to_string(next);
        seen.insert({level, next});
      }
      level = next;
    }
  }
  EXPECT_EQ(seen, edges) << "each edge is met";
}

TEST(Ladder, TheLimitsThemselvesStillBelongToTheBetterRung) {
  EXPECT_EQ(level_at(ladder_times, ladder_times.fresh), valid);
  EXPECT_EQ(level_at(ladder_times, ladder_times.slow_after), predicted);
  EXPECT_EQ(level_at(ladder_times, ladder_times.hold_after), slowed);
  EXPECT_EQ(level_at(ladder_times, ladder_times.land_after), hold);
  for (const auto& [age, level] :
       {std::pair{0.021, predicted}, {0.201, slowed}, {0.501, hold}, {2.001, land}}) {
    EXPECT_EQ(level_at(ladder_times, age), level) << age;
  }
}

TEST(Ladder, TheWorstReasonDecides) {
  for (const FallbackLevel own : all_levels) {
    for (const FallbackLevel partners : all_levels) {
      for (const FallbackLevel plan : all_levels) {
        const FallbackLevel next =
            next_level(valid, ladder_times, {age_for(own), age_for(partners), age_for(plan)}, false);
        const auto of = [](FallbackLevel level) { return level == grounded ? land : level; };
        EXPECT_EQ(next, std::max({of(own), std::min(of(partners), hold), of(plan)}));
      }
    }
  }
}

TEST(Ladder, ARobotDoesNotLandBecauseOfItsPartners) {
  EXPECT_EQ(next_level(valid, ladder_times, {.partners = std::numeric_limits<double>::infinity()}, false),
            hold);
  EXPECT_EQ(next_level(hold, ladder_times, {.partners = 1e9}, true), hold);
}

TEST(Ladder, BlindForTooLongARobotLandsWhateverComesThen) {
  for (const FallbackLevel from : {land, grounded}) {
    EXPECT_EQ(next_level(from, ladder_times, {}, false), from);
  }
  EXPECT_EQ(next_level(grounded, ladder_times, {}, true), grounded);
}

TEST(Ladder, AnAgeThatIsNoNumberIsTheWorst) {
  EXPECT_EQ(next_level(valid, ladder_times, {.own = std::numeric_limits<double>::quiet_NaN()}, false), land);
}

}  // namespace
}  // namespace sightline
