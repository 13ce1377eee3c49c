#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

using std::numbers::pi;

/// Of a vehicle of 2 kg with four rotors of 0.127 m, at the origin.
Jet jet_of(double thrust = 19.62) {
  return {.p = {}, .down = {0, 0, -1}, .thrust = thrust, .radius2 = 4 * square(0.127)};
}
double induced(const Jet& jet) { return std::sqrt(jet.thrust / (2 * Jet::air_density * pi * jet.radius2)); }
double speed(const Jet& jet, double r, double z) { return -jet.air({r, 0, -z}).z; }

TEST(Downwash, AtTheDiscTheAirHasTheInducedVelocityOfMomentumTheory) {
  for (const double thrust : {0.3, 5.0, 19.62, 100.0}) {
    const Jet jet = jet_of(thrust);
    EXPECT_NEAR(speed(jet, 0, 1e-12), induced(jet), 1e-9 * induced(jet));
  }
}

TEST(Downwash, WithoutGrowthItWouldReachTwiceThatSpeedAndWithItStaysBelow) {
  const Jet jet = jet_of();
  double most = 0.0;
  for (double z = 0.01; z < 20; z += 0.01) most = std::max(most, speed(jet, 0, z));
  EXPECT_LT(most, 2 * induced(jet));
  EXPECT_GT(most, 1.8 * induced(jet));
}

TEST(Downwash, TheFluxOfMomentumIsHalfTheThrustAtTheDiscAndAllOfItBelow) {
  for (const double thrust : {0.3, 19.62}) {
    const Jet jet = jet_of(thrust);
    for (const double z : {1e-9, 0.1, 0.25, 1.0, 3.0, 20.0}) {
      double flux = 0.0;
      const double reach = 4 * (std::sqrt(2 * jet.radius2) + Jet::growth * z), step = reach / 20'000;
      for (double r = 0.5 * step; r < reach; r += step)
        flux += Jet::air_density * square(speed(jet, r, z)) * 2 * pi * r * step;
      const double zeta = z / std::sqrt(jet.radius2 + z * z);
      EXPECT_NEAR(flux, 0.5 * thrust * (1 + zeta), 1e-5 * thrust) << z;
    }
  }
}

TEST(Downwash, FarBelowTheSpeedFallsWithTheDistanceAsInMeasuredRoundJets) {
  const Jet jet = jet_of();
  for (const double z : {10.0, 20.0, 40.0}) {
    EXPECT_NEAR(speed(jet, 0, 2 * z) / speed(jet, 0, z), 0.5, 0.02) << z;
    // U_0 / U_J = B d / z of a nozzle with this momentum; B = 5.8 to 6.1 is measured (Pope,
    // Turbulent Flows, 5.1).
    const double nozzle = std::numbers::sqrt2 * std::sqrt(jet.radius2);
    EXPECT_NEAR(speed(jet, 0, z) / (2 * induced(jet)) * z / nozzle, 6.0, 0.6) << z;
  }
  double before = speed(jet, 0, 1.0);
  for (double z = 1.2; z < 30; z += 0.2) {
    EXPECT_LT(speed(jet, 0, z), before);
    before = speed(jet, 0, z);
  }
}

TEST(Downwash, OffTheAxisItFallsAndTheJetWidensWithTheDistance) {
  const Jet jet = jet_of();
  double narrower = 0.0;
  for (const double z : {1.0, 2.0, 5.0, 10.0}) {
    double before = std::numeric_limits<double>::infinity(), half = 0.0;
    for (double r = 0.0; r < 3; r += 0.01) {
      const double w = speed(jet, r, z);
      EXPECT_TRUE(w < before || w == 0) << r;
      before = w;
      if (w > 0.5 * speed(jet, 0, z)) half = r;
    }
    EXPECT_GT(half, narrower);
    narrower = half;
  }
  EXPECT_NEAR(narrower, 0.094 * 10, 0.1) << "the measured half-width of a round jet, 0.094 z";
}

TEST(Downwash, TheSpeedGrowsWithTheRootOfTheThrustAndWithoutThrustNothingMoves) {
  EXPECT_NEAR(speed(jet_of(40), 0.2, 2), 2 * speed(jet_of(10), 0.2, 2), 1e-12);
  EXPECT_EQ(speed(jet_of(0), 0, 1), 0.0);
}

TEST(Downwash, ItGoesAgainstTheThrustAndIsTheSameAllAroundThatAxis) {
  Jet jet = jet_of();
  jet.p = {1, 2, 3};
  jet.down = {0.6, 0, -0.8};
  const Vec3<double> across = {0.8, 0, 0.6}, side = {0, 1, 0}, below = jet.p + 2.0 * jet.down;
  const Vec3<double> straight = jet.air(below);
  EXPECT_NEAR(norm(cross(straight, jet.down)), 0.0, 1e-12);
  for (double a = 0; a < 6; a += 0.5) {
    const Vec3<double> w = jet.air(below + (0.3 * std::cos(a)) * across + (0.3 * std::sin(a)) * side);
    EXPECT_NEAR(dot(w, jet.down), speed(jet_of(), 0.3, 2), 1e-12);
  }
}

TEST(Downwash, UnderAMovingDiscItStaysWhereTheDiscWasWhenTheAirLeftIt) {
  const Jet still = jet_of();
  Jet moving = jet_of();
  for (const double fast : {0.5, 1.5, 20.0}) {
    moving.v = {fast, -0.5, 0.2};
    for (const double z : {0.1, 0.5, 2.0}) {
      const Vec3<double> below = {0.1, 0.2, -z};
      const double age = z / speed(still, 0, z);
      const Vec3<double> left_behind = below - age * Vec3<double>{fast, -0.5, 0};
      EXPECT_NEAR(moving.air(left_behind).z, still.air(below).z, 1e-9 * norm(still.air(below))) << z;
      EXPECT_GE(norm(moving.air({-0.1, 0, -z})), norm(moving.air({0.1, 0, -z}))) << "it trails";
    }
  }
  moving.v = {0, 0, 3};
  EXPECT_NEAR(moving.air({0.1, 0.2, -1}).z, still.air({0.1, 0.2, -1}).z, 1e-12) << "not along its axis";
}

TEST(Downwash, ItIsSmoothAndBounded) {
  Jet jet = jet_of();
  jet.v = {1.0, 0.3, 0.0};
  const auto slope = [&](const Vec3<double>& at, const Vec3<double>& along, double step) {
    return (jet.air(at + step * along).z - jet.air(at - step * along).z) / (2 * step);
  };
  for (double x = -1.0; x <= 1.0; x += 0.1) {
    for (double z = 0.1; z <= 4.0; z += 0.3) {
      const Vec3<double> at = {x, 0.2, -z};
      EXPECT_LE(norm(jet.air(at)), 2 * induced(jet));
      for (const Vec3<double>& along : {Vec3<double>{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
        const double fine = slope(at, along, 1e-5);
        EXPECT_NEAR(fine, slope(at, along, 1e-4), 1e-3 * (1 + std::abs(fine))) << x << ' ' << z;
      }
    }
  }
}

TEST(Downwash, NothingMovesAboveTheDiscInItsPlaneFarAsideAndWhereANumberIsNotFinite) {
  const Jet jet = jet_of();
  constexpr double inf = std::numeric_limits<double>::infinity(),
                   nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vec3<double>& there : {Vec3<double>{0, 0, 0},
                                    {0, 0, 1},
                                    {0.5, 0, 0},
                                    {9, 0, -1},
                                    {0, 0, -inf},
                                    {0, 0, inf},
                                    {nan, 0, -1},
                                    {0, 0, nan},
                                    {inf, 0, -1},
                                    {0, 0, -1e200}}) {
    const Vec3<double> w = jet.air(there);
    EXPECT_EQ(norm(w), 0.0) << there.x << ' ' << there.z;
  }
  Jet lost = jet;
  lost.p.x = nan;
  EXPECT_EQ(norm(lost.air({0, 0, -1})), 0.0);
}

TEST(Downwash, ItsScaleIsFrom0To2) {
  for (const double scale : {0.0, 0.5, 1.0, 2.0}) EXPECT_NO_THROW(DownwashOptions{scale}.check());
  for (const double scale : {-0.1, 2.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(refusal_of([&] { DownwashOptions{scale}.check(); }), HasSubstr("expected 0 to 2"));
  EXPECT_EQ(DownwashOptions{}.scale, 0.0) << "off, where nothing is said";
}

}  // namespace
}  // namespace sightline
