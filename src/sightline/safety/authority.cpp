#include "sightline/safety/authority.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/safety/projection.hpp"

namespace sightline {
namespace {

constexpr double finite_step = 1e-4;  // [s], and of inputs
constexpr double rounding = 1e-6;     // smaller values count as zero

using Inputs = std::array<double, most_inputs>;

struct Motion {
  std::array<double, most_states> x{};  // the first nx
  Inputs u{};
};

/// Motion under constant inputs.
struct Response {
  Vec3<double> v, a;       // velocity [m/s] and its derivative [m/s^2]
  Vec2<double> d;          // heading
  double turn_rate = 0.0;  // [rad/s]
};

Response response(const Model& model, const Motion& at) {
  std::array<double, most_states> later = at.x, rate{};
  model.f(at.x.data(), at.u.data(), rate.data());
  for (std::size_t i = 0; i < rate.size(); ++i) later[i] += finite_step * rate[i];
  const Sight<double> now = model.sight(at.x.data(), at.u.data()),
                      then = model.sight(later.data(), at.u.data());
  return {now.v, (1.0 / finite_step) * (then.v - now.v), now.d,
          (now.d.x * then.d.y - now.d.y * then.d.x) / finite_step};
}

/// Derivatives of the horizontal acceleration, and of the vertical velocity and acceleration, by
/// the inputs.
struct Columns {
  std::array<Vec2<double>, most_inputs> thrust{};
  std::array<double, most_inputs> climb{}, climb_later{};
  bool climbs = false, climbs_late = false;
};

Columns columns(const Model& model, const Motion& at) {
  Columns c;
  for (std::size_t k = 0; k < static_cast<std::size_t>(model.nu()); ++k) {
    Motion up = at, down = at;
    up.u[k] += 0.5;
    down.u[k] -= 0.5;
    const Response higher = response(model, up), lower = response(model, down);
    const Vec3<double> a = higher.a - lower.a;
    const double climb = higher.v.z - lower.v.z;
    c.thrust[k] = {std::abs(a.x) > rounding ? a.x : 0.0, std::abs(a.y) > rounding ? a.y : 0.0};
    c.climb[k] = std::abs(climb) > rounding ? climb : 0.0;
    c.climbs = c.climbs || std::abs(climb) > rounding;
    if (std::abs(climb) <= rounding && std::abs(a.z) > rounding) c.climb_later[k] = a.z, c.climbs_late = true;
  }
  return c;
}

/// What remains of the thrusts after they compensate `other`, by the smallest commands s_i . a; s_i
/// are the rows of the pseudo-inverse.
struct Strength {
  double disc = 0.0;  ///< radius of attainable accelerations [m/s^2]
  double part = 0.0;  ///< free part of each command, in [0, 1]
};

Strength strength(const Columns& c, const Vec2<double>& other, std::span<const double> u_min,
                  std::span<const double> u_max) {
  double xx = 0, xy = 0, yy = 0;
  for (const Vec2<double>& g : c.thrust) xx += g.x * g.x, xy += g.x * g.y, yy += g.y * g.y;
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > rounding * (xx + yy) * (xx + yy))) return {};
  Strength least = {infinity, 1.0};
  for (std::size_t i = 0; i < u_min.size(); ++i) {
    const Vec2<double>& g = c.thrust[i];
    const Vec2<double> s = {(yy * g.x - xy * g.y) / determinant, (xx * g.y - xy * g.x) / determinant};
    const double length = norm(s.x, s.y), held = dot(s, other);
    if (length == 0) continue;
    const double whole = std::min(u_max[i], -u_min[i]), free = std::min(u_max[i] - held, held - u_min[i]);
    least.disc = std::min(least.disc, free / length);
    least.part = std::min(least.part, whole > 0 ? (whole - std::abs(held)) / whole : 0.0);
  }
  return {std::max(least.disc, 0.0), std::max(least.part, 0.0)};
}

/// A state reached from rest in some heading under diverse commands, and the thrusts there.
struct ResponseSample {
  Motion at;  // without commands
  Vec2<double> v, drift, heading;
  double climb = 0.0, brake = 0.0;  // vertical speed [m/s], and its derivative without commands [m/s^2]
  double turn = 0.0;                // turn rate without commands [rad/s]
  Columns columns;
  Vec2<double> push{};  // of all inputs together, including those that turn the push [m/s^2]
  double rise = 0.0;    // of all inputs together [m/s]
};

std::vector<ResponseSample> response_samples(const Model& model, std::span<const double> u_min,
                                             std::span<const double> u_max) {
  constexpr int headings = 8, stops = 8;
  constexpr double pace = 0.05, longest = 1.2;  // [s]
  std::vector<ResponseSample> found;
  for (int i = 0; i < headings; ++i) {
    const double psi = 0.1 + 2 * std::numbers::pi * i / headings;
    Motion at;
    const auto x = std::span(at.x).first(static_cast<std::size_t>(model.nx()));
    model.at_rest({{0, 0, 1}, {std::cos(psi), std::sin(psi)}}, at.x.data());
    const Columns resting = columns(model, at);
    std::vector<double> rows(RungeKuttaScratch::rows_needed * x.size());
    Inputs driven{};
    for (std::size_t k = 0; k < u_min.size(); ++k)
      driven[k] = ((i >> (k % 3)) + static_cast<int>(k / 3)) % 2 == 0 ? u_min[k] : u_max[k];
    for (int stop = 0; stop < stops; ++stop) {
      for (double t = 0; stop > 0 && t < longest; t += pace) {
        rk4_step([&](std::span<const double> z,
                     std::span<double> rate) { model.f(z.data(), driven.data(), rate.data()); },
                 x, pace, {rows});
        if (!model.normalise(at.x.data())) break;
      }
      // Inputs that do not push at rest, such as yaw, do not count.
      Columns here = columns(model, at);
      Vec2<double> push;
      double rise = 0.0;
      for (std::size_t k = 0; k < u_min.size(); ++k) {
        const double most = std::max(std::abs(u_min[k]), std::abs(u_max[k]));
        push = {push.x + most * std::abs(here.thrust[k].x), push.y + most * std::abs(here.thrust[k].y)};
        rise += most * std::abs(here.climb[k]);
      }
      for (std::size_t k = 0; k < most_inputs; ++k) {
        if (dot(resting.thrust[k], resting.thrust[k]) == 0) here.thrust[k] = {};
      }
      const auto& [v, a, d, turn_rate] = response(model, at);
      found.push_back({at, {v.x, v.y}, {a.x, a.y}, d, v.z, a.z, turn_rate, here, push, rise});
    }
  }
  return found;
}

Vec2<double> in_frame(const ResponseSample& sample, std::size_t k, bool turns) {
  const Vec2<double> back = {sample.heading.x, -sample.heading.y};
  return turns ? rotate(back, sample.columns.thrust[k]) : sample.columns.thrust[k];
}

/// Writes the thrusts in V, or else in G, if they are equal in all samples; writes none if they are
/// constant in neither.
void add_thrusts(const std::vector<ResponseSample>& all, double part, std::span<const double> u_min,
                 std::span<const double> u_max, Authority& authority) {
  constexpr double same = 1e-3;  // relative to a thrust
  for (const bool turns : {true, false}) {
    const bool fixed = std::all_of(all.begin(), all.end(), [&](const ResponseSample& sample) {
      for (std::size_t k = 0; k < u_min.size(); ++k) {
        const Vec2<double> g = in_frame(all.front(), k, turns), h = in_frame(sample, k, turns);
        if (norm(g.x - h.x, g.y - h.y) > same * (norm(g.x, g.y) + rounding)) return false;
      }
      return true;
    });
    if (!fixed) continue;
    authority.turns = turns;
    for (std::size_t k = 0; k < u_min.size(); ++k) {
      const double reach = part * std::min(u_max[k], -u_min[k]);
      const Vec2<double> g = in_frame(all.front(), k, turns);
      if (dot(g, g) > 0)
        authority.thrusts[static_cast<std::size_t>(authority.thrust_count++)] = {reach * g.x, reach * g.y};
    }
    return;
  }
}

/// tau of a vertical speed that follows its commands with one lag; 0 if it follows at once [s].
/// @throws std::invalid_argument if it follows in another way
double climb_lag_of(const Model& model, const std::vector<ResponseSample>& all) {
  constexpr double fast = 1e-2, same = 1e-3;  // [m/s]; relative to the lag
  const auto late = [](const ResponseSample& sample) { return sample.columns.climbs_late; };
  if (std::none_of(all.begin(), all.end(), late)) return 0.0;
  double lag = 0.0;
  bool one = std::all_of(all.begin(), all.end(), late);
  for (const ResponseSample& sample : all) {
    if (std::abs(sample.climb) < fast) continue;
    const double here = -sample.climb / sample.brake;
    if (lag == 0) lag = here;
    one = one && here > 0 && std::abs(here - lag) <= same * lag;
  }
  if (!one || lag == 0) {
    throw std::invalid_argument(fmt::format(
        "barrier: the height of \"{}\" follows its commands neither at once nor by one lag, expected a "
        "vertical velocity that is commanded",
        model.name()));
  }
  return lag;
}

/// Fills the authority of a robot that drives along its heading. @return whether it is one
bool find_drive(const std::vector<ResponseSample>& all, std::span<const double> u_min,
                std::span<const double> u_max, Authority& authority) {
  constexpr double fitted_to = 1e-3;  // relative, for drag and acceleration
  const Columns& resting = all.front().columns;
  int drive = -1, others = 0;
  for (std::size_t k = 0; k < u_min.size(); ++k) {
    if (dot(resting.thrust[k], resting.thrust[k]) > 0)
      drive = drive < 0 ? static_cast<int>(k) : static_cast<int>(most_inputs);
    else
      ++others;
  }
  if (drive < 0 || drive >= most_inputs || others > 1) return false;
  const auto of_drive = static_cast<std::size_t>(drive);
  const double range = std::min(u_max[of_drive], -u_min[of_drive]);
  const double gain = dot(resting.thrust[of_drive], all.front().heading), c = authority.drag;
  for (const ResponseSample& sample : all) {
    const Vec2<double>& d = sample.heading;
    const auto across = [&](const Vec2<double>& v) { return d.x * v.y - d.y * v.x; };
    const Vec2<double>& g = sample.columns.thrust[of_drive];
    const double speed = dot(d, sample.v), off = fitted_to * (1 + std::abs(speed));
    // Without commands the heading rests, so that the velocity keeps its direction.
    if (std::abs(across(sample.v)) > off || std::abs(across(sample.drift)) > off ||
        std::abs(sample.turn) > fitted_to || std::abs(sample.climb) > off || sample.columns.climbs ||
        sample.columns.climbs_late || std::abs(dot(d, sample.drift) + c * speed) > off ||
        std::abs(across(g)) > off || std::abs(dot(d, g) - gain) > fitted_to * std::abs(gain))
      return false;
  }
  if (!(range > 0)) return false;
  authority.drive = drive;
  authority.acceleration = range * std::abs(gain);
  authority.free = 1.0;
  authority.turns = true;
  return true;
}

/// Derivative of g(x, u) in time under constant inputs, by a central difference.
template <class G>
auto rate_of(const Model& model, const Motion& at, const G& g) {
  std::array<double, most_states> rate{};
  model.f(at.x.data(), at.u.data(), rate.data());
  Motion before = at, after = at;
  for (std::size_t i = 0; i < rate.size(); ++i)
    before.x[i] -= finite_step * rate[i], after.x[i] += finite_step * rate[i];
  return (0.5 / finite_step) * (g(after) - g(before));
}

/// Fills the authority of a robot whose horizontal acceleration follows its commands with one lag.
/// @return whether it is one
bool find_thrust_lag(const Model& model, const std::vector<ResponseSample>& all,
                     std::span<const double> u_min, std::span<const double> u_max, Authority& authority) {
  constexpr double slow = 1e-2, same = 1e-4;  // [m/s^2] or [rad/s]; relative
  const auto tilt = [&](const Motion& at) {
    const Vec2<double> lean = model.sight(at.x.data(), at.u.data()).lean;
    return Vec3<double>{gravity * lean.x, gravity * lean.y, 0.0};
  };
  const auto moves = [&](const Motion& at) { return model.sight(at.x.data(), at.u.data()).v; };
  const auto turns = [&](const Motion& at) { return response(model, at).turn_rate; };
  const auto agrees = [](double& known, double value) {
    if (known == 0) known = value;
    return value > 0 && std::abs(value - known) <= same * known;
  };
  // The lags of the tilt and of the yaw rate, and what the commands add to the tilt.
  Columns gains;
  double turned = 0.0;  // of all commands together [rad/s^2]
  for (const ResponseSample& sample : all) {
    const Vec3<double> a = tilt(sample.at), fades = rate_of(model, sample.at, tilt);
    if (norm(a) > slow && !agrees(authority.thrust_lag, -dot(a, a) / dot(a, fades))) return false;
    if (std::abs(sample.turn) > slow &&
        !agrees(authority.turn_lag, -sample.turn / rate_of(model, sample.at, turns)))
      return false;
  }
  if (authority.thrust_lag == 0) return false;
  for (std::size_t k = 0; k < u_min.size(); ++k) {
    const double greatest = std::max(-u_min[k], u_max[k]);
    for (const ResponseSample& sample : all) {
      Motion pushed = sample.at;
      pushed.u[k] = 1.0;
      if (&sample == all.data())
        turned += greatest * std::abs(rate_of(model, pushed, turns) - rate_of(model, sample.at, turns));
      const Vec3<double> at_once = tilt(pushed) - tilt(sample.at),
                         gain = authority.thrust_lag *
                                (rate_of(model, pushed, tilt) - rate_of(model, sample.at, tilt));
      if (&sample == all.data()) gains.thrust[k] = {gain.x, gain.y};
      if (norm(at_once) > rounding || norm(gain.x - gains.thrust[k].x, gain.y - gains.thrust[k].y) > same)
        return false;
    }
    if (norm(gains.thrust[k].x, gains.thrust[k].y) < rounding) gains.thrust[k] = {};
  }
  authority.turn = 2 * turned;
  authority.rate_state = authority.turn_lag > 0 ? roles_of(model).rate : -1;
  if (authority.turn_lag > 0 && authority.rate_state < 0) return false;
  // Drag and lift, from the acceleration with and without a command that keeps the vertical speed.
  struct Seen {
    Vec2<double> v, a, steady;
  };
  std::vector<Seen> seen;
  double along = 0.0, speed = 0.0;
  for (const ResponseSample& sample : all) {
    Motion steady = sample.at;
    for (std::size_t k = 0; k < u_min.size(); ++k) {
      if (sample.columns.climb_later[k] != 0) steady.u[k] = -sample.brake / sample.columns.climb_later[k];
    }
    const Vec3<double> a_V = tilt(sample.at), with = rate_of(model, steady, moves),
                       without = rate_of(model, sample.at, moves);
    const Vec2<double> a = rotate(sample.heading, Vec2<double>{a_V.x, a_V.y}),
                       lifted = {without.x - with.x, without.y - with.y};
    seen.push_back({sample.v, a, {with.x, with.y}});
    along -= dot(Vec2<double>{with.x - a.x, with.y - a.y}, sample.v);
    speed += dot(sample.v, sample.v);
    if (std::abs(sample.brake) * dot(a, a) < slow) continue;
    const double lift = dot(lifted, a) / (without.z * dot(a, a));
    if (authority.lift == 0) authority.lift = lift;
    if (std::abs(lift - authority.lift) > same ||
        norm(lifted.x - lift * without.z * a.x, lifted.y - lift * without.z * a.y) > same)
      return false;
  }
  const double c = speed > rounding ? std::max(along / speed, 0.0) : 0.0;
  for (const Seen& one : seen)
    authority.misfit = std::max(
        authority.misfit, norm(one.steady.x - one.a.x + c * one.v.x, one.steady.y - one.a.y + c * one.v.y));
  if (authority.misfit < rounding) authority.misfit = 0.0;
  authority.lift = std::abs(authority.lift);
  authority.drag = c;
  authority.acceleration = strength(gains, {}, u_min, u_max).disc;
  authority.free = 1.0;
  Vec2<double> most;
  for (std::size_t k = 0; k < u_min.size(); ++k) {
    // Earlier commands may have had wider limits.
    const double u = std::max({-u_min[k], u_max[k], -model.u_min()[k], model.u_max()[k]});
    most = {most.x + u * std::abs(gains.thrust[k].x), most.y + u * std::abs(gains.thrust[k].y)};
    if (dot(gains.thrust[k], gains.thrust[k]) > 0) authority.reach[k] = std::min(u_max[k], -u_min[k]);
  }
  authority.thrust_most = norm(most.x, most.y);
  const double jerk = authority.climb_lag > 0 ? 2 * authority.climb / authority.climb_lag : 0.0;
  authority.push = (1 + authority.lift * jerk) * authority.thrust_most;
  return authority.acceleration > rounding;
}

}  // namespace

double Authority::part(std::span<const double> u_min, std::span<const double> u_max) const noexcept {
  constexpr double least = 0.05;  // below this, plans hardly move
  double left = 1.0;
  for (std::size_t k = 0; k < u_min.size(); ++k) {
    if (reach[k] > 0) left = std::min(left, std::min(u_max[k], -u_min[k]) / reach[k]);
  }
  return std::max(least, (left - (1.0 - free)) / free);
}

bool moves_alike(const Authority& a, const Authority& b) noexcept {
  constexpr double fitted_to = 1e-6;  // relative, for drag and lag
  const auto same = [](double x, double y) { return std::abs(x - y) <= fitted_to * (1 + std::abs(x)); };
  return a.drive == b.drive && a.turns == b.turns && a.climbs == b.climbs &&
         a.thrust_count == b.thrust_count && same(a.drag, b.drag) && same(a.climb_lag, b.climb_lag) &&
         same(a.thrust_lag, b.thrust_lag);
}

Authority authority_of(const Model& model, std::span<const double> u_min, std::span<const double> u_max) {
  if (model.nu() > most_inputs || model.nx() > most_states) {
    throw std::invalid_argument(
        fmt::format("barrier: \"{}\" has {} inputs and {} states, expected at most {} and {}", model.name(),
                    model.nu(), model.nx(), most_inputs, most_states));
  }
  const std::vector<ResponseSample> all = response_samples(model, u_min, u_max);
  Authority authority;
  authority.climb_lag = climb_lag_of(model, all);
  authority.climb = infinity;
  double along = 0.0, speed = 0.0;
  for (const ResponseSample& sample : all) {
    along -= dot(sample.drift, sample.v);
    speed += dot(sample.v, sample.v);
    authority.climbs = authority.climbs || sample.columns.climbs || sample.columns.climbs_late;
    double climb = 0.0;
    for (std::size_t k = 0; k < u_min.size(); ++k) {
      const double rises = sample.columns.climb[k] + authority.climb_lag * sample.columns.climb_later[k];
      climb += std::abs(rises) * std::max(0.0, std::min(u_max[k], -u_min[k]));
    }
    authority.climb = std::min(authority.climb, climb);
  }
  authority.drag = speed > rounding ? std::max(along / speed, 0.0) : 0.0;
  Strength all_have = {infinity, 1.0};
  double at_rest = 0.0;  // radius of the disc in the first sample [m/s^2]
  for (const ResponseSample& sample : all) {
    const double c = authority.drag;
    const Vec2<double> other = {-c * sample.v.x - sample.drift.x, -c * sample.v.y - sample.drift.y};
    const Strength here = strength(sample.columns, other, u_min, u_max);
    if (&sample == all.data()) at_rest = here.disc;
    all_have = {std::min(all_have.disc, here.disc), std::min(all_have.part, here.part)};
    authority.push = std::max(authority.push, norm(other.x, other.y) + norm(sample.push.x, sample.push.y));
    authority.rise = std::max(authority.rise, sample.rise);
  }
  authority.acceleration = all_have.disc;
  authority.free = all_have.part;
  for (std::size_t k = 0; k < u_min.size(); ++k) {
    const Columns& resting = all.front().columns;
    if (dot(resting.thrust[k], resting.thrust[k]) > 0 || resting.climb[k] != 0 || resting.climb_later[k] != 0)
      authority.reach[k] = std::min(u_max[k], -u_min[k]);
  }
  if (!(authority.acceleration > rounding) && find_drive(all, u_min, u_max, authority)) return authority;
  if (Authority late = authority; !(at_rest > rounding) && find_thrust_lag(model, all, u_min, u_max, late))
    return late;
  // If the heading continues to turn, the corners of the thrusts turn with it; the disc does not.
  const auto turns_on = [](const ResponseSample& sample) { return std::abs(sample.turn) > rounding; };
  const bool turns = std::any_of(all.begin(), all.end(), turns_on);
  if (!(authority.acceleration > rounding) && turns && at_rest > rounding) {
    throw std::invalid_argument(fmt::format(
        "barrier: the velocity of \"{}\" turns with its heading, faster than its commands accelerate it "
        "against that, expected a lower yaw rate, a velocity that stays in G, or a yaw rate without a lag",
        model.name()));
  }
  if (!(authority.acceleration > rounding)) {
    throw std::invalid_argument(
        fmt::format("barrier: the commands of \"{}\" do not accelerate it in every horizontal direction at "
                    "once, expected a robot that can flee any way, or one that drives along its heading",
                    model.name()));
  }
  if (turns) return authority;
  add_thrusts(all, all_have.part, u_min, u_max, authority);
  if (authority.thrust_count == 0) {
    throw std::invalid_argument(fmt::format(
        "barrier: the thrusts of \"{}\" turn neither with its heading nor stay in G, expected one of them",
        model.name()));
  }
  return authority;
}

}  // namespace sightline
