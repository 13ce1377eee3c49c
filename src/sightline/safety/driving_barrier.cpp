#include "sightline/safety/driving_barrier.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/safety/barrier_rows.hpp"
#include "sightline/safety/barrier_threats.hpp"
#include "sightline/safety/row_projection.hpp"

namespace sightline {
namespace {

constexpr double driving_rounding = 1e-9;     // [m] tolerance of a condition
constexpr int most_driving_conditions = 128;  // if more bodies are near, the robot brakes

/// The segment on which a robot brakes, from p to p + length along; `time` until it stands.
struct BrakingPath {
  Vec3<double> at(double part) const {
    return {p.x + part * length * along.x, p.y + part * length * along.y, p.z};
  }
  /// Least n . x of its points x.
  double support(const Vec3<double>& n) const { return std::min(dot(n, p), dot(n, at(1.0))); }
  Vec3<double> nearest(const Vec3<double>& q) const {
    const double ahead = along.x * (q.x - p.x) + along.y * (q.y - p.y);
    return length > 0 ? at(std::clamp(ahead / length, 0.0, 1.0)) : p;
  }

  Vec3<double> p;
  Vec2<double> along;
  double length, time;
};

BrakingPath braking_path(const BarrierLaw& law, const Vec3<double>& p, const Vec2<double>& v, double part) {
  const double speed = norm(v.x, v.y);
  const Stop stop = law.stop(speed, part);
  if (stop.time == 0) return {p, {1, 0}, 0.0, 0.0};
  return {p, {v.x / speed, v.y / speed}, stop.length, stop.time};
}

/// From the nearest point of `b` to that of `a`.
Vec3<double> between_paths(const BrakingPath& a, const BrakingPath& b) {
  // In the plane the least distance is at an end of one of them, unless they cross.
  const Vec3<double> a_end = a.at(1.0), b_end = b.at(1.0);
  std::array<Vec3<double>, 4> between = {a.p - b.nearest(a.p), a_end - b.nearest(a_end), a.nearest(b.p) - b.p,
                                         a.nearest(b_end) - b_end};
  const double across = a.along.x * b.along.y - a.along.y * b.along.x;
  const Vec3<double> r = b.p - a.p;
  if (a.length > 0 && b.length > 0 && across != 0) {
    const double of_a = (r.x * b.along.y - r.y * b.along.x) / across,
                 of_b = (r.x * a.along.y - r.y * a.along.x) / across;
    if (of_a >= 0 && of_a <= a.length && of_b >= 0 && of_b <= b.length) return {0, 0, a.p.z - b.p.z};
  }
  return *std::min_element(between.begin(), between.end(), [](const auto& one, const auto& other) {
    return dot(one, one) < dot(other, other);
  });
}

/// What the path after the period must keep: dist(x, at) >= least of a ball, or at . x >= least.
struct Condition {
  Vec3<double> at;
  bool is_ball;
  double least;    // [m]
  double speed;    // growth of the ball while the robot moves [m/s]
  double reserve;  // h [m]
  int neighbour;
  Wall wall;
};

/// The bodies and walls of a period as conditions on the path.
class Conditions {
 public:
  Conditions(const BarrierLaw& law, const BarrierPeriod& now)
      : law_(law),
        now_(now),
        path_(braking_path(law, now.self.p, {now.self.v.x, now.self.v.y}, now.part)),
        kept_part_(1.0 - law.options.rate * law.dt) {
    // No command moves a point of the path by more than this.
    const double speed = norm(now.self.v.x, now.self.v.y) + law.can.push * law.dt;
    const Stop later = law.stop(speed, now.part);
    latest_ = later.time + law.dt;
    shift_ = law.dt * (speed + latest_ * law.can.push);
  }

  /// The condition of a neighbour.
  Condition of(const Neighbour& n, int index) const {
    const double age = std::max(n.age, 0.0), drift = 3 * law_.options.velocity_sigma;
    double rho = n.d_hard + law_.options.margin + 3 * n.sigma;
    if (n.behavior != Behavior::cooperative) {
      rho += n.speed_max * age;
      const double speed = n.speed_max + drift, h = norm(path_.nearest(n.p) - n.p) - rho - speed * path_.time;
      // A body that moves may use up all of the reserve at once.
      const double wanted = speed > 0 ? std::min(h, 0.0) : wanted_of(h);
      return {n.p, true, rho + wanted, speed, h, index, Wall::none};
    }
    const double fast = norm(n.v.x, n.v.y), a = std::min(n.acceleration_max, of_member(fast, age));
    const BrakingPath other = braking_path(law_, n.p + age * n.v, {n.v.x, n.v.y}, std::min(n.part, 1.0));
    rho += 0.5 * a * age * age + a * age * law_.stop(fast + a * age, n.part).time + drift * path_.time;
    Vec3<double> r = between_paths(path_, other);
    double D = norm(r);
    if (!(D > 1e-9)) r = path_.p - other.p, D = 0.0;
    const double length = norm(r);
    const Vec3<double> n_G = length > 1e-9 ? (1.0 / length) * r : Vec3<double>{n.tie, 0, 0};
    const double h = D - rho;
    return {n_G,   false,     path_.support(n_G) - law_.options.share * (h - wanted_of(h)), 0.0, h,
            index, Wall::none};
  }

  /// Adds a neighbour, unless no command of one period can break its condition.
  void add(const Neighbour& n, int index) {
    const Condition one = of(n, index);
    least_ = std::min(least_, one.reserve);
    const double used = law_.options.rate * law_.dt * one.reserve;
    const double spare = !one.is_ball    ? law_.options.share * used
                         : one.speed > 0 ? one.reserve - one.speed * (law_.dt + latest_ - path_.time)
                                         : used;
    if (spare >= shift_) return;
    if (all_.size() >= most_driving_conditions)
      too_many_ = true;
    else
      all_.push_back(one);
  }
  void add(const BoundPlane& plane) {
    const Vec3<double> n = {plane.n.x, plane.n.y, 0.0};
    const double h = plane.offset + path_.support(n);
    all_.push_back({n, false, wanted_of(h) - plane.offset, 0.0, h, -1, plane.wall});
  }

  /// What a condition leaves after the motion of a period [m].
  double left(const Condition& one, const Flown& flown, const BrakingPath& after) const {
    if (one.is_ball && one.speed > 0 && path_.time == 0 && after.time == 0) return infinity;  // it stands
    double least = one.is_ball ? norm(after.nearest(one.at) - one.at) - one.speed * (law_.dt + after.time)
                               : after.support(one.at);
    for (std::size_t k = 0; k < flown.between.size(); ++k) {
      const double s = law_.dt * static_cast<double>(k + 1) / law_.parts;
      least = std::min(least, one.is_ball ? norm(flown.between[k] - one.at) - one.speed * s
                                          : dot(one.at, flown.between[k]));
    }
    return least - one.least;
  }
  double left(std::span<const double> u) const { return tightest(u).left; }

  struct Tightest {
    const Condition* condition;
    double left;
  };
  Tightest tightest(std::span<const double> u) const {
    const Flown flown = law_.flown(now_.x, u);
    BrakingPath after = braking_path(law_, flown.after.p, flown.after.v, now_.part);
    // Rounding must not turn a robot that stands into one that moves.
    if (norm(flown.after.v.x, flown.after.v.y) > 0.5 * BarrierLaw::still)
      after.time = std::max(after.time, law_.dt);
    Tightest found = {nullptr, infinity};
    for (const Condition& one : all_) {
      const double here = left(one, flown, after);
      if (found.condition == nullptr || here < found.left) found = {&one, here};
    }
    return found;
  }

  /// Least reserve of all neighbours, and of the conditions, walls included [m].
  double least_reserve() const { return least_; }
  double least_of_all() const {
    double least = least_;
    for (const Condition& one : all_) least = std::min(least, one.reserve);
    return least;
  }
  bool too_many() const { return too_many_; }

 private:
  double wanted_of(double h) const { return h > 0 ? kept_part_ * h : h; }
  /// Greatest acceleration of a cooperative neighbour of a measured speed and age.
  double of_member(double speed, double age) const {
    return law_.can.push + law_.can.drag * (speed + law_.can.push * age);
  }

  const BarrierLaw& law_;
  const BarrierPeriod& now_;
  BrakingPath path_;
  double kept_part_, shift_, latest_, least_ = infinity;
  Bounded<Condition, most_driving_conditions + 4 + most_pieces> all_;  // planes after the neighbours
  bool too_many_ = false;
};

/// The command of the plan.
std::array<double, most_inputs> braking_command(const BarrierLaw& law, const BarrierPeriod& now) {
  std::array<double, most_inputs> command{};
  const std::size_t nu = now.u_min.size(), k = static_cast<std::size_t>(law.can.drive);
  for (std::size_t i = 0; i < nu; ++i) command[i] = std::clamp(0.0, now.u_min[i], now.u_max[i]);
  const Vec2<double>& d = now.self.d;
  const double speed = d.x * now.self.v.x + d.y * now.self.v.y;
  const double wanted = std::copysign(law.stop(std::abs(speed), now.part).next_speed, speed);
  // The next speed is affine in the input.
  const auto next_speed = [&](double u_k) {
    command[k] = u_k;
    const NextState next = law.next(now.x, std::span(command).first(nu));
    return dot(next.d, next.v);
  };
  const double low = next_speed(now.u_min[k]), high = next_speed(now.u_max[k]);
  const double part = std::abs(high - low) > 0 ? (wanted - low) / (high - low) : 0.0;
  command[k] = std::clamp(now.u_min[k] + part * (now.u_max[k] - now.u_min[k]), now.u_min[k], now.u_max[k]);
  return command;
}

/// Search for the nearest command, from the plan's own.
class NearestCommand {
 public:
  NearestCommand(const BarrierLaw& law, const BarrierPeriod& now, const Conditions& conditions,
                 std::span<const double> nominal)
      : now_(now),
        conditions_(conditions),
        nominal_(nominal),
        drive_(static_cast<std::size_t>(law.can.drive)),
        braking_(braking_command(law, now)),
        best_(braking_),
        least_(infinity) {
    if (conditions.too_many()) return;
    if (nominal.size() == 1) {
      try_turn(0.0);
      return;
    }
    const std::size_t turn = 1 - drive_;
    const double low = now.u_min[turn], high = now.u_max[turn];
    try_turn(nominal[turn]);
    constexpr int steps = 4, rounds = 3;
    for (int i = 0; i <= steps; ++i) try_turn(low + (high - low) * i / steps);
    double step = (high - low) / (2 * steps);
    for (int round = 0; round < rounds; ++round, step *= 0.5) {
      const double around = best_[turn];
      for (const double other : {around - step, around + step}) try_turn(std::clamp(other, low, high));
    }
  }
  const std::array<double, most_inputs>& best() const { return best_; }

 private:
  /// The nearest command with this turn, on the line from the braking drive to the nominal one.
  void try_turn(double turn) {
    const std::size_t nu = nominal_.size();
    std::array<double, most_inputs> u{};
    if (nu > 1) u[1 - drive_] = turn;
    const double turned = nu > 1 ? square(turn - nominal_[1 - drive_]) : 0.0;
    if (turned >= least_) return;
    const auto is_kept = [&](double part) {
      u[drive_] = std::clamp(braking_[drive_] + part * (nominal_[drive_] - braking_[drive_]),
                             now_.u_min[drive_], now_.u_max[drive_]);
      return conditions_.left(std::span(u).first(nu)) >= -driving_rounding;
    };
    double part = 0.0;
    if (is_kept(1.0)) {
      part = 1.0;
    } else if (!is_kept(0.0)) {
      return;
    } else {
      constexpr int halvings = 12;
      double more = 0.5;
      for (int i = 0; i < halvings; ++i, more *= 0.5)
        if (is_kept(part + more)) part += more;
    }
    (void)is_kept(part);
    const double cost = turned + square(u[drive_] - nominal_[drive_]);
    if (cost < least_) least_ = cost, best_ = u;
  }

  const BarrierPeriod& now_;
  const Conditions& conditions_;
  std::span<const double> nominal_;
  std::size_t drive_;
  std::array<double, most_inputs> braking_, best_;
  double least_;
};

}  // namespace

double driving_reserve(const BarrierLaw& law, const BarrierPeriod& now, const Neighbour& neighbour) noexcept {
  return Conditions(law, now).of(neighbour, 0).reserve;
}

BarrierResult keep_driving_distances(const BarrierLaw& law, BarrierPeriod& now,
                                     std::span<double> u) noexcept {
  BarrierResult result;
  Conditions conditions(law, now);
  bool all_known = true;
  for (std::size_t i = 0; i < now.neighbours.size(); ++i) {
    const Neighbour& n = now.neighbours[i];
    if (!is_finite(n))
      all_known = false;
    else if (norm(now.self.p - n.p) < far_away)
      conditions.add(n, static_cast<int>(i));
  }
  find_bounds(law, now);
  for (const BoundPlane& plane : now.planes) conditions.add(plane);
  result.reserve = conditions.least_reserve();
  if (conditions.too_many() || conditions.left(u) < -driving_rounding) {
    const auto nearest = NearestCommand(law, now, conditions, u).best();
    result.active = !std::equal(u.begin(), u.end(), nearest.begin());
    std::copy_n(nearest.begin(), u.size(), u.begin());
  }
  const Conditions::Tightest tightest = conditions.tightest(u);
  if (tightest.condition != nullptr) {
    result.neighbour = tightest.condition->neighbour;
    result.wall = tightest.condition->wall;
  }
  result.violation = std::max({0.0, -conditions.least_of_all(), -tightest.left});
  result.conflict = result.violation > corrected;
  if (!result.conflict) result.violation = 0.0;
  if (!all_known) {
    result.conflict = true;
    result.violation = infinity;
  }
  return result;
}

}  // namespace sightline
