/// Robots on a circle, each bound for the place across: they all meet in the middle.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/potentials.hpp"
#include "sightline/team.hpp"
#include "tests/support/random.hpp"

namespace sightline {

struct Swap {
  static constexpr double d_hard = 0.6, radius = 2.5;

  Team team;
  std::vector<AgentId> robots;
  std::vector<double> x0;
  std::vector<Vec3<double>> goals;

  /// @param scatter  of the starts, each axis [m]
  explicit Swap(int n, double circle = 8.0, double delta = 0.25, double scatter = 0.0, std::uint64_t seed = 1)
      : Swap(n, {.circle = circle, .scatter = scatter, .seed = seed},
             16.0 * PassRight{.d_min = 1.2, .delta = delta, .kappa = 15.0}, radius, 320) {}

  struct SpscQueue {
    double circle = 8.0;   // its radius [m]
    double pace = 0.8;     // of the reference [m/s]
    double scatter = 0.0;  // of the starts, each axis [m]
    std::uint64_t seed = 1;
  };

  /// As scenarios/swarm32.toml up to 32 robots, and as scenarios/swarm128.toml beyond, where many
  /// press on those in the middle and the potential is stronger. Their places are 1.57 m apart, or
  /// 1.2 m on a ring too wide to cross within a minute.
  static Swap of(int n) {
    if (n <= 32) return Swap(n);
    const double circle = std::fmax(std::fmin(0.25 * n, 50.0), 0.195 * n);
    return Swap(n, {.circle = circle, .pace = std::fmin(0.05 * circle, 2.2)},
                128.0 * PassRight{.d_min = 0.9, .delta = 0.25, .kappa = 15.0}, 2.0, 30 * n);
  }

 private:
  Swap(int n, const SpscQueue& ring, const Weighted& term, double reach, int room) {
    const double circle = ring.circle, pace = ring.pace, scatter = ring.scatter;
    Random random(ring.seed);
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n, heading = angle + std::numbers::pi;
      const auto off = [&] { return scatter * uniform(random, -1.0, 1.0); };
      const Vec3<double> there = {circle * std::cos(angle), circle * std::sin(angle), 1.5};
      const Vec3<double> start = there + Vec3<double>{off(), off(), off()};
      goals.push_back({-there.x, -there.y, there.z});
      robots.push_back(team.add(Multirotor{}, {.Q = {0.3, 0.3, 1.0, 1.0, 1.0, 0.1, 0.1},
                                               .R = {0.5, 0.5, 0.5, 0.5},
                                               .x_ref = Waypoints{.times = {0.0, 2.0 * circle / pace},
                                                                  .p = {start, goals.back()},
                                                                  .heading = {heading, heading}}}));
      x0.insert(x0.end(), {start.x, start.y, start.z, std::cos(heading), std::sin(heading), 0.0, 0.0});
    }
    team.keep_apart(term, robots, reach, room);
  }

 public:
  static Vec3<double> position(std::span<const double> x, std::size_t robot) {
    return {x[7 * robot], x[7 * robot + 1], x[7 * robot + 2]};
  }
  double least_distance(std::span<const double> x) const {
    double least = 1e9;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) least = std::fmin(least, norm(position(x, i) - position(x, j)));
    }
    return least;
  }
  int pairs_within(std::span<const double> x, double distance) const {
    int pairs = 0;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) pairs += norm(position(x, i) - position(x, j)) < distance;
    }
    return pairs;
  }
  /// How far the last robot is from its goal [m].
  double to_go(std::span<const double> x) const {
    double most = 0.0;
    for (std::size_t i = 0; i < robots.size(); ++i) most = std::fmax(most, norm(position(x, i) - goals[i]));
    return most;
  }
};

}  // namespace sightline
