/// Potentials as a field: value, gradient and Hessian over many places at once, from the formula's own graph.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sightline/formula/derive.hpp"
#include "sightline/formula/interpret.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// Where two bodies are, at rest, at time 0.
struct Station {
  Vec3<double> observer{}, target{};   ///< in G [m]
  double psi = 0.0, psi_target = 0.0;  ///< headings [rad]
};

Sight<double> observer_of(const Station& s);
Sight<double> target_of(const Station& s);

/// A station whose observer is at the origin, heading along x, and whose target is at p_S in the frame of a sensor;
/// without a sensor S is the observer's own frame V.
Station seen_at(const Vec3<double>& p_S, const SensorMount* mount);
/// The target in the frame of the sensor.
Vec3<double> in_sensor_frame(const Station& s, const SensorMount* mount);

/// What a field is at a station; derivatives by the target's position in G [m] and by both headings [rad].
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
  /// Eigenvalues of the Hessian by the position, rising [1/m^2].
  std::array<double, 3> curvatures() const;
};

/// The value of a potential alone; equal programs are the same formula with the same numbers.
Program formula_of(const Potential& potential);

/// Whether it matters where in G two bodies are, besides where they are to each other; by its gradients at random poses.
bool sees_place(const Potential& potential);
/// The same potential as it is around a place of G: that place becomes the origin.
Potential moved_to(const Vec3<double>& place, const Potential& potential);

/// Where a body is at the states x (team.nx()) and inputs of 0; empty: at the origin.
Vec3<double> place_at(const Team& team, BodyId body, std::span<const double> x);

/// The couplings of a team, each as it is while its third body stays where the states x (team.nx()) have it; empty: at the origin.
std::vector<Coupling> with_thirds_at(const Team& team, std::span<const double> x);

/// A potential of a coupling as its field counts it.
struct FieldTerm {
  Weighted term;
  bool turned = false;  ///< the field's target is its observer
};

/// A weighted sum of potentials between the same two bodies. Making it records and derives the formula.
class Field {
 public:
  explicit Field(std::span<const FieldTerm> terms);
  explicit Field(const Potential& potential);

  std::vector<FieldValue> operator()(std::span<const Station> stations) const;
  FieldValue operator()(const Station& station) const;
  /// Whether it depends on the observer's heading.
  bool sees_heading() const { return sees_heading_; }

 private:
  bool sees_heading_ = false;
  Program program_;
};

/// Ascending eigenvalues of a symmetric 3 x 3 matrix {xx, xy, xz, yy, yz, zz}.
std::array<double, 3> eigenvalues(const std::array<double, 6>& m);

/// A place to which Newton's method with Levenberg's damping comes down.
struct Rest {
  Station station;
  double l = 0.0;
  bool is_minimum = false;  ///< the gradient vanished where the Hessian is not negative
};

/// @param free  which of the FieldValue::variables may move
Rest descend(const Field& field, const Station& start, std::span<const int> free);

}  // namespace sightline
