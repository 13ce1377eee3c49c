/// Robots that see each other, estimated together in one place.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/estimate/agreement.hpp"
#include "sightline/estimate/heading_filter.hpp"
#include "sightline/estimate/pose_filter.hpp"
#include "sightline/estimate/stamped_list.hpp"

namespace sightline {

/// The joint Kalman filter of several robots: the mathematics of HeadingFilter for each, and one covariance of
/// all. What one robot learns of another corrects both, and nothing is counted twice, in whatever order and
/// circle they see each other.
///
/// Late measurements are applied at their stamps, as by Delayed; gates and beginnings are its too. A robot begins
/// where its sightings of anchors, or of robots that have begun, mean one place; they need a yaw. With n robots
/// an update takes time in proportion to n^2, and each of 64 samples a memory of 100 n^2 numbers.
class JointFilter {
 public:
  static constexpr std::size_t memory = PoseFilter::memory;
  static constexpr int states = HeadingFilter::n;  ///< of each robot
  static constexpr int anchor = -1;                ///< a target whose pose comes with the measurement

  /// @param mounts  of the robots' sensors; as many as there are robots
  /// @throws std::invalid_argument from FilterOptions::check(), and without a robot
  JointFilter(const FilterOptions& options, std::span<const SensorMount> mounts);

  int robots() const noexcept { return static_cast<int>(filters_.size()); }
  /// The robots moved so, one sample each, all of one period; it is ignored unless all are usable and of that
  /// period.
  void advance(std::span<const MotionSample> motion) noexcept;
  /// A robot's measurement. Of a target in here, what it tells of its pose is not used. One ahead of the samples
  /// is not taken.
  Fit take(int robot, const Measurement& z, int target = anchor) noexcept;
  /// At the end of the last sample.
  PoseEstimate estimate(int robot) const noexcept;
  /// Covariance of the errors of (p, psi) of one robot with those of another.
  Mat<4, 4> covariance(int robot, int other) const noexcept;

 private:
  struct Robot {
    HeadingFilter::State state{};  // its P is not used
    Reckoned reckoned{};
    bool known = false;
    double last_accepted = 0.0;
  };
  struct Slot {
    double from = 0.0, until = 0.0;
    std::vector<MotionSample> motion;
    std::vector<Robot> robots;  // at `from`, before what is measured then
    std::vector<double> P;      // likewise
  };
  struct Heard {
    double stamp = 0.0;
    int source = 0;  // of the robot and the measurement, together
    int robot = 0, target = anchor;
    Measurement z{};
  };
  struct Doubts {
    Agreement candidates{}, contradictions{}, turned{};
  };

  Slot& at(std::size_t i) noexcept { return slots_[(first_ + i) % memory]; }
  Robot& robot(int i) noexcept { return robots_[static_cast<std::size_t>(i)]; }
  double& P(std::size_t i, std::size_t j) noexcept { return P_[i * n_ + j]; }
  static std::size_t row(int robot) noexcept { return static_cast<std::size_t>(robot) * states; }
  std::size_t slot_of(double stamp) noexcept;
  void drop_slot() noexcept;
  bool remember(const Heard& heard) noexcept;

  void move(const Slot& slot, double dt) noexcept;
  Measurement completed(const Heard& heard) const noexcept;
  Fit weigh(const Heard& heard, const Slot& slot) noexcept;
  template <int m>
  bool apply(const Heard& heard, const Innovation<m, states>& of, const Mat<m, 4>& H_target,
             Fit& fit) noexcept;
  void correct() noexcept;
  Fit run(const Slot& slot, double until, const Heard* watched) noexcept;
  Fit replay(const Heard* watched, std::size_t from) noexcept;
  Meaning meaning(const Heard& heard, double psi, double psi_variance) noexcept;
  FitVerdict judge(const Heard& heard, FitVerdict verdict) noexcept;
  void begin(const Heard& heard) noexcept;

  FilterOptions options_;
  std::vector<HeadingFilter> filters_;
  std::size_t n_;            // error states of all robots
  std::vector<Slot> slots_;  // ring
  std::size_t first_ = 0, count_ = 0;
  StampedList<Heard, memory> heard_{};
  std::vector<Robot> robots_;
  std::vector<double> P_;  // n x n, row by row
  std::vector<double> Gt_, Kt_, error_;
  std::vector<Doubts> doubts_;
  std::vector<MotionSample> last_;
  double now_;
};

}  // namespace sightline
