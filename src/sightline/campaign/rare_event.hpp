/// Probability of a rare event by importance sampling, in the space of independent standard normal numbers.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/campaign/confidence.hpp"

namespace sightline {

/// A trial of the event: `point` fixes what is drawn, and `seed` all other noise.
struct Trial {
  std::vector<double> point;  ///< independent standard normal numbers under the true distribution
  std::uint64_t seed = 0;     ///< below 2^53
};

/// A mixture of normal distributions.
class NormalMixture {
 public:
  /// The standard normal distribution.
  explicit NormalMixture(int dimensions);
  /// Fits up to `components_max` normal distributions to weighted points, by expectation and
  /// maximisation; Bayes' information criterion chooses their number. Covariances are drawn towards
  /// the identity as far as few points determine them.
  /// @param points   not empty, each of the same length
  /// @param weights  one for each point, >= 0, their sum > 0
  NormalMixture(const std::vector<std::vector<double>>& points, std::span<const double> weights);

  std::vector<double> draw(std::uint64_t seed) const;
  /// Logarithm of the density relative to that of the standard normal distribution.
  double log_ratio(std::span<const double> point) const;

  static constexpr int components_max = 4;

 private:
  struct Component {
    double share = 1.0;
    std::vector<double> mean, factor;  // factor: Cholesky's L, by rows
    double log_determinant = 0.0;      // of L
  };
  Component component(double share, std::vector<double> mean, std::vector<double> covariance,
                      double points) const;
  double log_density(const Component& component, std::span<const double> point) const;
  /// One fit with that many components. @return Bayes' information criterion, lower is better
  double fit(const std::vector<std::vector<double>>& points, std::span<const double> weights, int components);

  int dimensions_;
  std::vector<Component> components_;
};

/// The estimate of a probability.
struct RareEvent {
  double probability = 0.0;
  Interval bounds{};     ///< of 95 %
  int trials = 0;        ///< flown, all levels
  int levels = 0;        ///< of the search for the event
  int seen = 0;          ///< trials of the last level in which the event occurred
  double effective = 0;  ///< trials of equal weight that would tell as much about the event
};

/// Estimates P(severity >= 0) (Rubinstein and Kroese 2004, the cross-entropy method). The first half
/// of the trials searches: level by level, a mixture of normal distributions is fitted to the worst
/// tenth, of all trials so far, each weighted by the ratio of the true density to that of the mixture
/// of all proposals (Owen and Zhou 2000), until the event itself is frequent. The other half draws a
/// tenth from the true distribution, half from the earlier proposals and the rest from the last one,
/// so that no weight exceeds 10:
///
///   p = 1/n sum w_i 1{severity_i >= 0},   w = phi / sum_k share_k q_k
///
/// The bounds have the normal quantile of 99 %, and the correction for skewness of Johnson (1978): with
/// that of 95 % they hold less often than stated, for the weights are skewed. The correction never moves
/// the lower bound up: one heavy weight may make that skewness. The bounds hold if the search has found
/// each region that matters to p. If no trial of the second half shows the event, they are those of the
/// true distribution's trials, clopper_pearson().
///
/// @param dimensions  length of each point, >= 1
/// @param trials      in all, >= 200
/// @param fly         returns the severities of trials, in their order; -infinity is allowed
RareEvent estimate_rare_event(int dimensions, int trials, std::uint64_t seed,
                              const std::function<std::vector<double>(const std::vector<Trial>&)>& fly);

}  // namespace sightline
