/// A team of planar robots among landmarks, whose odometry and sightings have the errors of
/// TeamNoise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "sightline/estimate/team_filter.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

/// Drives the robots in arcs within a square of 8 m; all errors are drawn at the construction or as
/// they occur.
class SyntheticTeam {
 public:
  struct Constants {
    double speed_scale, turn_scale, turn_loss, yaw_rate_bias, clock_offset,
        wheel_turn = 0.0, sensor_turn = 0.0, range_scale = 0.0, range_depth = 0.0, axis_turn = 0.0,
        range_offset = 0.0, bearing_scale = 0.0;
  };
  struct Member {
    PlanarPose pose{};
    Constants of{};
    std::vector<WheelOdometry> odometry{};  // from the start on; each acts `clock_offset` late
    std::size_t at_work = 0;
  };
  static constexpr double dt = 0.02, sight_period = 0.26;

  SyntheticTeam(int robots, int landmarks, const TeamNoise& noise, std::uint64_t seed)
      : noise_(noise), random_(seed) {
    for (int i = 0; i < landmarks; ++i)
      marks.push_back({uniform(random_, -4, 4), uniform(random_, -4, 4), 0.0});
    for (int i = 0; i < robots; ++i) {
      Member one;
      one.pose = {uniform(random_, -2, 2), uniform(random_, -2, 2), uniform(random_, -3, 3)};
      one.of = {drawn(noise.speed_scale),
                drawn(noise.turn_scale),
                std::abs(drawn(noise.turn_loss)),
                drawn(noise.yaw_rate_bias),
                std::abs(drawn(noise.clock_offset)),
                drawn(noise.wheel_turn),
                drawn(noise.sensor_turn),
                drawn(noise.range_scale),
                drawn(noise.range_depth),
                drawn(noise.axis_turn),
                drawn(noise.range_offset),
                drawn(noise.bearing_scale)};
      members.push_back(one);
    }
  }

  double drawn(double sigma) { return sigma * normal_(random_); }
  double time() const { return t_; }

  /// Advances by dt; new odometry samples are at the end of `odometry`.
  void step() {
    for (Member& one : members) {
      if (one.odometry.empty() || uniform(random_, 0, 1) < dt / 3.0) {
        const double to_centre = wrap(std::atan2(-one.pose.y, -one.pose.x) - one.pose.psi);
        const bool away = norm(one.pose.x, one.pose.y) > 3.0;
        const double speed = uniform(random_, 0.1, 0.3), rate = uniform(random_, -0.5, 0.5);
        one.odometry.push_back({t_, speed, away ? std::copysign(0.5, to_centre) : rate});
      }
      while (one.at_work + 1 < one.odometry.size() &&
             one.odometry[one.at_work + 1].t + one.of.clock_offset <= t_)
        ++one.at_work;
      const bool starts = one.odometry[one.at_work].t + one.of.clock_offset <= t_;
      const WheelOdometry u = starts ? one.odometry[one.at_work] : WheelOdometry{};
      const double v =
          std::max(0.0, (1 + one.of.speed_scale) * u.v - one.of.turn_loss * std::abs(u.yaw_rate));
      const double r = (1 + one.of.turn_scale) * u.yaw_rate + one.of.yaw_rate_bias;
      const SinCos<double> ahead = sincos(one.pose.psi + one.of.wheel_turn + 0.5 * dt * r);
      const double along = v * dt + drawn(noise_.distance_noise * std::sqrt(v * dt));
      const double across = drawn(noise_.skid_noise * std::sqrt(v * dt));
      one.pose.x += along * ahead.cos - across * ahead.sin + drawn(noise_.position_walk * std::sqrt(dt));
      one.pose.y += along * ahead.sin + across * ahead.cos + drawn(noise_.position_walk * std::sqrt(dt));
      one.pose.psi += r * dt + drawn(noise_.curve_noise * std::sqrt(v * dt)) +
                      drawn(noise_.turn_noise * std::sqrt(std::abs(u.yaw_rate) * dt)) +
                      drawn(noise_.heading_walk * std::sqrt(dt));
    }
    t_ += dt;
  }

  /// What a robot sees: bodies within 5 m and 0.6 rad of ahead.
  std::vector<TeamSighting> sightings(int observer) {
    std::vector<TeamSighting> seen;
    const Member& i = members[static_cast<std::size_t>(observer)];
    for (int j = 0; j < static_cast<int>(members.size() + marks.size()); ++j) {
      if (j == observer) continue;
      const auto k = static_cast<std::size_t>(j);
      const double x = k < members.size() ? members[k].pose.x : marks[k - members.size()].x;
      const double y = k < members.size() ? members[k].pose.y : marks[k - members.size()].y;
      const double range = norm(x - i.pose.x, y - i.pose.y);
      const double bearing = wrap(std::atan2(y - i.pose.y, x - i.pose.x) - i.pose.psi);
      if (range > 5.0 || range < 0.3 || std::abs(bearing) > 0.6) continue;
      const auto [rho, eta] = lasting(observer, j);
      TeamSighting z;
      z.stamp = t_, z.observer = observer, z.subject = j;
      const double off_axis = bearing - i.of.sensor_turn,
                   flat = 1 + i.of.range_depth * (std::cos(off_axis - i.of.axis_turn) - 1);
      z.range = range * flat * (1 + i.of.range_scale) * (1 + rho) + i.of.range_offset +
                drawn(noise_.range_noise) + drawn(noise_.range_share * range);
      z.bearing = off_axis * (1 + i.of.bearing_scale) + eta + drawn(noise_.bearing_noise);
      seen.push_back(z);
    }
    return seen;
  }

  std::vector<TeamFilter::Landmark> marks;
  std::vector<Member> members;

 private:
  /// Gauss-Markov errors of a pair, drawn exactly between any two times.
  std::pair<double, double> lasting(int i, int j) {
    const auto found = errors_.try_emplace({i, j});
    const bool first = found.second;
    auto& [rho, eta, last] = found.first->second;
    const double at = last;
    const auto advance = [&](double& e, double sigma, double tau) {
      const double a = first ? 0.0 : std::exp(-(t_ - at) / tau);
      e = a * e + drawn(sigma * std::sqrt(1 - a * a));
    };
    advance(rho, noise_.range_error, noise_.range_error_time);
    advance(eta, noise_.bearing_error, noise_.bearing_error_time);
    last = t_;
    return {rho, eta};
  }
  struct Errors {
    double rho = 0.0, eta = 0.0, at = 0.0;
  };

  TeamNoise noise_;
  Random random_;
  std::normal_distribution<double> normal_;
  double t_ = 0.0;
  std::map<std::pair<int, int>, Errors> errors_;
};

}  // namespace sightline::test
