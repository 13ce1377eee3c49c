#include "sightline/judge/localization_summary.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/judge/summary_keys.hpp"

namespace sightline {
namespace {

bool is_estimated(FitVerdict verdict) {
  return verdict == FitVerdict::accepted || verdict == FitVerdict::accepted_position ||
         verdict == FitVerdict::started || verdict == FitVerdict::restarted;
}

}  // namespace

PoseError error_of(const PoseEstimate& estimate, const Vec3<double>& p, double psi) noexcept {
  PoseError error{p - estimate.p, wrap(psi - estimate.psi)};
  const Column<4> e{{{{error.p.x}, {error.p.y}, {error.p.z}, {error.psi}}}};
  error.nees = mahalanobis(e, estimate.P);
  return error;
}

LocalizationSummary::LocalizationSummary(const Scenario& scenario)
    : team_(scenario.team), settle_(scenario.simulation.settle) {
  for (const LocalizedRobot& one : scenario.localization.robots)
    robots_.push_back({.body = one.robot, .known_from = no_value, .seen = no_value});
}

void LocalizationSummary::add(const Sample& sample) noexcept {
  for (std::size_t i = 0; i < sample.fit_count; ++i) {
    const DetectionFit& fit = sample.fits[i];
    for (Robot& robot : robots_) {
      if (robot.body != fit.observer) continue;
      ++robot.detections;
      robot.rejected += fit.fit.verdict == FitVerdict::rejected ? 1 : 0;
      robot.restarts += fit.fit.verdict == FitVerdict::restarted ? 1 : 0;
      if (is_estimated(fit.fit.verdict)) robot.seen = std::fmax(robot.seen, fit.stamp);
    }
  }
  for (Robot& robot : robots_)
    if (at(robot.body) < sample.estimates.size()) add_estimate(robot, sample);
}

void LocalizationSummary::add_estimate(Robot& robot, const Sample& sample) noexcept {
  const PoseEstimate& estimate = sample.estimates[at(robot.body)];
  if (!estimate.known) return;
  if (std::isnan(robot.known_from)) robot.known_from = sample.time;
  robot.unseen = std::max(robot.unseen, sample.time - (std::isnan(robot.seen) ? 0.0 : robot.seen));
  if (sample.time < settle_) return;
  robot.sigma_max = std::max(robot.sigma_max, estimate.position_sigma());
  if (!sample.truth_known) return;
  const Sight<double> truth = true_sight(team_, robot.body, sample);
  const PoseError error = error_of(estimate, truth.p, std::atan2(truth.d.y, truth.d.x));
  robot.squares += dot(error.p, error.p);
  robot.heading_squares += square(error.psi);
  robot.nees += error.nees;
  ++robot.errors;
}

std::vector<RobotLocalization> LocalizationSummary::robots() const {
  std::vector<RobotLocalization> all;
  for (const Robot& robot : robots_) {
    const double n = robot.errors > 0 ? static_cast<double>(robot.errors) : no_value;
    all.push_back({.name = std::string(team_.name(robot.body)),
                   .known_from = robot.known_from,
                   .rmse = std::sqrt(robot.squares / n),
                   .heading_rmse = std::sqrt(robot.heading_squares / n),
                   .anees = robot.nees / n,
                   .sigma_max = std::isnan(robot.known_from) ? no_value : robot.sigma_max,
                   .detections = robot.detections,
                   .rejected = robot.rejected,
                   .restarts = robot.restarts,
                   .longest_without_sight = std::isnan(robot.known_from) ? no_value : robot.unseen});
  }
  return all;
}

std::string LocalizationSummary::json() const {
  if (robots_.empty()) return {};
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RobotLocalization& robot : robots())
    list.push_back({{"agent"_key, robot.name},
                    {"known_from"_key, robot.known_from},
                    {"rmse"_key, robot.rmse},
                    {"heading_rmse"_key, robot.heading_rmse},
                    {"anees"_key, robot.anees},
                    {"sigma_max"_key, robot.sigma_max},
                    {"detections"_key, robot.detections},
                    {"rejected"_key, robot.rejected},
                    {"restarts"_key, robot.restarts},
                    {"longest_without_sight"_key, robot.longest_without_sight}});
  return json_text(list);
}

}  // namespace sightline
