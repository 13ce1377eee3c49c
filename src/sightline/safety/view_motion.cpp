#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <vector>

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

/// Whether the motion follows the axes that were fitted, and what differs.
enum class Difference { none, turned, other };
Difference difference(const ViewMotion& law, const MotionInV& m, const std::vector<double>& u) {
  const auto of = [&](const ViewMotion::Axis& axis, double v) {
    return -axis.drag * v + (axis.input >= 0 ? axis.gain * u[size(axis.input)] : 0.0);
  };
  const auto differs = [](double a, double b) { return std::abs(a - b) > fitted * (1 + std::abs(b)); };
  if (differs(m.climb, of(law.climb, 0)) || differs(m.turn, of(law.turn, 0))) return Difference::other;
  const Vec2<double> a = {of(law.along, m.v.x), of(law.across, m.v.y)};
  if (!differs(m.a.x, a.x) && !differs(m.a.y, a.y)) return Difference::none;
  const bool turned = !differs(m.a.x, a.x + m.turn * m.v.y) && !differs(m.a.y, a.y - m.turn * m.v.x);
  return turned ? Difference::turned : Difference::other;
}

}  // namespace

ViewMotion view_motion(const Model& model, std::span<const double> u_min, std::span<const double> u_max) {
  const std::size_t nu = u_min.size();
  std::vector<double> rest(size(model.nx())), u(nu);
  model.at_rest({{0, 0, 1}, {1, 0}}, rest.data());
  ViewMotion law;
  // One input for each coordinate, from its effect at rest.
  const MotionInV still = motion_in_V(model, rest, u);
  constexpr double effect = 1e-6;
  for (std::size_t k = 0; k < nu; ++k) {
    std::vector<double> one(nu);
    one[k] = 1.0;
    const MotionInV m = motion_in_V(model, rest, one);
    if (std::abs(m.lift - still.lift) > effect && std::abs(m.climb) < effect)
      refuse(model, "climbs late, by a lag of its vertical velocity",
             "a vertical velocity that is commanded");
    if (std::abs(m.turn_rate - still.turn_rate) > 1e-2 && std::abs(m.turn) < effect)
      refuse(model, "turns late, by a lag of its yaw rate", "a yaw rate that is commanded");
    const std::array<std::pair<ViewMotion::Axis*, double>, 4> effects = {
        {{&law.along, m.a.x}, {&law.across, m.a.y}, {&law.climb, m.climb}, {&law.turn, m.turn}}};
    int moved = 0;
    for (const auto& [axis, gain] : effects) {
      if (std::abs(gain) < effect) continue;
      if (axis->input >= 0 || ++moved > 1)
        refuse(model, "has no separate input for each motion",
               "one each along, across, up and about its heading");
      *axis = {static_cast<int>(k), gain, std::abs(gain) * std::min(u_max[k], -u_min[k]), 0.0};
    }
  }
  if (law.along.input < 0 || law.turn.input < 0) {
    refuse(model,
           law.turn.input < 0 ? "does not turn by one input"
                              : "does not accelerate along its heading by one input at once",
           "one input that accelerates it along its heading, and one that turns it at once");
  }
  // Drag, from a state in motion; then the whole law at many states.
  constexpr int headings = 6, stops = 6;
  constexpr double pace = 0.05, longest = 0.6;  // [s]
  Difference worst = Difference::none;
  for (int i = 0; i < headings; ++i) {
    std::vector<double> x(rest.size()), driven(nu);
    const double psi = 0.2 + 2 * std::numbers::pi * i / headings;
    model.at_rest({{0, 0, 1}, {std::cos(psi), std::sin(psi)}}, x.data());
    for (std::size_t k = 0; k < nu; ++k)
      driven[k] = ((i + 1) >> (k % 3)) % 2 == (k < 3 ? 0 : 1) ? u_min[k] : 0.8 * u_max[k];
    for (int stop = 0; stop < stops; ++stop) {
      for (double t = 0; t < longest; t += pace) {
        model.step(x.data(), driven.data(), pace);
        if (!model.normalise(x.data())) refuse(model, "has states that are not finite", "finite ones");
      }
      if (i == 0 && stop == 0) {
        const MotionInV free = motion_in_V(model, x, u);
        law.along.drag = std::max(0.0, -free.a.x / free.v.x);
        if (law.across.input >= 0) law.across.drag = std::max(0.0, -free.a.y / free.v.y);
      }
      const MotionInV m = motion_in_V(model, x, driven);
      law.lean = {std::max(law.lean.x, std::abs(m.lean.x)), std::max(law.lean.y, std::abs(m.lean.y))};
      worst = std::max(worst, difference(law, m, driven));
    }
  }
  if (worst == Difference::turned)
    refuse(model, "keeps its velocity in G while it turns",
           "a velocity that turns with the heading, as in (24)");
  if (worst == Difference::other)
    refuse(model, "moves by another law than a drag and a thrust in each direction",
           "v' = -c v + b u along and across its heading, as in (24)");
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
