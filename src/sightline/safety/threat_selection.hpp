/// Selects the few bodies that threaten a robot most, so that its barrier considers these alone.
///
///   key = |r| - d_hard + r . w / |r| - speed,     r = p - p_j [m]
///
/// with w = v - v_j and speed = 0 if j is cooperative, else w = v and speed = speed_max [m/s].
///
/// The key is the distance left after 1 s of closing in. Columns of all bodies are contiguous, so
/// that the keys are computed in SIMD lanes. A barrier that receives all bodies selects the same
/// ones, in the same order.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// Distance that remains of r after 1 s at velocity w, less d_hard and the body's own speed [m].
inline double nearest_threats_key(const Vec3<double>& r, const Vec3<double>& w, double d_hard,
                                  double speed) noexcept {
  const double D = std::sqrt(dot(r, r)), length = D > 1e-9 ? D : 1e-9;
  return length - d_hard + dot(r, w) / length - speed;
}

/// Selection among the bodies of one period. clear(), add() and nearest_threats() do not allocate.
class ThreatSelection {
 public:
  struct Body {
    int id;
    Vec3<double> p, v;  // [m], [m/s]
    double d_hard;      // [m]
    double speed_max;   // of an uncooperative body [m/s]
  };

  /// Input and work space of one request; several threads may each use their own.
  class Requester {
   public:
    explicit Requester(int bodies);

    /// For each added body, in that order: 1 if it is cooperative to the robot of the request, else
    /// 0.
    std::vector<double> cooperative;

   private:
    friend class ThreatSelection;
    std::vector<int> chosen_;
    std::vector<double> key_, chosen_key_;
  };

  /// @param bodies  capacity
  explicit ThreatSelection(int bodies);

  void clear() noexcept { count_ = 0; }
  void add(const Body& body) noexcept;
  int size() const noexcept { return static_cast<int>(count_); }
  int id(int i) const noexcept { return ids_[static_cast<std::size_t>(i)]; }

  /// The ids of the `most` bodies with the least keys, in ascending order, then of all bodies with
  /// a key that is not finite.
  /// @param p, v  position [m] and velocity [m/s] of the robot `self`, which is excluded
  /// @param requester  cooperation of the bodies; holds the result until its next request
  std::span<const int> nearest_threats(int self, const Vec3<double>& p, const Vec3<double>& v,
                                       std::size_t most, Requester& requester) const noexcept;

 private:
  std::size_t count_ = 0;
  std::vector<int> ids_;
  std::vector<double> p_x_, p_y_, p_z_, v_x_, v_y_, v_z_, hard_, speed_;
};

}  // namespace sightline
