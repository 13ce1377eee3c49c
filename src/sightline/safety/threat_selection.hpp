/// Which few of many bodies press most on a robot, so that its barrier is told of these alone.
///
///   key = |r| - d_hard + r . w / |r| - speed      r = p - p_j [m], w = v - v_j and speed = 0 where j is cooperative,
///                                                 else w = v and speed = speed_max [m/s]
///
/// is the distance left after a second of closing in. Columns of all bodies lie side by side, so the keys are computed in
/// lanes; a barrier that is told of all bodies picks the same, in the same order.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "sightline/base/fixed.hpp"

namespace sightline {

/// What is closing in with velocity w has of a distance r after a second, beside d_hard and its own speed [m].
inline double nearest_threats_key(const Vec3<double>& r, const Vec3<double>& w, double d_hard,
                                  double speed) noexcept {
  const double D = std::sqrt(dot(r, r)), length = D > 1e-9 ? D : 1e-9;
  return length - d_hard + dot(r, w) / length - speed;
}

/// Neither `clear`, `add` nor `pressing` allocates.
class ThreatSelection {
 public:
  struct Body {
    int id;
    Vec3<double> p, v;  // [m], [m/s]
    double d_hard;      // [m]
    double speed_max;   // of one that is not cooperative [m/s]
  };

  /// Whoever asks; several may at once.
  class Requester {
   public:
    explicit Requester(int bodies);

    /// Of each body that was added, in that order: 1 if the robot that is asked about knows it as cooperative, else 0.
    std::vector<double> cooperative;

   private:
    friend class ThreatSelection;
    std::vector<int> chosen_;
    std::vector<double> key_, chosen_key_;
  };

  /// @param bodies  room for so many
  explicit ThreatSelection(int bodies);

  void clear() noexcept { count_ = 0; }
  void add(const Body& body) noexcept;
  int size() const noexcept { return static_cast<int>(count_); }
  int id(int i) const noexcept { return ids_[static_cast<std::size_t>(i)]; }

  /// The ids of the `most` bodies with the least keys, the least first, and of all with a key that is not finite.
  /// @param p, v   of the robot `self`, which is not among them
  /// @param asker  what it knows; has the answer until it asks again
  std::span<const int> nearest_threats(int self, const Vec3<double>& p, const Vec3<double>& v,
                                       std::size_t most, Requester& requester) const noexcept;

 private:
  std::size_t count_ = 0;
  std::vector<int> ids_;
  std::vector<double> p_x_, p_y_, p_z_, v_x_, v_y_, v_z_, hard_, speed_;
};

}  // namespace sightline
