#include "sightline/barrier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/safety/barrier_check.hpp"
#include "sightline/safety/barrier_rows.hpp"
#include "sightline/safety/barrier_threats.hpp"
#include "sightline/safety/driving_barrier.hpp"
#include "sightline/safety/joint_plan.hpp"
#include "sightline/safety/row_projection.hpp"
#include "sightline/safety/surrounded.hpp"
#include "sightline/safety/zone.hpp"

namespace sightline {
namespace {

constexpr double kept = 1e-9;  // [m] a row counts as kept if missed by less

void require(bool good, std::string_view name, double value, std::string_view expected) {
  if (!good) throw std::invalid_argument(fmt::format("barrier: {} = {}, expected {}", name, value, expected));
}

/// A period without limits, threats and rows.
BarrierPeriod begin(const BarrierLaw& law, std::span<const double> x, std::span<const double> u,
                    std::span<const Neighbour> neighbours) {
  const Sight<double> seen = law.model.sight(x.data(), u.data()), self = law.settled(seen);
  const Lagging late = law.lagging(x, seen);
  const double beside = std::abs(seen.p.z - self.p.z);
  return {.x = x,
          .u_min = {},
          .u_max = {},
          .neighbours = neighbours,
          .self = self,
          .part = 1.0,
          .beside = beside,
          .lagging = late,
          .p_z = seen.p.z,
          .leading = law.leading(self.p, {self.v.x, self.v.y}, late),
          .settling = law.settling_of_leading(beside, late.rate),
          .threats = {},
          .rows = {},
          .heights = {},
          .planes = {}};
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
  require(o.residual_acceleration >= 0 && o.residual_acceleration < infinity, "residual_acceleration",
          o.residual_acceleration, ">= 0 m/s^2");
  require(o.command_delay >= 0 && o.command_delay < infinity, "command_delay", o.command_delay, ">= 0 s");
  require(o.velocity_sigma >= 0 && o.velocity_sigma < infinity, "velocity_sigma", o.velocity_sigma,
          ">= 0 m/s");
  require(o.share > 0 && o.share <= 1, "share", o.share, "in (0, 1]");
  for (const Zone& zone : o.zones) validate(zone);
  return o;
}

std::string_view to_string(Wall wall) noexcept {
  constexpr std::array<std::string_view, 8> names = {"none",  "floor", "ceiling", "x_min",
                                                     "x_max", "y_min", "y_max",   "zone"};
  return names[static_cast<std::size_t>(wall)];
}

Barrier::Barrier(const Model& model, std::span<const double> u_min, std::span<const double> u_max, double dt,
                 const BarrierOptions& options)
    : Barrier(model, authority_of(model, u_min, u_max), dt, options) {}

Barrier::Barrier(const Model& model, const Authority& can, double dt, const BarrierOptions& options)
    : law_(std::make_shared<const BarrierLaw>(model, can, dt, options)) {}

bool Barrier::lags() const noexcept { return law_->can.climb_lag > 0 || law_->can.thrust_lag > 0; }

bool Barrier::drives() const noexcept { return law_->can.drives(); }

double Barrier::part(std::span<const double> u_min, std::span<const double> u_max) const noexcept {
  return law_->can.part(u_min, u_max);
}

double Barrier::acceleration() const noexcept { return law_->b; }

const BarrierOptions& Barrier::options() const noexcept { return law_->options; }

double Barrier::reserve(std::span<const double> x, const Neighbour& neighbour) const noexcept {
  const std::array<double, most_inputs> at_rest{};
  BarrierPeriod now = begin(*law_, x, at_rest, {&neighbour, 1});
  if (drives()) return is_finite(neighbour) ? driving_reserve(*law_, now, neighbour) : infinity;
  (void)find_threats(*law_, now);
  return now.threats.empty() ? infinity : now.threats[0].reserve;
}

bool Barrier::keeps(std::span<const double> x, const Neighbour& neighbour) const noexcept {
  if (law_->can.thrust_lag == 0) return reserve(x, neighbour) >= 0;
  constexpr double difference_error = 1e-4;  // [m/s^2] of the differences that give the limit
  const std::array<double, most_inputs> at_rest{};
  BarrierPeriod now = begin(*law_, x, at_rest, {&neighbour, 1});
  // What settles is bounded for tilts that commands can give.
  if (norm(now.lagging.a.x, now.lagging.a.y) > law_->can.thrust_most + difference_error) return false;
  return find_threats(*law_, now) && (now.threats.empty() || now.proven);
}

double Barrier::lacked(std::span<const double> x, const Neighbour& neighbour, std::span<const double> u_min,
                       std::span<const double> u_max, std::span<const double> u) const noexcept {
  BarrierPeriod now = begin(*law_, x, u, {&neighbour, 1});
  now.part = part(u_min, u_max);
  (void)find_threats(*law_, now);
  add_neighbours(*law_, now);
  const NextState after = law_->next(x, u);
  double most = -infinity;
  for (const BarrierRow& row : now.rows) most = std::max(most, row.missed(after));
  return now.rows.empty() ? 0.0 : most;
}

BarrierResult Barrier::filter(std::span<const double> x, std::span<const Neighbour> neighbours,
                              std::span<const double> u_min, std::span<const double> u_max,
                              std::span<double> u, EvasiveManeuver& maneuver) const noexcept {
  const BarrierLaw& law = *law_;
  assert(u.size() == static_cast<std::size_t>(law.model.nu()) &&
         "a command has as many numbers as the model inputs");
  assert(x.size() == static_cast<std::size_t>(law.model.nx()) &&
         "a state has as many numbers as the model has");
  BarrierResult result;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double wanted = u[i];
    u[i] = std::clamp(std::isfinite(wanted) ? wanted : 0.0, u_min[i], u_max[i]);
    result.active = result.active || u[i] != wanted;
  }
  if (!all_finite(x)) {
    result.conflict = true;
    result.violation = infinity;
    maneuver.plan = {};
    return result;
  }
  BarrierPeriod now = begin(law, x, u, neighbours);
  now.u_min = u_min, now.u_max = u_max;
  now.part = part(u_min, u_max);
  if (drives()) {
    maneuver = {};
    const bool limited = result.active;
    result = keep_driving_distances(law, now, u);
    result.active = result.active || limited;
    return result;
  }
  now.plan_before = maneuver.plan;
  const bool all_known = find_threats(law, now);
  for (const Threat& threat : now.threats) result.reserve = std::min(result.reserve, threat.reserve);
  find_bounds(law, now);
  const double joint = join_plans(law, now);
  const double least = result.reserve;
  if (std::isfinite(joint)) result.reserve = joint;
  result.surrounded = joint == -infinity;
  std::array<double, most_inputs> nominal{};
  std::copy(u.begin(), u.end(), nominal.begin());
  NextState after = law.next(x, u);
  const auto side = [](double at, double then) {
    constexpr double slight = 1e-6;
    return std::copysign(1.0, std::abs(at) > slight ? at : then);
  };
  now.turn_side = side(now.lagging.rate, after.lagging.rate);
  now.beside_side = side(now.p_z - now.self.p.z, after.beside);
  add_neighbours(law, now);
  add_walls(law, std::isfinite(joint) ? Approach::at_once : Approach::slowing, now);
  if (law.can.thrust_lag > 0) add_cuts(law, after, now);

  const auto keep_rows = [&] {
    double missed = 0.0;
    for (const BarrierRow& row : now.rows) missed = std::max(missed, row.missed(after));
    if (missed <= kept) return;
    result.violation = project_on_rows(law, after, now, u);
    after = law.next(x, u);
  };
  keep_rows();
  const bool contradicted = result.violation > corrected;
  constexpr double serious = 0.02;  // [m]
  // Either no joint plan exists and one is needed, or a wall obstructs the joint plan.
  const bool lost = joint == -infinity ? least < 0 || result.violation > serious || is_surrounded(law, now)
                                       : joint < infinity && result.violation > serious;
  if (lost) {
    if (choose_maneuver(law, now, after, contradicted, maneuver)) {
      fly_maneuver(law, now, maneuver, u);
      now.rows.clear();
      now.heeded = Heeded::members;
      add_neighbours(law, now);
      add_walls(law, Approach::at_once, now);
      after = law.next(x, u);
      result.violation = 0.0;
      keep_rows();
      result.violation = std::max(result.violation, -maneuver.left);
    }
  } else {
    maneuver = {};
  }
  // For a long period, or with a lag, linear rows are not accurate enough.
  bool is_ensured = false;
  if (law.parts > 1 || law.can.thrust_lag > 0) {
    ensure_walls(law, now, u, after);
    is_ensured = !lost && joint > -infinity && ensure_distances(law, now, u, after);
    if (is_ensured) result.violation = now.missed_of_heights(after);
  }
  maneuver.plan = {};
  if (now.proven && (is_ensured || now.threats[0].reserve >= law.ample)) {
    const Threat& threat = now.threats[0];
    maneuver.plan = {threat.plan.a.x / threat.tube.beta, threat.plan.a.y / threat.tube.beta};
  }
  // A row of the joint plan counts as missed only beyond its margin to the hard distance.
  const auto is_missed = [&](const BarrierRow& row) {
    const double margin = row.threat < 0 ? 0.0 : now.threats[static_cast<std::size_t>(row.threat)].margin;
    return row.missed(after) > margin + corrected;
  };
  const bool planned = std::isfinite(joint) && !maneuver.taken;
  result.conflict =
      result.violation > corrected && (!planned || std::any_of(now.rows.begin(), now.rows.end(), is_missed));
  result.active = result.active || !std::equal(u.begin(), u.end(), nominal.begin());
  const BarrierRow* tightest = nullptr;
  for (const BarrierRow& row : now.rows) {
    if (row.threat < 0 && row.wall == Wall::none) continue;  // of the robot's own rate or climb
    if (tightest == nullptr || tightest->missed(after) < row.missed(after)) tightest = &row;
  }
  if (tightest != nullptr) {
    if (tightest->threat >= 0)
      result.neighbour = now.threats[static_cast<std::size_t>(tightest->threat)].neighbour;
    result.wall = tightest->wall;
  }
  if (maneuver.taken && result.neighbour < 0) {
    const auto tighter = [](const Threat& a, const Threat& b) { return a.reserve < b.reserve; };
    result.neighbour = std::min_element(now.threats.begin(), now.threats.end(), tighter)->neighbour;
  }
  if (!all_known) {
    result.conflict = true;
    result.violation = infinity;
  }
  return result;
}

}  // namespace sightline
