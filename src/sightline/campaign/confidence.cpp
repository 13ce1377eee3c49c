#include "sightline/campaign/confidence.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <span>

#include "sightline/base/split_mix.hpp"

namespace sightline {
namespace {

/// Continued fraction of I_x, by Lentz's method; converges fast for x < (a + 1) / (a + b + 2).
double fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto away_from_0 = [](double value) { return std::abs(value) < tiny ? tiny : value; };
  double c = 1.0, d = 1.0 / away_from_0(1.0 - (a + b) * x / (a + 1.0)), value = d;
  for (int m = 1; m < 10'000; ++m) {
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    double factor = 1.0;
    for (const double term : {even, odd}) {
      d = 1.0 / away_from_0(1.0 + term * d);
      c = away_from_0(1.0 + term / c);
      factor = c * d;
      value *= factor;
    }
    if (std::abs(factor - 1.0) < 1e-15) break;
  }
  return value;
}

/// log Gamma; avoids the global sign that std::lgamma writes.
double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

/// The median of sorted values, value i taken times[i] times; times sum to their number.
double median_of(std::span<const double> sorted, std::span<const std::uint32_t> times) {
  const std::size_t half = sorted.size() / 2;
  std::size_t i = 0, until = times[0];  // values until i
  const auto value = [&](std::size_t rank) {
    while (until <= rank) until += times[++i];
    return sorted[i];
  };
  if (sorted.size() % 2 == 1) return value(half);
  const double below = value(half - 1);
  return 0.5 * (value(half) + below);
}

}  // namespace

/// By its series (Marsaglia 2004): 1/2 + phi(z) (z + z^3/3 +
/// z^5/(3 5) + ...).
double normal_probability(double z) {
  double sum = z, term = z;
  for (int i = 3; i < 1000 && std::abs(term) > 1e-17; i += 2) sum += term *= z * z / i;
  return 0.5 + sum * std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi);
}

/// Inverts normal_probability() by bisection.
double normal_quantile(double p) {
  double low = -8.0, high = 8.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_probability(middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0.0;
  if (x >= 1) return 1.0;
  const double front =
      std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1.0) / (a + b + 2.0) ? front * fraction(a, b, x) / a
                                       : 1.0 - front * fraction(b, a, 1.0 - x) / b;
}

Interval wilson(std::int64_t good, std::int64_t runs, double confidence) {
  assert(runs > 0 && good >= 0 && good <= runs && "no more successes than trials");
  const double n = static_cast<double>(runs), p = static_cast<double>(good) / n,
               z = normal_quantile(0.5 + confidence / 2), z2 = z * z / n;
  const double centre = p + z2 / 2, half = std::sqrt(z2 * (p * (1 - p) + z2 / 4));
  return {good == 0 ? 0.0 : std::max(0.0, (centre - half) / (1 + z2)),
          good == runs ? 1.0 : std::min(1.0, (centre + half) / (1 + z2))};
}

Interval clopper_pearson(std::int64_t seen, std::int64_t runs, double confidence) {
  assert(runs > 0 && seen >= 0 && seen <= runs && "no more events than trials");
  const double n = static_cast<double>(runs), k = static_cast<double>(seen), tail = (1 - confidence) / 2;
  // I_x(a, b) increases with x.
  const auto inverse = [](double a, double b, double p) {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (incomplete_beta(a, b, middle) < p ? low : high) = middle;
    }
    return 0.5 * (low + high);
  };
  return {seen == 0 ? 0.0 : inverse(k, n - k + 1, tail),
          seen == runs ? 1.0 : inverse(k + 1, n - k, 1 - tail)};
}

MedianBounds bootstrap_median(std::vector<double> values, double confidence, int resamples,
                              std::uint64_t seed) {
  assert(!values.empty() && resamples > 1 && "there is a median");
  std::sort(values.begin(), values.end());  // the result must not depend on their order
  std::vector<std::uint32_t> times(values.size(), 1);
  const double median = median_of(values, times);
  std::vector<double> medians;
  for (int i = 0; i < resamples; ++i) {
    std::fill(times.begin(), times.end(), 0);
    for (std::size_t drawn = 0; drawn < values.size(); ++drawn) ++times[next_split_mix(seed) % values.size()];
    medians.push_back(median_of(values, times));
  }
  std::sort(medians.begin(), medians.end());
  const auto at_share = [&](double share) {
    return medians[static_cast<std::size_t>(std::llround(share * static_cast<double>(resamples - 1)))];
  };
  const double tail = (1 - confidence) / 2;
  return {at_share(tail), median, at_share(1 - tail)};
}

double sign_test(std::int64_t less, std::int64_t more) {
  if (less == more) return 1.0;
  const double n = static_cast<double>(less + more), k = static_cast<double>(std::min(less, more));
  // 2 P(X <= k), X binomial with probability 1/2.
  return std::min(1.0, 2 * incomplete_beta(n - k, k + 1, 0.5));
}

}  // namespace sightline
