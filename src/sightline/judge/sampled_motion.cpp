#include "sightline/judge/sampled_motion.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/safety/zone.hpp"

namespace sightline {
namespace {

constexpr double longest_step = 0.02;   // of the model's motion [s]
constexpr std::size_t steps_most = 32;  // of one body between two samples
constexpr std::size_t rows_most = 4;    // inputs in force between two samples
constexpr std::size_t knots_most = 1 + steps_most + 2 * (rows_most - 1);
constexpr double jump = 1e-7;           // duration of a change of the inputs [s]
constexpr double close_enough = 1e-5;   // tolerance of an extreme [m]
constexpr double close_to_zone = 1e-4;  // tolerance of an extreme of a zone [m]
constexpr int halvings = 20;            // maximum number of bisections
constexpr double unsteady_speed = 1.0;  // allowed speed of a step beyond twice the body's speed [m/s]
constexpr double off_chord = 4.0 / 27;  // greatest s (1 - s)^2

bool all_finite(const Vec3<double>& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Knot between(const Knot& a, const Knot& b) noexcept {
  const double h = b.time - a.time;
  return {0.5 * (a.time + b.time), 0.5 * (a.p + b.p) + (h / 8) * (a.v - b.v),
          (1.5 / h) * (b.p - a.p) - 0.25 * (a.v + b.v)};
}

/// The cubic at the time a + s (b - a), s in [0, 1].
Vec3<double> place(const Knot& a, const Knot& b, double s) noexcept {
  const double h = b.time - a.time;
  const Vec3<double> d = b.p - a.p, from = h * a.v - d, to = d - h * b.v;
  return a.p + s * d + (s * (1 - s)) * ((1 - s) * from + s * to);
}

void find_least_distance(const Knot& a, const Knot& b, Extreme& least, int depth) noexcept {
  const double h = b.time - a.time;
  const Vec3<double> d = b.p - a.p, w = (1 / h) * d;
  const double dd = dot(d, d), s = dd > 0 ? std::clamp(-dot(a.p, d) / dd, 0.0, 1.0) : 0.0;
  const double off = off_chord * h * (norm(a.v - w) + norm(b.v - w));
  if (!(norm(a.p + s * d) - off < least.value - close_enough)) return;
  if (off <= close_enough || depth == 0) {
    const double reached = norm(place(a, b, s));
    if (reached < least.value) least = {reached, a.time + s * h};
    return;
  }
  const Knot middle = between(a, b);
  find_least_distance(a, middle, least, depth - 1);
  find_least_distance(middle, b, least, depth - 1);
}

void find_greatest(const Knot& a, const Knot& b, const Vec3<double>& n, Extreme& most, int depth) noexcept {
  const double h = b.time - a.time, from = dot(n, a.p), to = dot(n, b.p), w = (to - from) / h;
  const double off = off_chord * h * (std::abs(dot(n, a.v) - w) + std::abs(dot(n, b.v) - w));
  if (!(std::max(from, to) + off > most.value + close_enough)) return;
  if (off <= close_enough || depth == 0) {
    if (std::max(from, to) > most.value) most = {std::max(from, to), from > to ? a.time : b.time};
    return;
  }
  const Knot middle = between(a, b);
  find_greatest(a, middle, n, most, depth - 1);
  find_greatest(middle, b, n, most, depth - 1);
}

void find_greatest(const Knot& a, const Knot& b, const Zone& zone, Extreme& most, int depth) noexcept {
  const double h = b.time - a.time, from = -zone_reserve(zone, a.p), to = -zone_reserve(zone, b.p);
  const Vec3<double> d = b.p - a.p, w = (1 / h) * d;
  const double length = norm(d), off = off_chord * h * (norm(a.v - w) + norm(b.v - w));
  // The distance to a boundary changes no faster than the place.
  if (!(0.5 * (from + to + length) + off > most.value + close_to_zone)) return;
  if (std::max(from, to) > most.value) most = {std::max(from, to), from > to ? a.time : b.time};
  if (0.5 * length + off <= close_to_zone || depth == 0) return;
  const Knot middle = between(a, b);
  find_greatest(a, middle, zone, most, depth - 1);
  find_greatest(middle, b, zone, most, depth - 1);
}

}  // namespace

void find_least_distance(const Knot& a, const Knot& b, Extreme& least) noexcept {
  find_least_distance(a, b, least, halvings);
}

void find_greatest(const Knot& a, const Knot& b, const Vec3<double>& n, Extreme& most) noexcept {
  find_greatest(a, b, n, most, halvings);
}

void find_greatest(const Knot& a, const Knot& b, const Zone& zone, Extreme& most) noexcept {
  find_greatest(a, b, zone, most, halvings);
}

SampledMotion::SampledMotion(const Team& team, double input_delay, double period)
    : delay_(input_delay, period, resting_inputs(team)),
      delays_(input_delay > 0),
      x_(size(team.nx())),
      u_(size(team.nu())),
      x_before_(x_),
      held_(rows_most * u_.size()) {
  times_.reserve(knots_most);
  forces_.reserve(knots_most);
  std::size_t nx_most = 0;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    bodies_.push_back({team.model(body), team.is_agent(body), size(team.state_offset(body)),
                       size(team.input_offset(body))});
    bodies_.back().knots.reserve(knots_most);
    nx_most = std::max(nx_most, size(team.model(body).nx()));
  }
  x_model_.resize(nx_most);
}

void SampledMotion::follow(const Sample& sample, std::span<const Sight<double>> sights) noexcept {
  period_ = sample.time - time_;
  time_ = sample.time;
  const bool known = begun_ && truth_ && sample.truth_known && period_ > 0;
  begun_ = true;
  truth_ = sample.truth_known;
  x_.swap(x_before_);
  if (known) divide();
  std::copy_n(sample.x.begin(), std::min(x_.size(), sample.x.size()), x_.begin());
  std::copy_n(sample.u.begin(), std::min(u_.size(), sample.u.size()), u_.begin());
  delay_.give(time_, u_);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    const Vec3<double> v_before = body.v;
    body.p_before = body.p;
    body.p = sights[i].p, body.v = sights[i].v;
    const bool was_there = std::exchange(body.there, sample.presence[i] != Presence::absent);
    body.has_knots = body.moved = false;
    body.reach = 0.0;
    if (!body.there || !all_finite(body.p) || !all_finite(body.v)) continue;
    if (!was_there) body.fastest = 0.0;
    body.fastest = std::max(body.fastest, norm(body.v));
    const Vec3<double> d = body.p - body.p_before;
    if (!known || !was_there || !all_finite(d) || !all_finite(v_before)) continue;
    body.moved = norm(d) <= period_ * (2 * body.fastest + unsteady_speed);
    if (!body.moved) continue;
    body.reach = norm(d);
    if (!body.is_robot) continue;
    if (delays_) {  // velocities at the samples do not bound the reach if inputs change between
      body.reach = 0.0;
      const std::span<const Knot> all = knots(BodyId{static_cast<int>(i)});
      for (std::size_t k = 0; k + 1 < all.size(); ++k) {
        const double h = all[k + 1].time - all[k].time;
        const Vec3<double> w = (1 / h) * (all[k + 1].p - all[k].p);
        body.reach = std::max(body.reach, norm(all[k].p - body.p) +
                                              off_chord * h * (norm(all[k].v - w) + norm(all[k + 1].v - w)));
      }
      continue;
    }
    const Vec3<double> w = (1 / period_) * d;
    body.reach += 0.5 * period_ * (norm(v_before - w) + norm(body.v - w));
  }
}

/// Computes the knot times since the previous sample and the inputs in force between them. A change
/// of input between two samples has one knot just before it and one just after, because some
/// velocities jump with their commands.
void SampledMotion::divide() noexcept {
  const double T = period_, from = time_ - T, steps = std::ceil(T / longest_step - 1e-6);
  const std::size_t n =
      steps < steps_most + 1 ? std::max<std::size_t>(1, static_cast<std::size_t>(steps)) : steps_most;
  const double h = T / static_cast<double>(n);
  std::size_t row = 0;
  const auto hold = [&](double t) {
    const std::span<const double> u = delay_.at(t);
    std::copy(u.begin(), u.end(), held_.begin() + static_cast<std::ptrdiff_t>(row * u_.size()));
  };
  const auto end_step = [&](double t) {
    times_.push_back(t);
    forces_.push_back(row);
  };
  times_.assign(1, from);
  forces_.assign(1, row);
  hold(from + 2 * jump);
  for (std::size_t k = 1; k <= n; ++k) {
    const double end = k == n ? time_ : from + static_cast<double>(k) * h;
    for (double next = delay_.next_arrival(); row + 1 < rows_most && next < end - 2 * jump;
         next = delay_.next_arrival()) {
      if (next > times_.back() + jump) end_step(next);
      ++row;
      hold(next + jump);
      end_step(times_.back() + jump);
    }
    end_step(end);
  }
}

/// Motion of a body by its model, corrected by the model's error at the last sample.
void SampledMotion::fly(Body& body) noexcept {
  const std::size_t n = times_.size() - 1;
  const double T = period_, from = times_.front();
  body.knots.resize(n + 1);
  const Vec3<double> mean = (1 / T) * (body.p - body.p_before);
  const auto straight = [&] {
    for (std::size_t k = 0; k <= n; ++k) {
      body.knots[k] = {times_[k], body.p_before + (times_[k] - from) * mean, mean};
    }
    body.knots[n].p = body.p;
  };
  if (!body.is_robot) return straight();
  const double* u = nullptr;
  std::copy_n(x_before_.begin() + static_cast<std::ptrdiff_t>(body.x), body.model.nx(), x_model_.begin());
  for (std::size_t k = 0; k <= n; ++k) {
    u = held_.data() + forces_[k] * u_.size() + body.u;
    if (k > 0) body.model.step(x_model_.data(), u, times_[k] - times_[k - 1]);
    const Sight<double> seen = body.model.sight(x_model_.data(), u);
    body.knots[k] = {times_[k], seen.p, seen.v};
  }
  const Vec3<double> e_p = body.p - body.knots[n].p,
                     e_v = body.model.sight(x_.data() + body.x, u).v - body.knots[n].v,
                     missing = (1 / T) * e_p - 0.5 * e_v;
  if (!all_finite(missing) || !all_finite(e_v)) return straight();
  for (std::size_t k = 0; k <= n; ++k) {
    const double s = times_[k] - from;
    body.knots[k].p = body.knots[k].p + s * missing + (0.5 * s * s / T) * e_v;
    body.knots[k].v = body.knots[k].v + missing + (s / T) * e_v;
  }
  body.knots.front().p = body.p_before, body.knots[n].p = body.p;
}

std::span<const Knot> SampledMotion::knots(BodyId id) noexcept {
  Body& body = bodies_[at(id)];
  if (!std::exchange(body.has_knots, true)) fly(body);
  return body.knots;
}

void SampledMotion::find_least_distance(BodyId a, BodyId b, Extreme& least) noexcept {
  const std::span<const Knot> one = knots(a), other = knots(b);
  const auto relative = [&](std::size_t k) {
    return Knot{one[k].time, one[k].p - other[k].p, one[k].v - other[k].v};
  };
  for (std::size_t k = 0; k + 1 < one.size(); ++k)
    sightline::find_least_distance(relative(k), relative(k + 1), least);
}

}  // namespace sightline
