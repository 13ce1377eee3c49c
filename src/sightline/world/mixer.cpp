#include "sightline/world/mixer.hpp"

#include <algorithm>

#include "sightline/world.hpp"

namespace sightline {
namespace {

/// Torque per thrust of rotor i [m].
Vec3<double> torque_of(const Vehicle& v, std::size_t i) {
  return {v.rotor_y[i], -v.rotor_x[i], -v.spin[i] * v.k_m};
}

/// A A^T by its columns, where the columns of A are the torques.
Rotation gram(const Vehicle& v) {
  Rotation g{{}, {}, {}};
  for (std::size_t i = 0; i < v.rotors(); ++i) {
    const Vec3<double> a = torque_of(v, i);
    g.x = g.x + a.x * a, g.y = g.y + a.y * a, g.z = g.z + a.z * a;
  }
  return g;
}

double determinant(const Rotation& m) { return dot(m.x, cross(m.y, m.z)); }

}  // namespace

bool Mixer::steers(const Vehicle& v) {
  const Rotation g = gram(v);
  return determinant(g) > 1e-6 * g.x.x * g.y.y * g.z.z;
}

Mixer::Mixer(const Vehicle& v) : rotors_(v.rotors()), top_(v.k_f * square(v.speed_max)) {
  const Rotation g = gram(v);
  const double scale = 1 / determinant(g);
  for (std::size_t i = 0; i < rotors_; ++i) {
    // (A A^T)^-1 is symmetric; its rows are the cross products of the columns, over the
    // determinant.
    const Vec3<double> a = torque_of(v, i);
    of_torque_[i] = {scale * dot(cross(g.y, g.z), a), scale * dot(cross(g.z, g.x), a),
                     scale * dot(cross(g.x, g.y), a)};
  }
}

Thrusts Mixer::operator()(double thrust, const Vec3<double>& torque) const noexcept {
  Thrusts tilt{}, turn{};
  double low = 0.0, high = 0.0;
  for (std::size_t i = 0; i < rotors_; ++i) {
    tilt[i] = of_torque_[i].x * torque.x + of_torque_[i].y * torque.y;
    turn[i] = of_torque_[i].z * torque.z;
    low = std::min(low, tilt[i]), high = std::max(high, tilt[i]);
  }
  const double scale = high - low > top_ ? top_ / (high - low) : 1.0;
  const double each = std::clamp(thrust / static_cast<double>(rotors_), -scale * low,
                                 std::max(-scale * low, top_ - scale * high));
  double part = 1.0;
  for (std::size_t i = 0; i < rotors_; ++i) {
    tilt[i] = each + scale * tilt[i];
    const double room = turn[i] > 0 ? top_ - tilt[i] : tilt[i], requested = std::abs(turn[i]);
    if (part * requested > room) part = std::max(room, 0.0) / requested;
  }
  for (std::size_t i = 0; i < rotors_; ++i) tilt[i] = std::clamp(tilt[i] + part * turn[i], 0.0, top_);
  return tilt;
}

}  // namespace sightline
