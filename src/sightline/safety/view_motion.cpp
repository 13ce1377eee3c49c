#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "sightline/model/state_roles.hpp"
#include "sightline/safety/view_certificate.hpp"

namespace sightline {
namespace {

constexpr double flow_step = 1e-5;  // [s]
constexpr double fitted = 1e-3;     // greatest error of the law, in m/s^2, m/s and rad/s

/// Motion in V at a state under inputs.
struct MotionInV {
  Vec2<double> v, a, lean;  // velocity [m/s] and its rate in V [m/s^2], tilt
  double climb, lift;       // vertical velocity [m/s] and its rate [m/s^2]
  double turn, turn_rate;   // yaw rate [rad/s] and its rate [rad/s^2]
};

/// The state a short time later.
std::vector<double> later(const Model& model, std::vector<double> x, const std::vector<double>& u) {
  std::vector<double> rate(x.size());
  model.f(x.data(), u.data(), rate.data());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += flow_step * rate[i];
  return x;
}

double turn_of(const Model& model, const std::vector<double>& x, const std::vector<double>& u) {
  const Vec2<double> d = model.sight(x.data(), u.data()).d,
                     then = model.sight(later(model, x, u).data(), u.data()).d;
  return std::atan2(d.x * then.y - d.y * then.x, dot(d, then)) / flow_step;
}

MotionInV motion_in_V(const Model& model, const std::vector<double>& x, const std::vector<double>& u) {
  const auto in_V = [](const Sight<double>& s) { return rotate<double>({s.d.x, -s.d.y}, {s.v.x, s.v.y}); };
  const std::vector<double> next = later(model, x, u);
  const Sight<double> now = model.sight(x.data(), u.data()), then = model.sight(next.data(), u.data());
  const Vec2<double> v = in_V(now), v_then = in_V(then);
  const double turn = turn_of(model, x, u);
  return {.v = v,
          .a = {(v_then.x - v.x) / flow_step, (v_then.y - v.y) / flow_step},
          .lean = now.lean,
          .climb = now.v.z,
          .lift = (then.v.z - now.v.z) / flow_step,
          .turn = turn,
          .turn_rate = (turn_of(model, next, u) - turn) / flow_step};
}

[[noreturn]] void refuse(const Model& model, std::string_view why, std::string_view expected) {
  throw_invalid("\"{}\" {}, expected {}", model.name(), why, expected);
}

/// Whether the motion follows the law that was fitted.
bool follows(const ViewMotion& law, const MotionInV& m, const std::vector<double>& u) {
  const auto commanded = [&](const ViewMotion::Axis& axis) {
    return axis.input >= 0 ? axis.gain * u[size(axis.input)] : 0.0;
  };
  const auto agree = [](double a, double b) { return std::abs(a - b) <= fitted * (1 + std::abs(b)); };
  const auto rate_follows = [&](const ViewMotion::Axis& axis, double rate, double change) {
    return axis.lag > 0 ? agree(axis.lag * change, commanded(axis) - rate) : agree(rate, commanded(axis));
  };
  const double turned = law.is_level ? m.turn : 0.0;
  return rate_follows(law.climb, m.climb, m.lift) && rate_follows(law.turn, m.turn, m.turn_rate) &&
         agree(m.a.x, commanded(law.along) - law.along.drag * m.v.x + turned * m.v.y) &&
         agree(m.a.y, commanded(law.across) - law.across.drag * m.v.y - turned * m.v.x);
}

/// Drives a state by constant inputs for a time [s].
void drive(const Model& model, std::vector<double>& x, const std::vector<double>& u, double time) {
  constexpr double pace = 0.05;  // [s]
  for (double t = 0; t < time; t += pace) {
    model.step(x.data(), u.data(), pace);
    if (!model.normalise(x.data())) refuse(model, "has states that are not finite", "finite ones");
  }
}

/// The axes with their inputs and gains, from the effect of each input at rest.
ViewMotion axes_of(const Model& model, const std::vector<double>& rest, std::span<const double> u_min,
                   std::span<const double> u_max) {
  constexpr double effect = 1e-6, late = 1e-2;  // of an input; of one on a rate's rate
  ViewMotion law;
  const std::vector<double> none(u_min.size());
  // The effects of an input that lasts: rates that follow late, from the lag of a state in motion.
  std::vector<double> moving = rest, half(u_min.size());
  for (std::size_t k = 0; k < half.size(); ++k) half[k] = 0.5 * u_max[k];
  drive(model, moving, half, 0.5);
  const MotionInV free = motion_in_V(model, moving, none);
  for (std::size_t k = 0; k < u_min.size(); ++k) {
    std::vector<double> one(u_min.size());
    one[k] = 1.0;
    MotionInV m = motion_in_V(model, rest, one);
    if (std::abs(m.climb) < effect && std::abs(m.lift) > late) {
      law.climb.lag = -free.climb / free.lift;
      m.climb = law.climb.lag * m.lift;
    }
    if (std::abs(m.turn) < effect && std::abs(m.turn_rate) > late) {
      law.turn.lag = -free.turn / free.turn_rate;
      m.turn = law.turn.lag * m.turn_rate;
    }
    const std::array<std::pair<ViewMotion::Axis*, double>, 4> effects = {
        {{&law.along, m.a.x}, {&law.across, m.a.y}, {&law.climb, m.climb}, {&law.turn, m.turn}}};
    int moved = 0;
    for (const auto& [axis, gain] : effects) {
      if (std::abs(gain) < effect) continue;
      if (axis->input >= 0 || ++moved > 1)
        refuse(model, "has no separate input for each motion",
               "one each along, across, up and about its heading");
      axis->input = static_cast<int>(k), axis->gain = gain;
      axis->most = std::abs(gain) * std::min(u_max[k], -u_min[k]);
    }
  }
  if (law.turn.input < 0) refuse(model, "does not turn by one input", "one that turns it");
  if (law.along.input < 0)
    refuse(model, "does not accelerate along its heading at once, by one input", "one that does");
  if (law.turn.lag > 0) law.rate_state = roles_of(model).rate;
  return law;
}

}  // namespace

Vec2<double> ViewMotion::pushes(double part) const {
  const double c = std::abs(ahead.x), s = std::abs(ahead.y), b = along.most, b_s = across.most;
  if (!is_turned()) return most_push();
  const double beside = part * std::min(b / s, b_s / c);
  return {std::min((b - s * beside) / c, (b_s - c * beside) / s), beside};
}

Vec2<double> ViewMotion::most_push() const {
  const double c = std::abs(ahead.x), s = std::abs(ahead.y);
  return {c * along.most + s * across.most, s * along.most + c * across.most};
}

Vec2<double> ViewMotion::drags() const {
  const double c = square(ahead.x), s = square(ahead.y);
  return {c * along.drag + s * across.drag, s * along.drag + c * across.drag};
}

double ViewMotion::drag_between() const { return std::abs((along.drag - across.drag) * ahead.x * ahead.y); }

Vec2<double> view_direction(std::span<const Potential> limits) {
  constexpr double least = 1e-3, nearly = 0.01;
  Vec2<double> sum{};
  for (const Potential& limit : limits) {
    if (limit.mount() == nullptr) continue;
    const Vec3<double> axis = limit.mount()->attitude() * Vec3<double>{1, 0, 0};
    sum = {sum.x + axis.x, sum.y + axis.y};
  }
  const double length = norm(sum.x, sum.y);
  if (length < least) return {1, 0};
  const Vec2<double> ahead = {sum.x / length, sum.y / length};
  // A right angle costs no thrust.
  if (std::abs(ahead.y) < nearly) return {ahead.x > 0 ? 1.0 : -1.0, 0};
  if (std::abs(ahead.x) < nearly) return {0, ahead.y > 0 ? 1.0 : -1.0};
  return ahead;
}

ViewMotion view_motion(const Model& model, std::span<const double> u_min, std::span<const double> u_max,
                       const Vec2<double>& ahead) {
  const std::size_t nu = u_min.size();
  std::vector<double> rest(size(model.nx()));
  model.at_rest({{0, 0, 1}, {1, 0}}, rest.data());
  ViewMotion law = axes_of(model, rest, u_min, u_max);
  // Drag, without a turn.
  std::vector<double> moving = rest, straight(nu);
  for (std::size_t k = 0; k < nu; ++k)
    straight[k] = static_cast<int>(k) == law.turn.input ? 0.0 : 0.5 * u_max[k];
  drive(model, moving, straight, 0.5);
  const MotionInV free = motion_in_V(model, moving, std::vector<double>(nu));
  law.along.drag = std::max(0.0, -free.a.x / free.v.x);
  if (law.across.input >= 0) law.across.drag = std::max(0.0, -free.a.y / free.v.y);
  // The whole law, in either frame, at many states.
  constexpr int headings = 6, stops = 6;
  bool in_V = true, in_G = law.across.input >= 0;
  for (int i = 0; i < headings; ++i) {
    std::vector<double> x(rest.size()), driven(nu);
    const double psi = 0.2 + 2 * std::numbers::pi * i / headings;
    model.at_rest({{0, 0, 1}, {std::cos(psi), std::sin(psi)}}, x.data());
    for (std::size_t k = 0; k < nu; ++k)
      driven[k] = ((i + 1) >> (k % 3)) % 2 == (k < 3 ? 0 : 1) ? u_min[k] : 0.8 * u_max[k];
    for (int stop = 0; stop < stops; ++stop) {
      drive(model, x, driven, 0.6);
      const MotionInV m = motion_in_V(model, x, driven);
      law.lean = {std::max(law.lean.x, std::abs(m.lean.x)), std::max(law.lean.y, std::abs(m.lean.y))};
      law.is_level = false;
      in_V = in_V && follows(law, m, driven);
      law.is_level = true;
      in_G = in_G && follows(law, m, driven);
    }
  }
  law.is_level = !in_V;
  if (!in_V && !in_G)
    refuse(model, "moves by another law than a drag and a thrust in each direction",
           "v' = -c v + b u along and across its heading, as in (24)");
  law.ahead = ahead;
  if (law.across.input < 0 && ahead.y != 0)
    refuse(model, "does not move sideward", "a sensor that looks ahead or back");
  if (law.turn.lag > 0 && law.rate_state < 0)
    refuse(model, "turns late, by a lag that is no state", "its yaw rate as a state");
  // Tilts of both signs and of every input.
  for (std::size_t k = 0; k < nu; ++k) {
    for (const double bound : {u_min[k], u_max[k]}) {
      std::vector<double> one(nu);
      one[k] = bound;
      const Vec2<double> lean = model.sight(rest.data(), one.data()).lean;
      law.lean = {std::max(law.lean.x, std::abs(lean.x)), std::max(law.lean.y, std::abs(lean.y))};
    }
  }
  return law;
}

}  // namespace sightline
