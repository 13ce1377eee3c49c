#include "sightline/analysis/localization/rig_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

#include "sightline/analysis/localization/noise_text.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/config.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/record/log_table.hpp"
#include "sightline/report/page.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

using RigJson = nlohmann::ordered_json;

constexpr std::string_view smoothed_suffix = "_smoothed";

RigJson accuracy_json(const RigAccuracy& of) {
  return {{"samples", of.samples},     {"rmse", of.rmse},
          {"max_error", of.max_error}, {"attitude_rmse", of.attitude_rmse},
          {"sigma", of.sigma},         {"anees", of.anees},
          {"anees_bounds", of.bounds}, {"independent_samples", of.independent}};
}

std::string accuracy_row(std::string_view name, const RigAccuracy& of) {
  return fmt::format("{:<10} {:>8} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.2f} {:>6.2f}  {:.2f} to {:.2f}\n", name,
                     of.samples, of.rmse, of.max_error, of.sigma, degrees_of_radian * of.attitude_rmse,
                     of.anees, of.bounds[0], of.bounds[1]);
}

StampedAttitude attitude_of(double time, const Rotation& R) {
  const Quaternion q = quaternion(R);
  return {.time = nanoseconds(time), .q = {q.x, q.y, q.z, q.w}};
}

PoseCovariance covariance_of(const RigLocalization::Estimate& of) {
  const Mat<6, 6> P = pose_covariance(of);
  PoseCovariance covariance{};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) covariance[size(6 * i + j)] = P(i, j);
  return covariance;
}

}  // namespace

std::string to_string(const LocalizedRig& localized) {
  const RigRecording& recording = localized.recording;
  const RigLocalization& result = localized.result;
  std::string text = fmt::format(
      "{}: camera rig {}, {} cameras, {} tags seen, {} sightings, {}, {:.0f} s\n", localized.place,
      recording.name, recording.cameras.size(), result.places, recording.sightings.size(),
      (recording.odometry.empty() ? "no odometry"
                                  : fmt::format("{} poses of odometry", recording.odometry.size())) +
          (recording.turn_rates.empty() ? "" : fmt::format(", {} turn rates", recording.turn_rates.size())),
      result.seconds);
  if (recording.left_out > 0)
    text +=
        fmt::format("{} sightings of tags or by cameras of no body used are left out\n", recording.left_out);
  text += fmt::format(
      "{} sightings accepted, {} rejected, {} waiting; innovations {:.2f}, restarts {}, longest without "
      "{:.1f} s\n",
      result.accepted, result.rejected, result.waiting, result.innovation, result.restarts,
      result.longest_unseen);
  if (!result.reference.empty()) {
    text += fmt::format("\n{:<10} {:>8} {:>8} {:>8} {:>8} {:>9} {:>6}  {}\n", "estimates", "samples",
                        "RMSE [m]", "max [m]", "sigma", "att [deg]", "ANEES", "95 %");
    text += accuracy_row("filter", result.of_filter) + accuracy_row("in view", result.in_view) +
            accuracy_row("smoothed", result.of_smoother);
    text +=
        "\nfilter: nothing later is used, but for one sample of odometry. in view: a tag was seen within 1 "
        "s.\n"
        "smoothed: the whole recording is used. ANEES is of position and attitude, 6 is consistent.\n";
  }
  if (result.wall_seconds > 0)
    text += fmt::format("{:.2f} s, {:.0f} times real time\n", result.wall_seconds,
                        result.seconds / result.wall_seconds);
  if (localized.identified)
    text += "\nrandom walks identified from the whole recording, without the reference:\n" +
            noise_text(localized.noise);
  return text;
}

std::string to_json(const LocalizedRig& localized) {
  const RigRecording& recording = localized.recording;
  const RigLocalization& result = localized.result;
  RigJson json = {{"recording", localized.place},
                  {"kind", "camera rig"},
                  {"command", localized.command},
                  {"version", version},
                  {"seconds", result.seconds},
                  {"times_real_time",
                   result.wall_seconds > 0 ? RigJson(result.seconds / result.wall_seconds) : RigJson()},
                  {"cameras", recording.cameras.size()},
                  {"tags", result.places},
                  {"odometry", recording.odometry.size()},
                  {"turn_rates", recording.turn_rates.size()},
                  {"sightings",
                   {{"accepted", result.accepted},
                    {"rejected", result.rejected},
                    {"waiting", result.waiting},
                    {"left_out", recording.left_out}}},
                  {"restarts", result.restarts},
                  {"longest_unseen", result.longest_unseen},
                  {"innovations", {{"mean_square", result.innovation}}}};
  json.update(accuracy_json(result.of_filter));
  json["in_view"] = accuracy_json(result.in_view);
  json["smoothed"] = accuracy_json(result.of_smoother);
  json["cost"] = result.cost;
  json["identified"] = localized.identified;
  json["noise"] = noise_json(localized.noise);
  return json_text(json, 2) + "\n";
}

std::string to_html(const LocalizedRig& localized) {
  constexpr double shown_every = 0.2;  // [s]
  const RigLocalization& result = localized.result;
  Drawing::Curve error{.title = "error", .colour = 0, .mark = Drawing::Mark::line},
      sigma{.title = "sigma", .colour = 0, .mark = Drawing::Mark::dashed},
      smoothed_error{.title = "smoothed", .colour = 1, .mark = Drawing::Mark::line},
      path{.title = "filter", .colour = 0, .mark = Drawing::Mark::line},
      smoothed_path{.title = "smoothed", .colour = 1, .mark = Drawing::Mark::line},
      reference_path{.title = "reference", .colour = 2, .mark = Drawing::Mark::thin};
  double last = -infinity;
  for (std::size_t k = 0; k < result.filter.size(); ++k) {
    const RigLocalization::Estimate &one = result.filter[k], &other = result.smoothed[k];
    if (one.t - last < shown_every) continue;
    last = one.t;
    const double t = one.t - localized.recording.start;
    path.x.push_back(one.pose.p.x), path.y.push_back(one.pose.p.y);
    smoothed_path.x.push_back(other.pose.p.x), smoothed_path.y.push_back(other.pose.p.y);
    sigma.x.push_back(t), sigma.y.push_back(sqrt(trace(position_covariance(one))));
    if (result.reference.empty()) continue;
    const Vec3<double>& is = result.reference[k].p;
    reference_path.x.push_back(is.x), reference_path.y.push_back(is.y);
    error.x.push_back(t), error.y.push_back(norm(one.pose.p - is));
    smoothed_error.x.push_back(t), smoothed_error.y.push_back(norm(other.pose.p - is));
  }
  Drawing errors{.title = "Error of the position",
                 .caption = "Lines: errors against the reference. Dashed: reported standard deviation."};
  Drawing::Panel panel{.x_label = "t [s]", .y_label = "[m]"};
  panel.curves = {std::move(error), std::move(sigma), std::move(smoothed_error)};
  errors.panels.push_back(std::move(panel));
  Drawing paths{.title = "Paths", .caption = "From above."};
  Drawing::Panel map{.x_label = "x [m]", .y_label = "y [m]", .height = 500, .equal_scales = true};
  map.curves = {std::move(path), std::move(smoothed_path), std::move(reference_path)};
  paths.panels.push_back(std::move(map));
  return page_head("Localization of a camera rig") +
         fmt::format("<pre>{}</pre>\n", escaped(to_string(localized))) +
         page_figures({std::move(errors), std::move(paths)}) + page_end();
}

void write_rig_log(const std::filesystem::path& file, const LocalizedRig& localized) {
  const RigRecording& recording = localized.recording;
  const RigLocalization& result = localized.result;
  McapWriter log(file, "ros2", fmt::format("sightline {}", version));
  log.metadata("sightline", {{"version", std::string(version)},
                             {"recording", "camera rig"},
                             {"smoothed", "uses the whole recording"},
                             {"noise", noise_text(localized.noise)}});
  constexpr LogTopic estimate = log_topic("/ROBOT/estimate"), pose = log_topic("/BODY/pose"),
                     innovation = log_topic("/ROBOT/innovation");
  const SchemaId estimates = estimate.add_schema(log, estimate_schema().text),
                 poses = pose.add_schema(log, pose_schema().text), innovations = innovation.add_schema(log);
  McapChannel filtered = estimate.open(log, estimates, recording.name),
              smoothed = estimate.open(log, estimates, recording.name + std::string(smoothed_suffix)),
              reference = pose.open(log, poses, recording.name),
              fits = innovation.open(log, innovations, recording.name);
  std::vector<std::byte> bytes;
  const auto send = [&](McapChannel& to, double time, const RigidPose& at, const PoseCovariance* covariance) {
    encode_rigid_pose(bytes, frame_of_G, {at.p.x, at.p.y, at.p.z}, attitude_of(time, at.R), covariance);
    log.message(to.id, to.sequence++, nanoseconds(time), bytes);
  };
  LogMessage message(log);
  std::size_t next = 0;
  const auto fits_until = [&](double t) {
    for (; next < result.fits.size() && recording.sightings[next].t <= t; ++next) {
      const TagFit& fit = result.fits[next];
      const RigRecording::Sighting& z = recording.sightings[next];
      if (!(fit.squared >= 0)) continue;
      const double time = z.t - recording.start;
      message.begin(time);
      message.put("target", std::string_view(fmt::format("tag{}", recording.tags[z.tag].id)));
      message.put("stamp", time);
      message.put("verdict", to_string(fit.verdict));
      message.put("dimension", 8);
      message.put("squared", fit.squared);
      message.put("y", std::span<const double>(fit.y));
      message.send(fits, time);
    }
  };
  for (std::size_t k = 0; k < result.filter.size(); ++k) {
    const RigLocalization::Estimate& one = result.filter[k];
    const double time = one.t - recording.start;
    if (time < 0) continue;
    fits_until(one.t);
    PoseCovariance covariance = covariance_of(one);
    send(filtered, time, one.pose, &covariance);
    covariance = covariance_of(result.smoothed[k]);
    send(smoothed, time, result.smoothed[k].pose, &covariance);
    if (!result.reference.empty()) send(reference, time, result.reference[k], nullptr);
  }
  fits_until(infinity);
  log.close();
  if (!log.ok()) throw std::runtime_error(fmt::format("{}: {}", file.native(), log.error()));
}

}  // namespace sightline
