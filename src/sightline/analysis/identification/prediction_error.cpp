#include "sightline/analysis/identification/prediction_error.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base/quantile.hpp"

namespace sightline {
namespace {

Vec2<double> velocity_in_G(const SeenMotion& m) {
  return rotate<double>({std::cos(m.psi), std::sin(m.psi)}, {m.v_f, m.v_s});
}

double squared_distance(const Vec2<double>& a, const Vec2<double>& b) {
  return square(a.x - b.x) + square(a.y - b.y);
}

}  // namespace

double PredictionError::whole() const {
  return std::sqrt(square(position) + square(height) + square(velocity) + square(heading));
}

PredictionError prediction_error(const FlownMotion& motion, const Stretch& stretch,
                                 const ModelStructure& structure, const ModelNumbers& numbers) {
  const auto periods = [&](double seconds) {
    return static_cast<std::size_t>(std::lround(seconds / motion.period));
  };
  PredictionError error;
  error.of_truth = !motion.truth.empty();
  const std::vector<SeenMotion>& flown = error.of_truth ? motion.truth : motion.measured;
  const std::size_t before = error.of_truth ? 0 : periods(0.5), soon = std::max<std::size_t>(1, periods(0.1)),
                    ahead = periods(1.0), forgotten = periods(MotionPrediction::forgotten);
  const MotionPrediction prediction(motion, structure, numbers);
  double of_velocity = 0.0, of_change = 0.0, of_position = 0.0, of_height = 0.0, of_heading = 0.0;
  std::vector<double> left;
  for (std::size_t k = std::max(stretch.from, forgotten); k + before + ahead < stretch.to; k += 3) {
    const std::size_t now = k + before;
    if (!is_seen(flown[now]) || !is_seen(flown[now + soon]) || !is_seen(flown[now + ahead])) continue;
    const SeenMotion start = error.of_truth ? flown[k] : fitted_start(motion, prediction, k, before);
    SeenMotion last = start;
    prediction.run(k, before + ahead, start, [&](std::size_t j, const SeenMotion& then) {
      const SeenMotion& y = flown[k + j];
      const SeenMotion m = between(then, last, y.before / motion.period);
      last = then;
      if (j == before + soon) {
        const double off = std::sqrt(squared_distance(velocity_in_G(m), velocity_in_G(y)));
        left.push_back(off / (static_cast<double>(soon) * motion.period));
      }
      if (j != before + ahead) return;
      of_velocity += squared_distance(velocity_in_G(m), velocity_in_G(y));
      of_change += squared_distance(velocity_in_G(y), velocity_in_G(flown[now]));
      of_position += square(m.p.x - y.p.x) + square(m.p.y - y.p.y);
      of_height += square(m.p.z - y.p.z);
      of_heading += square(m.psi - y.psi);
      ++error.predictions;
    });
  }
  const double n = std::max(1.0, static_cast<double>(error.predictions));
  error.r2 = of_change > 0 ? 1 - of_velocity / of_change : 0.0;
  error.velocity = std::sqrt(of_velocity / n);
  error.position = std::sqrt(of_position / n);
  error.height = std::sqrt(of_height / n);
  error.heading = std::sqrt(of_heading / n);
  error.acceleration = left.empty() ? 0.0 : quantile(left, 0.999);
  return error;
}

}  // namespace sightline
