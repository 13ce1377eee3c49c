#include "sightline/campaign/confidence.hpp"

#include <cassert>
#include <cmath>
#include <initializer_list>

namespace sightline {
namespace {

/// The continued fraction of I_x, by Lentz's method; fast for x < (a + 1) / (a + b + 2).
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

/// log Gamma, without the global sign that std::lgamma writes.
double log_gamma(double x) {
  int sign = 0;
  return ::lgamma_r(x, &sign);
}

/// The x where I_x(a, b) = p, by halving.
double beta_quantile(double a, double b, double p) {
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (incomplete_beta(a, b, middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0.0;
  if (x >= 1) return 1.0;
  const double front =
      std::exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * std::log(x) + b * std::log1p(-x));
  return x < (a + 1.0) / (a + b + 2.0) ? front * fraction(a, b, x) / a
                                       : 1.0 - front * fraction(b, a, 1.0 - x) / b;
}

Interval clopper_pearson(std::int64_t good, std::int64_t runs, double confidence) {
  assert(good >= 0 && good <= runs && "no more successes than trials");
  const double k = static_cast<double>(good), n = static_cast<double>(runs), tail = (1.0 - confidence) / 2;
  return {good == 0 ? 0.0 : beta_quantile(k, n - k + 1, tail),
          good == runs ? 1.0 : beta_quantile(k + 1, n - k, 1.0 - tail)};
}

}  // namespace sightline
