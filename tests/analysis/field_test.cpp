#include "sightline/analysis/field.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <numbers>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

Station random_station(Random& random) {
  return {random_point(random, 2.0), random_point(random, 2.0), uniform(random, -3, 3),
          uniform(random, -3, 3)};
}

std::vector<Potential> potentials() {
  return {SensorCone{}, KeepOut{}, Cohesion{},
          Region(all_of({"bearing < 20 deg", "0.3 m < range < 6 m"})).slope(Softplus{}).sigmoid(5.0)};
}

/// dl by one of the five variables, and the gradient's own change by it.
double& variable(Station& s, int i) {
  return i == 0 ? s.target.x : i == 1 ? s.target.y : i == 2 ? s.target.z : i == 3 ? s.psi : s.psi_target;
}

double difference(Station s, int i, const std::function<double(const Station&)>& f) {
  constexpr double h = 1e-3;
  const auto at = [&](double step) {
    Station there = s;
    variable(there, i) += step;
    return f(there);
  };
  return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
}

TEST(Field, IsWorthWhatItsPotentialIs) {
  Random random(1);
  for (const Potential& p : potentials()) {
    const Field field(p);
    std::vector<Station> stations;
    for (int n = 0; n < 1000; ++n) stations.push_back(random_station(random));
    const auto values = field(stations);
    for (std::size_t k = 0; k < stations.size(); ++k) {
      const double l = p(observer_of(stations[k]), target_of(stations[k]), 0.0);
      ASSERT_NEAR(values[k].l, l, 1e-12 * (1 + std::fabs(l))) << p.name();
      ASSERT_NEAR(field(stations[k]).l, l, 1e-12 * (1 + std::fabs(l))) << p.name();
    }
  }
}

TEST(Field, HasTheDerivativesOfDifferencesByPositionAndHeadings) {
  Random random(2);
  for (const Potential& p : potentials()) {
    const Field field(p);
    for (int n = 0; n < 200; ++n) {
      const Station s = random_station(random);
      const FieldValue f = field(s);
      for (int i = 0; i < FieldValue::variables; ++i) {
        const double first = difference(s, i, [&](const Station& at) { return field(at).l; });
        ASSERT_NEAR(f.first[static_cast<std::size_t>(i)], first, 1e-6 * (1 + std::fabs(first)))
            << p.name() << i;
        for (int j = i; j < FieldValue::variables; ++j) {
          const double second = difference(
              s, j, [&](const Station& at) { return field(at).first[static_cast<std::size_t>(i)]; });
          ASSERT_NEAR(f.at(i, j), second, 1e-5 * (1 + std::fabs(second))) << p.name() << i << j;
          ASSERT_EQ(f.at(i, j), f.at(j, i));
        }
      }
    }
  }
}

TEST(Field, OfATermThatIsTurnedIsThatOfTheBodiesExchanged) {
  Random random(3);
  const Field straight(SensorCone{}), turned(std::vector{FieldTerm{1.0 * SensorCone{}, true}});
  for (int n = 0; n < 200; ++n) {
    const Station s = random_station(random), exchanged = {s.target, s.observer, s.psi_target, s.psi};
    EXPECT_NEAR(turned(s).l, straight(exchanged).l, 1e-12);
  }
}

TEST(Field, IsTheWeightedSumOfItsTerms) {
  Random random(4);
  const Field sum(std::vector{FieldTerm{0.4 * KeepOut{}}, FieldTerm{0.7 * Cohesion{}}});
  const Field first(KeepOut{}), second(Cohesion{});
  for (int n = 0; n < 200; ++n) {
    const Station s = random_station(random);
    EXPECT_NEAR(sum(s).l, 0.4 * first(s).l + 0.7 * second(s).l, 1e-12);
  }
}

TEST(Field, KnowsWhetherTheHeadingMatters) {
  EXPECT_TRUE(Field(SensorCone{}).sees_heading());
  EXPECT_FALSE(Field(KeepOut{}).sees_heading());
  EXPECT_TRUE(Field(Region("azimuth < 1 rad")).sees_heading());
  EXPECT_FALSE(Field(Region("distance < 1 m")).sees_heading());
}

TEST(Station, OfAPlaceInTheSensorFrameIsSeenThere) {
  Random random(5);
  for (int n = 0; n < 1000; ++n) {
    const SensorMount mount = {uniform(random, -1.5, 1.5), uniform(random, -1, 1)};
    const Vec3<double> p_S = random_point(random, 5.0);
    for (const SensorMount* m : {&mount, static_cast<const SensorMount*>(nullptr)}) {
      EXPECT_LE(norm(in_sensor_frame(seen_at(p_S, m), m) - p_S), 1e-12);
    }
  }
}

TEST(Eigenvalues, AreThoseOfEigen) {
  Random random(6);
  for (int n = 0; n < 1000; ++n) {
    const auto m = uniform_array<6>(random, -3, 3);
    Eigen::Matrix3d full;
    full << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5];
    const Eigen::Vector3d expected = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(full).eigenvalues();
    const auto found = eigenvalues(m);
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(found[static_cast<std::size_t>(i)], expected[i], 1e-7);
  }
  EXPECT_EQ(eigenvalues({2, 0, 0, 2, 0, 2}), (std::array<double, 3>{2, 2, 2}));
}

/// Least where the target is 1.5 m ahead of the observer, 0.5 m to its left, and level.
struct Bowl {
  template <class S>
  S operator()(const Sight<S>& observer, const Sight<S>& target) const {
    const Vec3<S> p = SensorMount{0.0, 0.0}(observer, target.p);
    return square(p.x - 1.5) + 2.0 * square(p.y - 0.5) + exp(p.z) + exp(-p.z);
  }
};

TEST(Descend, EndsInTheMinimum) {
  Random random(7);
  const Field field{Bowl{}};
  constexpr std::array position = {0, 1, 2};
  for (int n = 0; n < 50; ++n) {
    Station start = random_station(random);
    start.observer = {};
    const Rest rest = descend(field, start, position);
    EXPECT_TRUE(rest.is_minimum);
    EXPECT_NEAR(rest.l, 2.0, 1e-9);
    EXPECT_EQ(rest.station.psi, start.psi) << "what is not free stays";
    EXPECT_LE(norm(in_sensor_frame(rest.station, nullptr) - Vec3<double>{1.5, 0.5, 0.0}), 1e-6);
  }
}

TEST(Descend, DoesNotCallASlopeAMinimum) {
  constexpr std::array along = {0};
  EXPECT_FALSE(descend(Field{KeepOut{.kappa_G = 0.0}}, {.target = {0.9, 0, 0}}, along).station.target.x <
               0.9);
  EXPECT_FALSE(
      descend(Field{Region("x < -1e9 m").slope(Softplus{})}, {.target = {1, 0, 0}}, along).is_minimum);
}

}  // namespace
}  // namespace sightline
