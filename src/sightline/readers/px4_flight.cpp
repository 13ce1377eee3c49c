#include "sightline/readers/px4_flight.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr double microsecond = 1e-6;                          // [s]
constexpr double set_points_gap = 0.5;                        // most between two set-points of a stretch [s]
constexpr std::uint64_t armed = 2, offboard = 14;             // of vehicle_status
constexpr std::uint64_t frame_ned = 1, velocity_of_body = 3;  // of vehicle_odometry

Vec3<double> of_ned(const Vec3<double>& ned) { return {ned.y, ned.x, -ned.z}; }

std::vector<Vec3<double>> vectors(const ULog& log, const ULog::Topic& topic,
                                  const std::array<std::string_view, 3>& fields) {
  const std::array<std::vector<double>, 3> of = {log.column(topic, fields[0]), log.column(topic, fields[1]),
                                                 log.column(topic, fields[2])};
  std::vector<Vec3<double>> all(of[0].size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = {of[0][i], of[1][i], of[2][i]};
  return all;
}

/// The time at which a message's content was so [us]: of the sample, where the topic has it.
std::vector<std::uint64_t> times_of(const ULog& log, const ULog::Topic& topic) {
  return log.has(topic, "timestamp_sample") ? log.column<std::uint64_t>(topic, "timestamp_sample")
                                            : log.times(topic);
}

RecordedMotion local_position(const ULog& log, const ULog::Topic& topic) {
  const std::vector<std::uint64_t> times = times_of(log, topic);
  const std::vector<Vec3<double>> p = vectors(log, topic, {"x", "y", "z"}),
                                  v = vectors(log, topic, {"vx", "vy", "vz"});
  const std::vector<double> yaw = log.column(topic, "heading");
  std::vector<std::uint64_t> valid(times.size(), 1);
  for (const std::string_view field : {"xy_valid", "z_valid", "v_xy_valid", "v_z_valid"}) {
    if (!log.has(topic, field)) continue;
    const std::vector<std::uint64_t> one = log.column<std::uint64_t>(topic, field);
    std::transform(one.begin(), one.end(), valid.begin(), valid.begin(), std::multiplies<>());
  }
  RecordedMotion motion;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (valid[i] != 0)
      append_sample(motion, {microsecond * static_cast<double>(times[i]), of_ned(p[i]), of_ned(v[i]),
                             std::numbers::pi / 2 - yaw[i]});
  }
  return motion;
}

RecordedMotion odometry(const ULog& log, const ULog::Topic& topic) {
  const std::vector<std::uint64_t> times = times_of(log, topic),
                                   pose_frame = log.column<std::uint64_t>(topic, "pose_frame"),
                                   velocity_frame = log.column<std::uint64_t>(topic, "velocity_frame");
  const std::vector<Vec3<double>> p = vectors(log, topic, {"position[0]", "position[1]", "position[2]"}),
                                  v = vectors(log, topic, {"velocity[0]", "velocity[1]", "velocity[2]"}),
                                  axis = vectors(log, topic, {"q[1]", "q[2]", "q[3]"});
  const std::vector<double> w = log.column(topic, "q[0]");
  RecordedMotion motion;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (pose_frame[i] != frame_ned ||
        (velocity_frame[i] != frame_ned && velocity_frame[i] != velocity_of_body))
      throw_invalid(
          "{}: {} has the frames {} and {}, expected 1 (NED) of the pose, 1 or 3 (body) of the velocity",
          log.file(), topic.shown(), pose_frame[i], velocity_frame[i]);
    const Rotation R = rotation({w[i], axis[i].x, axis[i].y, axis[i].z});
    const Vec2<double> ahead = heading(R);
    append_sample(
        motion, {microsecond * static_cast<double>(times[i]), of_ned(p[i]),
                 of_ned(velocity_frame[i] == frame_ned ? v[i] : R.to_G(v[i])), std::atan2(ahead.x, ahead.y)});
  }
  return motion;
}

/// Times of the log at which something that interrupts a stretch of set-points begins [us].
class Interruptions {
 public:
  explicit Interruptions(const ULog& log) {
    if (const ULog::Topic* const status = log.find("vehicle_status")) {
      times_ = log.times(*status);
      arming_ = log.column<std::uint64_t>(*status, "arming_state");
      mode_ = log.column<std::uint64_t>(*status, "nav_state");
    }
    const ULog::Topic* const position = log.find("vehicle_local_position");
    if (position == nullptr) return;
    const std::vector<std::uint64_t> times = log.times(*position);
    for (const std::string_view field : {"xy_reset_counter", "z_reset_counter", "vxy_reset_counter",
                                         "vz_reset_counter", "heading_reset_counter"}) {
      if (!log.has(*position, field)) continue;
      const std::vector<std::uint64_t> count = log.column<std::uint64_t>(*position, field);
      for (std::size_t i = 1; i < count.size(); ++i)
        if (count[i] != count[i - 1]) resets_.push_back(times[i]);
    }
  }

  /// Whether the vehicle followed set-points at this time, as far as the log has it.
  bool followed(std::uint64_t time) const {
    if (times_.empty()) return true;
    const auto after = std::upper_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return false;
    const auto i = static_cast<std::size_t>(after - times_.begin()) - 1;
    return arming_[i] == armed && mode_[i] == offboard;
  }
  bool reset_between(std::uint64_t from, std::uint64_t to) const {
    return std::any_of(resets_.begin(), resets_.end(),
                       [&](std::uint64_t time) { return time > from && time <= to; });
  }

 private:
  std::vector<std::uint64_t> times_, arming_, mode_, resets_;
};

}  // namespace

RecordedMotion px4_motion(const ULog& log, std::string_view topic) {
  if (std::find(px4_motions.begin(), px4_motions.end(), topic) == px4_motions.end())
    throw_invalid("{}: body = {}, expected one of {}", log.file(), topic, fmt::join(px4_motions, ", "));
  const ULog::Topic& of = log.topic(topic);
  return topic == "vehicle_odometry" ? odometry(log, of) : local_position(log, of);
}

std::vector<VelocityCommand> px4_velocity_commands(const ULog& log) {
  const ULog::Topic* const topic = log.find("trajectory_setpoint");
  if (topic == nullptr) return {};
  const std::vector<std::uint64_t> times = log.times(*topic);
  const std::vector<Vec3<double>> v = vectors(log, *topic, {"velocity[0]", "velocity[1]", "velocity[2]"}),
                                  p = vectors(log, *topic, {"position[0]", "position[1]", "position[2]"});
  const std::vector<double> yaw_rate = log.column(*topic, "yawspeed");
  const Interruptions interruptions(log);
  std::vector<VelocityCommand> longest, now;
  const auto seconds = [](const std::vector<VelocityCommand>& of) {
    return of.empty() ? -1.0 : of.back().t - of.front().t;
  };
  const auto end = [&] {
    if (seconds(now) > seconds(longest)) longest = std::move(now);
    now.clear();
  };
  for (std::size_t i = 0; i < times.size(); ++i) {
    const VelocityCommand command{microsecond * static_cast<double>(times[i]), of_ned(v[i]),
                                  std::isfinite(yaw_rate[i]) ? -yaw_rate[i] : 0.0};
    const bool by_velocity = std::isfinite(v[i].x + v[i].y + v[i].z) && !std::isfinite(p[i].x) &&
                             !std::isfinite(p[i].y) && !std::isfinite(p[i].z);
    const bool goes_on = !now.empty() && command.t > now.back().t &&
                         command.t - now.back().t <= set_points_gap &&
                         !interruptions.reset_between(times[i - 1], times[i]);
    if (!goes_on) end();
    if (by_velocity && interruptions.followed(times[i]))
      now.push_back(command);
    else
      end();
  }
  end();
  return longest;
}

}  // namespace sightline
