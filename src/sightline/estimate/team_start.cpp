#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/base/bounded.hpp"
#include "sightline/estimate/team_filter.hpp"

namespace sightline {
namespace {

constexpr double clear = 10.0;                    // a worse pose has a likelihood below e^-5 of the best
constexpr double apart_m = 0.3, apart_rad = 0.3;  // poses that differ by more are two
constexpr double step_m = 0.5, step_rad = 0.5;    // largest Gauss-Newton step
constexpr int directions = 16, headings = 16, refined = 12, iterations = 15;

struct Fitted {
  PlanarPose pose{};
  Mat<3, 3> information{};
  Column<3> slope{};
  double cost = infinity;  // y^T R^-1 y
  int components = 0;
};

bool same(const PlanarPose& a, const PlanarPose& b, double within_m = apart_m) {
  return norm(a.x - b.x, a.y - b.y) < within_m && std::abs(wrap(a.psi - b.psi)) < apart_rad;
}

}  // namespace

/// Maximum of the likelihood by Gauss-Newton from the best of many poses around another body. Lasting
/// errors are integrated out: with k = sigma^2 / (1 + sigma^2 q), R^-1 = w^-1 - k w^-1 s s^T w^-1.
std::optional<PoseGuess> TeamFilter::locate(int robot, std::span<const TeamSighting> frame) noexcept {
  const auto known = [&](int body) {
    constexpr double far = 0.5, turned = 0.3;  // [m], [rad]
    return body >= robots_ || (sigma(body, RobotState::x) < far && sigma(body, RobotState::y) < far &&
                               sigma(body, RobotState::psi) < turned);
  };
  const auto used = [&](const TeamSighting& z) {
    return is_usable(z) && z.subject >= 0 &&
           ((z.observer == robot && known(z.subject)) || (z.subject == robot && known(z.observer)));
  };
  const auto with_range = std::find_if(
      frame.begin(), frame.end(), [&](const TeamSighting& z) { return used(z) && z.of != Sighted::bearing; });
  if (with_range == frame.end()) return {};

  // k sightings that share an antenna of variance s^2: w 1 + s^2 1 1^T <= (w + k s^2) 1.
  int sharing = 0;
  for (const TeamSighting& z : frame)
    if (z.antenna >= 0 && used(z))
      sharing = std::max(
          sharing, static_cast<int>(std::count_if(frame.begin(), frame.end(), [&](const TeamSighting& other) {
            return used(other) && ((other.observer == z.observer && other.antenna == z.antenna) ||
                                   (other.subject == z.observer && other.other_antenna == z.antenna));
          })));
  const double by_antennas = 2 * sharing * square(noise_.antenna_error);

  const int k = index(robot, RobotState::x);
  const std::array before = {x_[at(k)], x_[at(k + 1)], x_[at(k + 2)]};
  const std::array sigma_squared = {square(noise_.range_error), square(noise_.bearing_error)};
  const auto fit = [&](const PlanarPose& pose) {
    x_[at(k)] = pose.x, x_[at(k + 1)] = pose.y, x_[at(k + 2)] = pose.psi;
    Fitted of{pose, {}, {}, 0.0, 0};
    std::fill(lasting_.begin(), lasting_.end(), LastingError{});
    for (const TeamSighting& z : frame) {
      if (!used(z)) continue;
      const Row row = row_of(z, -1);
      const int other = z.observer == robot ? 2 * z.subject : 2 * z.observer + 1;
      for (int a = 0; a < row.m; ++a) {
        const int component = z.of == Sighted::bearing ? 1 : a;
        const double range = z.range - (component == 0 ? row.y(a, 0) : 0.0);
        const double s = component == 0 ? range : 1.0;
        const double y = row.y(a, 0);
        double w = row.R(a, a) - sigma_squared[at(component)] * square(s) + by_antennas;
        Column<3> H;
        for (int l = 0; l < row.used; ++l) {
          const int column = row.columns[at(l)], i = column - k;
          if (i >= 0 && i < 3) {
            H(i, 0) = row.H(a, l);
          } else if (column < robots_ * robot_states && column % robot_states < first_constant) {
            w += square(row.H(a, l)) * P(column, column);  // pose of the other robot
          }
          // Each sighting shows the constants of its sensor in another way.
          if (column >= index(z.observer, RobotState::range_scale) &&
              column <= index(z.observer, RobotState::bearing_scale))
            w += square(row.H(a, l)) * P(column, column);
        }
        of.information += (1 / w) * (H * transposed(H));
        of.slope += (y / w) * H;
        of.cost += square(y) / w;
        ++of.components;
        LastingError& one = lasting_[at(2 * other + component)];
        one.q += square(s) / w, one.v += s * y / w, one.u += (s / w) * H;
      }
    }
    for (std::size_t i = 0; i < lasting_.size(); ++i) {
      const LastingError& one = lasting_[i];
      const double gain = sigma_squared[i % 2] / (1 + sigma_squared[i % 2] * one.q);
      of.information += -gain * (one.u * transposed(one.u));
      of.slope += -gain * one.v * one.u;
      of.cost -= gain * square(one.v);
    }
    return of;
  };

  // The best of a grid of poses at the measured range from another body.
  const TeamSighting& z = *with_range;
  const int other = z.observer == robot ? z.subject : z.observer;
  PlanarPose there;
  if (other < robots_) {
    there = pose(other).pose;
  } else {
    there = {landmarks_[at(other - robots_)].x, landmarks_[at(other - robots_)].y, 0.0};
  }
  const bool toward = z.of == Sighted::range_and_bearing;
  std::array<Fitted, refined> best{};
  for (int i = 0; i < headings; ++i)
    for (int j = 0; j < (toward ? 1 : directions); ++j) {
      const double psi = i * 2 * std::numbers::pi / headings;
      const double line = !toward               ? j * 2 * std::numbers::pi / directions
                          : z.observer == robot ? psi + z.bearing + std::numbers::pi
                                                : there.psi + z.bearing;
      const SinCos<double> e = sincos(line);
      const Fitted one = fit({there.x + z.range * e.cos, there.y + z.range * e.sin, psi});
      Fitted* const worst = std::max_element(
          best.begin(), best.end(), [](const Fitted& a, const Fitted& b) { return a.cost < b.cost; });
      if (one.cost < worst->cost) *worst = one;
    }
  for (Fitted& one : best) {
    for (int i = 0; i < iterations && std::isfinite(one.cost); ++i) {
      const Cholesky<3> factor(one.information + identity<3>(1e-9));
      if (!factor.positive) break;
      const Column<3> d = factor.solve(one.slope);
      const double longest = std::max({1.0, norm(d(0, 0), d(1, 0)) / step_m, std::abs(d(2, 0)) / step_rad});
      one = fit({one.pose.x + d(0, 0) / longest, one.pose.y + d(1, 0) / longest,
                 wrap(one.pose.psi + d(2, 0) / longest)});
    }
  }
  for (std::size_t i = 0; i < 3; ++i) x_[at(k) + i] = before[i];

  const Fitted& found = *std::min_element(best.begin(), best.end(),
                                          [](const Fitted& a, const Fitted& b) { return a.cost < b.cost; });
  const Cholesky<3> factor(found.information);
  const int freedom = std::max(found.components - 3, 0);
  if (!(found.cost <= sum_gate(freedom)) || !factor.positive) return {};  // false sightings fit nowhere
  for (const Fitted& one : best)
    if (!same(one.pose, found.pose) && one.cost < found.cost + clear) return {};
  return PoseGuess{found.pose, factor.solve(identity<3>())};
}

/// Whether a pose is too uncertain to associate sightings without identity one by one.
bool TeamFilter::is_lost(int robot) const noexcept {
  constexpr double far = 0.5, turned = 0.25;  // [m], [rad]
  return sigma(robot, RobotState::x) > far || sigma(robot, RobotState::y) > far ||
         sigma(robot, RobotState::psi) > turned;
}

/// Starts a robot again where landmarks explain most of its last sightings without identity, and no
/// other pose near the estimate does. Each hypothesis: one of the last sightings shows one landmark,
/// at one heading.
bool TeamFilter::find(int robot) noexcept {
  constexpr int used = 10, least = 8, first = 3, turns = 40;
  constexpr std::size_t near_max = 64;
  constexpr double hypotheses_apart_m = 2 * apart_m;
  constexpr double age_max = 8.0;                            // [s]
  constexpr double explained_m = 0.1, explained_rad = 0.02;  // standard deviation of a landmark's place
  constexpr double robot_m = 0.2;                            // of a robot, which moves between the sightings
  constexpr double unexplained = 12.4, likely = 6.0;         // costs, as of an association
  Robot& of = odometry_[at(robot)];
  if (of.refusals < used) return false;
  std::array<TeamSighting, used> frame;
  std::array<Vec2<double>, used> shown;  // in the frame of the robot
  const auto constant = [&](RobotState c) { return state(robot, c); };
  double farthest = 0.0;
  for (int i = 0; i < used; ++i) {
    const Refused& one = of.refused[at((of.refusals - 1 - i) % refused_sightings_max)];
    if (one.z.of != Sighted::range_and_bearing || now_ - one.z.stamp > age_max) return false;
    TeamSighting& z = frame[at(i)];
    z = moved(one);
    const double distance = (z.range - constant(RobotState::range_offset)) /
                            (1 + constant(RobotState::range_scale)) / depth_share(robot, z.bearing);
    const SinCos<double> e = sincos(z.bearing + constant(RobotState::sensor_turn));
    shown[at(i)] = {z.sensor.x + distance * e.cos, z.sensor.y + distance * e.sin};
    farthest = std::max(farthest, norm(shown[at(i)].x, shown[at(i)].y));
  }
  const PlanarPose here = pose(robot).pose;
  // A pose that is not lost but contradicted is wrong by more than it claims.
  const bool lost = is_lost(robot);
  const double position =
      norm(std::max(sigma(robot, RobotState::x), sigma(robot, RobotState::y)), lost ? 0.05 : wrong_position);
  const double heading = norm(sigma(robot, RobotState::psi), lost ? 0.05 : wrong_heading);
  const double within = 3 * position, sector = std::min(3 * heading, std::numbers::pi);
  struct Near {
    int body;
    double x, y, variance;
  };
  Bounded<Near, near_max> near;
  for (int j = 0; j < bodies(); ++j) {
    if (j == robot || near.is_full()) continue;
    Near one{j, 0.0, 0.0, 0.0};
    if (j < robots_) {
      const int other = index(j, RobotState::x);
      one = {j, x_[at(other)], x_[at(other + 1)],
             square(robot_m) + P(other, other) + P(other + 1, other + 1)};
    } else {
      one.x = landmarks_[at(j - robots_)].x, one.y = landmarks_[at(j - robots_)].y;
    }
    if (norm(one.x - here.x, one.y - here.y) < within + farthest) near.push_back(one);
  }
  struct Explained {
    PlanarPose pose{};
    int count = 0;
    double cost = infinity;
    std::array<int, used> body{};
  };
  const auto explained = [&](const PlanarPose& at_pose) {
    Explained result{at_pose, 0, 0.0, {}};
    result.cost = square(norm(at_pose.x - here.x, at_pose.y - here.y) / position) +
                  square((at_pose.psi - here.psi) / heading);
    const SinCos<double> e = sincos(at_pose.psi);
    for (int i = 0; i < used; ++i) {
      const Vec2<double>& p = shown[at(i)];
      const double x = at_pose.x + e.cos * p.x - e.sin * p.y, y = at_pose.y + e.sin * p.x + e.cos * p.y;
      const double variance = square(explained_m + explained_rad * norm(p.x, p.y));
      double least_cost = unexplained;
      result.body[at(i)] = -1;
      for (const Near& one : near) {
        const double c = (square(one.x - x) + square(one.y - y)) / (variance + one.variance);
        if (c < least_cost) least_cost = c, result.body[at(i)] = one.body;
      }
      result.cost += least_cost;
      if (result.body[at(i)] >= 0) ++result.count;
    }
    return result;
  };
  Explained best;
  double other = infinity;
  for (int i = 0; i < first; ++i)
    for (const Near& shown_body : near)
      for (int n = -turns; n <= turns; ++n) {
        const double psi = here.psi + n * sector / turns;
        const SinCos<double> e = sincos(psi);
        const Vec2<double>& p = shown[at(i)];
        const PlanarPose there{shown_body.x - (e.cos * p.x - e.sin * p.y),
                               shown_body.y - (e.sin * p.x + e.cos * p.y), psi};
        if (norm(there.x - here.x, there.y - here.y) > within) continue;
        const Explained one = explained(there);
        if (one.cost < best.cost) {
          if (!same(one.pose, best.pose, hypotheses_apart_m)) other = best.cost;
          best = one;
        } else if (!same(one.pose, best.pose, hypotheses_apart_m)) {
          other = std::min(other, one.cost);
        }
      }
  if (best.count < least || other < best.cost + likely) return false;
  std::size_t identified = 0;
  bool two_bodies = false;
  for (std::size_t i = 0; i < used; ++i)
    if (best.body[i] >= robots_) {
      frame[identified] = frame[i];
      frame[identified].subject = best.body[i];
      two_bodies = two_bodies || best.body[i] != frame[0].subject;
      ++identified;
    }
  if (!two_bodies) return false;
  Mat<3, 3> prior;
  prior(0, 0) = prior(1, 1) = square(position), prior(2, 2) = square(heading);
  const auto found = fit_near(robot, {frame.data(), identified}, {here, prior}, best.pose);
  if (!found) return false;
  restart(robot, *found);
  return true;
}

}  // namespace sightline
