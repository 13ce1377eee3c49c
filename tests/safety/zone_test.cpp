#include "sightline/safety/zone.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "cli/allocations.hpp"
#include "sightline/robots.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/random_zone.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::barrier;
using test::control_period;
using test::highest;
using test::lowest;
using test::random_zone;
using test::State;
using test::VehicleInput;

constexpr double lost_to_rows = 1e-3;  // [m] by which linear rows may miss a bound

bool piece_holds(const ForbiddenPiece& piece, const Vec3<double>& p, double margin) {
  return p.z > piece.low - margin && p.z < piece.high + margin &&
         std::all_of(piece.faces.begin(), piece.faces.end(), [&](const Face& face) {
           return face.n.x * p.x + face.n.y * p.y < face.offset + margin;
         });
}

bool any_piece_holds(const std::vector<ForbiddenPiece>& pieces, const Vec3<double>& p, double margin) {
  return std::any_of(pieces.begin(), pieces.end(),
                     [&](const auto& one) { return piece_holds(one, p, margin); });
}

Vec3<double> place_near_zones(Random& random) {
  return {uniform(random, -7, 7), uniform(random, -7, 7), uniform(random, -3, 5)};
}

TEST(Zone, ItsReserveHasTheSignOfItsSideAndChangesNoFasterThanThePlace) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Zone zone = random_zone(random);
    for (int k = 0; k < 40; ++k) {
      const Vec3<double> p = place_near_zones(random),
                         q = p + uniform(random, 0, 2) * test::any_direction(random, true);
      const bool within = test::winds_around(zone.polygon, {p.x, p.y}) && p.z > zone.from && p.z < zone.to;
      EXPECT_EQ(zone_reserve(zone, p) > 0, within == (zone.keep == Zone::Keep::inside)) << trial;
      EXPECT_LE(std::abs(zone_reserve(zone, p) - zone_reserve(zone, q)), norm(p - q) + 1e-12) << trial;
    }
  }
}

TEST(Zone, TheReserveOfABoxIsItsSignedDistance) {
  Random random(2);
  Zone zone{.polygon = {{-2, -1}, {-2, 1}, {2, 1}, {2, -1}}, .from = 0.0, .to = 3.0};
  for (int k = 0; k < 2000; ++k) {
    const Vec3<double> p = place_near_zones(random);
    const Vec3<double> q = {std::abs(p.x) - 2, std::abs(p.y) - 1, std::abs(p.z - 1.5) - 1.5},
                       out = {std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
    const double distance = norm(out) + std::min(std::max({q.x, q.y, q.z}), 0.0);
    zone.keep = Zone::Keep::outside;
    EXPECT_NEAR(zone_reserve(zone, p), distance, 1e-12);
    zone.keep = Zone::Keep::inside;
    EXPECT_NEAR(zone_reserve(zone, p), -distance, 1e-12);
  }
}

TEST(Zone, ItsPiecesAreTheForbiddenSpace) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Zone zone = random_zone(random);
    const std::vector<ForbiddenPiece> pieces = forbidden_pieces(zone);
    for (int k = 0; k < 100; ++k) {
      const Vec3<double> p = place_near_zones(random);
      const double reserve = zone_reserve(zone, p);
      if (reserve > 1e-8) {
        EXPECT_FALSE(any_piece_holds(pieces, p, -1e-9)) << trial;
      }
      if (reserve < -1e-8) {
        EXPECT_TRUE(any_piece_holds(pieces, p, 1e-9)) << trial;
      }
    }
  }
}

TEST(Zone, AMarginOfItsPiecesKeepsThatDistanceAndLittleMore) {
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const Zone zone = random_zone(random);
    const std::vector<ForbiddenPiece> pieces = forbidden_pieces(zone);
    const double margin = uniform(random, 0.05, 0.5);
    for (int k = 0; k < 100; ++k) {
      const Vec3<double> p = place_near_zones(random);
      const double reserve = zone_reserve(zone, p);
      if (reserve < margin - 1e-8) {
        EXPECT_TRUE(any_piece_holds(pieces, p, margin)) << trial;
      }
      // At a corner of a piece by sqrt(2), and at an upper or lower edge there by sqrt(3).
      if (reserve > std::sqrt(3.0) * margin + 1e-6) {
        EXPECT_FALSE(any_piece_holds(pieces, p, margin)) << trial;
      }
    }
  }
}

TEST(Zone, AConvexOneKeptOutsideIsOnePiece) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial)
    EXPECT_EQ(forbidden_pieces({.polygon = test::random_convex(random)}).size(), 1U);
}

TEST(Zone, OnTheGroundARoomHasNoFloorAndAForbiddenZoneItsOwn) {
  const Polygon box = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  const std::vector<Zone> zones = zones_to_land(
      {{.polygon = box, .from = 0.5, .to = 2.0, .keep = Zone::Keep::inside}, {.polygon = box, .from = 0.5}});
  EXPECT_EQ(zones[0].from, -infinity);
  EXPECT_EQ(zones[0].to, 2.0);
  EXPECT_EQ(zones[1].from, 0.5);
}

TEST(Zone, OneThatIsNoPrismIsRefused) {
  const auto refused = [](const Zone& zone) { return refusal_of([&] { barrier({.zones = {zone}}); }); };
  EXPECT_EQ(refused({.polygon = {{0, 0}, {1, 0}}}),
            "barrier: the polygon of a zone has 2 corners, expected at least 3 corners");
  EXPECT_EQ(refused({.polygon = {{0, 0}, {1, 0}, {1, 1}}, .from = 2, .to = 2}),
            "barrier: a zone from 2 to 2 m, expected from < to");
}

/// A flight under commands that do their worst.
struct ZoneFlight {
  double least = infinity;  // reserve of all zones, samples and between [m]
  int conflicts = 0;
};

Vec3<double> place_of(const State& x) { return {x[0], x[1], x[2]}; }

double least_reserve(const std::vector<Zone>& zones, const Vec3<double>& p) {
  double least = infinity;
  for (const Zone& zone : zones) least = std::min(least, zone_reserve(zone, p));
  return least;
}

/// @param goal  called at each period; a command straight at it, or at random without one
template <class Goal>
ZoneFlight fly_among(const Barrier& filter, State x, int periods, Random& random, Goal&& goal) {
  ZoneFlight flight;
  const std::vector<Zone>& zones = filter.options().zones;
  VehicleInput drawn{};
  for (int k = 0; k < periods; ++k) {
    if (k % 40 == 0) drawn = uniform_array<4>(random, -1, 1);
    const std::optional<Vec3<double>> to = goal(k);
    VehicleInput u = to ? test::towards(x, *to) : drawn;
    if (to) u[3] = drawn[3];
    flight.conflicts += filter.filter(x, {}, lowest, highest, u).conflict ? 1 : 0;
    test::fly(Multirotor{}, x, u, control_period, [&](const Vec3<double>& p, double) {
      flight.least = std::min(flight.least, least_reserve(zones, p));
    });
  }
  return flight;
}

/// At rest in any heading, at a place that keeps all zones and their margins.
State start_among(const Barrier& filter, Random& random, double reach) {
  for (;;) {
    const double psi = uniform(random, -std::numbers::pi, std::numbers::pi);
    const State x = {uniform(random, -reach, reach), uniform(random, -reach, reach),
                     uniform(random, 0.3, 3.0), std::cos(psi), std::sin(psi)};
    if (least_reserve(filter.options().zones, place_of(x)) > 0.1 + 2 * filter.options().wall_margin) return x;
  }
}

std::optional<Vec3<double>> at_random(int) { return std::nullopt; }

// Straight at its middle, past it, over it and at random, spinning.
TEST(Zone, AConvexOneIsNeverEnteredByAnyCommands) {
  Random random(6);
  int touched = 0;
  for (int trial = 0; trial < 120; ++trial) {
    Zone zone{.polygon = test::random_convex(random)};
    if (trial % 2 == 0) zone.to = uniform(random, 0.5, 2.0);
    const Barrier filter = barrier({.zones = {zone}});
    const State x = start_among(filter, random, 5.0);
    const Vec3<double> aside = {uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5), 0.0};
    const auto at_it = [&](int k) {
      const double side = k / 300 % 2 == 0 ? 1.0 : -1.0;
      return std::optional(Vec3<double>{side * aside.x, side * aside.y, k / 200 % 2 == 0 ? 0.2 : 1.5});
    };
    const ZoneFlight flight = trial % 3 == 0 ? fly_among(filter, x, 1500, random, at_random)
                                             : fly_among(filter, x, 1500, random, at_it);
    EXPECT_GE(flight.least, -lost_to_rows) << trial;
    EXPECT_EQ(flight.conflicts, 0) << trial;
    touched += flight.least < 0.05 ? 1 : 0;
  }
  EXPECT_GT(touched, 30);
}

// Each side alone: the wall of a convex room is a bound as that of the world.
TEST(Zone, AConvexRoomIsNotLeftThroughAnyOfItsSides) {
  Random random(7);
  for (int trial = 0; trial < 120; ++trial) {
    Polygon polygon = test::random_convex(random);
    for (Vec2<double>& p : polygon) p = {4 * p.x, 4 * p.y};
    const Barrier filter =
        barrier({.zones = {{.polygon = polygon, .from = 0.3, .to = 3.0, .keep = Zone::Keep::inside}}});
    const auto side = random() % polygon.size();
    const Vec2<double>&a = polygon[side], &b = polygon[(side + 1) % polygon.size()];
    const Vec2<double> amid = {0.5 * (a.x + b.x), 0.5 * (a.y + b.y)};
    // From the inside of the middle of a side, straight out through it.
    const double length = norm(b.x - a.x, b.y - a.y);
    const Vec2<double> out = {(b.y - a.y) / length, (a.x - b.x) / length};
    const State x = {amid.x - 0.3 * out.x, amid.y - 0.3 * out.y, 1.0, 0.6, 0.8};
    if (length < 1.0 || least_reserve(filter.options().zones, place_of(x)) < 0.29) continue;
    const auto beyond = [&](int k) {
      return std::optional(
          Vec3<double>{amid.x + 3 * out.x, amid.y + 3 * out.y, k / 200 % 2 == 0 ? 9.0 : -9.0});
    };
    const ZoneFlight flight = fly_among(filter, x, 600, random, beyond);
    EXPECT_GE(flight.least, -lost_to_rows) << trial;
    EXPECT_LE(flight.least, 0.02) << trial;
    EXPECT_EQ(flight.conflicts, 0) << trial;
  }
}

/// The law of several pieces: a flight without a conflict enters none. @return whether it is one
bool expect_kept_or_conflict(const ZoneFlight& flight, int trial) {
  if (flight.conflicts > 0) return false;
  EXPECT_GE(flight.least, -lost_to_rows) << trial;
  return true;
}

TEST(Zone, RoomsOfAnLAndAUAreKeptAroundTheirCorners) {
  Random random(8);
  int kept = 0, touched = 0;
  for (int trial = 0; trial < 80; ++trial) {
    const bool is_l = trial % 2 == 0;
    const Zone room{.polygon = is_l ? test::l_room : test::u_room, .to = 3.0, .keep = Zone::Keep::inside};
    const Barrier filter = barrier({.floor = 0.3, .wall_margin = 0.05, .zones = {room}});
    const State x = start_among(filter, random, 9.0);
    // Ends of the arms, and the pocket between them.
    const std::array<Vec3<double>, 3> goals =
        is_l ? std::array<Vec3<double>, 3>{{{9, 1, 1}, {5, 5, 2}, {1, 9, 1}}}
             : std::array<Vec3<double>, 3>{{{7.5, 9, 1}, {4.5, 5, 2}, {1.5, 9, 1}}};
    const auto goal = [&](int k) { return std::optional(goals[static_cast<std::size_t>(k / 500) % 3]); };
    const ZoneFlight flight = trial % 4 < 2 ? fly_among(filter, x, 3000, random, goal)
                                            : fly_among(filter, x, 3000, random, at_random);
    kept += expect_kept_or_conflict(flight, trial) ? 1 : 0;
    touched += flight.least < 0.1 ? 1 : 0;
  }
  EXPECT_GT(kept, 20);
  EXPECT_GT(touched, 30);
}

TEST(Zone, NonConvexOnesAndManyAtOnceAreKeptOutside) {
  Random random(9);
  int kept = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Zone> zones;
    if (trial % 2 == 0) {
      zones.push_back({.polygon = test::random_polygon(random, 4 + random() % 8, 4.0)});
    } else {
      for (int i = 0; i < 16; ++i) {
        Zone& zone = zones.emplace_back();
        const Vec2<double> at = {uniform(random, -8, 8), uniform(random, -8, 8)};
        for (const Vec2<double>& p : test::random_convex(random, 0.5))
          zone.polygon.push_back({at.x + p.x, at.y + p.y});
      }
    }
    const Barrier filter = barrier({.zones = zones});
    const State x = start_among(filter, random, 8.0);
    const auto goal = [&](int k) {
      const double angle = 2.4 * (k / 300);
      return std::optional(Vec3<double>{6 * std::cos(angle), 6 * std::sin(angle), 1.0});
    };
    const ZoneFlight flight = fly_among(filter, x, 2000, random, goal);
    kept += expect_kept_or_conflict(flight, trial) ? 1 : 0;
  }
  EXPECT_GT(kept, 10);
}

// The check of long periods is exact: nothing is lost to linear rows.
TEST(Zone, AConvexOneIsKeptBetweenSamplesAtEveryPeriod) {
  Random random(10);
  const Model robot = Multirotor{};
  for (int trial = 0; trial < 60; ++trial) {
    const double period = uniform(random, 0.02, Barrier::longest_period);
    const Zone zone{.polygon = test::random_convex(random)};
    const Barrier filter(robot, lowest, highest, period,
                         {.rate = std::min(4.0, 1.0 / period), .zones = {zone}});
    State x = start_among(filter, random, 5.0);
    const int parts = std::max(8, static_cast<int>(period / 0.005));
    for (int k = 0; k < static_cast<int>(12.0 / period); ++k) {
      VehicleInput u = test::towards(x, {0.0, 0.0, 1.0});
      if (trial % 2 == 0) u = uniform_array<4>(random, -1, 1);
      filter.filter(x, {}, lowest, highest, u);
      for (int part = 0; part < parts; ++part) {
        robot.step(x.data(), u.data(), period / parts);
        (void)robot.normalise(x.data());
        ASSERT_GE(zone_reserve(zone, place_of(x)), -1e-4) << trial << " at " << period << " s";
      }
    }
  }
}

TEST(Zone, ItsMarginIsKeptAboveItBelowItAndBesideIt) {
  const Zone zone{.polygon = {{-3, -3}, {3, -3}, {3, 3}, {-3, 3}}, .from = 2.0, .to = 3.0};
  const Barrier filter = barrier({.wall_margin = 0.1, .zones = {zone}});
  for (const double climb : {-1.0, 1.0}) {
    State x = {0.5, 0.2, climb < 0 ? 4.0 : 1.0, 1, 0, 0, 0};
    for (int k = 0; k < 500; ++k) {
      VehicleInput u = {0, 0, climb, 0};
      const BarrierResult result = filter.filter(x, {}, lowest, highest, u);
      EXPECT_FALSE(result.conflict);
      EXPECT_EQ(to_string(result.wall), "zone");
      test::fly(Multirotor{}, x, u, control_period, [](const Vec3<double>&, double) {});
    }
    EXPECT_NEAR(x[2], climb < 0 ? 3.1 : 1.9, 1e-3);
  }
  State x = {-6, 0, 2.5, 1, 0, 0, 0};
  for (int k = 0; k < 1500; ++k) {
    VehicleInput u = test::towards(x, {0, 0, 2.5});
    filter.filter(x, {}, lowest, highest, u);
    test::fly(Multirotor{}, x, u, control_period, [](const Vec3<double>&, double) {});
  }
  EXPECT_NEAR(x[0], -3.1, 5e-3);
}

TEST(Zone, ARobotThatClimbsLateStopsAboveIt) {
  const Model px4{VelocityMultirotor{}};
  const Zone zone{.polygon = {{-3, -3}, {3, -3}, {3, 3}, {-3, 3}}, .to = 1.0};
  const Barrier late(px4, px4.u_min(), px4.u_max(), control_period, {.zones = {zone}});
  std::vector<double> x(static_cast<std::size_t>(px4.nx())), u(4);
  px4.at_rest({{0, 0, 4.0}, {1, 0}}, x.data());
  for (int k = 0; k < 1500; ++k) {
    u = {0, 0, k / 100 % 3 == 2 ? 1.0 : -1.0, 0};
    EXPECT_FALSE(late.filter(x, {}, px4.u_min(), px4.u_max(), u).conflict);
    px4.step(x.data(), u.data(), control_period);
    EXPECT_GE(x[2], 1.0 - 1e-6) << k;
  }
}

TEST(Zone, ManyZonesAllocateNothingInAPeriod) {
  if (!cli::counts_allocations()) return;
  Random random(11);
  std::vector<Zone> zones;
  for (int i = 0; i < 16; ++i) zones.push_back(random_zone(random));
  const Barrier filter = barrier({.floor = 0.3, .ceiling = 3.0, .world = 9.0, .zones = zones});
  for (int k = 0; k < 200; ++k) {
    const Vec3<double> p = place_near_zones(random);
    const State x = {p.x, p.y, p.z, 1, 0, uniform(random, -2, 2), uniform(random, -2, 2)};
    std::array<Neighbour, 16> others;
    for (Neighbour& n : others) n.p = p + uniform(random, 0.5, 4) * test::any_direction(random, true);
    VehicleInput u = uniform_array<4>(random, -1, 1);
    const std::int64_t before = cli::allocations();
    filter.filter(x, others, lowest, highest, u);
    EXPECT_EQ(cli::allocations(), before);
    EXPECT_TRUE(all_finite(u));
  }
}

}  // namespace
}  // namespace sightline
