#include "sightline/safety/barrier_threats.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/safety/threat_selection.hpp"

namespace sightline {
namespace {

bool is_far(const Vec3<double>& r) {
  return !(std::max({std::abs(r.x), std::abs(r.y), std::abs(r.z)}) < far_away);
}

/// Adds w F(delay + t) to the radius: the deviation by an acceleration w since the measurement.
void add_residual(Tube& tube, const BarrierLaw& law, double w) {
  if (w == 0) return;
  constexpr double slight = 1e-3;  // drag [1/s], below which F(t) counts as t^2 / 2
  const double c = law.can.drag, delay = law.options.command_delay;
  tube.rho0 += w * law.plans.F(delay);
  tube.spread += w * law.plans.E(delay);
  if (c > slight)
    tube.speed += w / c, tube.spread -= w / c;  // F(t) = (t - E(t)) / c
  else
    tube.growth += w;
}

/// Fills a zero tube with a neighbour; for an uncooperative one without its measured motion.
void fill_tube(Tube& tube, const BarrierLaw& law, const BarrierPeriod& now, const Neighbour& n) {
  tube.r = now.self.p - n.p;
  tube.w = {now.self.v.x, now.self.v.y};
  tube.beta = now.part * law.b;
  tube.rho0 = n.d_hard + law.options.margin + 3 * n.sigma + now.beside;
  tube.spread = 3 * law.options.velocity_sigma;
  if (law.can.thrust_lag > 0) {
    tube.s = now.lagging.a;
    tube.spread += law.settling(now.beside, now.lagging.rate);
  }
  tube.tie.x = n.tie;
  if (n.behavior != Behavior::cooperative) return add_residual(tube, law, law.options.residual_acceleration);
  add_residual(tube, law, 2 * law.options.residual_acceleration);
  // The measured motion, and the bounded acceleration since the measurement.
  const double age = std::max(n.age, 0.0), both = std::min(now.part, n.part),
               a = std::min(n.acceleration_max, 3 * law.b);
  tube.r = tube.r - age * n.v;
  tube.w = {tube.w.x - n.v.x, tube.w.y - n.v.y};
  tube.beta = both * 2 * law.b;
  tube.rho0 += 0.5 * a * age * age;
  tube.spread += a * age;
}

/// Bounds of a cooperative neighbour's reserve: from below by the plan straight away, from above by
/// the present distance.
struct PairBounds {
  double least, most;  // [m]
  bool quiet;          // the next reserve suffices under any commands of both robots
};

PairBounds bounds_of_pair(const BarrierLaw& law, const Tube& tube) {
  const double D = norm(tube.r.x, tube.r.y), z = std::abs(tube.r.z);
  const double closing =
      D > 1e-9 ? -(tube.r.x * tube.w.x + tube.r.y * tube.w.y) / D : norm(tube.w.x, tube.w.y);
  const double t = law.plans.longest_time(), held = tube.rho0 + tube.spread * law.plans.E_longest() +
                                                    t * (tube.speed + 0.5 * tube.growth * t);
  // Straight away, the closing speed v vanishes after at most v^2 / (2 beta); drag shortens this
  // distance.
  const auto left = [&](double level, double height, double v) {
    const double after = std::max(0.0, level - 0.5 * square(std::max(v, 0.0)) / tube.beta);
    return std::sqrt(after * after + height * height) - held;
  };
  const double jolt = 2 * law.can.push * law.dt;
  const double then = left(std::max(0.0, D - law.dt * (std::max(closing, 0.0) + jolt)),
                           std::max(0.0, z - 2 * law.can.rise * law.dt), closing + jolt);
  const double most = norm(tube.r) - tube.rho0;
  return {std::min(left(D, z, closing), most), most,
          most > 0 && then >= (1.0 - law.options.rate * law.dt) * most};
}

/// Adds the chosen neighbours with their plans.
void add_threats(const BarrierLaw& law, std::span<const int> chosen, BarrierPeriod& now) {
  struct Requested {
    Bounded<const Tube*, 2 * most_neighbours> tubes;
    Bounded<Escape*, 2 * most_neighbours> plans;
  };
  Requested of_members, of_others;
  const auto request = [](Requested& requested, const Tube& tube, Escape& plan) {
    requested.tubes.push_back(&tube);
    requested.plans.push_back(&plan);
  };
  decltype(Tube::thrusts) thrusts{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(law.can.thrust_count); ++k) {
    const Vec2<double> g = law.can.turns ? rotate(now.self.d, law.can.thrusts[k]) : law.can.thrusts[k];
    thrusts[k] = {now.part * law.options.authority * g.x, now.part * law.options.authority * g.y};
  }
  // Tubes from a neighbour's measured motion, as an alternative to those from its speed limit
  // alone.
  Bounded<Tube, most_neighbours> measured;
  Bounded<Threat*, most_neighbours> measured_of;
  std::array<Escape, most_neighbours> measured_plans;
  for (const int i : chosen) {
    const Neighbour& n = now.neighbours[size(i)];
    Threat& threat = now.threats.emplace_back();
    threat.behavior = n.behavior;
    threat.neighbour = i;
    Tube& tube = threat.tube;
    fill_tube(tube, law, now, n);
    if (n.behavior == Behavior::cooperative) {
      request(of_members, tube, threat.plan);
      continue;
    }
    tube.thrust_count = law.can.thrust_count;
    tube.thrusts = thrusts;
    const double age = std::max(n.age, 0.0);
    if (n.acceleration_max < infinity) {
      Tube& known = measured.push_back(tube);
      known.r = known.r - age * n.v;
      known.drift = n.v;
      known.rho0 += 0.5 * n.acceleration_max * age * age;
      known.speed += n.acceleration_max * age;
      known.growth += n.acceleration_max;
      request(of_others, known, measured_plans[measured_of.size()]);
      measured_of.push_back(&threat);
    }
    tube.rho0 += n.speed_max * age;
    tube.speed += n.speed_max;
    request(of_others, tube, threat.plan);
  }
  for (Requested* requested : {&of_members, &of_others})
    law.plans.best(requested->tubes.items(), requested->plans.items());
  for (std::size_t k = 0; k < measured.size(); ++k) {
    Threat& threat = *measured_of[k];
    if (measured_plans[k].reserve() <= threat.plan.reserve()) continue;
    threat.tube = measured[k];
    threat.plan = measured_plans[k];
  }
  for (Threat& threat : now.threats) threat.reserve = threat.plan.reserve();
}

/// Proves that the one neighbour's plan keeps the distance, or takes the plan of the previous period:
/// its rest still keeps what was proven then.
void prove_plan(const BarrierLaw& law, BarrierPeriod& now) {
  Threat& threat = now.threats[0];
  const auto keeps = [&](double wanted) { return law.plans.keeps(threat.tube, threat.plan.a, wanted); };
  const bool is_far = threat.reserve >= law.ample;
  if (is_far && keeps(law.ample)) {
    now.proven = true;
    return;
  }
  now.proven = keeps(law.proven_least());
  const double checked = std::nextafter(law.ample, 0.0);  // the most of which commands are checked
  if (now.proven && is_far) threat.reserve = checked;
  const Vec2<double>& along = now.plan_before;
  if (now.proven || dot(along, along) == 0 || threat.tube.growth != 0) return;
  constexpr double rounding = 1e-5;  // [m]
  const Escape kept = law.plans.with(threat.tube, {threat.tube.beta * along.x, threat.tube.beta * along.y});
  if (kept.reserve() < law.proven_least() - rounding)
    return;  // a body or the robot moved otherwise than assumed
  threat.plan = kept;
  threat.reserve = std::min(kept.reserve(), checked);
  now.proven = true;
}

}  // namespace

bool is_finite(const Neighbour& n) noexcept {
  const std::array<double, 13> numbers = {n.p.x,       n.p.y, n.p.z,   n.v.x, n.v.y,  n.v.z,  n.d_hard,
                                          n.speed_max, n.age, n.sigma, n.tie, n.part, n.lacks};
  return all_finite(numbers) && !std::isnan(n.acceleration_max);
}

bool find_threats(const BarrierLaw& law, BarrierPeriod& now) noexcept {
  const std::span<const Neighbour> neighbours = now.neighbours;
  // The most threatening neighbours, by the distance that remains after 1 s of closing in.
  Bounded<int, most_neighbours> chosen;
  std::array<double, most_neighbours> key;
  // A height with a lag needs two rows for each neighbour.
  const std::size_t most = law.can.climb_lag > 0 ? most_neighbours / 2 : most_neighbours;
  const bool all_fit = neighbours.size() <= most;
  bool all_known = true;
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const Neighbour& n = neighbours[i];
    if (!is_finite(n)) {
      all_known = false;
      continue;
    }
    const Vec3<double> r = now.self.p - n.p;
    if (is_far(r)) continue;
    if (all_fit) {
      chosen.push_back(static_cast<int>(i));
      continue;
    }
    const bool member = n.behavior == Behavior::cooperative;
    const double left =
        nearest_threats_key(r, member ? now.self.v - n.v : now.self.v, n.d_hard, member ? 0.0 : n.speed_max);
    if (chosen.size() == most && left >= key[most - 1]) continue;
    if (chosen.size() < most) chosen.push_back(-1);
    std::size_t at = chosen.size() - 1;
    for (; at > 0 && key[at - 1] > left; --at) key[at] = key[at - 1], chosen[at] = chosen[at - 1];
    key[at] = left, chosen[at] = static_cast<int>(i);
  }
  // Among cooperative neighbours that cannot come too near within the period, only those that may
  // have the least reserve matter. A joint plan or a manoeuvre, however, must consider all.
  const auto is_member = [&](int i) { return neighbours[size(i)].behavior == Behavior::cooperative; };
  const bool all =
      std::count_if(chosen.begin(), chosen.end(), is_member) + 1 < static_cast<std::ptrdiff_t>(chosen.size());
  std::array<PairBounds, most_neighbours> within;
  constexpr double found_to = 1e-3;  // [m] tolerance of the plan search
  double most_of_least = infinity;
  for (std::size_t k = 0; k < chosen.size() && !all; ++k) {
    within[k] = {-infinity, infinity, false};
    if (!is_member(chosen[k])) continue;
    Tube tube;
    fill_tube(tube, law, now, neighbours[size(chosen[k])]);
    within[k] = bounds_of_pair(law, tube);
    most_of_least = std::min(most_of_least, within[k].most);
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (all || !within[k].quiet || within[k].least <= most_of_least + found_to) chosen[kept++] = chosen[k];
  }
  add_threats(law, {chosen.begin(), kept}, now);
  if (law.can.thrust_lag > 0 && now.threats.size() == 1) prove_plan(law, now);
  return all_known;
}

}  // namespace sightline
