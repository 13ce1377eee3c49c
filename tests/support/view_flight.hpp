/// Flights with the filter of a certified view, against a target that tries to escape.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <span>
#include <vector>

#include "tests/support/view_set.hpp"

namespace sightline::test {

enum class ViewNominal { random, adverse, tracking };
enum class ViewEscape { random, tangential, radial, overhead, greedy, planned };

/// A part of a target's motion: velocities as parts of their bounds.
struct ViewLeg {
  Vec2<double> direction{};  ///< norm <= 1
  double climb = 0.0;        ///< -1 to 1
};

struct ViewFlightOptions {
  ViewNominal nominal = ViewNominal::random;
  ViewEscape escape = ViewEscape::random;
  bool filtered = true, at_edge = false;
  double duration = 15.0;
  double faster = 1.0;              ///< true speed of the target, relative to its bound
  std::span<const ViewLeg> legs{};  ///< of a planned escape, equally long
};

struct ViewOutcome {
  int samples = 0, out_of_view = 0, uncertified = 0, active = 0;
  bool announced = true;     ///< each sample out of view came no later than one uncertified
  double changed = 0.0;      ///< mean change of an input
  double least = infinity;   ///< of the checker's reserves [m], for exact measurements at once
  double worst = -infinity;  ///< violation of a limit, in its unit; < 0: all held
};

/// One flight of a multirotor. The bounds of the certificate hold for the target's motion and for
/// the measurements, whose errors are at their bound.
inline ViewOutcome view_flight(const ViewFilter& filter, const ViewChecker& checker,
                               const std::vector<Potential>& limits, const ViewFlightOptions& o,
                               std::uint64_t seed) {
  const Multirotor robot;
  const Model model(robot);
  const ViewCertificate& z = filter.certificate();
  const ViewBounds& bounds = z.task.bounds;
  const double dt = z.task.dt;
  const auto late = static_cast<std::size_t>(std::lround(bounds.age / dt));
  const bool exact = late == 0 && bounds.error == 0;
  const double yaw = yaw_of(z), cosine = std::cos(yaw), sine = std::sin(yaw);
  Random random(seed);
  ViewState s = state_in(z, random, o.at_edge);
  if (!exact) {  // begin in the middle
    const double r = 0.5 * (z.near + z.far), h = 0.5 * (z.at(z.low, r) + z.at(z.high, r));
    s = {.z = 4, .target = {r * std::cos(yaw), r * std::sin(yaw), 4 - h}};
  }
  std::vector<double> x = state_of(model, s);
  std::deque<ViewState> past(late + 1, s);
  SlowEstimate estimate(bounds, dt);
  ViewBounds true_bounds = bounds;
  true_bounds.speed *= o.faster;

  ViewOutcome outcome;
  std::array<double, 4> u{};
  bool is_out = false;
  double until = 0, next_nominal = 0, side = 1, climb = 0;
  Vec2<double> direction = {1, 0};
  for (int k = 0; k * dt < o.duration; ++k) {
    const double t = k * dt;
    // What the robot knows.
    past.push_back(s), past.pop_front();
    Vec3<double> known = past.front().target;
    if (bounds.error > 0 && k > 0) {
      const double a = uniform(random, -4, 4);
      known = known + Vec3<double>{bounds.error * std::cos(a), bounds.error * std::sin(a),
                                   uniform(random, -bounds.error, bounds.error)};
    }
    const ViewTarget target = {estimate.follow(known), past.front().w};
    const Sight<double> sight = model.sight(x.data(), u.data());
    const Vec2<double> q =
        rotate<double>({sight.d.x, -sight.d.y}, {target.p.x - sight.p.x, target.p.y - sight.p.y});
    const double r = std::hypot(q.x, q.y),
                 theta = std::remainder(std::atan2(q.y, q.x) - yaw, 2 * std::numbers::pi),
                 h = sight.p.z - target.p.z;
    const ViewReserves reserves = filter.reserves(x, target);
    // The nominal command.
    if (o.nominal == ViewNominal::tracking) {
      const double middle = 0.5 * (z.near + z.far),
                   height = 0.5 * (z.at(z.low, middle) + z.at(z.high, middle));
      const double pull = 2 * (r - middle);
      u = {pull * cosine - 1.5 * x[5], -pull * sine + 1.5 * x[6], 2 * (height - h), 2 * theta};
    } else if (t >= next_nominal) {
      next_nominal = t + uniform(random, 0.02, 1.5);
      for (double& value : u)
        value = o.nominal == ViewNominal::random ? uniform(random, -1, 1) : random() & 1 ? 1.0 : -1.0;
    }
    if (o.nominal == ViewNominal::adverse) {
      u[3] = reserves[2] < reserves[3] ? -1 : 1;
      u[2] = reserves[4] < reserves[5] ? 1 : -1;
      if (seed % 3 == 0) {
        const double towards = reserves[0] < reserves[1] ? 1 : -1;
        if (std::abs(cosine) > 0.1) u[0] = towards * cosine / std::abs(cosine);
        if (std::abs(sine) > 0.1) u[1] = -towards * sine / std::abs(sine);
      }
    }
    for (double& value : u) value = std::clamp(value, -1.0, 1.0);
    const std::array<double, 4> wanted = u;
    if (o.filtered) {
      const ViewFilterResult result = filter.filter(x, target, model.u_min(), model.u_max(), u);
      outcome.uncertified += !result.certified;
      outcome.active += result.active;
      for (std::size_t i = 0; i < u.size(); ++i) outcome.changed += std::abs(u[i] - wanted[i]) / 4;
    }
    // A target beyond its bound may leave set and view in one period, which the next one reports.
    outcome.announced = outcome.announced && (!is_out || outcome.uncertified > 0);
    model.step(x.data(), u.data(), dt);
    // The target's move.
    const Sight<double> now = model.sight(x.data(), u.data());
    if (o.escape == ViewEscape::greedy) {
      double worst = infinity;
      int chosen = 0;
      for (int i = 0; i < moves; ++i) {
        ViewState moved = s;
        move(moved, true_bounds, i, dt);
        const ViewReserves left = filter.reserves(x, {moved.target, moved.w});
        const double least = *std::min_element(left.begin(), left.end() - 1);
        if (least < worst) worst = least, chosen = i;
      }
      move(s, true_bounds, chosen, dt);
    } else if (o.escape == ViewEscape::planned) {
      const auto legs = static_cast<double>(o.legs.size());
      const ViewLeg& leg = o.legs[static_cast<std::size_t>(std::min(t / o.duration * legs, legs - 1))];
      move(s, true_bounds, leg.direction, leg.climb, dt);
    } else {
      if (t >= until) {
        until = t + uniform(random, 0.1, 3.0), side = -side;
        const double a = uniform(random, -4, 4);
        direction = {std::cos(a), std::sin(a)}, climb = uniform(random, -1, 1);
      }
      const Vec2<double> away = {s.target.x - now.p.x, s.target.y - now.p.y};
      const double length = std::max(1e-9, std::hypot(away.x, away.y));
      const Vec2<double> e = {away.x / length, away.y / length};
      if (o.escape == ViewEscape::tangential) direction = {-side * e.y, side * e.x}, climb = side;
      if (o.escape == ViewEscape::radial) direction = {side * e.x, side * e.y}, climb = side;
      if (o.escape == ViewEscape::overhead) direction = {-e.x, -e.y}, climb = side > 0 ? 1 : climb;
      move(s, true_bounds, direction, climb, dt);
    }
    // The truth, by the limits themselves.
    ++outcome.samples;
    const Sight<double> seen = {{s.target, {1, 0}}, {}};
    double excess = -infinity;
    for (const Potential& limit : limits) excess = std::max(excess, limit.violation(now, seen));
    is_out = excess > 0;
    outcome.out_of_view += is_out;
    outcome.worst = std::max(outcome.worst, excess);
    if (exact) outcome.least = std::min(outcome.least, checker.least(now, s.target, s.w));
  }
  outcome.changed /= outcome.samples;
  return outcome;
}

/// A search for the motion of a target that leaves the view. From random motions, it takes random
/// steps of one leg that make the worst violation no smaller.
struct ViewSearch {
  int flights = 0, lost = 0;  // flights; searches that found a way out
  double worst = -infinity;   // violation
};
inline ViewSearch search_escapes(const ViewFilter& filter, const std::vector<Potential>& limits, int searches,
                                 int steps, ViewFlightOptions o, std::uint64_t seed) {
  const ViewChecker checker(filter.certificate());
  Random random(seed);
  const auto random_leg = [&] {
    const double a = uniform(random, -3.2, 3.2), part = random() & 1 ? 1.0 : uniform(random, 0, 1);
    return ViewLeg{{part * std::cos(a), part * std::sin(a)},
                   random() & 1   ? uniform(random, -1, 1)
                   : random() & 1 ? 1.0
                                  : -1.0};
  };
  o.escape = ViewEscape::planned, o.duration = 6.0;
  ViewSearch all;
  for (int search = 0; search < searches; ++search) {
    o.nominal = o.filtered ? static_cast<ViewNominal>(search % 3) : ViewNominal::tracking;
    o.at_edge = search % 2 == 0;
    const std::uint64_t start = random();
    std::array<ViewLeg, 12> best{};
    for (ViewLeg& leg : best) leg = random_leg();
    double worst = -infinity;
    for (int step = 0; step < steps && worst <= 0; ++step, ++all.flights) {
      std::array<ViewLeg, 12> legs = best;
      if (step > 0) legs[random() % legs.size()] = random_leg();
      o.legs = legs;
      const double reached = view_flight(filter, checker, limits, o, start).worst;
      if (reached >= worst) worst = reached, best = legs;
    }
    all.lost += worst > 0;
    all.worst = std::max(all.worst, worst);
  }
  return all;
}

/// Many flights, all nominal commands and escapes alike.
struct ViewCampaign {
  int flights = 0, lost = 0, uncertified = 0, unannounced = 0;
  double least = infinity, changed = 0.0, active = 0.0;
};
inline ViewCampaign view_campaign(const ViewFilter& filter, const std::vector<Potential>& limits, int flights,
                                  ViewFlightOptions o = {}, std::uint64_t seed = 1) {
  const ViewChecker checker(filter.certificate());
  ViewCampaign all;
  for (; all.flights < flights; ++all.flights) {
    o.nominal = static_cast<ViewNominal>(all.flights % 3);
    o.escape = static_cast<ViewEscape>(all.flights / 3 % 5);
    o.at_edge = all.flights / 15 % 2 == 0;
    const ViewOutcome one =
        view_flight(filter, checker, limits, o, seed + 1000003ull * static_cast<std::uint64_t>(all.flights));
    all.lost += one.out_of_view > 0;
    all.uncertified += one.uncertified > 0;
    all.unannounced += !one.announced;
    all.least = std::min(all.least, one.least);
    all.changed += one.changed / flights,
        all.active += static_cast<double>(one.active) / one.samples / flights;
  }
  return all;
}

}  // namespace sightline::test
