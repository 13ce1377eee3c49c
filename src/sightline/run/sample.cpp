#include "sightline/loop.hpp"

namespace sightline {

std::string_view to_string(EventKind kind) {
  constexpr std::array<std::string_view, event_kinds> names = {"missed_period",
                                                               "solver_status",
                                                               "input_refused",
                                                               "samples_dropped",
                                                               "valid",
                                                               "predicted",
                                                               "slowed",
                                                               "hold",
                                                               "land",
                                                               "grounded",
                                                               "measurement_not_finite",
                                                               "measurement_heading",
                                                               "measurement_world",
                                                               "measurement_speed",
                                                               "measurement_jump",
                                                               "measurement_frozen",
                                                               "measurement_time",
                                                               "barrier_conflict",
                                                               "event_happened",
                                                               "event_in_force",
                                                               "event_ignored",
                                                               "team_late",
                                                               "pairs_left_out",
                                                               "added_too_near",
                                                               "search",
                                                               "found",
                                                               "unheard",
                                                               "heard",
                                                               "robot_ready",
                                                               "robot_refused",
                                                               "view_certified",
                                                               "view_uncertified",
                                                               "view_handed_over"};
  static_assert(!names.back().empty(), "each kind of event has a name");
  return names[static_cast<std::size_t>(kind)];
}

Vec2<double> true_lean(const Vec2<double>& of_model, BodyId body, const Sample& sample) noexcept {
  const auto i = static_cast<std::size_t>(body.index);
  const bool known = i < sample.attitudes.size() && sample.attitudes[i] != no_attitude;
  return known ? lean(rotation(sample.attitudes[i])) : of_model;
}

Sight<double> true_sight(const Team& team, BodyId body, const Sample& sample) noexcept {
  Sight<double> seen = team.model(body).sight(sample.x.data() + team.state_offset(body),
                                              sample.u.data() + team.input_offset(body));
  seen.lean = true_lean(seen.lean, body, sample);
  return seen;
}

}  // namespace sightline
