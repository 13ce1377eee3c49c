#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "sightline/sensors.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::two_robots;

/// Robot a at the origin looks along x at robot b and, where it is asked for, past an obstacle.
struct Scene {
  Team team = two_robots();
  CameraOptions options{};
  std::vector<ExposedBody> bodies;

  Scene() {
    team.add(Obstacle{"pillar"});
    options.cameras = {{.observer = BodyId{0}, .mount = {.pitch = 0.0, .offset = 0.0}}};
    options.tags = {{BodyId{1}, {}}};
    bodies.resize(3);
    bodies[2].now.p = {50, 50, 0};
    place({1.5, 0, 0}, 0.5);
  }
  /// @param yaw  from showing its first face to the camera [rad]
  void place(const Vec3<double>& p, double yaw) {
    bodies[1].now = bodies[1].before = {p, turn_by({0, 0, std::numbers::pi + yaw})};
  }
  Camera& camera() { return options.cameras[0].camera; }
  RigidPose truth() const {
    return seen_from(sensor_pose(options.cameras[0].mount, bodies[0].now), bodies[1].now);
  }

  std::vector<Detection> look(int pictures) {
    SyntheticDetections source(team, options);
    std::vector<Detection> all, found(1);
    for (int k = 0; k < pictures; ++k) {
      if (source.find({0, 0.03 * k, 0.0, bodies}, found) == 1) all.push_back(found[0]);
    }
    return all;
  }
};

/// Errors that the covariance speaks of: the truth after what is said.
std::array<double, 6> errors(const Detection& seen, const RigidPose& truth) {
  const Vec3<double> dp = truth.p - seen.p;
  const Quaternion q = quaternion(compose(truth.R, between(rotation(seen.q), Rotation{})));
  return {dp.x, dp.y, dp.z, 2 * q.x, 2 * q.y, 2 * q.z};
}

double turn_of(const std::array<double, 6>& e) {
  return std::sqrt(square(e[3]) + square(e[4]) + square(e[5]));
}

TEST(SyntheticDetections, TheirErrorsHaveTheCovarianceThatTheySay) {
  for (const double d : {0.8, 1.5, 2.5}) {
    for (const double yaw : {0.5, 0.78}) {
      Scene scene;
      scene.place({d, 0.1, -0.05}, yaw);
      const std::vector<Detection> seen = scene.look(4000);
      ASSERT_GT(seen.size(), 500U) << d << " m, " << yaw;
      // Pictures of one and of two tags have covariances of their own.
      for (int tags = 1; tags <= 2; ++tags) {
        std::array<double, 6> mean{}, squares{};
        double count = 0;
        for (const Detection& one : seen) {
          if (one.tags != tags) continue;
          const std::array<double, 6> e = errors(one, scene.truth());
          for (std::size_t i = 0; i < 6; ++i) {
            const double by_sigma = e[i] / std::sqrt(one.covariance[Detection::place(i, i)]);
            mean[i] += by_sigma, squares[i] += by_sigma * by_sigma;
          }
          ++count;
        }
        if (count < 500) continue;
        for (std::size_t i = 0; i < 6; ++i) {
          EXPECT_NEAR(mean[i] / count, 0.0, 4.5 / std::sqrt(count)) << d << " " << yaw << " " << i;
          EXPECT_NEAR(squares[i] / count, 1.0, 4.5 * std::sqrt(2 / count)) << d << " " << yaw << " " << i;
        }
      }
    }
  }
}

TEST(SyntheticDetections, AreFoundAsOftenAsTheModelSays) {
  for (const double d : {2.2, 2.6, 3.0}) {
    Scene scene;
    scene.place({d, 0, 0}, 0.0);  // one face ahead, the others beyond 75 degrees
    const double n = scene.camera().pixels(0.2, d - 0.132);
    const double p = SyntheticDetections::probability(n, 1.0, 0.0);
    constexpr double pictures = 4000;
    EXPECT_NEAR(static_cast<double>(scene.look(4000).size()) / pictures, p,
                4.5 * std::sqrt(p * (1 - p) / pictures))
        << d;
  }
  EXPECT_NEAR(SyntheticDetections::probability(SyntheticDetections::half_found, 1.0, 0.0), 0.495, 1e-12);
  EXPECT_NEAR(SyntheticDetections::probability(20.0, 1.0, 2.0), 0.495, 1e-12) << "smeared";
  EXPECT_EQ(SyntheticDetections::probability(100.0, std::cos(1.31), 0.0), 0.0) << "from the side";
}

TEST(SyntheticDetections, WhatIsOutOfThePictureOrBehindOrHiddenIsNotSeen) {
  const auto seen = [](const auto& change) {
    Scene scene;
    change(scene);
    return scene.look(200).size();
  };
  EXPECT_GT(seen([](Scene&) {}), 190U);
  EXPECT_EQ(seen([](Scene& s) { s.place({-1.5, 0, 0}, 0.5); }), 0U) << "behind";
  EXPECT_EQ(seen([](Scene& s) { s.place({1.5, 1.3, 0}, 0.5); }), 0U) << "beside the picture";
  EXPECT_EQ(seen([](Scene& s) { s.place({12, 0, 0}, 0.5); }), 0U) << "too far";
  EXPECT_EQ(seen([](Scene& s) { s.bodies[1].there = false; }), 0U) << "gone";
  EXPECT_EQ(seen([](Scene& s) { s.options.tags[0].body = BodyId{0}; }), 0U) << "itself";

  const auto pillar = [&](double y) {
    return seen([&](Scene& s) {
      s.options.hulls = {{BodyId{2}, {.radius = 0.2, .height = 2.0}}};
      s.bodies[2].now.p = {0.8, y, 0};
    });
  };
  EXPECT_EQ(pillar(0.0), 0U);
  EXPECT_EQ(pillar(0.2), 0U) << "part of the tag";
  EXPECT_GT(pillar(0.6), 190U) << "beside the way";
  EXPECT_GT(seen([](Scene& s) {
              s.options.hulls = {{BodyId{2}, {.radius = 0.2}}};
              s.bodies[2].now.p = {0.8, 0, 0};
              s.bodies[2].there = false;
            }),
            190U)
      << "what is not there hides nothing";
  EXPECT_GT(seen([](Scene& s) {
              s.options.hulls = {{BodyId{0}, {.radius = 0.3}}, {BodyId{1}, {.radius = 0.3}}};
            }),
            190U)
      << "nor do the two themselves";
}

TEST(SyntheticDetections, ASmallTagSeenFromAheadIsMistakenForItsMirrorImage) {
  Scene scene;
  scene.place({2.6, 0, 0}, 0.2);
  const std::vector<Detection> seen = scene.look(4000);
  const auto wrong = std::count_if(seen.begin(), seen.end(), [&](const Detection& one) {
    return std::abs(errors(one, scene.truth())[5] - 0.4) < std::abs(errors(one, scene.truth())[5]);
  });
  EXPECT_GT(static_cast<double>(wrong) / static_cast<double>(seen.size()), 0.15);
  EXPECT_EQ(SyntheticDetections::mirror_share(15, 1.0), 0.35);
  EXPECT_EQ(SyntheticDetections::mirror_share(20, 1.0), 0.2);
  EXPECT_EQ(SyntheticDetections::mirror_share(23, 1.0), 0.0);
  EXPECT_EQ(SyntheticDetections::mirror_share(15, std::cos(0.5)), 0.0) << "from above, or from the side";

  // From above, the mirror image leans: the observer knows which way is up.
  Scene above;
  above.bodies[0].now.R = above.bodies[0].before.R = turn_by({0, 0.25, 0});
  above.place({2.6, 0, -0.66}, 0.2);
  for (const Detection& one : above.look(1000)) EXPECT_LT(turn_of(errors(one, above.truth())), 0.45);
}

TEST(SyntheticDetections, OutliersAndFlipsHaveTheirShares) {
  Scene scene;
  scene.camera().outliers = 0.1;
  scene.camera().flips = 0.2;
  const std::vector<Detection> seen = scene.look(4000);
  double elsewhere = 0, turned = 0;
  for (const Detection& one : seen) {
    const std::array<double, 6> e = errors(one, scene.truth());
    if (std::hypot(e[0], e[1], e[2]) > 0.1) {
      ++elsewhere;
    } else if (std::abs(e[5]) > 0.25) {
      ++turned;
    }
  }
  const auto count = static_cast<double>(seen.size());
  EXPECT_NEAR(elsewhere / count, 0.1, 0.02);
  EXPECT_NEAR(turned / count, 0.9 * 0.2, 0.03);
}

TEST(SyntheticDetections, AMisalignedCameraSeesAtAnAngleThatItDoesNotTell) {
  Scene scene;
  scene.camera().misalignment = 0.035;
  const std::vector<Detection> seen = scene.look(2000);
  std::array<double, 3> mean{};
  for (const Detection& one : seen) {
    const std::array<double, 6> e = errors(one, scene.truth());
    for (std::size_t i = 0; i < 3; ++i) mean[i] += e[i] / static_cast<double>(seen.size());
  }
  const Vec3<double> p = scene.truth().p, other = drawn_misalignments(scene.options)[0].to_B(p);
  EXPECT_NEAR(mean[1], p.y - other.y, 0.002);
  EXPECT_NEAR(mean[2], p.z - other.z, 0.002);
  EXPECT_GT(std::hypot(mean[1], mean[2]), 0.005);
}

TEST(SyntheticDetections, TheSameSeedDrawsTheSameBytesAndWhatHappensElsewhereChangesNone) {
  Scene scene;
  const std::vector<Detection> seen = scene.look(50), again = scene.look(50);
  ASSERT_EQ(seen.size(), again.size());
  for (std::size_t k = 0; k < seen.size(); ++k) {
    EXPECT_EQ(seen[k].p.x, again[k].p.x);
    EXPECT_EQ(seen[k].q, again[k].q);
    EXPECT_EQ(seen[k].covariance, again[k].covariance);
  }
  Scene other;
  other.options.seed = 2;
  EXPECT_NE(other.look(50)[0].p.x, seen[0].p.x);
  // One more body with tags, and a robot that hides the first for a while: what is drawn of the
  // first stays.
  Scene more;
  more.options.tags.insert(more.options.tags.begin(), {BodyId{2}, {}});
  SyntheticDetections source(more.team, more.options);
  std::vector<Detection> found(2);
  for (int k = 0; k < 20; ++k) {
    more.bodies[1].there = k % 2 == 0;
    if (source.find({0, 0.03 * k, 0.0, more.bodies}, found) == 0) continue;
    EXPECT_TRUE(
        std::any_of(seen.begin(), seen.end(), [&](const Detection& one) { return one.p.x == found[0].p.x; }));
  }
}

/// Errors of a detection in standard deviations along the axes of its covariance, L^-1 e.
Column<6> standardised(const Detection& seen, const RigidPose& truth) {
  const std::array<double, 6> e = errors(seen, truth);
  Column<6> error;
  Mat<6, 6> covariance;
  for (int i = 0; i < 6; ++i) {
    error(i, 0) = e[size(i)];
    for (int j = 0; j < 6; ++j) covariance(i, j) = seen.covariance[Detection::place(size(i), size(j))];
  }
  return Cholesky<6>(covariance).forward(error);
}

TEST(SyntheticDetections, TheirErrorsHaveTheStatedAutocorrelationAtIrregularTimesForEachBodyAndAxisAlone) {
  constexpr double time = 2.0;  // [s]
  constexpr std::array at = {0.0, 0.031, 0.2, 0.5, 1.7, 4.9};
  constexpr int seeds = 1500, bodies = 2;
  using Errors = std::array<std::array<std::optional<Column<6>>, at.size()>, bodies>;
  std::vector<Errors> drawn(seeds);
  for (int seed = 0; seed < seeds; ++seed) {
    Scene scene;
    scene.place({1.0, -0.25, 0}, 0.5);
    scene.bodies[2].now = scene.bodies[2].before = {{1.0, 0.25, 0}, scene.bodies[1].now.R};
    scene.options.tags.push_back({BodyId{2}, {}});
    scene.options.seed = static_cast<std::uint64_t>(seed);
    scene.camera().correlation_time = time;
    SyntheticDetections source(scene.team, scene.options);
    std::vector<Detection> found(bodies);
    for (std::size_t k = 0; k < at.size(); ++k) {
      const std::size_t count = source.find({0, at[k], 0.0, scene.bodies}, found);
      for (std::size_t i = 0; i < count; ++i) {
        const int body = found[i].target.index;
        const RigidPose truth = seen_from(sensor_pose(scene.options.cameras[0].mount, scene.bodies[0].now),
                                          scene.bodies[size(body)].now);
        drawn[size(seed)][size(body - 1)][k] = standardised(found[i], truth);
      }
    }
  }
  // Mean product of component i of one body and j of another at other times, and its standard
  // deviation for independent normal numbers.
  const auto expect_mean = [&](std::size_t a, std::size_t b, std::size_t j, std::size_t k, int shift,
                               double expected) {
    double sum = 0.0;
    long count = 0;
    for (const Errors& one : drawn) {
      if (!one[a][j] || !one[b][k]) continue;
      for (int i = 0; i < 6; ++i) sum += (*one[a][j])(i, 0) * (*one[b][k])((i + shift) % 6, 0);
      count += 6;
    }
    ASSERT_GT(count, 5 * seeds);
    const double n = static_cast<double>(count);
    EXPECT_NEAR(sum / n, expected, 4.5 * std::sqrt((1 + square(expected)) / n))
        << at[j] << " s, " << at[k] << " s";
  };
  for (std::size_t j = 0; j < at.size(); ++j) {
    for (std::size_t k = j; k < at.size(); ++k) {
      for (const std::size_t body : {0U, 1U})
        expect_mean(body, body, j, k, 0, std::exp(-(at[k] - at[j]) / time));
      expect_mean(0, 0, j, k, 1, 0.0);
      expect_mean(0, 1, j, k, 0, 0.0);
    }
  }
}

}  // namespace
}  // namespace sightline
