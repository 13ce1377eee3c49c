#include "sightline/run/sample.hpp"

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
                                                               "added_too_near"};
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace sightline
