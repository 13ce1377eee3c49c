#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/team.hpp"

namespace sightline {
namespace {

constexpr int samples = 500;

/// Random Sights of robots in the given range; deterministic.
class Draw {
 public:
  double operator()(double low, double high) {
    constexpr double steps = 1u << 31;
    return low + (high - low) * static_cast<double>(random_() & 0x7fffffffU) / steps;
  }
  Vec3<double> vector(double reach) {
    return {(*this)(-reach, reach), (*this)(-reach, reach), (*this)(-reach, reach)};
  }
  Sight<double> sight(double reach) {
    const double heading = (*this)(-3.15, 3.15);
    return {{vector(reach), {cos(heading), sin(heading)}}, vector(1.0)};
  }

 private:
  std::mt19937 random_{1};
};

/// Whether the potential ignores a common shift of both poses, and any velocity, tilt and time.
bool sees_differences_alone(const Potential& potential, double radius) {
  Draw draw;
  for (int i = 0; i < samples; ++i) {
    Sight<double> a = draw.sight(radius), b = draw.sight(radius);
    const double before = potential(a, b, 0.0);
    const Vec3<double> p = draw.vector(1.0), d = draw.vector(1.0);
    for (Sight<double>* const s : {&a, &b}) {
      s->p = s->p + p;
      s->d = {s->d.x + d.x, s->d.y + d.y};
      s->v = draw.vector(1.0);
      s->lean = {draw(-1.0, 1.0), draw(-1.0, 1.0)};
    }
    const double after = potential(a, b, draw(0.0, 10.0));
    if (!(std::abs(after - before) <= 1e-6 * (1.0 + std::abs(before)))) return false;
  }
  return true;
}

/// The largest weighted value [-] or slope [1/m] at the radius, over directions and headings.
double largest_at(const Weighted& term, double radius) {
  Draw draw;
  double largest = 0.0;
  for (int i = 0; i < samples; ++i) {
    Sight<double> a = draw.sight(1.0);
    const Sight<double> b = draw.sight(0.0);
    const double step = 1e-4 * radius, length = norm(a.p);
    if (!(length > 1e-3)) continue;
    const auto at = [&](double distance) {
      Sight<double> there = a;
      there.p = (distance / length) * a.p;
      return term.weight * term.potential(there, b, 0.0);
    };
    const double slope = (at(radius + step) - at(radius - step)) / (2 * step);
    for (const double value : {at(radius), slope}) {
      if (!(std::abs(value) <= largest)) largest = std::abs(value);
    }
  }
  return largest;
}

}  // namespace

void Swarm::check() const {
  const std::string_view name = term.potential.name();
  if (!(radius > 0) || !std::isfinite(radius)) throw_invalid("radius = {}, expected > 0 m", radius);
  if (capacity < 1) throw_invalid("capacity = {}, expected at least 1 pair", capacity);
  if (!std::isfinite(term.weight) || term.weight < 0) {
    throw_invalid("weight = {} of {}, expected >= 0", term.weight, name);
  }
  if (!term.potential.is_pair()) {
    throw_invalid("{} sees one robot alone, expected a potential between two bodies", name);
  }
  if (term.potential.sees_third())
    throw_invalid("{} looks past a third body, expected a potential between two", name);
  if (agents.size() < 2) throw_invalid("{} robots are kept apart, expected at least two", agents.size());
  if (!sees_differences_alone(term.potential, radius)) {
    throw_invalid(
        "{} depends on more than the differences of two positions and of two headings, expected one of "
        "keep_out, "
        "too_near, pass_right or alike",
        name);
  }
  const double rest = largest_at(term, radius);
  if (!(rest <= negligible)) {
    throw_invalid(
        "{} times {} is or slopes by {:.2g} at the radius of {} m, expected at most {}: a larger radius or a "
        "sharper potential",
        name, term.weight, rest, radius, negligible);
  }
}

double Swarm::cost(std::span<const Sight<double>> robots, double t) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (std::size_t j = i + 1; j < robots.size(); ++j) {
      const Vec3<double> r = robots[i].p - robots[j].p;
      if (dot(r, r) < square(radius)) sum += term.potential(robots[i], robots[j], t);
    }
  }
  return term.weight * sum;
}

}  // namespace sightline
