/// Two robots on a line, and an event monitor that looks at them.
#pragma once

#include <vector>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {

/// Two robots on a line; time goes on by 0.1 s at each look.
struct MonitoredLine {
  explicit MonitoredLine(std::vector<TeamEvent> events) : monitor({std::move(events)}, team) {}

  Team team = event_team(2);
  EventMonitor monitor;
  std::vector<double> x = event_start(team), u = std::vector<double>(8);
  std::vector<Presence> presence = {Presence::steered, Presence::steered};
  std::vector<double> ages = {0, 0};
  double t = 0.0;

  std::vector<std::size_t> look() {
    const auto triggered = monitor.look({t, x, u, ages, presence});
    t += 0.1;
    return {triggered.begin(), triggered.end()};
  }
  std::vector<std::size_t> look(double distance) {
    x[7] = x[0] - distance, x[8] = x[1], x[9] = x[2];
    return look();
  }
};

inline TeamEvent when(Trigger trigger) {
  return {.name = "", .trigger = std::move(trigger), .actions = {RemoveTerm{"sees1"}}};
}
inline Condition nearer(double below, double hysteresis = 0.0, double dwell = 0.0) {
  return {DistanceOf{BodyId{0}, BodyId{1}}, Condition::Side::below, below, hysteresis, dwell};
}

}  // namespace sightline
