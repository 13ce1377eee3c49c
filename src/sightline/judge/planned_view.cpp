#include "sightline/judge/planned_view.hpp"

#include <algorithm>

#include "sightline/base.hpp"

namespace sightline {
namespace {

/// Predicted state of a body at a stage of the path.
Sight<double> planned_sight(const Team& team, BodyId body, const Sample& sample, std::size_t stage) {
  return team.model(body).sight(sample.path.data() + stage * sample.x.size() + team.state_offset(body),
                                sample.path_u.data() + stage * sample.u.size() + team.input_offset(body));
}

}  // namespace

void make_room_for_plans(const Scenario& scenario, Sample& prototype) {
  const std::vector<bool> leans = leaning_bodies(scenario);
  if (std::find(leans.begin(), leans.end(), true) == leans.end()) return;
  prototype.path_u.resize(prototype.path.size() / prototype.x.size() * prototype.u.size());
}

void PlannedAhead::compare(double time, double flown, bool counts) {
  while (!planned_.empty() && planned_.front().time <= time + same_time) {
    const Planned planned = planned_.front();
    planned_.pop_front();
    // A lost sample leaves no flown value to compare with.
    if (!counts || std::abs(planned.time - time) > same_time || !std::isfinite(planned.value)) continue;
    const double by = flown - planned.value;
    squares_ += by * by;
    sum_ += planned.value;
    max_ = std::max(max_, planned.value);
    ++compared_;
  }
}

std::optional<PlannedAhead::Place> PlannedAhead::place_in(const Sample& sample) {
  if (!sample.has_path || sample.path_u.empty()) return std::nullopt;
  const double stages = (sample.time + ahead - sample.path_time) / sample.path_step;
  if (!(stages >= 0)) return std::nullopt;
  const auto stage = static_cast<std::size_t>(stages);
  if ((stage + 2) * sample.x.size() > sample.path.size()) return std::nullopt;
  return Place{stage, stages - static_cast<double>(stage)};
}

double PlannedAhead::rms() const {
  return compared_ == 0 ? no_value : std::sqrt(squares_ / static_cast<double>(compared_));
}

double PlannedAhead::mean() const {
  return compared_ == 0 ? no_value : sum_ / static_cast<double>(compared_);
}

double PlannedAhead::max() const { return compared_ == 0 ? no_value : max_; }

void PlannedView::add(const Team& team, const Observation& pair, const Sample& sample, double flown,
                      bool counts) {
  PlannedAhead::add(sample, flown, counts, [&](std::size_t stage) {
    return view_angle(pair.mount, planned_sight(team, pair.observer, sample, stage),
                      planned_sight(team, pair.target, sample, stage).p);
  });
}

void PlannedTilt::add(const Team& team, BodyId robot, const Sample& sample, double flown, bool counts) {
  PlannedAhead::add(sample, flown, counts, [&](std::size_t stage) {
    const Vec2<double> lean = planned_sight(team, robot, sample, stage).lean;
    return std::atan(norm(lean.x, lean.y));
  });
}

}  // namespace sightline
