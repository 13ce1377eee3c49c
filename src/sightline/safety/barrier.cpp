#include "sightline/safety/barrier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "sightline/math/integrate.hpp"
#include "sightline/safety/projection.hpp"

namespace sightline {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double far_away = 1e6;    // [m] what is farther cannot matter
constexpr double kept = 1e-9;       // [m] a row missed by less is kept
constexpr double corrected = 1e-7;  // [m] what the linearised step may miss the true one by
constexpr std::size_t most_states = 32;

void require(bool good, std::string_view name, double value, std::string_view expected) {
  if (!good) throw std::invalid_argument(fmt::format("barrier: {} = {}, expected {}", name, value, expected));
}

const BarrierOptions& checked(const BarrierOptions& o, double dt) {
  require(dt > 0 && dt <= 0.5, "dt", dt, "in (0, 0.5] s");
  require(o.ceiling > o.floor, "ceiling", o.ceiling, "above the floor");
  require(o.world > 0, "world", o.world, "> 0 m");
  require(o.margin >= 0 && o.margin < infinity, "margin", o.margin, ">= 0 m");
  require(o.rate > 0 && o.rate * dt <= 1, "rate", o.rate, "in (0, 1 / dt] 1/s");
  require(o.authority > 0 && o.authority <= 1, "authority", o.authority, "in (0, 1]");
  require(o.velocity_sigma >= 0 && o.velocity_sigma < infinity, "velocity_sigma", o.velocity_sigma,
          ">= 0 m/s");
  require(o.share > 0 && o.share <= 1, "share", o.share, "in (0, 1]");
  return o;
}

bool finite(const Neighbour& n) {
  const std::array<double, 11> numbers = {n.p.x,    n.p.y,       n.p.z, n.v.x,   n.v.y, n.v.z,
                                          n.d_hard, n.speed_max, n.age, n.sigma, n.tie};
  return all_finite(numbers) && !std::isnan(n.acceleration_max);
}

bool is_far(const Vec3<double>& r) {
  return !(std::max({std::abs(r.x), std::abs(r.y), std::abs(r.z)}) < far_away);
}

}  // namespace

std::string_view to_string(Wall wall) noexcept {
  constexpr std::array<std::string_view, 7> names = {"none",  "floor", "ceiling", "x_min",
                                                     "x_max", "y_min", "y_max"};
  return names[static_cast<std::size_t>(wall)];
}

/// What of the next sampled state counts.
struct Barrier::Next {
  Vec3<double> p;
  Vec2<double> d, v;
};

/// n . (p+ + E v+ + R(d+) thrust) >= least at the next sample.
struct Barrier::Row {
  Vec3<double> n;
  double E;             // [s]
  Vec2<double> thrust;  // what the plan adds after it, in V [m]
  double least;         // [m]
  int neighbour;        // or -1
  Wall wall;

  double value(const Next& next) const {
    const Vec2<double> push = rotate(next.d, thrust);
    return dot(n, next.p) + n.x * (E * next.v.x + push.x) + n.y * (E * next.v.y + push.y);
  }
  /// By how much it is missed [m].
  double missed(const Next& next) const { return least - value(next); }
};

struct Barrier::Rows {
  std::array<Row, most_half_spaces> row;
  std::size_t count = 0;
  double reserve = infinity;
  bool unknown = false;  // a neighbour that is no number

  void add(const Row& r) { row[count++] = r; }
  std::span<Row> all() { return std::span(row).first(count); }
};

Barrier::Barrier(const Model& model, std::span<const double> u_min, std::span<const double> u_max, double dt,
                 const BarrierOptions& options)
    : model_(model),
      options_(checked(options, dt)),
      dt_(dt),
      can_(authority_of(model, u_min, u_max)),
      b_(options.authority * can_.acceleration),
      plans_(can_.drag, dt) {}

Barrier::Next Barrier::next(std::span<const double> x, std::span<const double> u) const noexcept {
  std::array<double, most_states> state;
  std::array<double, RungeKuttaScratch::rows_needed * most_states> scratch;
  std::copy(x.begin(), x.end(), state.begin());
  rk4_step(
      [&](std::span<const double> z, std::span<double> rate) { model_.f(z.data(), u.data(), rate.data()); },
      std::span(state).first(x.size()), dt_,
      {std::span(scratch).first(RungeKuttaScratch::rows_needed * x.size())});
  const Sight<double> seen = model_.sight(state.data(), u.data());
  return {seen.p, seen.d, {seen.v.x, seen.v.y}};
}

Escape Barrier::escape(const Sight<double>& self, const Neighbour& n) const noexcept {
  const double age = std::max(n.age, 0.0);
  Tube tube{.r = self.p - n.p,
            .w = {self.v.x, self.v.y},
            .drift = {},
            .beta = b_,
            .rho0 = n.d_hard + options_.margin + 3 * n.sigma,
            .speed = 0.0,
            .growth = 0.0,
            .spread = 3 * options_.velocity_sigma,
            .tie = {n.tie, 0.0}};
  if (n.conduct == Conduct::member) {
    // Measured motion, and what it may have done since by an acceleration that is bounded.
    const double a = std::min(n.acceleration_max, 3 * b_);
    tube.r = tube.r - age * n.v;
    tube.w = {tube.w.x - n.v.x, tube.w.y - n.v.y};
    tube.beta = 2 * b_;
    tube.rho0 += 0.5 * a * age * age;
    tube.spread += a * age;
    return plans_.best(tube);
  }
  tube.thrust_count = can_.thrust_count;
  for (std::size_t k = 0; k < tube.thrusts.size(); ++k) {
    const Vec2<double> g = can_.turns ? rotate(self.d, can_.thrusts[k]) : can_.thrusts[k];
    tube.thrusts[k] = {options_.authority * g.x, options_.authority * g.y};
  }
  Tube anywhere = tube;
  anywhere.rho0 += n.speed_max * age;
  anywhere.speed = n.speed_max;
  const Escape plan = plans_.best(anywhere);
  if (n.acceleration_max == infinity) return plan;
  tube.r = tube.r - age * n.v;
  tube.drift = n.v;
  tube.rho0 += 0.5 * n.acceleration_max * age * age;
  tube.speed = n.acceleration_max * age;
  tube.growth = n.acceleration_max;
  const Escape measured = plans_.best(tube);
  return measured.reserve() > plan.reserve() ? measured : plan;
}

Barrier::Row Barrier::keep_away(const Sight<double>& self, const Escape& plan, const Touch& touch,
                                Conduct conduct) const noexcept {
  const double E = touch.shape.E, F = touch.shape.F;
  const EscapeShape left = plans_.left(touch);
  const auto level = [&](const Vec2<double>& v) { return touch.n.x * v.x + touch.n.y * v.y; };
  const double planned = dot(touch.n, self.p) + E * level({self.v.x, self.v.y});
  const double spare = touch.gap - (1.0 - options_.rate * dt_) * plan.reserve();
  if (conduct == Conduct::member) {
    // Half of the acceleration apart is this robot's; so is its share of what the plan would leave.
    const double least = planned + 0.5 * (F - left.F) * level(plan.a) - options_.share * spare;
    return {touch.n, left.E, {}, least, -1, Wall::none};
  }
  Row row{touch.n, left.E, {}, planned + F * level(plan.a) - spare, -1, Wall::none};
  if (can_.turns) {
    const Vec2<double> a_V = rotate<double>({self.d.x, -self.d.y}, plan.a);
    row.thrust = {left.F * a_V.x, left.F * a_V.y};
  } else {
    row.least -= left.F * level(plan.a);
  }
  return row;
}

void Barrier::add_neighbours(const Sight<double>& self, std::span<const Neighbour> neighbours,
                             Rows& rows) const noexcept {
  // The ones that press most, by the distance left after a second of closing in.
  std::array<int, most_neighbours> chosen;
  std::array<double, most_neighbours> key;
  std::size_t count = 0;
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const Neighbour& n = neighbours[i];
    if (!finite(n)) {
      rows.unknown = true;
      continue;
    }
    const Vec3<double> r = self.p - n.p;
    if (is_far(r)) continue;
    const Vec3<double> w = n.conduct == Conduct::member ? self.v - n.v : self.v;
    const double D = std::max(norm(r), 1e-9);
    const double left = D - n.d_hard + dot(r, w) / D - (n.conduct == Conduct::member ? 0.0 : n.speed_max);
    if (count == most_neighbours && left >= key[count - 1]) continue;
    std::size_t at = count < most_neighbours ? count++ : count - 1;
    for (; at > 0 && key[at - 1] > left; --at) key[at] = key[at - 1], chosen[at] = chosen[at - 1];
    key[at] = left, chosen[at] = static_cast<int>(i);
  }
  for (std::size_t k = 0; k < count; ++k) {
    const Neighbour& n = neighbours[static_cast<std::size_t>(chosen[k])];
    const Escape plan = escape(self, n);
    rows.reserve = std::min(rows.reserve, plan.reserve());
    for (std::size_t j = 0; j < plan.count; ++j) {
      Row row = keep_away(self, plan, plan.touches[j], n.conduct);
      row.neighbour = chosen[k];
      rows.add(row);
    }
  }
}

void Barrier::add_walls(const Sight<double>& self, Rows& rows) const noexcept {
  const double kept_part = 1.0 - options_.rate * dt_, c = can_.drag;
  if (can_.climbs && options_.floor > -infinity) {
    const double least = options_.floor + kept_part * (self.p.z - options_.floor);
    rows.add({{0, 0, 1}, 0.0, {}, least, -1, Wall::floor});
  }
  if (can_.climbs && options_.ceiling < infinity) {
    const double least = -options_.ceiling + kept_part * (options_.ceiling - self.p.z);
    rows.add({{0, 0, -1}, 0.0, {}, least, -1, Wall::ceiling});
  }
  if (options_.world == infinity) return;
  constexpr std::array<Wall, 4> walls = {Wall::x_max, Wall::x_min, Wall::y_max, Wall::y_min};
  for (std::size_t i = 0; i < walls.size(); ++i) {
    // Braking straight away from it, until the velocity towards it is zero.
    const double side = i % 2 == 0 ? -1.0 : 1.0;
    const Vec3<double> n = i < 2 ? Vec3<double>{side, 0, 0} : Vec3<double>{0, side, 0};
    const double away = n.x * self.v.x + n.y * self.v.y, now = options_.world + dot(n, self.p);
    const double stop = away >= 0 ? 0.0 : c > 1e-6 ? std::log1p(-away * c / b_) / c : -away / b_;
    const double t = std::max(stop, dt_), left = t - dt_;
    const double later = now + plans_.E(t) * away + b_ * plans_.F(t);
    const double wanted = kept_part * std::min(now, later);
    const double least = wanted - options_.world - b_ * plans_.F(left);
    rows.add({n, plans_.E(left), {}, least, -1, walls[i]});
  }
}

double Barrier::solve(std::span<const double> x, const Next& nominal, Rows& rows,
                      std::span<const double> u_min, std::span<const double> u_max,
                      std::span<double> u) const noexcept {
  // How the next sample follows the command.
  std::array<double, most_inputs> at{};
  std::copy(u.begin(), u.end(), at.begin());
  std::array<Next, most_inputs> slope{};
  for (std::size_t k = 0; k < u.size(); ++k) {
    constexpr double difference = 1e-3;
    std::array<double, most_inputs> moved = at;
    moved[k] += difference;
    const Next there = next(x, std::span(moved).first(u.size()));
    slope[k].p = (1.0 / difference) * (there.p - nominal.p);
    slope[k].d = {(there.d.x - nominal.d.x) / difference, (there.d.y - nominal.d.y) / difference};
    slope[k].v = {(there.v.x - nominal.v.x) / difference, (there.v.y - nominal.v.y) / difference};
  }

  // Rows that no command within the limits can miss are left out.
  std::array<HalfSpace, most_half_spaces> half;
  std::array<std::size_t, most_half_spaces> of;
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows.count; ++i) {
    const Row& row = rows.row[i];
    HalfSpace h;
    double lowest = 0.0, centre = 0.0;
    for (std::size_t k = 0; k < u.size(); ++k) {
      h.a[k] = row.value(slope[k]);
      lowest += std::min(h.a[k] * (u_min[k] - at[k]), h.a[k] * (u_max[k] - at[k]));
      centre += h.a[k] * at[k];
    }
    const double missing = std::clamp(row.missed(nominal), -far_away, far_away);
    constexpr double bent = 1e-3;  // [m] more than the step's curvature over the limits
    if (lowest - missing > bent) continue;
    h.b = centre + missing;
    of[count] = i;
    half[count++] = h;
  }

  // The step is nearly linear in u; what it misses is put into the rows.
  std::array<double, most_inputs> solution = at;
  double violation = 0.0;
  for (int round = 0; round < 4; ++round) {
    solution = at;
    const auto nearest = std::span(solution).first(u.size());
    const ProjectionResult result = project(std::span(half).first(count), u_min, u_max, nearest);
    violation = result.feasible ? 0.0 : result.violation;
    const Next there = next(x, nearest);
    double worst = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      double linear = half[i].b;
      for (std::size_t k = 0; k < u.size(); ++k) linear -= half[i].a[k] * solution[k];
      const double more = rows.row[of[i]].missed(there) - linear;
      half[i].b += more;
      worst = std::max(worst, std::abs(more));
    }
    if (worst < corrected) break;
  }
  if (all_finite(std::span(solution).first(u.size()))) std::copy_n(solution.begin(), u.size(), u.begin());
  return violation;
}

BarrierResult Barrier::filter(std::span<const double> x, std::span<const Neighbour> neighbours,
                              std::span<const double> u_min, std::span<const double> u_max,
                              std::span<double> u) const noexcept {
  assert(u.size() == static_cast<std::size_t>(model_.nu()) &&
         "a command has as many numbers as the model inputs");
  assert(x.size() == static_cast<std::size_t>(model_.nx()) &&
         "a state has as many numbers as the model says");
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
  const Sight<double> self = model_.sight(x.data(), u.data());
  Rows rows;
  add_neighbours(self, neighbours, rows);
  add_walls(self, rows);
  result.reserve = rows.reserve;

  Next after = next(x, u);
  double missed = 0.0;
  for (const Row& row : rows.all()) missed = std::max(missed, row.missed(after));
  if (missed > kept) {
    std::array<double, most_inputs> nominal{};
    std::copy(u.begin(), u.end(), nominal.begin());
    result.violation = solve(x, after, rows, u_min, u_max, u);
    result.conflict = result.violation > corrected;
    result.active = result.active || !std::equal(u.begin(), u.end(), nominal.begin());
    after = next(x, u);
  }
  double tightest = -infinity;
  for (const Row& row : rows.all()) {
    const double by = row.missed(after);
    if (by <= tightest) continue;
    tightest = by;
    result.neighbour = row.neighbour;
    result.wall = row.wall;
  }
  if (rows.unknown) {
    result.conflict = true;
    result.violation = infinity;
  }
  return result;
}

double Barrier::reserve(std::span<const double> x, const Neighbour& neighbour) const noexcept {
  const std::array<double, most_inputs> at_rest{};
  const Sight<double> self = model_.sight(x.data(), at_rest.data());
  if (!finite(neighbour) || is_far(self.p - neighbour.p)) return infinity;
  return escape(self, neighbour).reserve();
}

}  // namespace sightline
