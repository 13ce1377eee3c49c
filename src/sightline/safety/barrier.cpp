#include "sightline/barrier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/safety/barrier_threats.hpp"

namespace sightline {
namespace {

constexpr double kept = 1e-9;        // [m] a row counts as kept if missed by less
constexpr double least_ample = 0.3;  // [m]
constexpr double corrected = 1e-5;   // [m] tolerance of the linearised step

void require(bool good, std::string_view name, double value, std::string_view expected) {
  if (!good) throw std::invalid_argument(fmt::format("barrier: {} = {}, expected {}", name, value, expected));
}

}  // namespace

const BarrierOptions& validate(const BarrierOptions& o, double dt) {
  static_assert(Barrier::longest_period <= EscapePlans::most_parts * EscapePlans::longest_part);
  require(dt > 0 && dt <= Barrier::longest_period, "period", dt,
          fmt::format("in (0, {}] s, the longest for which the hard distance is guaranteed",
                      Barrier::longest_period));
  require(o.ceiling > o.floor, "ceiling", o.ceiling, "above the floor");
  require(o.world > 0, "world", o.world, "> 0 m");
  require(o.margin >= 0 && o.margin < infinity, "margin", o.margin, ">= 0 m");
  require(o.wall_margin >= 0 && o.wall_margin < infinity, "wall_margin", o.wall_margin, ">= 0 m");
  require(o.ceiling - o.floor > 2 * o.wall_margin && o.world > o.wall_margin, "wall_margin", o.wall_margin,
          "one that leaves room between floor and ceiling, and in the world");
  require(o.rate > 0 && o.rate * dt <= 1, "rate", o.rate, "in (0, 1 / dt] 1/s");
  require(o.authority > 0 && o.authority <= 1, "authority", o.authority, "in (0, 1]");
  require(o.velocity_sigma >= 0 && o.velocity_sigma < infinity, "velocity_sigma", o.velocity_sigma,
          ">= 0 m/s");
  require(o.share > 0 && o.share <= 1, "share", o.share, "in (0, 1]");
  return o;
}

std::string_view to_string(Wall wall) noexcept {
  constexpr std::array<std::string_view, 7> names = {"none",  "floor", "ceiling", "x_min",
                                                     "x_max", "y_min", "y_max"};
  return names[static_cast<std::size_t>(wall)];
}

Barrier::Barrier(const Model& model, std::span<const double> u_min, std::span<const double> u_max, double dt,
                 const BarrierOptions& options)
    : Barrier(model, authority_of(model, u_min, u_max), dt, options) {}

Barrier::Barrier(const Model& model, const Authority& can, double dt, const BarrierOptions& options)
    : model_(model),
      options_(validate(options, dt)),
      dt_(dt),
      parts_(EscapePlans::parts(dt)),
      can_(can),
      b_(options.authority * can_.acceleration),
      plans_(can_.drag, dt),
      ample_(std::max(least_ample, 2 * can_.push * (plans_.F(dt) + plans_.E(dt) * plans_.E_longest()))),
      maneuvers_(can_.drag, can_.climbs ? can_.climb : 0.0) {
  options_.floor += options_.wall_margin;
  options_.ceiling -= options_.wall_margin;
  // A period may begin and end within the bounds, and exceed them in between.
  options_.world -= options_.wall_margin + 0.15 * can_.push * square(dt_ / parts_);
  Arena arena{.disc = b_};
  for (std::size_t k = 0; can_.thrust_count == 2 && k < 2; ++k)
    arena.g[k] = {options.authority * can_.thrusts[k].x, options.authority * can_.thrusts[k].y};
  for (std::size_t i = 0; i < joint_.size(); ++i)
    joint_[i] = EvasiveManeuvers::thrust(arena, EvasiveManeuvers::heading(i));
}

Barrier::Next Barrier::next(std::span<const double> x, std::span<const double> u) const noexcept {
  std::array<double, most_states> state;
  std::copy(x.begin(), x.end(), state.begin());
  for (int k = 0; k < parts_; ++k) model_.step(state.data(), u.data(), dt_ / parts_);
  const Sight<double> seen = model_.sight(state.data(), u.data()), there = settled(seen);
  return {there.p, seen.d, {seen.v.x, seen.v.y}, seen.p.z - there.p.z};
}

/// Replaces the height by that at which the robot comes to rest without commands.
Sight<double> Barrier::settled(Sight<double> self) const noexcept {
  if (can_.climb_lag > 0) self.p.z += can_.climb_lag * self.v.z;
  return self;
}

Barrier::Row Barrier::keep_away(const Sight<double>& self, const Rows& rows, int index,
                                const Touch& touch) const noexcept {
  const Threat& threat = rows.threats[static_cast<std::size_t>(index)];
  const Vec2<double>& a = threat.plan.a;
  const double E = touch.shape.E, F = touch.shape.F;
  const EscapeShape left = plans_.left(touch);
  const auto level = [&](const Vec2<double>& v) { return touch.n.x * v.x + touch.n.y * v.y; };
  Vec3<double> n = touch.n;
  if (touch.level) n.z = 0.0;  // the final height of the plan does not depend on the command
  const double risen = touch.level ? 0.0 : dt_ * n.z * threat.tube.climb;
  const double planned = dot(n, self.p) + E * level({self.v.x, self.v.y}) + risen;
  const double spare = touch.gap - threat.margin - (1.0 - options_.rate * dt_) * threat.reserve;
  if (threat.behavior == Behavior::cooperative) {
    // This robot provides half of the relative acceleration, and may use its share of the spare
    // reserve.
    const double least = planned + 0.5 * (F - left.F) * level(a) - options_.share * spare;
    return {n, left.E, {}, least, Wall::none, index, touch.time, touch.slope, touch.curvature, left.e, false};
  }
  const double least = planned + F * level(a) - spare;
  Row row{n, left.E, {}, least, Wall::none, index, touch.time, touch.slope, touch.curvature, left.e, false};
  if (can_.turns) {
    const Vec2<double> a_V = rotate<double>({self.d.x, -self.d.y}, a);
    row.thrust = {left.F * a_V.x, left.F * a_V.y};
  } else {
    row.least -= left.F * level(a);
  }
  return row;
}

void Barrier::add_neighbours(const Sight<double>& self, Heeded heeded, Rows& rows) const noexcept {
  for (std::size_t k = 0; k < rows.threats.size(); ++k) {
    const Threat& threat = rows.threats[k];
    if (heeded == Heeded::members && threat.behavior != Behavior::cooperative) continue;
    for (std::size_t j = 0; j < threat.plan.count; ++j) {
      Row row = keep_away(self, rows, static_cast<int>(k), threat.plan.touches[j]);
      if (can_.climb_lag > 0) {
        // rho contains the present |beside|; the row requires that of the next sample.
        row.least -= rows.beside;
        row.side = 1.0;
        rows.all.push_back(row);
        row.side = -1.0;
      }
      rows.all.push_back(row);
    }
  }
}

void Barrier::add_walls(const Sight<double>& self, Approach approach, Rows& rows) const noexcept {
  const double kept_part = 1.0 - options_.rate * dt_, b = rows.part * b_;
  // A joint plan climbs or sinks until it reaches the wall, and the height follows the command at
  // once.
  const auto kept_height = [&](double room) {
    return approach == Approach::at_once && room > 0 ? 0.0 : kept_part * room;
  };
  if (can_.climbs && options_.floor > -infinity) {
    const double least = options_.floor + kept_height(self.p.z - options_.floor);
    rows.all.push_back(Rows::of_wall({0, 0, 1}, 0.0, least, Wall::floor));
  }
  if (can_.climbs && options_.ceiling < infinity) {
    const double least = -options_.ceiling + kept_height(options_.ceiling - self.p.z);
    rows.all.push_back(Rows::of_wall({0, 0, -1}, 0.0, least, Wall::ceiling));
  }
  if (options_.world == infinity) return;
  for (std::size_t i = 0; i < inward.size(); ++i) {
    // The plan brakes straight away from the wall, until the velocity towards it is zero.
    const Vec3<double> n = {inward[i].x, inward[i].y, 0.0};
    const double away = n.x * self.v.x + n.y * self.v.y, now = options_.world + dot(n, self.p);
    const double t = std::max(stopping_time(away, rows.part), dt_), left = t - dt_;
    const double later = now + plans_.E(t) * away + b * plans_.F(t);
    const double wanted = kept_part * std::min(now, later);
    const double least = wanted - options_.world - b * plans_.F(left);
    rows.all.push_back(Rows::of_wall(n, plans_.E(left), least, bounds_of_world[i]));
  }
}

/// Time until a velocity towards a bound is zero [s].
double Barrier::stopping_time(double away, double part) const noexcept {
  const double c = can_.drag, b = part * b_;
  return away >= 0 ? 0.0 : c > 1e-6 ? std::log1p(-away * c / b) / c : -away / b;
}

void Barrier::add_cuts(const Sight<double>& self, const Next& there, Rows& rows) const noexcept {
  const EscapeShape step = plans_.shape(dt_);
  const std::size_t before = rows.all.size();
  for (std::size_t i = 0; i < before && !rows.all.is_full(); ++i) {
    constexpr double tight = 2e-3, dip = 1e-5, longest = 0.25;  // [m], [m], [s]
    const Row& row = rows.all[i];
    if (row.threat < 0 || row.cut || row.curvature <= 0 || row.missed(there) < -tight) continue;
    // `less` is the change of the gap's slope against the plan; it moves the time of the least gap.
    const Threat& threat = rows.threats[static_cast<std::size_t>(row.threat)];
    const double part = threat.behavior == Behavior::cooperative ? 0.5 : 1.0;
    const Vec2<double>& a = threat.plan.a;
    Vec2<double> dv = {there.v.x - step.e * self.v.x - part * step.E * a.x,
                       there.v.y - step.e * self.v.y - part * step.E * a.y};
    double less = row.e * (row.n.x * dv.x + row.n.y * dv.y);
    if (row.thrust.x != 0 || row.thrust.y != 0) {
      const Vec2<double> turned = rotate(there.d, rotate<double>({self.d.x, -self.d.y}, a));
      less += row.E * (row.n.x * (turned.x - a.x) + row.n.y * (turned.y - a.y));
    }
    const double shift = -(row.slope + less) / row.curvature;
    const double time = std::max(dt_, row.time + std::clamp(shift, -longest, longest));
    if (0.5 * row.curvature * square(time - row.time) < dip) continue;
    rows.all[i].cut = true;
    Row later = keep_away(self, rows, row.threat, plans_.touch(threat.tube, a, time));
    if (row.side != 0) later.least -= rows.beside, later.side = rows.all[i].side;
    rows.all.push_back(later);
  }
}

/// Linearisation of the rows in the commands, at the nominal command.
struct Barrier::Linear {
  std::span<const double> u_min, u_max;
  double bent;                                    // [m] bound on the nonlinearity within the limits
  std::array<double, most_inputs> u{};            // the nominal command
  std::array<double, most_inputs> low{}, high{};  // the limits, narrowed by floor and ceiling
  double lost = 0.0;                              // violation of floor and ceiling due to the limits [m]
  Next nominal{};
  std::array<Next, most_inputs> slope{};
  Bounded<HalfSpace, most_half_spaces> half;
  Bounded<std::size_t, most_half_spaces> of;  // index of each half-space's row

  Linear(std::span<const double> least, std::span<const double> most, double curved, const Next& there)
      : u_min(least), u_max(most), bent(curved), nominal(there) {
    std::copy(least.begin(), least.end(), low.begin());
    std::copy(most.begin(), most.end(), high.begin());
  }

  /// Adds a row, unless no command within the limits can violate it.
  void add(const Row& row, std::size_t index) {
    HalfSpace h;
    double lowest = 0.0, centre = 0.0;
    for (std::size_t k = 0; k < u_min.size(); ++k) {
      h.a[k] = row.value(slope[k]);
      lowest += std::min(h.a[k] * (u_min[k] - u[k]), h.a[k] * (u_max[k] - u[k]));
      centre += h.a[k] * u[k];
    }
    const double missing = std::clamp(row.missed(nominal), -far_away, far_away);
    if (lowest - missing > bent) return;
    h.b = centre + missing;
    if (row.wall == Wall::floor || row.wall == Wall::ceiling) {
      // If one input alone climbs, floor and ceiling become limits of that input, which have
      // priority.
      const auto moves = [](double a) { return a != 0; };
      const auto k = static_cast<std::size_t>(std::find_if(h.a.begin(), h.a.end(), moves) - h.a.begin());
      if (std::count_if(h.a.begin(), h.a.end(), moves) == 1) {
        double& limit = h.a[k] > 0 ? low[k] : high[k];
        const double wanted = h.b / h.a[k];
        limit = h.a[k] > 0 ? std::clamp(wanted, limit, high[k]) : std::clamp(wanted, low[k], limit);
        lost = std::max(lost, h.b - h.a[k] * limit);
        return;
      }
    }
    h.hard = row.wall != Wall::none;
    of.push_back(index);
    half.push_back(h);
  }

  /// Adds the error of the linearised step to the rows. @return the largest error [m]
  double correct(const Rows& rows, const Next& there, const std::array<double, most_inputs>& at) {
    double most = 0.0;
    for (std::size_t i = 0; i < half.size(); ++i) {
      double linear = half[i].b;
      for (std::size_t k = 0; k < most_inputs; ++k) linear -= half[i].a[k] * at[k];
      const double more = rows.all[of[i]].missed(there) - linear;
      half[i].b += more;
      most = std::max(most, std::abs(more));
    }
    return most;
  }
};

double Barrier::solve(std::span<const double> x, const Sight<double>& self, const Next& nominal, Rows& rows,
                      std::span<const double> u_min, std::span<const double> u_max,
                      std::span<double> u) const noexcept {
  Linear linear(u_min, u_max, 1e-3 * square(parts_), nominal);
  std::copy(u.begin(), u.end(), linear.u.begin());
  for (std::size_t k = 0; k < u.size(); ++k) {
    constexpr double difference = 1e-3;
    std::array<double, most_inputs> moved = linear.u;
    moved[k] += difference;
    const Next there = next(x, std::span(moved).first(u.size()));
    linear.slope[k].p = (1.0 / difference) * (there.p - nominal.p);
    linear.slope[k].d = {(there.d.x - nominal.d.x) / difference, (there.d.y - nominal.d.y) / difference};
    linear.slope[k].v = {(there.v.x - nominal.v.x) / difference, (there.v.y - nominal.v.y) / difference};
    linear.slope[k].beside = (there.beside - nominal.beside) / difference;
  }
  std::size_t taken = 0;
  std::array<double, most_inputs> at = linear.u;
  const auto nearest = std::span(at).first(u.size());
  double violation = 0.0;
  constexpr int rounds = 5;
  for (int round = 0; round < rounds; ++round) {
    for (; taken < rows.all.size(); ++taken) linear.add(rows.all[taken], taken);
    at = linear.u;
    const ProjectionResult result = project(linear.half, std::span(linear.low).first(u.size()),
                                            std::span(linear.high).first(u.size()), nearest);
    violation = std::max(result.violation, linear.lost);
    const Next there = next(x, nearest);
    const double most = linear.correct(rows, there, at);
    if (!result.feasible) break;
    add_cuts(self, there, rows);
    if (most < corrected && taken == rows.all.size()) break;
  }
  if (all_finite(nearest)) std::copy(nearest.begin(), nearest.end(), u.begin());
  return violation;
}

BarrierResult Barrier::filter(std::span<const double> x, std::span<const Neighbour> neighbours,
                              std::span<const double> u_min, std::span<const double> u_max,
                              std::span<double> u, EvasiveManeuver& maneuver) const noexcept {
  assert(u.size() == static_cast<std::size_t>(model_.nu()) &&
         "a command has as many numbers as the model inputs");
  assert(x.size() == static_cast<std::size_t>(model_.nx()) && "a state has as many numbers as the model has");
  BarrierResult result;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double wanted = u[i];
    u[i] = std::clamp(std::isfinite(wanted) ? wanted : 0.0, u_min[i], u_max[i]);
    result.active = result.active || u[i] != wanted;
  }
  if (!all_finite(x)) {
    result.conflict = true;
    result.violation = infinity;
    return result;
  }
  const Sight<double> seen = model_.sight(x.data(), u.data()), self = settled(seen);
  Rows rows{.part = part(u_min, u_max), .beside = std::abs(seen.p.z - self.p.z), .threats = {}, .all = {}};
  const bool all_known = find_threats(self, neighbours, rows);
  for (const Threat& threat : rows.threats) result.reserve = std::min(result.reserve, threat.reserve);
  const double joint = join(self, rows);
  const double least = result.reserve;
  if (std::isfinite(joint)) result.reserve = joint;
  result.surrounded = joint == -infinity;
  add_neighbours(self, Heeded::all, rows);
  add_walls(self, std::isfinite(joint) ? Approach::at_once : Approach::slowing, rows);

  std::array<double, most_inputs> nominal{};
  std::copy(u.begin(), u.end(), nominal.begin());
  Next after = next(x, u);
  const auto keep_rows = [&] {
    double missed = 0.0;
    for (const Row& row : rows.all) missed = std::max(missed, row.missed(after));
    if (missed <= kept) return;
    result.violation = solve(x, self, after, rows, u_min, u_max, u);
    after = next(x, u);
  };
  keep_rows();
  const bool contradicted = result.violation > corrected;
  constexpr double serious = 0.02;  // [m]
  // Either no joint plan exists and one is needed, or a wall obstructs the joint plan.
  const bool lost = joint == -infinity
                        ? least < 0 || result.violation > serious || is_surrounded(self, neighbours, rows)
                        : joint < infinity && result.violation > serious;
  if (lost) {
    if (leave(self, after, contradicted, neighbours, rows, maneuver)) {
      follow(x, self, maneuver, u_min, u_max, u);
      rows.all.clear();
      add_neighbours(self, Heeded::members, rows);
      add_walls(self, Approach::at_once, rows);
      after = next(x, u);
      result.violation = 0.0;
      keep_rows();
      result.violation = std::max(result.violation, -maneuver.left);
    }
  } else {
    maneuver = {};
  }
  // For a long period linear rows are not accurate enough.
  if (parts_ > 1) {
    ensure_walls(x, self, rows, u_min, u_max, u, after);
    if (!lost && joint > -infinity && ensure_distances(x, self, rows, u_min, u_max, u, after))
      result.violation = rows.missed_of_heights(after);
  }
  // A row of the joint plan counts as missed only beyond its margin to the hard distance.
  const auto is_missed = [&](const Row& row) {
    const double margin = row.threat < 0 ? 0.0 : rows.threats[static_cast<std::size_t>(row.threat)].margin;
    return row.missed(after) > margin + corrected;
  };
  const bool planned = std::isfinite(joint) && !maneuver.taken;
  result.conflict =
      result.violation > corrected && (!planned || std::any_of(rows.all.begin(), rows.all.end(), is_missed));
  result.active = result.active || !std::equal(u.begin(), u.end(), nominal.begin());
  const auto looser = [&](const Row& a, const Row& b) { return a.missed(after) < b.missed(after); };
  if (const auto tightest = std::max_element(rows.all.begin(), rows.all.end(), looser); !rows.all.empty()) {
    if (tightest->threat >= 0)
      result.neighbour = rows.threats[static_cast<std::size_t>(tightest->threat)].neighbour;
    result.wall = tightest->wall;
  }
  if (maneuver.taken && result.neighbour < 0) {
    const auto tighter = [](const Threat& a, const Threat& b) { return a.reserve < b.reserve; };
    result.neighbour = std::min_element(rows.threats.begin(), rows.threats.end(), tighter)->neighbour;
  }
  if (!all_known) {
    result.conflict = true;
    result.violation = infinity;
  }
  return result;
}

}  // namespace sightline
