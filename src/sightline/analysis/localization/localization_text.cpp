#include "sightline/analysis/localization/localization_text.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "sightline/analysis/localization/noise_text.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/report/page.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

Json as_json(const InnovationStatistics& of) {
  Json lags = Json::array();
  for (const InnovationStatistics::Lag& one : of.autocorrelation)
    lags.push_back({{"lag", one.lag}, {"value", one.value}, {"bound", one.bound}});
  return {{"count", of.count},
          {"mean_square", of.mean_square},
          {"white", of.is_white()},
          {"correlation_time", of.correlation_time()},
          {"autocorrelation", std::move(lags)}};
}

std::string innovation_text(const InnovationStatistics& of) {
  if (of.count == 0) return "none";
  return fmt::format("{:.2f}, {}", of.mean_square,
                     of.is_white() ? "white" : fmt::format("{:.2f} s", of.correlation_time()));
}

/// "-" where the recording has no truth, or where the robot is the frame of the others.
std::string known_number(double x, int digits) {
  return std::isfinite(x) ? fmt::format("{:.{}f}", x, digits) : "-";
}

}  // namespace

std::string to_string(const LocalizedRecording& localized) {
  const TeamRecording& recording = localized.recording;
  const TeamLocalization& result = localized.result;
  const std::size_t landmarks = recording.landmarks.size();
  std::string text = fmt::format("{}: {}, {} robots, {} landmarks, {} sightings, {:.0f} s\n", localized.place,
                                 recording.kind, recording.robots.size(), landmarks,
                                 recording.sightings.size(), result.seconds);
  if (recording.unknown_codes > 0)
    text += fmt::format("{} sightings of codes that no body has are left out\n", recording.unknown_codes);
  text += fmt::format("\n{:<10} {:>8} {:>8} {:>8} {:>9} {:>6}  {:<13} {:<28} {:<14} {}\n", "robot",
                      "RMSE [m]", "max [m]", "sigma", "psi [deg]", "ANEES", "95 %",
                      "accepted, rejected, left out", "range", "bearing");
  for (std::size_t i = 0; i < recording.robots.size(); ++i) {
    const TeamLocalization::Robot& of = result.robots[i];
    text += fmt::format(
        "{:<10} {:>8} {:>8} {:>8} {:>9} {:>6}  {:<13} {:<28} {:<14} {}\n", recording.robots[i].name,
        known_number(of.rmse, 3), known_number(of.max_error, 3), known_number(of.sigma, 3),
        known_number(degrees_of_radian * of.heading_rmse, 2), known_number(of.anees, 2),
        std::isfinite(of.anees) ? fmt::format("{:.2f} to {:.2f}", of.bounds[0], of.bounds[1]) : "-",
        fmt::format("{}, {}, {}", of.accepted, of.rejected, of.left_out), innovation_text(of.range),
        innovation_text(of.bearing));
  }
  text += fmt::format("\nposition {} m, heading {} degrees (RMS), ANEES {}, 3 is consistent\n",
                      known_number(result.rmse, 3), known_number(degrees_of_radian * result.heading_rmse, 2),
                      known_number(result.anees, 2));
  if (localized.run.anchor != TeamRun::no_robot)
    text += fmt::format("without {}, whose pose is known at {:.0f} Hz: {:.3f} m\n",
                        recording.robots[static_cast<std::size_t>(localized.run.anchor)].name,
                        TeamRun::anchor_rate, result.rmse_without_anchor);
  text += fmt::format("poses relative to each other: {} m, {} degrees (mean absolute)\n",
                      known_number(result.relative_position, 3),
                      known_number(degrees_of_radian * result.relative_heading, 2));
  if (localized.wall_seconds > 0)
    text += fmt::format("{:.2f} s, {:.0f} times real time\n", localized.wall_seconds,
                        result.seconds / localized.wall_seconds);
  if (localized.identified) {
    text += fmt::format("\nidentified by {} runs, the cost falls from {:.1f} to {:.1f}\n",
                        localized.identified->runs, localized.identified->cost_before,
                        localized.identified->cost);
    for (const IdentifiedNoise::Number& one : localized.identified->numbers)
      text += fmt::format("{:<20} {:>10.4g} was {:>10.4g} {}\n", one.key, one.value, one.before, one.unit);
    text += "\n" + noise_text(localized.identified->noise);
  }
  return text;
}

std::string to_json(const LocalizedRecording& localized) {
  const TeamRecording& recording = localized.recording;
  const TeamLocalization& result = localized.result;
  Json robots = Json::array();
  for (std::size_t i = 0; i < recording.robots.size(); ++i) {
    const TeamLocalization::Robot& of = result.robots[i];
    Json constants;
    for (std::size_t k = 0; k < robot_constants.size(); ++k)
      constants[std::string(robot_constants[k])] = {{"value", of.states[first_constant + k]},
                                                    {"sigma", of.sigmas[first_constant + k]}};
    robots.push_back({{"name", recording.robots[i].name},
                      {"samples", of.samples},
                      {"rmse", of.rmse},
                      {"max_error", of.max_error},
                      {"heading_rmse", of.heading_rmse},
                      {"sigma", of.sigma},
                      {"anees", of.anees},
                      {"anees_bounds", of.bounds},
                      {"independent_samples", of.independent},
                      {"sightings",
                       {{"accepted", of.accepted},
                        {"rejected", of.rejected},
                        {"left_out", of.left_out},
                        {"located", of.located}}},
                      {"innovations", {{"range", as_json(of.range)}, {"bearing", as_json(of.bearing)}}},
                      {"constants", std::move(constants)}});
  }
  Json identified;
  if (localized.identified) {
    Json numbers;
    for (const IdentifiedNoise::Number& one : localized.identified->numbers)
      numbers[std::string(one.key)] = {{"value", one.value}, {"before", one.before}, {"unit", one.unit}};
    identified = {{"runs", localized.identified->runs},
                  {"cost_before", localized.identified->cost_before},
                  {"cost", localized.identified->cost},
                  {"numbers", std::move(numbers)}};
  }
  const int anchor = localized.run.anchor;
  Json json = {
      {"recording", localized.place},
      {"kind", recording.kind},
      {"command", localized.command},
      {"version", version},
      {"seed", localized.run.seed},
      {"identities", localized.run.identities},
      {"start_known", localized.run.start_known},
      {"anchor",
       anchor == TeamRun::no_robot ? Json() : Json(recording.robots[static_cast<std::size_t>(anchor)].name)},
      {"seconds", result.seconds},
      {"times_real_time",
       localized.wall_seconds > 0 ? Json(result.seconds / localized.wall_seconds) : Json()},
      {"landmarks", recording.landmarks.size()},
      {"sightings", recording.sightings.size()},
      {"unknown_codes", recording.unknown_codes},
      {"rmse", result.rmse},
      {"rmse_without_anchor", result.rmse_without_anchor},
      {"heading_rmse", result.heading_rmse},
      {"anees", result.anees},
      {"relative",
       {{"position_mean_absolute", result.relative_position},
        {"heading_mean_absolute", result.relative_heading}}},
      {"cost", result.cost},
      {"robots", std::move(robots)},
      {"noise", noise_json(localized.run.noise)},
      {"identified", std::move(identified)}};
  return json_text(json, 2) + "\n";
}

LocalizationCurves::LocalizationCurves(const TeamRecording& recording, TeamEstimates* next)
    : recording_(recording), next_(next), robots_(recording.robots.size()) {}

void LocalizationCurves::estimate(double t, int robot, const PoseGuess& pose,
                                  const std::optional<PlanarPose>& truth) {
  Curves& of = robots_[static_cast<std::size_t>(robot)];
  // Half a second of a curve is finer than a pixel.
  if (of.t.empty() || t - recording_.start - of.t.back() > 0.45) {
    const PlanarPose is = truth.value_or(PlanarPose{no_value, no_value, no_value});
    of.t.push_back(t - recording_.start);
    of.x.push_back(pose.pose.x), of.y.push_back(pose.pose.y);
    of.true_x.push_back(is.x), of.true_y.push_back(is.y);
    of.error.push_back(norm(pose.pose.x - is.x, pose.pose.y - is.y));
    of.sigma.push_back(sqrt(pose.P(0, 0) + pose.P(1, 1)));
  }
  if (next_ != nullptr) next_->estimate(t, robot, pose, truth);
}

void LocalizationCurves::fit(const TeamSighting& z, const TeamFit& fit) {
  if (next_ != nullptr) next_->fit(z, fit);
}

std::string LocalizationCurves::html(const LocalizedRecording& localized) const {
  Drawing errors{.title = "Error of the position",
                 .caption = "Line: error. Dashed: reported standard deviation."};
  Drawing paths{.title = "Paths", .caption = "Lines: estimated. Thin: true."};
  Drawing::Panel map{.x_label = "x [m]", .y_label = "y [m]", .height = 500, .equal_scales = true};
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Curves& of = robots_[i];
    const std::string& name = recording_.robots[i].name;
    const bool last = i + 1 == robots_.size();
    Drawing::Panel panel{.x_label = last ? "t [s]" : "", .y_label = name + " [m]"};
    panel.curves = {
        {.title = i == 0 ? "error" : "", .colour = 0, .mark = Drawing::Mark::line, .x = of.t, .y = of.error},
        {.title = i == 0 ? "sigma" : "",
         .colour = 1,
         .mark = Drawing::Mark::dashed,
         .x = of.t,
         .y = of.sigma}};
    errors.panels.push_back(std::move(panel));
    map.curves.push_back(
        {.title = name, .colour = i % Drawing::colours, .mark = Drawing::Mark::line, .x = of.x, .y = of.y});
    map.curves.push_back({.title = "",
                          .colour = i % Drawing::colours,
                          .mark = Drawing::Mark::thin,
                          .x = of.true_x,
                          .y = of.true_y});
  }
  paths.panels.push_back(std::move(map));
  return page_head("Localization of " + recording_.kind) +
         fmt::format("<pre>{}</pre>\n", escaped(to_string(localized))) +
         page_figures({std::move(errors), std::move(paths)}) + page_end();
}

}  // namespace sightline
