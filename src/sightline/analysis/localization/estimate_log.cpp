#include "sightline/analysis/localization/estimate_log.hpp"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

#include "sightline/config.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/record/log_table.hpp"

namespace sightline {
namespace {

constexpr double chunk_seconds = 10.0;

StampedPose stamped(double time, const PlanarPose& pose, double height) {
  const SinCos<double> e = sincos(pose.psi);
  return {.time = nanoseconds(time), .p = {pose.x, pose.y, height}, .d = {e.cos, e.sin}};
}

}  // namespace

EstimateLog::EstimateLog(const std::filesystem::path& file, const TeamRecording& recording,
                         const McapWords& words)
    : recording_(recording), file_(file), log_(file, "ros2", fmt::format("sightline {}", version)) {
  log_.metadata("sightline", words);
  constexpr LogTopic estimate = log_topic("/ROBOT/estimate"), pose = log_topic("/BODY/pose"),
                     innovation = log_topic("/ROBOT/innovation");
  const SchemaId estimates = estimate.add_schema(log_, estimate_schema().text),
                 poses = pose.add_schema(log_, pose_schema().text), innovations = innovation.add_schema(log_);
  for (const TeamRecording::Robot& robot : recording.robots)
    robots_.push_back({estimate.open(log_, estimates, robot.name), pose.open(log_, poses, robot.name),
                       innovation.open(log_, innovations, robot.name)});
}

void EstimateLog::flush_after(double time) {
  if (time - flushed_ < chunk_seconds) return;
  log_.flush();
  flushed_ = time;
}

const std::string& EstimateLog::name_of(int body) const {
  static const std::string unknown = "unknown";
  if (body < 0) return unknown;
  const auto i = static_cast<std::size_t>(body);
  return i < robots_.size() ? recording_.robots[i].name : recording_.landmarks[i - robots_.size()].name;
}

void EstimateLog::estimate(double t, int robot, const PoseGuess& pose,
                           const std::optional<PlanarPose>& truth) {
  const auto i = static_cast<std::size_t>(robot);
  const double time = t - recording_.start, height = recording_.robots[i].height;
  flush_after(time);
  PoseCovariance covariance{};
  constexpr std::array<std::size_t, 3> row = {0, 1, 5};  // x, y, rotation about z
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      covariance[6 * row[a] + row[b]] = pose.P(static_cast<int>(a), static_cast<int>(b));
  encode_estimate(bytes_, frame_of_G, stamped(time, pose.pose, height), covariance);
  log_.message(robots_[i].estimate.id, robots_[i].estimate.sequence++, nanoseconds(time), bytes_);
  if (!truth) return;
  encode_pose(bytes_, frame_of_G, stamped(time, *truth, height));
  log_.message(robots_[i].pose.id, robots_[i].pose.sequence++, nanoseconds(time), bytes_);
}

void EstimateLog::fit(const TeamSighting& z, const TeamFit& fit) {
  const double time = z.stamp - recording_.start;
  message_.begin(time);
  message_.put("target", std::string_view(name_of(fit.subject)));
  message_.put("stamp", time);
  message_.put("verdict", to_string(fit.verdict));
  message_.put("dimension", fit.dimension);
  message_.put("squared", fit.squared);
  message_.put("y", fit.y);
  message_.send(robots_[static_cast<std::size_t>(z.observer)].innovation, time);
}

void EstimateLog::close() {
  log_.close();
  if (!log_.ok()) throw std::runtime_error(fmt::format("{}: {}", file_.native(), log_.error()));
}

}  // namespace sightline
