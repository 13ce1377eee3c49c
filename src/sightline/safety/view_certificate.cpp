#include "sightline/safety/view_certificate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sightline/safety/slow_down.hpp"

namespace sightline {
namespace {

constexpr double inset = 0.003;        // of lo and hi, for the interpolation of the table [m]
constexpr double spare = 1e-5;         // of each reserve, for rounding [m]
constexpr double estimate_rate = 1.2;  // speed of an estimate, relative to the target's
constexpr std::size_t most_nodes = ViewSection::distances;

constexpr std::array sideward_speeds = {0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7};  // [m/s]
constexpr std::array turn_shares = {0.015, 0.02, 0.03, 0.045, 0.07, 0.12, 0.25, 0.45, 0.7, 1.0};
constexpr std::array climb_shares = {0.5, 0.7, 1.0};         // of the vertical speed; above: of the yaw rate
constexpr std::array across_shares = {0.7, 0.5, 0.25, 0.1};  // of the thrust, if two commands share it

/// Greatest distance of a target from its estimate. The estimate moves by `step` in a period
/// towards a measurement with an error of at most `error`, the target by `move`. At a distance d
/// the direction of the measurement is off by at most asin(error / d).
double estimate_radius(double error, double move, double step) {
  constexpr double finer = 1.01, farthest = 5.0;  // [m]
  for (double radius = error; radius < farthest; radius *= finer) {
    const double d = radius + move, sine = error / d;
    if (sine < 1 && square(d) - 2 * d * step * std::sqrt(1 - square(sine)) + square(step) <= square(radius))
      return radius;
  }
  return infinity;
}

/// The parameters of a set beside its distances.
struct SetLimits {
  double theta, sideward, turn, climb, across;
};

/// Tables of one bearing limit, sideward speed, yaw rate and vertical speed, and the sets between two
/// distances.
class Sets {
 public:
  Sets(const ViewTask& task, const ViewSection& section, ViewLimit ignored)
      : task_(task),
        section_(section),
        known_(task.bounds.known(task.dt)),
        own_(view_prediction(task.bounds, task.dt)),
        between_(task.motion.drag_between()),
        ignored_(ignored) {}

  /// @return false if no set exists for any distances
  bool prepare(const SetLimits& limits);
  /// Whether the conditions hold from r_i to r_j, at least corridor() apart.
  bool holds(int i, int j);
  /// Volume of the set from r_i to r_j; 0 if a condition fails.
  double volume(int i, int j);
  ViewCertificate certificate(int i, int j);

  int first() const { return first_; }        ///< the least r_i at which the section is not empty
  int last() const { return last_; }          ///< the greatest r_j of the same interval
  int corridor() const { return corridor_; }  ///< least j - i, (C1)

 private:
  void tabulate_heights(double bearing, double above);
  double fastest_within(int k) const;  ///< fastest_[k]
  /// The left sides of (C2) over r at r_k, for the greatest speeds ahead and back there [rad/s].
  Vec2<double> rates(int k, double ahead, double back) const;
  bool follows(const Vec2<double>& rates) const {
    const double turn = limits_.turn, error = task_.odometry.turn;
    return rates.x <= turn - error && rates.y <= 2 * turn - error;
  }
  bool follows(int i, int j) const;           ///< (C2)
  bool holds_sideward(double fastest) const;  ///< (C6)
  /// Whether a robot that is requested to slow down needs no more than that speed, along up to
  /// `fastest`, and brakes in its set as requested beyond it.
  bool slows_down(double fastest) const;

  ViewTask task_;
  const ViewSection& section_;
  ViewBounds::Known known_;
  ViewPrediction own_;
  double between_;  // acceleration along per velocity across, by drag [1/s]
  ViewLimit ignored_;
  SetLimits limits_{};
  Vec2<double> push_{};  // b, b_s
  double across_ = 0, held_ = 0, sine_ahead_ = 0, sine_back_ = 0, sine_between_ = 0, moved_ = 0, varied_ = 0;
  ViewBrake brake_{};
  int first_ = 0, last_ = 0, corridor_ = 0;
  // [k]: greatest v_f within a period from a state whose braking distance is at most (k + 1) steps.
  std::array<double, most_nodes> fastest_{};
  // [k]: greatest v_f with a braking distance of k steps, for k < speed_count_.
  std::array<double, most_nodes> speeds_{};
  int speed_count_ = 0;
  std::array<ViewSection::Heights, most_nodes> heights_{};
  double bearing_ = -1, above_ = 0;  // of heights_
  std::array<double, most_nodes> low_{}, high_{};
};

bool Sets::prepare(const SetLimits& limits) {
  const double theta = limits.theta, sideward = limits.sideward, turn = limits.turn, climb = limits.climb;
  const ViewMotion& robot = task_.motion;
  const ViewBounds& bounds = task_.bounds;
  const double dt = task_.dt;
  push_ = robot.pushes(limits.across);
  const Vec2<double> drags = robot.drags();
  const double c = drags.x, b = push_.x;
  const double late = robot.turn.lag * turn;              // of the heading behind where it will stop
  const double between = theta + late + 1.5 * turn * dt;  // T
  if (between >= 1.5) return false;
  const bool measured = bounds.is_velocity_measured();
  // Between samples a velocity may exceed its values at both by what the target and wind change it.
  const double turned = robot.is_level ? 2 * turn * robot.most_push().x * dt : 0.0;
  const double varied = (bounds.wind + turned + (measured ? bounds.acceleration : 0.0)) * dt;
  const double w = own_.speed + (measured ? 0.0 : known_.speed),
               tangent = (sideward + varied) * std::tan(between);
  const double W_e = w / std::cos(between) + tangent;
  // Thrust that wind, the target's drag and acceleration, and a turn in V may use up.
  const auto used = [&](double drag) {
    const double moves =
        measured ? bounds.acceleration + (drag + between_ + (robot.is_level ? 0.0 : turn)) * known_.speed
                 : 0.0;
    return bounds.wind + moves;
  };
  const double along = used(c) + (between_ + (robot.is_level ? turn : 0.0)) * (sideward + varied);
  const double least = b - along, most = b + along;
  if (least - c * W_e < 0.02 * b) return false;
  limits_ = limits, held_ = used(drags.y);
  across_ = w + sideward + varied;
  sine_ahead_ = std::sin(std::max(0.0, theta - late)), sine_back_ = std::sin(std::max(0.0, late - theta));
  sine_between_ = std::sin(between);
  brake_ = {c, least - c * W_e, W_e};

  // (C1): a thrust for one border uses up at most `lost` of the other's reserve, 2 q_0.
  const double change = (most + c * W_e) * dt * std::exp(c * dt);
  const double lost = 2 * change * (2 * W_e + change) / (least + c * W_e);
  if (ignored_ != ViewLimit::request && !slows_down(W_e + 2 * change)) return false;
  const double length = brake_.distance(W_e) + 2 * (lost + spare);
  corridor_ =
      ignored_ == ViewLimit::range ? 2 : std::max(2, static_cast<int>(std::ceil(length / section_.step())));
  if (corridor_ >= ViewSection::distances) return false;

  tabulate_heights(theta + late,
                   inset + known_.height + robot.climb.lag * climb + task_.odometry.delay * bounds.climb);
  if (corridor_ > last_ - first_) return false;

  moved_ = dt * (W_e + brake_.fastest((last_ - first_) * section_.step())), varied_ = varied;
  // The shortest corridor at the greatest distances has the least speeds and rates. If these fail at one
  // of its ends, all sets do.
  const double slowest = fastest_within(0), fastest = fastest_within(corridor_ - 1);
  if (!holds_sideward(fastest)) return false;
  if (ignored_ != ViewLimit::yaw &&
      !(follows(rates(last_ - corridor_, slowest, fastest)) && follows(rates(last_ - 1, fastest, slowest))))
    return false;
  for (int k = 0; k < last_ - first_; ++k) fastest_[size(k)] = fastest_within(k);
  speed_count_ = 0;
  return true;
}

/// The longest interval of distances with heights.
void Sets::tabulate_heights(double bearing, double above) {
  if (bearing == bearing_ && above == above_) return;
  bearing_ = bearing, above_ = above;
  for (int k = 0; k < ViewSection::distances; ++k) {
    const ViewSection::Heights all = section_.heights(k, bearing, known_.radius + own_.radius);
    heights_[size(k)] = {all.low + above, all.high - above};
  }
  first_ = last_ = 0;
  for (int k = 0, begin = 0; k < ViewSection::distances; ++k) {
    if (heights_[size(k)].is_empty()) begin = k + 1;
    if (k - begin > last_ - first_) first_ = begin, last_ = k;
  }
}

bool Sets::slows_down(double fastest) const {
  if (task_.requested == infinity) return true;
  const double beside = limits_.sideward, speed = norm(fastest, beside);
  // Of the directions of its velocity then, one of the outer two has the least deceleration.
  const double slowing = std::min(push_.x, (push_.x * fastest + push_.y * beside) / speed);
  return speed <= task_.requested && slowing >= least_deceleration(task_.motion, 0.0);
}

double Sets::fastest_within(int k) const {
  return brake_.fastest((k + 1) * section_.step() + moved_) + varied_;
}

bool Sets::holds_sideward(double fastest) const {
  const ViewMotion& robot = task_.motion;
  if (robot.across.input < 0) return true;
  const double held = held_ + (between_ + (robot.is_level ? limits_.turn : 0.0)) * fastest;
  return held < 0.95 * push_.y && limits_.sideward > 2 * held * task_.dt;
}

Vec2<double> Sets::rates(int k, double ahead, double back) const {
  const double r = section_.distance(k) - 4 * task_.motion.most_push().x * square(task_.dt);
  if (r <= 0) return {infinity, infinity};
  // At theta = Theta behind the lag: the heading itself may be on the other side of the target.
  const double drawn = ahead > 0        ? std::max(ahead * sine_between_, back * sine_back_)
                       : sine_back_ > 0 ? std::max(0.0, back * sine_back_)
                                        : ahead * sine_ahead_;
  return {(across_ + drawn) / r, (across_ + std::max({0.0, ahead, back}) * sine_between_) / r};
}

bool Sets::follows(int i, int j) const {
  if (ignored_ == ViewLimit::yaw) return true;
  double most = 0.0;
  for (int k = i; k < j; ++k) {
    const Vec2<double> one = rates(k, fastest_[size(k - i)], fastest_[size(j - k - 1)]);
    if (!follows(one)) return false;
    most = std::max({most, one.x, one.y});
  }
  return limits_.theta >= (limits_.turn + most + task_.odometry.turn) * task_.dt + spare;
}

bool Sets::holds(int i, int j) {
  if (!holds_sideward(fastest_[size(j - i - 1)]) || !follows(i, j)) return false;
  const double climb = limits_.climb - known_.climb - task_.odometry.velocity, d = section_.step();
  if (climb < 0 && ignored_ != ViewLimit::height) return false;
  for (int k = i; k <= j; ++k)
    low_[size(k - i)] = heights_[size(k)].low, high_[size(k - i)] = heights_[size(k)].high;
  const int n = j - i;
  if (ignored_ != ViewLimit::height) {
    const auto narrow = [&](int to, int from, double speed) {  // (C4)
      const double step = d * climb / std::max(brake_.speed + speed, 1e-3);
      high_[size(to)] = std::min(high_[size(to)], high_[size(from)] + step);
      low_[size(to)] = std::max(low_[size(to)], low_[size(from)] - step);
    };
    for (int k = 1; k <= n; ++k) narrow(k, k - 1, fastest_[size(k - 1)]);
    for (int k = n - 1; k >= 0; --k) narrow(k, k + 1, fastest_[size(n - 1 - k)]);
  }
  const double least =
      ignored_ == ViewLimit::height ? 0.0 : 4 * limits_.climb * task_.dt + 2 * spare;  // (C3)
  for (int k = 0; k <= n; ++k)
    if (high_[size(k)] - low_[size(k)] < least) return false;
  return true;
}

double Sets::volume(int i, int j) {
  if (!holds(i, j)) return 0.0;
  const double d = section_.step();
  const int n = j - i;
  for (; speed_count_ <= n; ++speed_count_) speeds_[size(speed_count_)] = brake_.fastest(speed_count_ * d);
  double sum = 0.0;
  for (int k = 0; k <= n; ++k)
    sum += (high_[size(k)] - low_[size(k)]) * (speeds_[size(k)] + speeds_[size(n - k)]) *
           section_.distance(i + k) * d;
  return std::max(4 * limits_.theta * std::max(limits_.sideward, 1e-3) * sum, 1e-12);
}

ViewCertificate Sets::certificate(int i, int j) {
  ViewCertificate z{.task = task_,
                    .theta = limits_.theta,
                    .sideward = limits_.sideward,
                    .push = push_,
                    .near = section_.distance(i),
                    .far = section_.distance(j),
                    .turn = limits_.turn,
                    .climb = limits_.climb,
                    .brake = brake_,
                    .volume = volume(i, j)};
  z.low.assign(low_.begin(), low_.begin() + (j - i + 1));
  z.high.assign(high_.begin(), high_.begin() + (j - i + 1));
  return z;
}

/// A set by its places in the tables.
struct Candidate {
  int climb, turn, bearing, sideward, across, near, far;
};

/// The sets of a task; those that `ignored` forbids count too.
class CertificateSearch {
 public:
  CertificateSearch(const ViewTask& task, const ViewSection& section, ViewLimit ignored)
      : motion_(task.motion),
        lags_(motion_.is_level || motion_.turn.lag > 0 || motion_.climb.lag > 0),
        slowest_turn_(task.bounds.is_velocity_measured() ? 0
                      : lags_                            ? turns / 2
                                                         : turns - 1),
        slowest_climb_(motion_.climb.lag > 0 ? 0 : climbs - 1),
        sideward_count_(task.motion.across.input >= 0 ? size(sideward_speeds.size()) : 1),
        across_count_(task.motion.is_turned() ? size(across_shares.size()) : 1),
        sets_(task, section, ignored) {}

  /// Calls visit(sets, candidate) for the tables of every `stride`-th bearing limit and sideward speed,
  /// until it returns true; of robots with further limits to choose for half of them.
  template <class Visit>
  bool any(int stride, Visit&& visit) {
    if (lags_) stride *= 2;
    for (int climb = slowest_climb_; climb < climbs; ++climb)
      for (int turn = slowest_turn_; turn < turns; ++turn)
        for (int i = stride - 1; i < ViewSection::bearings; i += stride)
          for (int k = 0; k < sideward_count_; k += stride)
            for (int across = 0; across < across_count_; ++across) {
              const Candidate of = {climb, turn, i, k, across, 0, 0};
              if (prepare(of) && visit(sets_, of)) return true;
            }
    return false;
  }
  /// The volume of a candidate's set; 0 if a condition fails.
  double volume(const Candidate& of) {
    const bool is_one = of.climb >= slowest_climb_ && of.climb < climbs && of.turn >= slowest_turn_ &&
                        of.turn < turns && of.bearing >= 0 && of.bearing < ViewSection::bearings &&
                        of.sideward >= 0 && of.sideward < sideward_count_ && of.across >= 0 &&
                        of.across < across_count_;
    if (!is_one || !prepare(of)) return 0.0;
    const bool fits =
        of.near >= sets_.first() && of.far <= sets_.last() && of.far - of.near >= sets_.corridor();
    return fits ? sets_.volume(of.near, of.far) : 0.0;
  }
  ViewCertificate certificate(const Candidate& of) {
    prepare(of);
    return sets_.certificate(of.near, of.far);
  }

 private:
  static constexpr int turns = static_cast<int>(turn_shares.size()),
                       climbs = static_cast<int>(climb_shares.size());
  static int size(std::size_t n) { return static_cast<int>(n); }

  bool prepare(const Candidate& of) {
    return sets_.prepare({ViewSection::bearing(of.bearing),
                          sideward_count_ > 1 ? sideward_speeds[at(of.sideward)] : 0.0,
                          turn_shares[at(of.turn)] * motion_.turn.most,
                          climb_shares[at(of.climb)] * motion_.climb.most, across_shares[at(of.across)]});
  }

  ViewMotion motion_;
  bool lags_;
  int slowest_turn_, slowest_climb_, sideward_count_, across_count_;
  Sets sets_;
};

/// Some set of a task, or none. Of one r1 the shortest corridor has the least speeds.
std::optional<Candidate> any_certificate(const ViewTask& task, const ViewSection& section,
                                         ViewLimit ignored) {
  std::optional<Candidate> found;
  CertificateSearch(task, section, ignored).any(1, [&](Sets& sets, Candidate of) {
    for (of.near = sets.first(); of.near + sets.corridor() <= sets.last(); ++of.near) {
      of.far = of.near + sets.corridor();
      if (!sets.holds(of.near, of.far)) continue;
      found = of;
      return true;
    }
    return false;
  });
  return found;
}

/// The condition without which the task would be certified; the thrust if no single one.
ViewLimit limit_of(const ViewTask& task, const ViewSection& section) {
  for (const ViewLimit one : {ViewLimit::range, ViewLimit::yaw, ViewLimit::height, ViewLimit::request})
    if (any_certificate(task, section, one)) return one;
  return ViewLimit::thrust;
}

}  // namespace

ViewBounds::Known ViewBounds::known(double dt) const {
  if (error == 0) return {speed, climb, spread + speed * age, climb * age};
  const double faster = estimate_rate * speed, up = estimate_rate * climb;
  const double radius = estimate_radius(error, speed * dt, faster * dt);
  return {faster, up, spread + radius + faster * age, error + climb * dt + up * age};
}

ViewPrediction view_prediction(const ViewBounds& bounds, double dt) {
  if (bounds.age == 0) return {};
  const double late = bounds.age + dt, lag = bounds.wind * bounds.age * late;
  return {2 * bounds.wind * late, 0.5 * bounds.wind * square(bounds.age) + lag, lag};
}

double ViewOdometry::velocity_error(const ViewBounds& bounds, double dt) const {
  const double pushed = bounds.wind * dt;
  return estimate_radius(velocity, pushed, estimate_rate * pushed) + bounds.wind * delay;
}

ViewBounds ViewOdometry::seen(const ViewBounds& bounds, double reach, double dt) const {
  if (!is_used()) return bounds;
  ViewBounds seen = bounds;
  seen.age = 0.0;
  seen.speed += velocity_error(bounds, dt) + turn * reach;
  seen.climb += velocity;
  seen.spread += bounds.speed * delay;
  seen.error += delay * (velocity + 0.5 * bounds.wind * delay + turn * reach);
  seen.wind *= estimate_rate;
  return seen;
}

ViewRegion view_region(std::vector<Potential> limits, const ViewMotion& motion) {
  const Vec2<double>& lean = motion.lean;
  const auto holds = [](const Potential& limit, const Sight<double>& robot, const Sight<double>& target) {
    return limit.violation(robot, target) <= 0;
  };
  // Upright first, as other limits than those of sensors that tilt need no more.
  std::vector<Vec2<double>> leans = {{0, 0}};
  const auto is_level = [](const Potential& limit) {
    return limit.mount() == nullptr || limit.mount()->frame != MountFrame::body;
  };
  // Those come first: most places are too far.
  const bool tilts = std::stable_partition(limits.begin(), limits.end(), is_level) != limits.end();
  if (tilts) {
    for (const double f : {-1.0, 0.0, 1.0})
      for (const double s : {-1.0, 0.0, 1.0})
        if (f != 0 || s != 0) leans.push_back({f * lean.x, s * lean.y});
  }
  for (const Potential& limit : limits) {
    // The same relative position with another place, heading, velocity and time.
    constexpr double turned = 0.7;
    const Vec2<double> d = {std::cos(turned), std::sin(turned)};
    bool same = !limit.sees_third();
    for (const Vec3<double>& r : {Vec3<double>{1.1, 0.2, -0.5}, Vec3<double>{0.4, -0.9, 0.3}}) {
      const Sight<double> robot = {{{0, 0, 0}, {1, 0}}, {}}, target = {{r, {1, 0}}, {}};
      const Vec2<double> moved = rotate(d, {r.x, r.y});
      const Sight<double> other = {{{2, -3, 4}, d},
                                   {0.3, 0.2, -0.1},
                                   tilts ? Vec2<double>{} : Vec2<double>{0.05, -0.04}},
                          seen = {{{2 + moved.x, -3 + moved.y, 4 + r.z}, {0.8, 0.6}}, {-0.2, 0.4, 0.3}};
      same = same && std::abs(limit.violation(robot, target) - limit.violation(other, seen, 5.0)) < 1e-9;
    }
    if (!same)
      throw_invalid(
          "the limit \"{}\" depends on more than the relative position, expected one "
          "of the position alone",
          limit.name());
  }
  return [limits = std::move(limits), leans = std::move(leans), holds, is_level, direction = motion.ahead](
             double ahead, double left, double above) {
    const Vec2<double> p = rotate(direction, {ahead, left});
    const Sight<double> target = {{{p.x, p.y, 0}, {1, 0}}, {}};
    return std::all_of(limits.begin(), limits.end(), [&](const Potential& limit) {
      return std::all_of(leans.begin(), is_level(limit) ? leans.begin() + 1 : leans.end(),
                         [&](const Vec2<double>& xi) {
                           return holds(limit, {{{0, 0, above}, {1, 0}}, {}, xi}, target);
                         });
    });
  };
}

ViewSection::ViewSection(const ViewRegion& region) : heights_(size(distances * bearings)) {
  constexpr double farthest = 30.0, coarse = 0.05;  // [m]
  constexpr int levels = 100;
  // The distances at which some height straight ahead is in the region.
  const auto holds_at = [&](double r, double reach) {
    for (int k = -levels; k <= levels; ++k)
      if (region(r, 0.0, reach * k / levels)) return true;
    return false;
  };
  double first = infinity, last = 0.0;
  for (double r = coarse; r <= farthest + coarse; r += coarse) {
    if (!holds_at(r, std::max(3.0, r))) continue;
    first = std::min(first, r), last = r;
  }
  if (last == 0.0)
    throw_invalid(
        "no place within {} m in the direction of the sensor is in the region, expected some: the "
        "certificate "
        "keeps the target there",
        farthest);
  if (last > farthest)
    throw_invalid(
        "the region reaches beyond {} m, expected a limit of the distance such as "
        "d_max",
        farthest);
  first_ = std::max(0.5 * coarse, first - coarse);
  step_ = (last + coarse - first_) / (distances - 1);

  // Heights as far apart as distances and bearings of the table are, but none in a thin layer is missed.
  const double reach = std::max(3.0, last), scan = std::clamp(1.5 * step_, 0.02, 0.05);
  const auto longest = [&](double r, double theta, Heights within) {
    const double x = r * std::cos(theta), y = r * std::sin(theta);
    Heights best = {1, 0};
    double begin = 0.0, before = within.low;
    bool in = false;
    const auto border = [&](double out, double inside) {  // by bisection, on the inner side
      while (std::abs(out - inside) > 1e-4) {
        const double middle = 0.5 * (out + inside);
        (region(x, y, middle) ? inside : out) = middle;
      }
      return inside;
    };
    const auto count = static_cast<int>(std::ceil((within.high - within.low) / scan));
    for (int k = 0; k <= count + 1; ++k) {
      const double h = std::min(within.high, within.low + k * scan);
      const bool now = k <= count && region(x, y, h);
      if (now && !in) begin = k == 0 ? h : border(before, h);
      if (in && !now) {
        const double end = k > count ? within.high : border(h, before);
        if (best.is_empty() || end - begin > best.high - best.low) best = {begin, end};
      }
      in = now, before = h;
    }
    return best;
  };
  for (int k = 0; k < distances; ++k) {
    const double r = distance(k);
    Heights run = longest(r, 0.0, {-reach, reach});
    for (int i = 0; i < bearings; ++i) {
      for (const double side : {1.0, -1.0})
        if (!run.is_empty()) run = longest(r, side * bearing(i), run);
      heights_[size(i * distances + k)] = run;
    }
  }
}

ViewSection::Heights ViewSection::heights(int k, double bearing, double radius) const {
  const double r = distance(k);
  if (radius >= r) return {1, 0};
  const double wide = bearing + std::asin(radius / r);
  const int i = std::max(0, static_cast<int>(std::ceil(wide / bearing_step - 1e-9)) - 1),
            beside = static_cast<int>(std::ceil(radius / step_ - 1e-9));
  if (i >= bearings || k - beside < 0 || k + beside >= distances) return {1, 0};
  Heights all = heights_[size(i * distances + k)];
  for (int j = k - beside; j <= k + beside; ++j) {
    const Heights& one = heights_[size(i * distances + j)];
    if (one.is_empty()) return one;
    all = {std::max(all.low, one.low), std::min(all.high, one.high)};
  }
  return all;
}

// With y = v + W_e and z = c y / thrust: n = y^2 / thrust (z - ln(1 + z)) / z^2.
double ViewBrake::distance(double v) const noexcept {
  const double y = v + speed;
  if (y <= 0) return 0.0;
  const double z = drag * y / thrust;
  const double g = z < 1e-3 ? 0.5 - z / 3 + z * z / 4 : (z - std::log1p(z)) / (z * z);
  return y * y / thrust * g;
}

double ViewBrake::slope(double v) const noexcept {
  const double y = v + speed;
  return y <= 0 ? 0.0 : y / (thrust + drag * y);
}

double ViewBrake::fastest(double d) const noexcept {
  if (d <= 0) return -speed;
  double v = -speed + std::sqrt(2 * thrust * d);
  constexpr double settled = 1e-13;  // [m/s]
  for (int k = 0; k < 6; ++k) {
    const double change = (distance(v) - d) / slope(v);
    v -= change;
    if (std::abs(change) < settled) break;
  }
  return v;
}

std::string_view to_string(ViewLimit limit) noexcept {
  constexpr std::array<std::string_view, 6> names = {
      "nothing",    "the range corridor", "the yaw rate",
      "the height", "the thrust",         "the speed that the observer keeps on request"};
  return names[static_cast<std::size_t>(limit)];
}

double ViewCertificate::at(const std::vector<double>& heights, double r) const noexcept {
  const auto last = static_cast<double>(heights.size() - 1);
  // In this order a distance that is not a number counts as the nearest.
  const double s = std::min(std::max(0.0, (r - near) / step()), last);
  const std::size_t k = std::min(static_cast<std::size_t>(s), heights.size() - 2);
  return heights[k] + (s - static_cast<double>(k)) * (heights[k + 1] - heights[k]);
}

ViewCertificate certify_view(const ViewTask& task, const ViewSection& section) {
  CertificateSearch search(task, section, ViewLimit::none);
  std::optional<Candidate> best;
  double volume = 0.0;
  // A coarse grid first; a thin set that it misses is found by the whole one.
  constexpr int stride = 3, coarse = 8;
  search.any(stride, [&](Sets& sets, Candidate of) {
    for (of.near = sets.first(); of.near + sets.corridor() <= sets.last(); of.near += coarse) {
      for (of.far = of.near + sets.corridor(); of.far <= sets.last(); of.far += coarse) {
        const double one = sets.volume(of.near, of.far);
        if (one > volume) volume = one, best = of;
      }
    }
    return false;
  });
  if (!best) best = any_certificate(task, section, ViewLimit::none);
  if (!best) return {.task = task};
  // Then from neighbour to neighbour, in ever smaller steps.
  constexpr std::array members = {&Candidate::climb,    &Candidate::turn,   &Candidate::bearing,
                                  &Candidate::sideward, &Candidate::across, &Candidate::near,
                                  &Candidate::far};
  for (int step = coarse / 2; step > 0; step /= 2) {
    for (bool better = true; better;) {
      better = false;
      for (const auto member : members) {
        for (const int change : {-step, step}) {
          Candidate next = *best;
          next.*member += change;
          const double one = search.volume(next);
          if (one > volume) volume = one, best = next, better = true;
        }
      }
    }
  }
  return search.certificate(*best);
}

CertifiedSpeed certified_speed(ViewTask task, const ViewSection& section) {
  const ViewBounds given = task.bounds;
  const auto holds = [&](double speed, ViewLimit ignored) {
    task.bounds.speed = speed;
    // In the delay a faster target moves farther, as ViewOdometry::seen() counts.
    task.bounds.spread = std::max(0.0, given.spread + task.odometry.delay * (speed - given.speed));
    return any_certificate(task, section, ignored).has_value();
  };
  constexpr double fine = 0.005, slowest = 0.01, fastest = 32.0;  // relative; [m/s]
  if (!holds(0.0, ViewLimit::none)) return {0.0, limit_of(task, section)};
  double low = 0.0, high = 0.5;
  while (high < fastest && holds(high, ViewLimit::none)) low = high, high *= 2;
  while (high - low > std::max(fine * high, slowest * fine)) {
    const double middle = 0.5 * (low + high);
    (holds(middle, ViewLimit::none) ? low : high) = middle;
  }
  task.bounds.speed = high;
  return {low, limit_of(task, section)};
}

}  // namespace sightline
