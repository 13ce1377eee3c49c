/// Motion of bodies between two samples, and its least distances to other bodies and to walls.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/loop.hpp"
#include "sightline/model.hpp"
#include "sightline/team.hpp"
#include "sightline/world.hpp"

namespace sightline {

/// A point of a motion. Between two knots the motion is the cubic through both positions and
/// velocities (Hermite).
struct Knot {
  double time = 0.0;  ///< [s]
  Vec3<double> p{};   ///< [m]
  Vec3<double> v{};   ///< [m/s]
};

/// An extreme value of a motion and its time.
struct Extreme {
  double value = 0.0, time = 0.0;  ///< [m], [s]
};

/// Lowers `least` to the least distance from 0 on the motion from a to b, to 1e-5 m. Never below a
/// distance that is reached.
void find_least_distance(const Knot& a, const Knot& b, Extreme& least) noexcept;
/// Raises `most` to the greatest n . p on the motion from a to b, to 1e-5 m. Never above a value
/// that is reached.
void find_greatest(const Knot& a, const Knot& b, const Vec3<double>& n, Extreme& most) noexcept;
/// Raises `most` to the greatest distance beyond a zone's boundary on the motion from a to b, to
/// 1e-4 m. Never above a value that is reached.
void find_greatest(const Knot& a, const Knot& b, const Zone& zone, Extreme& most) noexcept;

/// Motion of each body of a team between the last two samples.
///
/// The motion of a robot is that of its model from the first sample, with the inputs in force,
/// corrected by
///
///   p(s) = p_model(s) + (e_p - e_v T / 2) s / T + e_v s^2 / (2 T),   0 <= s <= T
///
/// with the model's error at the second sample, e_p [m] and e_v [m/s]. The correction is exact if
/// the model lacks a constant acceleration or a constant velocity. Inputs that come into force
/// between the samples divide the interval. The model's motion is cubic over steps of at most 0.02
/// s. Any other body moves on a straight line.
///
/// Three cases have no motion and are known only at the samples: a body that joins or leaves; a
/// step longer than 1 m/s plus twice the body's greatest speed so far allow; measured states
/// instead of true ones. Memory is bounded; nothing allocates after construction.
class SampledMotion {
 public:
  /// @param input_delay  from a command to its effect [s], in [0, 1]
  /// @param period       shortest time between two samples [s]
  explicit SampledMotion(const Team& team, double input_delay = 0.0, double period = 0.01);

  /// Adds the next sample, sized by sized_sample() for the team. Times must increase.
  /// @param sights  of all bodies at the sample
  void follow(const Sample& sample, std::span<const Sight<double>> sights) noexcept;

  /// True if a body's motion to the last sample is known.
  bool moved(BodyId body) const noexcept { return bodies_[at(body)].moved; }
  /// Greatest distance of the body from its position at the last sample since the previous sample
  /// [m]; 0 without a motion.
  double reach(BodyId body) const noexcept { return bodies_[at(body)].reach; }
  /// Knots from sample to sample; the same number for each body that moved().
  std::span<const Knot> knots(BodyId body) noexcept;
  /// Lowers `least` to the least distance of two bodies that both moved().
  void find_least_distance(BodyId a, BodyId b, Extreme& least) noexcept;

 private:
  struct Body {
    Model model;
    bool is_robot;
    std::size_t x, u;  // index of the first state and input in the sample
    bool there = false, moved = false, has_knots = false;
    Vec3<double> p{}, v{};              // at the last sample
    Vec3<double> p_before{};            // at the previous sample
    double fastest = 0.0, reach = 0.0;  // [m/s], [m]
    std::vector<Knot> knots{};
  };
  void divide() noexcept;
  void fly(Body& body) noexcept;

  std::vector<Body> bodies_;
  InputDelay delay_;
  bool delays_;
  std::vector<double> x_, u_, x_before_, x_model_;
  std::vector<double> times_;        // of the knots since the previous sample [s]
  std::vector<std::size_t> forces_;  // row of held_ in force before each knot except the first
  std::vector<double> held_;
  double time_ = 0.0, period_ = 0.0;  // of the last sample, and since the previous one [s]
  bool begun_ = false, truth_ = false;
};

}  // namespace sightline
