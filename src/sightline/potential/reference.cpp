#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sightline/potential.hpp"

namespace sightline {
namespace {

/// Index of the last time <= t; 0 before the first.
std::size_t last_before(const std::vector<double>& times, double t) {
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  return after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin() - 1);
}

void check_times(std::string_view name, const std::vector<double>& times, std::size_t places,
                 std::size_t headings) {
  if (times.empty() || places != times.size() || (headings != 0 && headings != times.size())) {
    throw std::invalid_argument(fmt::format(
        "{} has {} times, {} positions and {} headings, expected at least one time and as many of each", name,
        times.size(), places, headings));
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && !(times[i] > times[i - 1]))) {
      throw std::invalid_argument(
          fmt::format("{}.times[{}] = {}, expected times that rise", name, i, times[i]));
    }
  }
}

void check_list(std::string_view name, const std::vector<double>& times, const std::vector<Vec3<double>>& p,
                const std::vector<double>& heading) {
  check_times(name, times, p.size(), heading.size());
  for (const Vec3<double>& at : p) {
    for (const double c : {at.x, at.y, at.z}) require(true, name, "p", c, "finite m");
  }
  for (const double psi : heading) require(true, name, "heading", psi, "finite rad");
}

Vec2<double> direction(const std::vector<double>& heading, std::size_t i) {
  if (heading.empty()) return {};
  return {cos(heading[i]), sin(heading[i])};
}

}  // namespace

Pose<double> Constant::operator()(double) const {
  return {p, heading ? Vec2<double>{cos(*heading), sin(*heading)} : Vec2<double>{}};
}

void Waypoints::check() const {
  check_list(name, times, p, heading);
  if (v.empty()) return;
  if (v.size() != times.size())
    throw std::invalid_argument(
        fmt::format("{} has {} velocities, expected {}, one for each time", name, v.size(), times.size()));
  for (const Vec3<double>& at : v) {
    for (const double c : {at.x, at.y, at.z}) require(true, name, "v", c, "finite m/s");
  }
}

Pose<double> Waypoints::operator()(double t) const {
  const std::size_t i = last_before(times, t);
  if (i + 1 >= times.size() || t <= times[i]) return {p[i], direction(heading, i)};
  const double h = times[i + 1] - times[i], s = (t - times[i]) / h;
  Vec3<double> at = p[i] + s * (p[i + 1] - p[i]);
  if (!v.empty()) {
    const Vec3<double> mean = (1 / h) * (p[i + 1] - p[i]);
    at = at + (h * s * (1 - s)) * ((1 - s) * (v[i] - mean) + s * (mean - v[i + 1]));
  }
  if (heading.empty()) return {at, {}};
  const double turn = wrap_angle(heading[i + 1] - heading[i]);
  return {at, {cos(heading[i] + s * turn), sin(heading[i] + s * turn)}};
}

double Waypoints::top_speed() const {
  double most = 0.0;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const Vec3<double> mean = (1 / (times[i + 1] - times[i])) * (p[i + 1] - p[i]);
    most = std::max(most, norm(mean));
    // The velocity is a polynomial of Bezier, within the hull of its control points.
    if (!v.empty()) most = std::max({most, norm(v[i]), norm(v[i + 1]), norm(3.0 * mean - v[i] - v[i + 1])});
  }
  return most;
}

void Steps::check() const { check_list(name, times, p, heading); }

Pose<double> Steps::operator()(double t) const {
  const std::size_t i = last_before(times, t);
  return {p[i], direction(heading, i)};
}

std::size_t Reference::checked_length(std::size_t length) {
  if (length == 0) throw std::invalid_argument("a reference has no numbers, expected one for each state");
  return length;
}

void Reference::along(double t, double h, int n, const Model& model, double* x, std::ptrdiff_t stage,
                      std::ptrdiff_t entry) const noexcept {
  try {
    write_({t, h, n}, model, {x, stage, entry});
  } catch (...) {
    for (int k = 0; k < n; ++k) {
      for (int i = 0; i < model.nx(); ++i)
        x[k * stage + i * entry] = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

Reference Reference::between(const Reference& from, const Reference& to, const Ramp& ramp) {
  if (from.length_ != 0 && to.length_ != 0 && from.length_ != to.length_) {
    throw std::invalid_argument(
        fmt::format("a reference has {} numbers, the next {}, expected as many", from.length_, to.length_));
  }
  if (std::max(from.length_, to.length_) > static_cast<std::size_t>(max_states)) {
    throw std::invalid_argument(
        fmt::format("a reference of {} numbers goes over into another, expected at most {}",
                    std::max(from.length_, to.length_), max_states));
  }
  Reference mixed;
  mixed.length_ = std::max(from.length_, to.length_);
  mixed.constant_ = false;
  mixed.write_ = [a = from.write_, b = to.write_, ramp](const Times& times, const Model& model,
                                                        const Target& x) {
    std::array<double, max_states> x_a, x_b;
    const auto n = static_cast<std::size_t>(model.nx());
    expect(model.nx() <= max_states);
    for (int k = 0; k < times.n; ++k) {
      const double t = times.at(k), part = ramp.at(t);
      a({t, 0.0, 1}, model, {x_a.data(), 0, 1});
      b({t, 0.0, 1}, model, {x_b.data(), 0, 1});
      for (std::size_t i = 0; i < n; ++i) x_a[i] += part * (x_b[i] - x_a[i]);
      x.put(k, std::span<const double>(x_a).first(n), model.nx());
    }
  };
  return mixed;
}

}  // namespace sightline
