#include "sightline/record/localization_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>
#include <stdexcept>

#include "sightline/readers/cdr.hpp"
#include "sightline/record/log_table.hpp"
#include "sightline/scenario/read_estimate.hpp"

namespace sightline {
namespace {

std::array<double, 3> numbers_of_vector(const Vec3<double>& v) { return {v.x, v.y, v.z}; }

Vec3<double> vector_of(const LogText& text, std::string_view key) {
  const std::span<const double> v = text.numbers(key);
  if (v.size() != 3) throw std::runtime_error(fmt::format("{} numbers in {}, expected 3", v.size(), key));
  return {v[0], v[1], v[2]};
}

Mat<4, 4> covariance_of(const LogText& text) {
  const std::span<const double> all = text.numbers("covariance");
  if (all.size() != 10)
    throw std::runtime_error(fmt::format("{} numbers in covariance, expected 10", all.size()));
  Mat<4, 4> P;
  std::size_t place = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) P(i, j) = P(j, i) = all[place++];
  return P;
}

}  // namespace

LocalizationLog::LocalizationLog(const Scenario& scenario, MessageSink& sink)
    : team_(scenario.team), sink_(sink), message_(sink) {
  const TelemetryOptions telemetry = telemetry_options(scenario);
  if (telemetry.robots.empty()) return;
  constexpr LogTopic motion = log_topic("/ROBOT/motion"), broadcast = log_topic("/BODY/broadcast"),
                     localization = log_topic("/ROBOT/localization"),
                     innovation = log_topic("/ROBOT/innovation"), estimate = log_topic("/ROBOT/estimate");
  const SchemaId motions = motion.add_schema(sink), broadcasts = broadcast.add_schema(sink),
                 localizations = localization.add_schema(sink), innovations = innovation.add_schema(sink);
  const SchemaId estimates = estimate.add_schema(sink, estimate_schema().text);
  for (const MovingRobot& one : telemetry.robots) {
    const std::string_view name = team_.name(one.robot);
    robots_.push_back({one.robot, motion.open(sink, motions, name), estimate.open(sink, estimates, name),
                       localization.open(sink, localizations, name),
                       innovation.open(sink, innovations, name)});
  }
  for (const BodyId body : telemetry.broadcasters)
    senders_.push_back({body, broadcast.open(sink, broadcasts, team_.name(body))});
}

LocalizationLog::Robot* LocalizationLog::robot(BodyId body) {
  const auto found =
      std::find_if(robots_.begin(), robots_.end(), [&](const Robot& one) { return one.body == body; });
  return found != robots_.end() ? &*found : nullptr;
}

void LocalizationLog::add(const Sample& sample) {
  for (std::size_t i = 0; i < sample.motion_count; ++i) add_motion(sample.motions[i], sample.time);
  for (std::size_t i = 0; i < sample.broadcast_count; ++i) add_broadcast(sample.broadcasts[i], sample.time);
  for (std::size_t i = 0; i < sample.fit_count; ++i) add_fit(sample.fits[i], sample.time);
  for (Robot& one : robots_)
    if (at(one.body) < sample.estimates.size())
      add_estimate(one, sample.estimates[at(one.body)], sample.time);
}

void LocalizationLog::add_motion(const RobotMotion& reported, double time) {
  Robot* const of = robot(reported.robot);
  if (of == nullptr) return;
  const MotionSample& u = reported.motion;
  message_.begin(time);
  message_.put("t", u.t);
  message_.put("dt", u.dt);
  message_.put("v", numbers_of_vector(u.v_V));
  message_.put("yaw_rate", u.yaw_rate);
  message_.put("roll", u.roll);
  message_.put("pitch", u.pitch);
  message_.put("gyro", numbers_of_vector(u.gyro));
  message_.put("force", numbers_of_vector(u.force));
  if (u.compass) message_.put("compass", *u.compass);
  message_.send(of->motion, time);
}

void LocalizationLog::add_broadcast(const BodyBroadcast& reported, double time) {
  const auto sender = std::find_if(senders_.begin(), senders_.end(),
                                   [&](const Sender& one) { return one.body == reported.body; });
  if (sender == senders_.end()) return;
  message_.begin(time);
  message_.put("stamp", reported.pose.stamp);
  message_.put("p", numbers_of_vector(reported.pose.p));
  message_.put("v", numbers_of_vector(reported.pose.v));
  message_.put("heading", reported.pose.psi);
  message_.put("yaw_rate", reported.pose.yaw_rate);
  message_.put("covariance", upper_triangle(reported.pose.P));
  message_.send(sender->broadcast, time);
}

void LocalizationLog::add_estimate(Robot& of, const PoseEstimate& estimate, double time) {
  if (!estimate.known) return;
  message_.begin(time);
  message_.put("stamp", estimate.stamp);
  message_.put("accepted", estimate.last_accepted);
  message_.put("p", numbers_of_vector(estimate.p));
  message_.put("v", numbers_of_vector(estimate.v));
  message_.put("heading", estimate.psi);
  message_.put("yaw_rate", estimate.yaw_rate);
  message_.put("covariance", upper_triangle(estimate.P));
  message_.send(of.localization, time);
  PoseCovariance covariance{};
  constexpr std::array<std::size_t, 4> row = {0, 1, 2, 5};  // x, y, z, rotation about z
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      covariance[6 * row[i] + row[j]] = estimate.P(static_cast<int>(i), static_cast<int>(j));
  const StampedPose pose{.time = nanoseconds(std::max(0.0, estimate.stamp)),
                         .p = numbers_of_vector(estimate.p),
                         .d = {std::cos(estimate.psi), std::sin(estimate.psi)}};
  encode_estimate(bytes_, frame_of_G, pose, covariance);
  sink_.message(of.estimate.id, of.estimate.sequence++, nanoseconds(time), bytes_);
}

void LocalizationLog::add_fit(const DetectionFit& fit, double time) {
  Robot* const of = robot(fit.observer);
  if (of == nullptr) return;
  message_.begin(time);
  message_.put("target", team_.name(fit.target));
  message_.put("stamp", fit.stamp);
  message_.put("verdict", to_string(fit.fit.verdict));
  message_.put("dimension", fit.fit.dimension);
  message_.put("squared", fit.fit.squared);
  message_.put("y", fit.fit.y);
  message_.send(of->innovation, time);
}

MotionSample motion_of(const LogText& text) {
  MotionSample u{.t = text.number("t"), .dt = text.number("dt")};
  u.v_V = vector_of(text, "v");
  u.yaw_rate = text.number("yaw_rate");
  u.roll = text.number("roll");
  u.pitch = text.number("pitch");
  u.gyro = vector_of(text, "gyro");
  u.force = vector_of(text, "force");
  if (text.has("compass")) u.compass = text.number("compass");
  return u;
}

BroadcastPose broadcast_of(const LogText& text) {
  BroadcastPose pose{.stamp = text.number("stamp")};
  pose.p = vector_of(text, "p");
  pose.v = vector_of(text, "v");
  pose.psi = text.number("heading");
  pose.yaw_rate = text.number("yaw_rate");
  pose.P = covariance_of(text);
  return pose;
}

PoseEstimate estimate_of(const LogText& text) {
  PoseEstimate estimate{.known = true, .stamp = text.number("stamp")};
  estimate.p = vector_of(text, "p");
  estimate.v = vector_of(text, "v");
  estimate.psi = text.number("heading");
  estimate.yaw_rate = text.number("yaw_rate");
  estimate.P = covariance_of(text);
  estimate.last_accepted = text.number("accepted");
  return estimate;
}

}  // namespace sightline
