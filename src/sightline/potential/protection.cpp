#include "sightline/potential/protection.hpp"

#include <cmath>
#include <numbers>

namespace sightline {
namespace {

constexpr int encounters = 64;
constexpr double near = 1e-6, far = 1e4, away = 1e6;  // [m]

/// Two bodies; the distance is measured from the point at `from` [m] in the observer's frame V.
struct Encounter {
  Sight<double> observer, target;

  Encounter(int i, double distance, const Vec3<double>& from) {
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double z = 1.0 - (2.0 * i + 1.0) / encounters, r = std::sqrt(1.0 - z * z), around = golden * i;
    const auto heading = [](double angle) { return Vec2<double>{std::cos(angle), std::sin(angle)}; };
    observer.p = {0.0, 0.0, 1.0};
    observer.d = heading(2.0 * i);
    target.d = heading(5.0 * i + 1.0);
    observer.v = {std::cos(i), std::sin(i), 0.0};
    observer.third = {away, away, away};
    target.v = {std::sin(2.0 * i), std::cos(2.0 * i), 0.0};
    const Vec3<double> direction = {r * std::cos(around), r * std::sin(around), z};
    const Vec2<double> level = rotate<double>(observer.d, {from.x, from.y});
    const Vec3<double> origin = observer.p + Vec3<double>{level.x, level.y, from.z};
    target.p = origin + distance * direction;
  }
};

/// Whether the limit is violated in all encounters at this distance (`broken`), or holds in all.
bool is_always(bool broken, const Potential& potential, double distance, const Vec3<double>& from) {
  for (int i = 0; i < encounters; ++i) {
    const Encounter e(i, distance, from);
    if ((potential.violation(e.observer, e.target, 0.1 * i) > 0) != broken) return false;
  }
  return true;
}

}  // namespace

bool limits_distance_from_below(const Potential& potential) {
  if (!potential.is_pair()) return false;
  const Vec3<double> body{}, sensor = potential.mount() != nullptr ? potential.mount()->offset : LeverArm{};
  return (is_always(true, potential, near, body) || is_always(true, potential, near, sensor)) &&
         is_always(false, potential, far, body);
}

bool keeps_apart(const Potential& potential) {
  const std::optional<bool> stated = potential.says_keeps_apart();
  return stated ? *stated : limits_distance_from_below(potential);
}

std::vector<Potential> keep_outs(const Potential& potential) {
  if (keeps_apart(potential)) return {potential};
  std::vector<Potential> found;
  for (Potential& one : potential.conjuncts()) {
    if (keeps_apart(one)) found.push_back(std::move(one));
  }
  return found;
}

bool observes(const Potential& potential) {
  const std::optional<bool> stated = potential.says_observes();
  return stated ? *stated : potential.mount() != nullptr && !keeps_apart(potential);
}

}  // namespace sightline
