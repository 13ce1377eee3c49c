#include "sightline/world/view_flight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"
#include "sightline/sensors.hpp"
#include "sightline/world/sighting.hpp"

namespace sightline {
namespace {

constexpr double view_period = 0.01, settled_from = 4.0;          // [s]
constexpr double circle_radius = 0.8;                             // [m]
constexpr double swaying = 1.3;                                   // [rad/s]
constexpr double slowest_turning = 0.15, fastest_turning = 0.45;  // [rad/s]

/// Heading of the body over time [rad].
struct Turning {
  double from = 0.0, rate = 0.0;
  double at(double t) const { return from + rate * t; }
};

struct Places {
  Vec3<double> target{}, own{};
  double target_heading = 0.0;  // the observer's is 0
};

Vec3<double> target_place(const ViewFlight& flight, double t) {
  const SinCos<double> h = sincos(flight.target_speed / circle_radius * t);
  return {circle_radius * h.cos, circle_radius * h.sin, 1.2};
}

/// Positions of both at t. The observer would hold the body on its optical axis but for its lag.
Places places_at(const ViewFlight& flight, double distance, double t, const Turning& turning) {
  Places at{.target = target_place(flight, t), .target_heading = wrap(turning.at(t))};
  const double swayed = distance + flight.sway * sin(swaying * t + turning.from);
  at.own =
      target_place(flight, t - flight.lag) - flight.mount.point_in_F({flight.mount.depth_at(swayed), 0, 0});
  return at;
}

RigidPose standing(const Vec3<double>& p, double heading) {
  const SinCos<double> h = sincos(heading);
  return {p, rotation(leaning(Vec2<double>{h.cos, h.sin}, Vec2<double>{}))};
}

}  // namespace

ViewFigures fly_beside(const ViewFlight& flight, double distance) {
  Team team;
  const BodyId observer = team.add(Multirotor{}), target = team.add(Multirotor{});
  CameraOptions options{.seed = flight.seed};
  options.cameras.push_back({.observer = observer, .mount = flight.mount, .camera = flight.camera});
  options.tags.push_back({target, flight.tags});
  SyntheticDetections pictures(team, options);
  MotionSensor motion(flight.filter, flight.seed, observer.index);
  RandomStream received(flight.seed, StreamId::position_noise, target.index),
      dropped(flight.seed, StreamId::picture, observer.index);
  const auto filter = make_pose_filter(flight.filter, flight.mount);
  std::array<ExposedBody, 2> bodies;
  const auto expose = [&](const Places& at) {
    for (ExposedBody& body : bodies) body.before = body.now;
    bodies[0].now = standing(at.own, 0.0);
    bodies[1].now = standing(at.target, at.target_heading);
  };
  RandomStream draw(flight.seed, StreamId::draw, 0);
  const Turning turning = {.from = 2 * std::numbers::pi * draw.uniform(),
                           .rate = slowest_turning + (fastest_turning - slowest_turning) * draw.uniform()};
  expose(places_at(flight, distance, 0.0, turning));

  ViewFigures sum;
  long taken = 0, found = 0, periods = 0, known = 0, lost = 0;
  double next_picture = 0.0, last_seen = 0.0;
  bool is_lost = false;
  const long all = std::lround(flight.duration / view_period);
  for (long k = 1; k <= all; ++k) {
    const double t = static_cast<double>(k) * view_period;
    expose(places_at(flight, distance, t, turning));
    const MotionSample u = motion.measure(t, view_period, bodies[0].before.p, matrix(bodies[0].before.R),
                                          bodies[0].now.p, matrix(bodies[0].now.R));
    filter->advance(u);
    if (const auto compass = compass_of(u, flight.filter)) filter->take(*compass);
    const bool counts = t >= settled_from;
    if (t >= next_picture - 1e-9) {
      next_picture += 1 / flight.camera.rate;
      std::array<Detection, 1> detection;
      const bool shown =
          pictures.find({.camera = 0, .time = t, .since = view_period, .bodies = bodies}, detection) > 0;
      const bool is_found = shown && dropped.uniform() > flight.camera.dropout;
      taken += counts, found += counts && is_found;
      if (is_found) {
        last_seen = t;
        detection[0].stamp = detection[0].arrival = t;
        if (flight.camera.output == CameraOutput::position) detection[0].forget_attitude();
        Measurement z = sighting_of(detection[0], flight.mount, {u.roll, u.pitch});
        z.p_other = bodies[1].now.p + flight.given_sigma * received.normals();
        z.psi_other = wrap(turning.at(t) + flight.given_sigma * received.normal());
        z.P_other = identity<4>(square(flight.given_sigma));
        filter->take(z);
      }
    }
    if (!counts) {
      last_seen = std::max(last_seen, t - flight.loss);
      continue;
    }
    ++periods;
    const bool now_lost = t - last_seen > flight.loss;
    sum.losses += now_lost && !is_lost;
    lost += now_lost;
    is_lost = now_lost;
    const PoseEstimate estimate = filter->estimate();
    if (!estimate.known) continue;
    ++known;
    const Vec3<double> e = estimate.p - bodies[0].now.p;
    sum.sigma += square(estimate.position_sigma());
    sum.error += dot(e, e);
  }
  const auto share = [](long part, long whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  const auto root_mean = [&](double squares) {
    return known > 0 ? sqrt(squares / static_cast<double>(known)) : infinity;
  };
  sum.found = share(found, taken);
  sum.known = share(known, periods);
  sum.lost = share(lost, periods);
  sum.losses *= 60.0 / (static_cast<double>(std::max(periods, 1L)) * view_period);
  sum.sigma = root_mean(sum.sigma);
  sum.error = root_mean(sum.error);
  return sum;
}

ViewVariance view_variance(const ViewFlight& flight) {
  constexpr double step = 0.25, farthest = 100.0;  // [m]
  // A tag below 4 px is never read.
  const double last = std::min(farthest, flight.camera.focal() * flight.tags.size / 4.0);
  ViewVariance over{.step = step, .values = {}};
  std::size_t unseen = 0;
  for (double distance = 0.0; distance <= last; distance += step) {
    const ViewFigures at = distance > 0 ? fly_beside(flight, distance) : ViewFigures{};
    if (at.found >= 0.5) {
      over.values.resize(over.values.size() + unseen, square(at.sigma));
      unseen = 0;
      over.values.push_back(square(at.sigma));
    } else if (!over.values.empty()) {
      break;
    } else {
      ++unseen;
    }
  }
  return over;
}

}  // namespace sightline
