#include "sightline/analysis/identification/model_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/base/symmetric.hpp"

namespace sightline {
namespace {

constexpr double window_seconds = 1.0;
constexpr std::size_t channels = 6;  // p_x, p_y, p_z, psi, v_f, v_s
constexpr std::array<std::size_t, channels> kind_of = {0, 0, 1, 2, 3, 3};
constexpr std::size_t kinds = 4;  // plane, height, heading, velocity
using Sigmas = std::array<double, kinds>;
constexpr Sigmas first_sigma = {0.005, 0.005, 0.01, 0.03}, least_sigma = {1e-4, 1e-4, 1e-4, 1e-3};
constexpr double normal_95 = 1.96;  // 97.5 % quantile

using Channels = std::array<double, channels>;
Channels channels_of(const SeenMotion& m) { return {m.p.x, m.p.y, m.p.z, m.psi, m.v_f, m.v_s}; }
SeenMotion moved(SeenMotion m, std::size_t channel, double by) {
  const std::array<double*, channels> at = {&m.p.x, &m.p.y, &m.p.z, &m.psi, &m.v_f, &m.v_s};
  *at[channel] += by;
  return m;
}

/// Residuals of a window over sigma, sample by sample; 0 if nothing was measured.
void residuals(const FlownMotion& motion, const MotionPrediction& prediction, const Sigmas& sigma,
               std::size_t k, std::size_t samples, const SeenMotion& start, std::vector<double>& r) {
  r.clear();
  SeenMotion last = start;
  prediction.run(k, samples, start, [&](std::size_t j, const SeenMotion& m) {
    const SeenMotion& y = motion.measured[k + j];
    const bool there = is_seen(y) && (j > 0 || y.before == 0);
    const Channels predicted = channels_of(between(m, last, y.before / motion.period)), seen = channels_of(y);
    last = m;
    for (std::size_t c = 0; c < channels; ++c)
      r.push_back(there ? (predicted[c] - seen[c]) / sigma[kind_of[c]] : 0.0);
  });
}

double squares(const std::vector<double>& r) {
  double sum = 0.0;
  for (const double v : r) sum += v * v;
  return sum;
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Derivatives of the residuals with respect to the initial state, by finite differences.
std::vector<std::vector<double>> columns_of_start(const FlownMotion& motion,
                                                  const MotionPrediction& prediction, const Sigmas& sigma,
                                                  std::size_t k, std::size_t samples, const SeenMotion& start,
                                                  const std::vector<double>& r) {
  constexpr double step = 1e-4;
  std::vector<std::vector<double>> columns(channels);
  for (std::size_t c = 0; c < channels; ++c) {
    residuals(motion, prediction, sigma, k, samples, moved(start, c, step), columns[c]);
    for (std::size_t i = 0; i < r.size(); ++i) columns[c][i] = (columns[c][i] - r[i]) / step;
  }
  return columns;
}

/// The first measurement of a window, as the initial guess of its start.
SeenMotion first_seen(const FlownMotion& motion, std::size_t k, std::size_t samples) {
  for (std::size_t j = k; j <= k + samples; ++j) {
    if (is_seen(motion.measured[j])) return motion.measured[j];
  }
  return {};
}

class FitProblem {
 public:
  /// @param only  key of the only free number; empty: all numbers are free
  FitProblem(const FlownMotion& motion, const Stretch& stretch, const ModelStructure& structure,
             const ModelNumbers& first = {}, std::string_view only = {})
      : motion_(motion),
        structure_(structure),
        first_(first),
        numbers_(first),
        samples_(static_cast<std::size_t>(std::lround(window_seconds / motion.period))) {
    const std::array<bool, 4> has_moved = inputs_moved(motion, stretch);
    for (const FittedNumber& number : fitted_numbers(structure)) {
      const bool moves = number.input < 4 ? has_moved[number.input] : has_moved[0] || has_moved[1];
      if (moves && (only.empty() || only == number.key)) free_.push_back(number);
    }
    const auto forgotten = static_cast<std::size_t>(std::ceil(MotionPrediction::forgotten / motion.period));
    for (std::size_t k = std::max(stretch.from, forgotten); k + samples_ < stretch.to; k += samples_) {
      windows_.push_back(k);
      starts_.push_back(first_seen(motion, k, samples_));
    }
  }

  /// Steps until the cost no longer decreases. @return the sum of squares over sigma
  double descend() {
    double cost = cost_of(numbers_, starts_), damping = 1e-3;
    constexpr int steps_max = 40, tries_max = 8;
    for (int step = 0; step < steps_max; ++step) {
      linearise();
      double gain = 0.0;
      for (int tries = 0; tries < tries_max && gain <= 0; ++tries) {
        ModelNumbers numbers = numbers_;
        std::vector<SeenMotion> starts = starts_;
        take_step(damping, numbers, starts);
        const double next = cost_of(numbers, starts);
        if (next < cost) {
          gain = (cost - next) / cost;
          numbers_ = numbers, starts_ = std::move(starts), cost = next;
          damping *= 0.2;
        } else {
          damping *= 5;
        }
      }
      if (gain < 1e-9) break;
    }
    return cost;
  }

  /// Starts from several delays if the structure has one: the cost has several minima over it.
  void find() {
    const std::vector<SeenMotion> starts = starts_;
    FitProblem best = *this;
    double least = std::numeric_limits<double>::infinity();
    for (const double delay : {0.03, 0.15, 0.35}) {
      starts_ = starts;
      numbers_ = first_;
      numbers_.delay = structure_.delay ? delay : 0.0;
      if (const double cost = descend(); cost < least) least = cost, best.take(*this);
      if (!structure_.delay) break;
    }
    take(best);
    for (int round = 0; round < 3; ++round) {
      weigh();
      descend();
    }
  }

  FittedModel result() {
    linearise();
    FittedModel model{structure_, numbers_, {}};
    const std::vector<double> interval = intervals();
    for (const FittedNumber& number : fitted_numbers(structure_)) {
      FoundNumber one{.number = number, .value = numbers_.*number.value, .moved = false};
      for (std::size_t i = 0; i < free_.size(); ++i) {
        if (free_[i].key == number.key) one.moved = true, one.interval = interval[i];
      }
      model.found.push_back(one);
    }
    return model;
  }

 private:
  /// Normal equations of a window: those of its start, and its contribution to those of the
  /// numbers.
  struct Window {
    Symmetric start{channels};               // factored
    std::vector<std::vector<double>> mixed;  // [number][channel]
    std::vector<double> start_slope, slope;  // by channel; by number, with the start eliminated
  };

  void take(const FitProblem& other) { numbers_ = other.numbers_, starts_ = other.starts_; }

  double cost_of(const ModelNumbers& numbers, const std::vector<SeenMotion>& starts) {
    const MotionPrediction prediction(motion_, structure_, numbers);
    double sum = 0.0;
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      residuals(motion_, prediction, sigma_, windows_[w], samples_, starts[w], r_);
      sum += squares(r_);
    }
    return sum;
  }

  void linearise() {
    const std::size_t n = free_.size();
    const MotionPrediction now(motion_, structure_, numbers_);
    std::vector<MotionPrediction> moved_on;
    std::vector<double> steps;
    for (const FittedNumber& number : free_) {
      ModelNumbers other = numbers_;
      steps.push_back(1e-5);
      other.*number.value += steps.back();
      moved_on.emplace_back(motion_, structure_, other);
    }
    H_ = Symmetric(n);
    g_.assign(n, 0.0);
    parts_.clear();
    std::vector<std::vector<double>> J(n);
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      const std::size_t k = windows_[w];
      residuals(motion_, now, sigma_, k, samples_, starts_[w], r_);
      for (std::size_t i = 0; i < n; ++i) {
        residuals(motion_, moved_on[i], sigma_, k, samples_, starts_[w], J[i]);
        for (std::size_t row = 0; row < r_.size(); ++row) J[i][row] = (J[i][row] - r_[row]) / steps[i];
      }
      const auto S = columns_of_start(motion_, now, sigma_, k, samples_, starts_[w], r_);
      Window part;
      for (std::size_t a = 0; a < channels; ++a) {
        part.start_slope.push_back(product(S[a], r_));
        for (std::size_t b = 0; b <= a; ++b) part.start.at(a, b) = product(S[a], S[b]);
      }
      part.start.factor();
      // Schur complement: eliminates the start from the numbers' equations.
      const std::vector<double> own = part.start.solve(part.start_slope);
      for (std::size_t i = 0; i < n; ++i) {
        std::vector<double>& row = part.mixed.emplace_back();
        for (std::size_t a = 0; a < channels; ++a) row.push_back(product(J[i], S[a]));
      }
      for (std::size_t i = 0; i < n; ++i) {
        part.slope.push_back(product(J[i], r_) - product(part.mixed[i], own));
        g_[i] += part.slope[i];
        const std::vector<double> absorbed = part.start.solve(part.mixed[i]);
        for (std::size_t j = 0; j < n; ++j)
          H_.at(i, j) += product(J[i], J[j]) - product(absorbed, part.mixed[j]);
      }
      parts_.push_back(std::move(part));
    }
  }

  void take_step(double damping, ModelNumbers& numbers, std::vector<SeenMotion>& starts) const {
    const std::size_t n = free_.size();
    Symmetric H = H_;
    for (std::size_t i = 0; i < n; ++i) H.at(i, i) *= 1 + damping;
    H.factor();
    std::vector<double> change = H.solve(g_);
    for (std::size_t i = 0; i < n; ++i) {
      double& value = numbers.*free_[i].value;
      const double before = value;
      value = std::clamp(before - change[i], free_[i].low, free_[i].high);
      change[i] = before - value;
    }
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      const Window& part = parts_[w];
      std::vector<double> slope = part.start_slope;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t a = 0; a < channels; ++a) slope[a] -= part.mixed[i][a] * change[i];
      const std::vector<double> own = part.start.solve(slope);
      for (std::size_t a = 0; a < channels; ++a) starts[w] = moved(starts[w], a, -own[a]);
    }
  }

  /// Estimates sigma of each kind from its residuals.
  void weigh() {
    const MotionPrediction prediction(motion_, structure_, numbers_);
    Sigmas sum{};
    std::array<double, kinds> count{};
    for (std::size_t w = 0; w < windows_.size(); ++w) {
      residuals(motion_, prediction, sigma_, windows_[w], samples_, starts_[w], r_);
      for (std::size_t i = 0; i < r_.size(); ++i) {
        const std::size_t kind = kind_of[i % channels];
        sum[kind] += r_[i] * r_[i] * sigma_[kind] * sigma_[kind];
        count[kind] += r_[i] != 0.0 ? 1.0 : 0.0;
      }
    }
    const double all = count[0] + count[1] + count[2] + count[3];
    const double estimated = static_cast<double>(free_.size() + channels * windows_.size());
    const double share = std::max(0.1, 1 - estimated / std::max(all, 1.0));  // degrees of freedom
    for (std::size_t kind = 0; kind < kinds; ++kind)
      sigma_[kind] = std::max(least_sigma[kind], std::sqrt(sum[kind] / std::max(1.0, share * count[kind])));
  }

  std::vector<double> intervals() const {
    const std::size_t n = free_.size(), clusters = windows_.size();
    Symmetric H = H_;
    H.factor();
    std::vector<double> wide(n);
    const double few = clusters > n + 1 ? static_cast<double>(clusters) / static_cast<double>(clusters - n)
                                        : static_cast<double>(clusters);
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<double> unit(n, 0.0);
      unit[i] = 1.0;
      const std::vector<double> row = H.solve(unit);
      double clustered = 0.0;
      for (const Window& part : parts_) {
        const double one = product(row, part.slope);
        clustered += one * one;
      }
      wide[i] = normal_95 * std::sqrt(std::max(row[i], few * clustered));
    }
    return wide;
  }

  const FlownMotion& motion_;
  ModelStructure structure_;
  ModelNumbers first_, numbers_;
  std::size_t samples_;  // per window
  std::vector<FittedNumber> free_;
  std::vector<std::size_t> windows_;  // first period of each window
  std::vector<SeenMotion> starts_;
  Sigmas sigma_ = first_sigma;
  Symmetric H_{0};
  std::vector<double> g_, r_;
  std::vector<Window> parts_;
};

}  // namespace

bool FoundNumber::known() const {
  if (number.of_flight) return true;
  if (!moved) return false;
  constexpr double share = 0.25, shortest = 0.02;  // [s]
  return interval <= share * std::abs(value) || (number.unit == "s" && interval <= shortest);
}

FittedModel fit_model(const FlownMotion& motion, const Stretch& stretch, const ModelStructure& structure) {
  FitProblem fit(motion, stretch, structure);
  fit.find();
  return fit.result();
}

FittedModel fit_lumped(const FlownMotion& motion, const Stretch& stretch, const FittedModel& with_lags) {
  ModelStructure structure = with_lags.structure;
  structure.lags = false, structure.delay = true;
  FitProblem fit(motion, stretch, structure, with_lags.numbers, "delay");
  fit.find();
  FittedModel model = fit.result();
  for (FoundNumber& one : model.found) {
    for (const FoundNumber& same : with_lags.found) {
      if (same.number.key == one.number.key && one.number.key != "delay") one = same;
    }
  }
  return model;
}

SeenMotion fitted_start(const FlownMotion& motion, const MotionPrediction& prediction, std::size_t k,
                        std::size_t samples) {
  SeenMotion start = first_seen(motion, k, samples);
  std::vector<double> r;
  for (int step = 0; step < 3; ++step) {
    residuals(motion, prediction, first_sigma, k, samples, start, r);
    const auto S = columns_of_start(motion, prediction, first_sigma, k, samples, start, r);
    Symmetric H(channels);
    std::vector<double> slope;
    for (std::size_t a = 0; a < channels; ++a) {
      slope.push_back(product(S[a], r));
      for (std::size_t b = 0; b <= a; ++b) H.at(a, b) = product(S[a], S[b]);
    }
    H.factor();
    const std::vector<double> change = H.solve(slope);
    for (std::size_t a = 0; a < channels; ++a) start = moved(start, a, -change[a]);
  }
  return start;
}

std::array<bool, 4> inputs_moved(const FlownMotion& motion, const Stretch& stretch) {
  std::array<bool, 4> has_moved{};
  const double n = static_cast<double>(stretch.to - stretch.from);
  for (std::size_t i = 0; i < has_moved.size(); ++i) {
    double sum = 0.0, square = 0.0;
    for (std::size_t k = stretch.from; k < stretch.to; ++k)
      sum += motion.u[k][i], square += motion.u[k][i] * motion.u[k][i];
    const double variance = square / n - (sum / n) * (sum / n);
    has_moved[i] = std::sqrt(std::max(0.0, variance)) > 0.01 * motion.u_max[i];
  }
  return has_moved;
}

}  // namespace sightline
