/// How bodies moved from one sample to the next, and how near they came to each other and to walls meanwhile.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "sightline/model/model.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// A place on a motion. Between two of them it is the cubic that has both places and both velocities.
struct Knot {
  double time = 0.0;  ///< [s]
  Vec3<double> p{};   ///< [m]
  Vec3<double> v{};   ///< [m/s]
};

/// An extreme of a motion, and when.
struct Extreme {
  double value = 0.0, time = 0.0;  ///< [m], [s]
};

/// Lowers `least` to the least distance from 0 on the motion from a to b, to 1e-5 m. Never below a distance that is reached.
void find_least_distance(const Knot& a, const Knot& b, Extreme& least) noexcept;
/// Raises `most` to the greatest n . p on the motion from a to b, to 1e-5 m. Never above a value that is reached.
void find_greatest(const Knot& a, const Knot& b, const Vec3<double>& n, Extreme& most) noexcept;

/// The motion of each body of a team between the last two samples.
///
/// A robot's is that of its model from the first of them, under the inputs that were in force meanwhile:
///
///   p(s) = p_model(s) + (e_p - e_v T / 2) s / T + e_v s^2 / (2 T),   0 <= s <= T
///
/// with what it misses at the second, e_p [m] and e_v [m/s]: an acceleration that the model lacks is exact, and so is a
/// velocity that it lacks. Inputs that come into force between the samples divide it. The model's motion is cubic over steps
/// of at most 0.02 s. Another body moves on a straight line.
///
/// No motion is: what joins or leaves, a step that is longer than 1 m/s and twice the body's speed so far allow, and states
/// that are measured, not true. Such bodies are known at the samples alone. Bounded memory; allocates nothing after its construction.
class SampledMotion {
 public:
  /// @param input_delay  from a command to its effect [s], in [0, 1]
  /// @param period       the shortest time between two samples [s]
  explicit SampledMotion(const Team& team, double input_delay = 0.0, double period = 0.01);

  /// Takes the next sample, of sized_sample() for the team. Times rise.
  /// @param sights  of all bodies at the sample
  void follow(const Sample& sample, std::span<const Sight<double>> sights) noexcept;

  /// Whether a body's motion to the last sample is known.
  bool moved(BodyId body) const noexcept { return bodies_[at(body)].moved; }
  /// How far from its place at the last sample the body was at most since the one before [m]; 0 without a motion.
  double reach(BodyId body) const noexcept { return bodies_[at(body)].reach; }
  /// From sample to sample, as many for each body that moved().
  std::span<const Knot> knots(BodyId body) noexcept;
  /// Lowers `least` to the least distance of two bodies that both moved().
  void find_least_distance(BodyId a, BodyId b, Extreme& least) noexcept;

 private:
  struct Body {
    Model model;
    bool is_robot;
    std::size_t x, u;  // first state and input in the sample
    bool there = false, moved = false, has_knots = false;
    Vec3<double> p{}, v{};              // at the last sample
    Vec3<double> p_before{};            // at the one before
    double fastest = 0.0, reach = 0.0;  // [m/s], [m]
    std::vector<Knot> knots{};
  };
  void divide() noexcept;
  void fly(Body& body) noexcept;

  std::vector<Body> bodies_;
  InputDelay delay_;
  bool delays_;
  std::vector<double> x_, u_, x_before_, x_model_;
  std::vector<double> times_;        // of the knots since the sample before [s]
  std::vector<std::size_t> forces_;  // in force before each knot but the first: a row of held_
  std::vector<double> held_;
  double time_ = 0.0, period_ = 0.0;  // of the last sample, and since the one before [s]
  bool begun_ = false, truth_ = false;
};

}  // namespace sightline
