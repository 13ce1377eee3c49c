#include "sightline/analysis/identification/motion_prediction.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/robots.hpp"

namespace sightline {
namespace {

constexpr double longest_step = 0.005;  // [s]

using Row = std::array<double, 4>;

/// Integral of the commands from the first period to t [s]; 0 for earlier t.
Row integral(const FlownMotion& motion, const std::vector<Row>& sums, double t) {
  const double rows = t / motion.period;
  if (rows <= 0) return {};
  const std::size_t k = std::min(static_cast<std::size_t>(rows), motion.size() - 1);
  const double over = std::min(rows - static_cast<double>(k), 1.0) * motion.period;
  Row value = sums[k];
  for (std::size_t i = 0; i < value.size(); ++i) value[i] += over * motion.u[k][i];
  return value;
}

/// First-order lag of a command; without a lag it follows at once.
class Follower {
 public:
  Follower(double tau, bool lags, double h)
      : keeps_(lags ? std::exp(-h / tau) : 0.0), share_(lags ? (1 - keeps_) * tau / h : 0.0) {}
  /// Mean over a step under a constant command.
  double operator()(double command) {
    const double off = value_ - command;
    value_ = command + keeps_ * off;
    return command + share_ * off;
  }
  /// Value at the end of that step.
  double value() const { return value_; }

 private:
  double keeps_, share_, value_ = 0.0;
};

}  // namespace

MotionPrediction::MotionPrediction(const FlownMotion& motion, const ModelStructure& structure,
                                   const ModelNumbers& n)
    : structure_(structure),
      a_f_(n.a_f),
      a_s_(n.a_s),
      wind_{n.w_x, n.w_y},
      parts_(static_cast<std::size_t>(std::max(1.0, std::ceil(motion.period / longest_step - 1e-9)))),
      h_(motion.period / static_cast<double>(parts_)) {
  const bool tilts = structure.commands == Commands::tilt;
  double b_f = n.b_f, b_s = n.b_s, b_z = n.b_z, b_psi = n.b_psi;
  if (!tilts) {
    a_f_ = -1 / n.tau_f, b_f = 1 / n.tau_f, a_s_ = -1 / n.tau_s, b_s = -1 / n.tau_s;
    b_z = b_psi = 1.0;
  }
  std::vector<Row> sums(1, Row{});
  for (const Row& u : motion.u) {
    Row next = sums.back();
    for (std::size_t i = 0; i < next.size(); ++i) next[i] += motion.period * u[i];
    sums.push_back(next);
  }
  const double delay = structure.delay ? n.delay : 0.0;
  const bool tilt_lags = tilts && structure.lags;
  double climb_before = 0.0;
  Follower push_f(n.tau, tilt_lags, h_), push_s(n.tau, tilt_lags, h_), climb(n.tau_z, structure.lags, h_),
      rate(n.tau_psi, structure.lags, h_);
  const std::size_t steps = motion.size() * parts_;
  forced_.reserve(steps);
  Row before = integral(motion, sums, -delay);
  for (std::size_t i = 0; i < steps; ++i) {
    const Row after = integral(motion, sums, static_cast<double>(i + 1) * h_ - delay);
    const auto mean = [&](std::size_t input) { return (after[input] - before[input]) / h_; };
    Forced forced = {push_f(b_f * mean(0)), push_s(-b_s * mean(1)), climb(b_z * mean(2)),
                     rate(b_psi * mean(3))};
    if (tilt_lags) {
      const double lift = 1 + (climb.value() - climb_before) / (h_ * HoverMultirotor::g);
      forced.push_f *= lift, forced.push_s *= lift;
    }
    climb_before = climb.value();
    forced_.push_back(forced);
    before = after;
  }
}

void MotionPrediction::step(const Forced& forced, SeenMotion& m) const {
  const double turn = structure_.coriolis ? forced.rate : 0.0, psi = m.psi + 0.5 * h_ * forced.rate;
  const Vec2<double> d = {std::cos(psi), std::sin(psi)};
  const Vec2<double> wind = rotate<double>({d.x, -d.y}, wind_);
  const auto change = [&](double v_f, double v_s) {
    return Vec2<double>{a_f_ * v_f + forced.push_f + turn * v_s + wind.x,
                        a_s_ * v_s + forced.push_s - turn * v_f + wind.y};
  };
  const Vec2<double> first = change(m.v_f, m.v_s);
  const Vec2<double> middle = {m.v_f + 0.5 * h_ * first.x, m.v_s + 0.5 * h_ * first.y};
  const Vec2<double> second = change(middle.x, middle.y);
  const Vec2<double> v = rotate<double>(d, middle);
  m.p = m.p + h_ * Vec3<double>{v.x, v.y, forced.climb};
  m.psi += h_ * forced.rate;
  m.v_f += h_ * second.x;
  m.v_s += h_ * second.y;
}

}  // namespace sightline
