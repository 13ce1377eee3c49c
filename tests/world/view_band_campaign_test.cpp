#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "sightline/estimator.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/potentials.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/team.hpp"
#include "sightline/world/sighting.hpp"
#include "sightline/world/view_flight.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/campaign.hpp"

/// Closed loop at a distance: a robot knows its place by the tags of one on a circle. A solver
/// keeps it there; the outcome is its view.
namespace sightline::test {
namespace {

/// The same figures as of fly_beside(), with the same camera, mount, tags, filter, speed and seed.
/// The distance is kept to within 5 cm.
ViewFigures fly_in_loop(const ViewFlight& view, double distance) {
  constexpr double dt = 0.01, from = 4.0, circle = 0.8, turning = 0.3;
  constexpr double gusts = 0.3;  // [m/s^2]
  const std::uint64_t seed = view.seed;
  RandomStream draw(seed, StreamId::draw, 1), reported(seed, StreamId::position_noise, 9),
      latency(seed, StreamId::latency, 9);
  const double turned = 2 * std::numbers::pi * draw.uniform(), rate = view.target_speed / circle;
  Team team;
  const AgentId self = team.add(Multirotor{}, {.R = {.1, .1, .1, .1}});
  const AgentId other = team.add(
      Multirotor{}, {.Q = {3, 3, 3, 2, 2, 0, 0}, .R = {.3, .3, .3, .3}, .x_ref = [rate, turned](double t) {
                       return std::array<double, 7>{circle * std::cos(rate * t),
                                                    circle * std::sin(rate * t),
                                                    1.2,
                                                    std::cos(turning * t + turned),
                                                    std::sin(turning * t + turned),
                                                    0.0,
                                                    0.0};
                     }});
  const Between pair{self, other};
  team.couple(4.0 * Bearing{.alpha = 0.5, .width = 0.1, .tilt = 0.2, .mount = view.mount}, pair,
              felt_by(self));
  team.couple(8.0 * TooNear{.d_min = distance - 0.05, .kappa = 20}, pair, felt_by(self));
  team.couple(8.0 * TooFar{.d_max = distance + 0.05, .kappa = 20}, pair, felt_by(self));
  team.couple(0.1 * RelativeVelocity{.v_0 = 1.0}, pair, felt_by(self));
  const double s = std::sin(view.mount.pitch), height = distance * s;
  const std::vector<double> x0 = {circle + std::sqrt(square(distance) - square(height)),
                                  0.0,
                                  1.2 + height,
                                  -1.0,
                                  0.0,
                                  0.0,
                                  0.0,
                                  circle,
                                  0.0,
                                  1.2,
                                  std::cos(turned),
                                  std::sin(turned),
                                  0.0,
                                  0.0};
  PlantOptions plant{.seed = seed};
  plant.disturbances.gust_sigma = gusts;
  ModelWorld world(team, x0, plant);
  CameraOptions options{.seed = seed};
  options.cameras.push_back({.observer = self, .mount = view.mount, .camera = view.camera});
  options.tags.push_back({other, view.tags});
  SyntheticDetections pictures(team, options);
  MotionSensor motion(view.filter, seed, self.index);
  const auto filter = make_pose_filter(view.filter, view.mount);
  NewtonRiccati solver(Ocp(team, {.T = 1.0, .N = 20, .dt = dt}));

  std::vector<double> u(8), rest(8), estimated;
  std::array<ExposedBody, 2> bodies;
  std::vector<std::pair<double, Measurement>> waiting;
  ViewFigures sum;
  long taken = 0, found = 0, periods = 0, known = 0, lost = 0;
  double next_picture = 0.0, last_seen = 0.0;
  bool is_lost = false;
  Vec2<double> roll_pitch{};
  for (long k = 0; k < std::lround(view.duration / dt); ++k) {
    const double t = static_cast<double>(k) * dt;
    const Measured now = world.measure(t);
    const auto sight = [&](BodyId body) {
      return team.model(body).sight(&now.truth[size(team.state_offset(body))], rest.data());
    };
    for (ExposedBody& body : bodies) body.before = body.now;
    const Sight<double> own = sight(self), seen = sight(other);
    bodies[0].now = {own.p, rotation(leaning(own.d, Vec2<double>{}))};
    bodies[1].now = {seen.p, rotation(leaning(seen.d, Vec2<double>{}))};
    if (k > 0) {
      const MotionSample m = motion.measure(t, dt, bodies[0].before.p, matrix(bodies[0].before.R),
                                            bodies[0].now.p, matrix(bodies[0].now.R));
      roll_pitch = {m.roll, m.pitch};
      filter->advance(m);
    }
    const bool counts = t >= from;
    if (k > 0 && t >= next_picture - 1e-9) {
      next_picture += 1 / view.camera.rate;
      std::array<Detection, 1> detection;
      const bool is_found = pictures.find({0, t, dt, bodies}, detection) > 0;
      const double late = 0.03 + 0.05 * latency.uniform();
      taken += counts, found += counts && is_found;
      if (is_found) {
        last_seen = t;
        detection[0].stamp = t;
        Measurement z = sighting_of(detection[0], view.mount, roll_pitch);
        z.p_other = seen.p + view.given_sigma * reported.normals();
        z.psi_other = wrap(std::atan2(seen.d.y, seen.d.x) + view.given_sigma * reported.normal());
        z.P_other = identity<4>(square(view.given_sigma));
        waiting.emplace_back(t + late, z);
      }
    }
    std::erase_if(waiting, [&](const auto& one) {
      if (one.first > t) return false;
      filter->take(one.second);
      return true;
    });
    // It begins with what it knows on the ground.
    if (k == 1) filter->start(own.p, std::atan2(own.d.y, own.d.x), identity<4>(1e-4));
    const PoseEstimate estimate = filter->estimate();
    if (estimate.known) {
      estimated.assign(now.truth.begin(), now.truth.end());
      estimated[0] = estimate.p.x, estimated[1] = estimate.p.y, estimated[2] = estimate.p.z;
      estimated[3] = std::cos(estimate.psi), estimated[4] = std::sin(estimate.psi);
      const Solution solution = solver.solve(t, estimated);
      std::copy(solution.u.begin(), solution.u.end(), u.begin());
    }
    if (counts) {
      ++periods;
      const bool now_lost = t - last_seen > ViewFlight::loss;
      sum.losses += now_lost && !is_lost;
      lost += now_lost;
      is_lost = now_lost;
      if (estimate.known) {
        const Vec3<double> e = estimate.p - own.p;
        sum.error += dot(e, e), sum.sigma += square(estimate.position_sigma());
        ++known;
      }
    } else {
      last_seen = std::max(last_seen, t - ViewFlight::loss);
    }
    (void)test::apply(world, t, now.measured, u, dt, 1);
  }
  sum.found = static_cast<double>(found) / static_cast<double>(taken);
  sum.known = static_cast<double>(known) / static_cast<double>(periods);
  sum.lost = static_cast<double>(lost) / static_cast<double>(periods);
  sum.losses *= 60.0 / (static_cast<double>(periods) * dt);
  sum.error = std::sqrt(sum.error / static_cast<double>(known));
  sum.sigma = std::sqrt(sum.sigma / static_cast<double>(known));
  return sum;
}

}  // namespace
}  // namespace sightline::test

namespace sightline {
namespace {

/// Whether one is at most so many times the other.
void expect_within(double received, double flown, double factor, std::string_view what, double distance) {
  EXPECT_LE(received, factor * flown) << what << " at " << distance;
  EXPECT_LE(flown, factor * received) << what << " at " << distance;
}

/// fly_beside() against a closed loop with its solver, latencies and gusts.
TEST(ViewFlight, WhatIsToldOfADistanceIsWhatAHundredFlightsShow) {
  constexpr int flights = 100;
  const std::vector<double> distances =
      whole_campaign() ? std::vector{1.0, 1.5, 2.0, 2.5, 2.75, 3.0} : std::vector{1.5, 2.75};
  fmt::print("camera  distance  found          error             view lost\n");
  for (const MountFrame frame : {MountFrame::level, MountFrame::body}) {
    for (const double distance : distances) {
      const ViewFlight view{.mount = {.frame = frame}, .target_speed = 0.5};
      const ViewFigures received = mean_figures(view, distance, flights),
                        flown = mean_figures(view, distance, flights, test::fly_in_loop);
      fmt::print("{}   {:.2f} m  {:3.0f} %, {:3.0f} %  {:4.1f} mm, {:4.1f} mm  {:4.1f}, {:4.1f} a minute\n",
                 frame == MountFrame::level ? "level" : "body ", distance, 100 * received.found,
                 100 * flown.found, 1e3 * received.sigma, 1e3 * flown.error, received.losses, flown.losses);
      expect_within(received.sigma, flown.error, 1.3, "error", distance);
      if (received.losses > 1.0) {
        expect_within(received.losses, flown.losses, 1.3, "losses", distance);
      }
      if (received.losses < 0.1) {
        EXPECT_LE(flown.losses, 1.0) << distance;
      }
    }
  }
}

}  // namespace
}  // namespace sightline
