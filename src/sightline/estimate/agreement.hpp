/// Consensus of measurements on one pose, for a start when no single measurement can be trusted.
#pragma once

#include <array>
#include <cstddef>

#include "sightline/estimator.hpp"

namespace sightline {

/// Dead reckoning in an arbitrary frame: two results give the motion in between.
struct DeadReckoning {
  Vec3<double> p{};
  double psi = 0.0;

  void advance(const MotionSample& motion, double dt) noexcept {
    p = p + dt * (turn_z(psi) * motion.v_V);
    psi = wrap(psi + dt * motion.yaw_rate);
  }
};

/// Robot pose that a measurement implies, and dead reckoning at its stamp.
struct PoseHypothesis {
  double stamp = 0.0;
  Vec3<double> p{};
  double psi = 0.0;
  double sigma = 0.0, psi_sigma = 0.0;  ///< [m], [rad]
  DeadReckoning reckoned{};
};

/// The last few hypotheses. Two agree if the motion between them leads from one to the other. The
/// tolerance is three standard deviations plus 0.05 m or 0.05 rad plus the drift of dead reckoning.
class Agreement {
 public:
  static constexpr std::size_t memory = 32;
  static constexpr double window = 1.5;  ///< maximum age difference of two agreeing hypotheses [s]

  void clear() noexcept { count_ = next_ = 0; }
  /// Adds one hypothesis.
  /// @return number of hypotheses that agree with it, itself included
  int add(const PoseHypothesis& meaning) noexcept {
    int agreeing = 1;
    for (std::size_t i = 0; i < count_; ++i) agreeing += agree(items_[i], meaning) ? 1 : 0;
    items_[next_] = meaning;
    next_ = (next_ + 1) % memory;
    count_ += count_ < memory ? 1 : 0;
    return agreeing;
  }

 private:
  static bool agree(const PoseHypothesis& a, const PoseHypothesis& b) noexcept {
    constexpr double near = 0.05, drift = 0.15, turn_drift = 0.05;  // [m] or [rad], [m/s], [rad/s]
    const double between = std::abs(b.stamp - a.stamp);
    if (between > window) return false;
    const double turned = wrap(b.reckoned.psi - a.reckoned.psi);
    const double off = std::abs(wrap(b.psi - a.psi - turned));
    if (off > near + 3 * norm(a.psi_sigma, b.psi_sigma) + turn_drift * between) return false;
    const Vec3<double> way = turn_z(a.psi - a.reckoned.psi) * (b.reckoned.p - a.reckoned.p);
    return norm(a.p + way - b.p) <= near + 3 * norm(a.sigma, b.sigma) + drift * between;
  }

  std::array<PoseHypothesis, memory> items_{};
  std::size_t count_ = 0, next_ = 0;
};

}  // namespace sightline
