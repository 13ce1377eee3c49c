#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/solver.hpp"

namespace sightline {
namespace {

Sight<double> going_on(Sight<double> s, double dt) {
  if (dt != 0) s.p = s.p + dt * s.v;
  return s;
}

Sight<double> between(const Sight<double>& a, const Sight<double>& b, double share) {
  const auto mixed = [&](double from, double to) { return from + share * (to - from); };
  Sight<double> s = share < 0.5 ? a : b;
  s.p = a.p + share * (b.p - a.p);
  s.v = a.v + share * (b.v - a.v);
  s.lean = {mixed(a.lean.x, b.lean.x), mixed(a.lean.y, b.lean.y)};
  const Vec2<double> d = {mixed(a.d.x, b.d.x), mixed(a.d.y, b.d.y)};
  const double length = norm(d.x, d.y);
  if (length > 0) s.d = {d.x / length, d.y / length};  // no direction lies between opposite headings
  return s;
}

}  // namespace

bool Prediction::holds(double t, const Vec3<double>& p) const noexcept {
  const double length = h * static_cast<double>(sights.size());
  return !sights.empty() && std::abs(t - time) < length && norm(at(t, 0).p - p) <= astray;
}

Sight<double> Prediction::at(double t, int k) const noexcept {
  const double stage = (t - time) / h + k;
  const double last = static_cast<double>(sights.size() - 1);
  if (stage <= 0) return going_on(sights.front(), stage * h);
  if (stage >= last) return going_on(sights.back(), (stage - last) * h);
  const auto i = static_cast<std::size_t>(stage);
  const double share = stage - static_cast<double>(i);
  return share == 0 ? sights[i] : between(sights[i], sights[i + 1], share);
}

bool Prediction::is_finite() const noexcept {
  return std::isfinite(time) && std::all_of(sights.begin(), sights.end(), [](const Sight<double>& s) {
           std::array<double, sight_size> numbers;
           write_sight(s, numbers);
           return std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); });
         });
}

}  // namespace sightline
