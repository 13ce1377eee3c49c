/// Robots that go from one drawn place to the next and localize by looking at each other. Variances
/// of positions as numbers, no filter and no solver. Who looks at whom is chosen by the nearest or
/// by a ViewChooser.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/events.hpp"
#include "sightline/world.hpp"
#include "sightline/world/view_flight.hpp"

namespace sightline::test {

enum class Chooses { nearest_anchor, nearest, best };

struct LayoutOptions {
  int robots = 8, anchors = 2;  ///< the first ones know their places
  double area = 8.0;            ///< side of a square [m]
  double duration = 120.0, from = 10.0, speed = 0.5;
  double margin = 0.01;  ///< of `best`
  int at_most = 100;
};

struct LayoutFigures {
  double squares = 0.0;  ///< sum of variances [m^2]
  long samples = 0, blind = 0, rootless = 0, changes = 0;
  double minutes = 0.0;
  double least_between = 1e9;  ///< of two changes of one observer [s]
  int most_observers = 0;

  double sigma() const { return std::sqrt(squares / static_cast<double>(samples)); }
  double share(long part) const { return static_cast<double>(part) / static_cast<double>(samples); }
  double changes_a_minute() const { return static_cast<double>(changes) / minutes; }
  void add(const LayoutFigures& other) {
    squares += other.squares, samples += other.samples, blind += other.blind, rootless += other.rootless;
    changes += other.changes, minutes += other.minutes;
    least_between = std::min(least_between, other.least_between);
    most_observers = std::max(most_observers, other.most_observers);
  }
};

/// Of robots whose last n - anchors observe any other.
inline ViewChoice choice_of(const LayoutOptions& o, const ViewVariance& variance) {
  ViewChoice choice{.name = "best", .at_most = o.at_most, .margin = o.margin};
  for (int i = 0; i < o.robots; ++i) choice.targets.push_back(BodyId{i});
  for (int i = o.anchors; i < o.robots; ++i) choice.observers.push_back(AgentId{{i}});
  choice.variances.assign(choice.observers.size() * choice.targets.size(), variance);
  choice.first.assign(choice.observers.size(), ViewChoice::nobody);
  return choice;
}

class DrawnLayout {
 public:
  static constexpr double dt = 0.02, nearer_by = 0.3, reported = 1e-4;

  DrawnLayout(const LayoutOptions& options, const ViewVariance& variance, std::uint64_t seed)
      : o_(options), variance_(variance), chance_(seed, StreamId::draw, 0) {
    for (int i = 0; i < o_.robots; ++i) {
      team_.add(Multirotor{});
      Robot& robot = robots_.emplace_back();
      robot.p = draw(), robot.goal = draw(), robot.heading = 2 * std::numbers::pi * chance_.uniform();
    }
    x_.resize(size(team_.nx())), u_.resize(size(team_.nu()));
  }

  LayoutFigures run(Chooses how) {
    ViewChooser chooser(choice_of(o_, variance_));
    LayoutFigures sum;
    const double dwell = choice_of(o_, variance_).dwell;
    for (long k = 0; static_cast<double>(k) * dt < o_.duration; ++k) {
      const double t = static_cast<double>(k) * dt;
      move(t);
      if (how == Chooses::best) {
        ConditionState none;
        const EventContext known{.t = t, .x = x_, .u = u_, .ages = {}, .presence = {}};
        chooser.look({team_, known, 0.0, false, none});
        for (int i = o_.anchors; i < o_.robots; ++i) {
          const auto place = size(i - o_.anchors);
          if (chooser.changed(place)) turn(i, chooser.target(place), t, sum);
        }
      } else {
        for (int i = o_.anchors; i < o_.robots; ++i) nearest(i, how, dwell, t, sum);
      }
      learn(t, sum);
    }
    sum.minutes = o_.duration / 60 * (o_.robots - o_.anchors);
    return sum;
  }

 private:
  struct Robot {
    Vec2<double> p{}, goal{};
    double heading = 0.0, variance = 0.01, blind_for = 0.0;
    int sees = -1;
    double turned = -1e9, turn_end = 0.0, since = -1.0;
    double turn_rate = 0.0;
  };

  Vec2<double> draw() { return {o_.area * chance_.uniform(), o_.area * chance_.uniform()}; }
  double distance(int i, int j) const {
    return std::hypot(robots_[size(i)].p.x - robots_[size(j)].p.x,
                      robots_[size(i)].p.y - robots_[size(j)].p.y);
  }
  double bearing(int i, int j) const {
    return std::atan2(robots_[size(j)].p.y - robots_[size(i)].p.y,
                      robots_[size(j)].p.x - robots_[size(i)].p.x);
  }
  static double angle(double a) { return std::remainder(a, 2 * std::numbers::pi); }

  void move(double t) {
    for (int i = 0; i < o_.robots; ++i) {
      Robot& robot = robots_[size(i)];
      const double dx = robot.goal.x - robot.p.x, dy = robot.goal.y - robot.p.y, d = std::hypot(dx, dy);
      if (d < 0.2) {
        robot.goal = draw();
      } else {
        robot.p.x += o_.speed * dt * dx / d, robot.p.y += o_.speed * dt * dy / d;
      }
      if (robot.sees >= 0 && t <= robot.turn_end) robot.heading += dt * robot.turn_rate;
      if (robot.sees >= 0 && t > robot.turn_end) robot.heading = bearing(i, robot.sees);
      double* const x = &x_[size(team_.state_offset(BodyId{i}))];
      x[0] = robot.p.x, x[1] = robot.p.y, x[2] = 1.0;
      x[3] = std::cos(robot.heading), x[4] = std::sin(robot.heading);
    }
  }

  void turn(int i, int target, double t, LayoutFigures& sum) {
    Robot& robot = robots_[size(i)];
    sum.least_between = std::min(sum.least_between, t - robot.turned);
    if (robot.sees >= 0) ++sum.changes;
    robot.sees = target, robot.turned = t, robot.since = -1.0;
    if (target < 0) return;
    const double by = angle(bearing(i, target) - robot.heading), takes = 0.2 + std::abs(by) / 1.2;
    robot.turn_end = t + takes, robot.turn_rate = by / takes;
  }

  void nearest(int i, Chooses how, double dwell, double t, LayoutFigures& sum) {
    Robot& robot = robots_[size(i)];
    int best = -1;
    for (int j = 0; j < (how == Chooses::nearest ? o_.robots : o_.anchors); ++j)
      if (j != i && (best < 0 || distance(i, j) < distance(i, best))) best = j;
    if (robot.sees < 0) return turn(i, best, t, sum);
    if (distance(i, best) + nearer_by >= distance(i, robot.sees)) {
      robot.since = -1.0;
      return;
    }
    if (robot.since < 0) robot.since = t;
    if (t - robot.since >= dwell - 1e-9) turn(i, best, t, sum);
  }

  /// What comes from a target is as good as it and the view, however often it is looked at.
  void learn(double t, LayoutFigures& sum) {
    const TurnPrice blind;
    std::vector<int> observers(robots_.size());
    std::vector<double> next(robots_.size());
    for (int i = o_.anchors; i < o_.robots; ++i) {
      Robot& robot = robots_[size(i)];
      const double adds = robot.sees >= 0 ? variance_.at(distance(i, robot.sees)) : 1e9;
      const bool sees = robot.sees >= 0 && t > robot.turn_end && std::isfinite(adds);
      if (robot.sees >= 0) sum.most_observers = std::max(sum.most_observers, ++observers[size(robot.sees)]);
      robot.blind_for = sees ? 0.0 : robot.blind_for + dt;
      double v = robot.variance + blind.walk * blind.walk * dt +
                 2 * blind.drift_sigma * blind.drift_sigma * robot.blind_for * dt;
      if (sees) {
        const double known = (robot.sees < o_.anchors ? reported : robots_[size(robot.sees)].variance) + adds;
        if (v > known) v = known + (v - known) * std::exp(-dt / 0.2);
      }
      next[size(i)] = v;
      if (t < o_.from) continue;
      sum.squares += v, ++sum.samples, sum.blind += !sees;
      int on = i;
      for (int steps = 0; on >= o_.anchors && steps < o_.robots; ++steps) on = robots_[size(on)].sees;
      sum.rootless += on < 0 || on >= o_.anchors;
    }
    for (int i = o_.anchors; i < o_.robots; ++i) robots_[size(i)].variance = next[size(i)];
  }

  LayoutOptions o_;
  ViewVariance variance_;
  RandomStream chance_;
  Team team_;
  std::vector<Robot> robots_;
  std::vector<double> x_, u_;
};

/// The camera of 640 x 480 px and the tags of 0.2 m of the study.
inline const ViewVariance& variance_of_study() {
  static const ViewVariance variance =
      view_variance({.camera = {.width = 640, .height = 480}, .mount = {.pitch = 0.0, .offset = 0.0}});
  return variance;
}

inline LayoutFigures fly_layouts(const LayoutOptions& options, Chooses how, int layouts) {
  LayoutFigures sum;
  for (int i = 1; i <= layouts; ++i)
    sum.add(DrawnLayout(options, variance_of_study(), static_cast<std::uint64_t>(i)).run(how));
  return sum;
}

}  // namespace sightline::test
