#include "sightline/record/planned_view.hpp"

#include <cmath>

#include "sightline/base/index.hpp"
#include "sightline/base/no_value.hpp"
#include "sightline/base/same_time.hpp"

namespace sightline {
namespace {

/// The angle at a stage of the predicted path.
double angle_at(const Team& team, const Observation& pair, const Sample& sample, std::size_t stage) {
  const double* const x = sample.path.data() + stage * sample.x.size();
  const double* const u = sample.path_u.data() + stage * sample.u.size();
  const auto sight = [&](BodyId body) {
    return team.model(body).sight(x + team.state_offset(body), u + team.input_offset(body));
  };
  return view_angle(pair.mount, sight(pair.observer), sight(pair.target).p);
}

}  // namespace

void make_room_for_plans(const Scenario& scenario, Sample& prototype) {
  bool looks = false;
  for (int i = 0; i < scenario.team.bodies(); ++i) looks = looks || has_body_camera(scenario, BodyId{i});
  if (looks) prototype.path_u.resize(prototype.path.size() / prototype.x.size() * prototype.u.size());
}

void PlannedView::add(const Team& team, const Observation& pair, const Sample& sample, double flown,
                      bool counts) {
  while (!planned_.empty() && planned_.front().time <= sample.time + same_time) {
    const Planned planned = planned_.front();
    planned_.pop_front();
    // A sample that was lost leaves nothing to compare with.
    if (!counts || std::abs(planned.time - sample.time) > same_time || !std::isfinite(planned.angle))
      continue;
    const double by = flown - planned.angle;
    squares_ += by * by;
    ++compared_;
  }
  if (!sample.has_path || sample.path_u.empty()) return;
  const double stages = (sample.time + ahead - sample.path_time) / sample.path_step;
  if (!(stages >= 0)) return;
  const auto stage = static_cast<std::size_t>(stages);
  if ((stage + 2) * sample.x.size() > sample.path.size()) return;
  const double share = stages - static_cast<double>(stage);
  const double first = angle_at(team, pair, sample, stage), second = angle_at(team, pair, sample, stage + 1);
  planned_.push_back({sample.time + ahead, first + share * (second - first)});
}

double PlannedView::rms() const {
  if (compared_ == 0) return no_value;
  return std::sqrt(squares_ / static_cast<double>(compared_));
}

}  // namespace sightline
