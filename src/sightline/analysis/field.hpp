/// Potentials as a field: value, gradient and Hessian at many places at once, from the formula's
/// graph.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sightline/formula.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// Poses of two bodies at rest at time 0.
struct Station {
  Vec3<double> observer{}, target{};   ///< in G [m]
  double psi = 0.0, psi_target = 0.0;  ///< headings [rad]
};

Sight<double> observer_of(const Station& s);
Sight<double> target_of(const Station& s);

/// A station with the observer at the origin, heading along x, and the target at p_S in the frame S
/// of the sensor. If `mount` is null, S is the observer's own frame V.
Station seen_at(const Vec3<double>& p_S, const SensorMount* mount);
/// Position of the target in the frame of the sensor [m]; in V if `mount` is null.
Vec3<double> in_sensor_frame(const Station& s, const SensorMount* mount);

/// Value and derivatives of a field at a station, by the target's position in G [m] and by both
/// headings [rad].
struct FieldValue {
  static constexpr int variables = 5;  ///< target.x, .y, .z, psi, psi_target

  double l = 0.0;
  std::array<double, variables> first{};
  std::array<double, variables*(variables + 1) / 2> second{};  ///< `upper_index`

  double slope() const;                    ///< |gradient| by the position [1/m]
  double yaw() const { return first[3]; }  ///< [1/rad]
  double at(int i, int j) const {
    return second[static_cast<std::size_t>(upper_index(std::min(i, j), std::max(i, j), variables))];
  }
  /// Eigenvalues of the Hessian by the position, ascending [1/m^2].
  std::array<double, 3> curvatures() const;
};

/// The value of a potential alone. Equal programs are the same formula with the same numbers.
Program formula_of(const Potential& potential);

/// Whether a potential depends on the bodies' places in G, not only on their relative pose. Tests
/// the sum of both position gradients at random poses.
bool sees_place(const Potential& potential);
/// The same potential with `place` of G as its origin.
Potential moved_to(const Vec3<double>& place, const Potential& potential);

/// Position of a body [m] at the states x (team.nx()) and zero inputs; if x is empty, the origin.
Vec3<double> place_at(const Team& team, BodyId body, std::span<const double> x);

/// The couplings of a team, with each third body fixed at the states x (team.nx()); if x is empty,
/// at the origin.
std::vector<Coupling> with_thirds_at(const Team& team, std::span<const double> x);

/// A potential of a coupling as a term of a field.
struct FieldTerm {
  Weighted term;
  bool turned = false;  ///< the field's target is the potential's observer
};

/// A weighted sum of potentials between the same two bodies. Construction records and
/// differentiates the formula.
class Field {
 public:
  explicit Field(std::span<const FieldTerm> terms);
  explicit Field(const Potential& potential);

  std::vector<FieldValue> operator()(std::span<const Station> stations) const;
  FieldValue operator()(const Station& station) const;
  /// Whether the field depends on the observer's heading.
  bool sees_heading() const { return sees_heading_; }

 private:
  bool sees_heading_ = false;
  Program program_;
};

/// Ascending eigenvalues of a symmetric 3 x 3 matrix {xx, xy, xz, yy, yz, zz}.
std::array<double, 3> eigenvalues(const std::array<double, 6>& m);

/// End point of Newton's method with Levenberg damping.
struct Rest {
  Station station;
  double l = 0.0;
  bool is_minimum = false;  ///< the gradient vanished and the Hessian is positive semidefinite
};

/// Descends from `start`.
/// @param free  indices of the FieldValue::variables that may change
Rest descend(const Field& field, const Station& start, std::span<const int> free);

}  // namespace sightline
