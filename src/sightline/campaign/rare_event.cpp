#include "sightline/campaign/rare_event.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "sightline/base/split_mix.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr double worst_share = 0.1;      // of the trials, which the next proposal is fitted to
constexpr double defensive_share = 0.1;  // of the last level, drawn from the true distribution
constexpr double earlier_share = 0.5;    // of the last level, drawn from the proposals before the last one
constexpr double widening = 1.5;         // of the covariances, since too narrow a proposal has large weights
constexpr int levels_max = 5;            // of the search
constexpr int iterations = 50;           // of a fit

double log_sum_exp(std::span<const double> values) {
  const double most = *std::max_element(values.begin(), values.end());
  if (!std::isfinite(most)) return most;
  double sum = 0.0;
  for (const double value : values) sum += std::exp(value - most);
  return most + std::log(sum);
}

double squared_distance(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

}  // namespace

NormalMixture::NormalMixture(int dimensions) : dimensions_(dimensions) {
  const std::size_t d = size(dimensions);
  std::vector<double> identity(d * d);
  for (std::size_t i = 0; i < d; ++i) identity[i * d + i] = 1.0;
  components_.push_back({1.0, std::vector<double>(d), identity, 0.0});
}

NormalMixture::NormalMixture(const std::vector<std::vector<double>>& points, std::span<const double> weights)
    : dimensions_(static_cast<int>(points.front().size())) {
  double least = infinity;
  std::vector<Component> best;
  for (int components = 1; components <= components_max; ++components) {
    const double criterion = fit(points, weights, components);
    if (!(criterion < least)) continue;
    least = criterion;
    best = components_;
  }
  components_ = std::move(best);
  for (Component& one : components_) {
    for (double& value : one.factor) value *= std::sqrt(widening);
    one.log_determinant += dimensions_ * std::log(widening) / 2;
  }
}

NormalMixture::Component NormalMixture::component(double share, std::vector<double> mean,
                                                  std::vector<double> covariance, double points) const {
  const std::size_t d = size(dimensions_);
  const double keep = points / (points + static_cast<double>(d) + 1.0);
  for (std::size_t i = 0; i < d * d; ++i)
    covariance[i] = keep * covariance[i] + (i % (d + 1) == 0 ? 1 - keep : 0.0);
  Component made{share, std::move(mean), std::vector<double>(d * d), 0.0};
  for (std::size_t i = 0; i < d; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = covariance[i * d + j];
      for (std::size_t k = 0; k < j; ++k) sum -= made.factor[i * d + k] * made.factor[j * d + k];
      made.factor[i * d + j] = i == j ? std::sqrt(std::max(sum, 1e-12)) : sum / made.factor[j * d + j];
    }
    made.log_determinant += std::log(made.factor[i * d + i]);
  }
  return made;
}

/// Without the constant of the normal distribution.
double NormalMixture::log_density(const Component& component, std::span<const double> point) const {
  const std::size_t d = size(dimensions_);
  std::vector<double> y(d);
  double squares = 0.0;
  for (std::size_t i = 0; i < d; ++i) {
    double sum = point[i] - component.mean[i];
    for (std::size_t k = 0; k < i; ++k) sum -= component.factor[i * d + k] * y[k];
    y[i] = sum / component.factor[i * d + i];
    squares += y[i] * y[i];
  }
  return std::log(component.share) - component.log_determinant - squares / 2;
}

double NormalMixture::fit(const std::vector<std::vector<double>>& points, std::span<const double> weights,
                          int components) {
  const std::size_t d = size(dimensions_), n = points.size(), count = size(components);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  double squares = 0.0;
  for (const double weight : weights) squares += weight * weight;
  const double effective = sum * sum / squares;

  // The first centre is the heaviest point, each other one the point of most weight times squared distance.
  std::vector<std::size_t> centres;
  for (std::size_t c = 0; c < count; ++c) {
    const auto worth = [&](std::size_t i) {
      double nearest = c == 0 ? 1.0 : infinity;
      for (const std::size_t centre : centres)
        nearest = std::min(nearest, squared_distance(points[i], points[centre]));
      return weights[i] * nearest;
    };
    std::size_t best = 0;
    for (std::size_t i = 1; i < n; ++i)
      if (worth(i) > worth(best)) best = i;
    centres.push_back(best);
  }
  components_.clear();
  const NormalMixture standard(dimensions_);
  for (const std::size_t centre : centres)
    components_.push_back(
        {1.0 / static_cast<double>(count), points[centre], standard.components_.front().factor, 0.0});

  std::vector<double> logs(count), belongs(n * count);
  double likelihood = -infinity;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const double before = likelihood;
    likelihood = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t c = 0; c < count; ++c) logs[c] = log_density(components_[c], points[i]);
      const double all = log_sum_exp(logs);
      for (std::size_t c = 0; c < count; ++c) belongs[i * count + c] = weights[i] * std::exp(logs[c] - all);
      likelihood += weights[i] / sum * all;
    }
    if (likelihood - before < 1e-6) break;
    for (std::size_t c = 0; c < count; ++c) {
      double of_this = 0.0;
      std::vector<double> mean(d), covariance(d * d);
      for (std::size_t i = 0; i < n; ++i) {
        of_this += belongs[i * count + c];
        for (std::size_t a = 0; a < d; ++a) mean[a] += belongs[i * count + c] * points[i][a];
      }
      if (!(of_this > 0)) return infinity;
      for (double& value : mean) value /= of_this;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t a = 0; a < d; ++a)
          for (std::size_t b = 0; b < d; ++b)
            covariance[a * d + b] +=
                belongs[i * count + c] / of_this * (points[i][a] - mean[a]) * (points[i][b] - mean[b]);
      const double share = of_this / sum;
      components_[c] = component(share, std::move(mean), std::move(covariance), share * effective);
    }
  }
  const double parameters =
      static_cast<double>(count) * (1.0 + static_cast<double>(d) + static_cast<double>(d * (d + 1)) / 2) - 1;
  return parameters * std::log(effective) - 2 * effective * likelihood;
}

std::vector<double> NormalMixture::draw(std::uint64_t seed) const {
  RandomStream random(seed, StreamId::draw, 0);
  double left = random.uniform();
  std::size_t c = 0;
  while (c + 1 < components_.size() && left > components_[c].share) left -= components_[c++].share;
  const std::size_t d = size(dimensions_);
  std::vector<double> normal(d), point = components_[c].mean;
  for (double& value : normal) value = random.normal();
  for (std::size_t i = 0; i < d; ++i)
    for (std::size_t k = 0; k <= i; ++k) point[i] += components_[c].factor[i * d + k] * normal[k];
  return point;
}

double NormalMixture::log_ratio(std::span<const double> point) const {
  std::vector<double> logs;
  for (const Component& one : components_) logs.push_back(log_density(one, point));
  double squares = 0.0;
  for (const double value : point) squares += value * value;
  return log_sum_exp(logs) + squares / 2;
}

RareEvent estimate_rare_event(int dimensions, int trials, std::uint64_t seed,
                              const std::function<std::vector<double>(const std::vector<Trial>&)>& fly) {
  assert(dimensions >= 1 && trials >= 200 && "there is something to draw");
  RareEvent event;
  std::uint64_t state = seed;
  std::vector<NormalMixture> proposals = {NormalMixture(dimensions)};
  std::vector<std::vector<double>> points;  // of the search
  std::vector<double> severities;
  int of_truth = 0, seen_of_truth = 0;  // trials of the true distribution

  // The search, of levels of one size.
  const int of_level = trials / (2 * levels_max);
  bool found = false, refined = false;
  while (event.levels < levels_max && !refined) {
    std::vector<Trial> level;
    for (int i = 0; i < of_level; ++i) {
      const std::uint64_t own = next_split_mix(state);
      level.push_back({proposals.back().draw(own), next_split_mix(state) >> 11});
    }
    const std::vector<double> flown = fly(level);
    for (int i = 0; i < of_level; ++i) {
      points.push_back(std::move(level[size(i)].point));
      severities.push_back(flown[size(i)]);
    }
    event.trials += of_level;
    if (event.levels == 0) {
      of_truth = of_level;
      seen_of_truth =
          static_cast<int>(std::count_if(flown.begin(), flown.end(), [](double s) { return s >= 0; }));
    }
    ++event.levels;

    std::vector<double> sorted = flown;
    std::sort(sorted.begin(), sorted.end(), std::greater());
    const double threshold = std::min(0.0, sorted[size(static_cast<int>(worst_share * of_level))]);
    std::vector<std::vector<double>> worst;
    std::vector<double> weights;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!(severities[i] >= threshold)) continue;
      double density = 0.0;  // of all proposals so far, relative to the true one
      for (const NormalMixture& one : proposals) density += std::exp(one.log_ratio(points[i]));
      worst.push_back(points[i]);
      weights.push_back(static_cast<double>(proposals.size()) / density);
    }
    proposals.emplace_back(worst, weights);
    refined = found;
    found = found || threshold == 0.0;
  }

  // Of the last level, a tenth from the true distribution, which is the first proposal, and most from the last one.
  const int n = trials - event.trials, others = static_cast<int>(proposals.size()) - 2;
  std::vector<int> draws(proposals.size(), others > 0 ? static_cast<int>(earlier_share * n) / others : 0);
  draws.front() = static_cast<int>(defensive_share * n);
  draws.back() = n - std::accumulate(draws.begin(), draws.end() - 1, 0);
  std::vector<Trial> last;
  for (std::size_t k = 0; k < proposals.size(); ++k)
    for (int i = 0; i < draws[k]; ++i) {
      const std::uint64_t own = next_split_mix(state);
      last.push_back({proposals[k].draw(own), next_split_mix(state) >> 11});
    }
  const std::vector<double> flown = fly(last);
  event.trials += n;
  of_truth += draws.front();
  double sum = 0.0, squares = 0.0;
  std::vector<double> values(size(n));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(flown[i] >= 0)) continue;
    if (i < size(draws.front())) ++seen_of_truth;
    ++event.seen;
    double density = 0.0;  // relative to the true one
    for (std::size_t k = 0; k < proposals.size(); ++k)
      density += draws[k] * std::exp(proposals[k].log_ratio(last[i].point)) / n;
    values[i] = 1 / density;
    sum += values[i];
    squares += values[i] * values[i];
  }
  event.bounds = clopper_pearson(seen_of_truth, of_truth);
  if (event.seen == 0) return event;
  event.effective = sum * sum / squares;
  event.probability = sum / n;
  double second = 0.0, third = 0.0;
  for (const double value : values) {
    const double off = value - event.probability;
    second += off * off;
    third += off * off * off;
  }
  if (!(second > 0)) return event;  // all alike, of which a sample has no deviation
  const double deviation = std::sqrt(second / (n - 1)), skewness = third / n / std::pow(second / n, 1.5);
  constexpr double t = 2.576;  // 99.5 % of the normal distribution
  const double root = std::sqrt(static_cast<double>(n)), shift = skewness * (1 + 2 * t * t) / (6 * root);
  event.bounds = {std::max(0.0, event.probability + (std::min(shift, 0.0) - t) * deviation / root),
                  std::min(1.0, event.probability + (shift + t) * deviation / root)};
  return event;
}

}  // namespace sightline
