#include "sightline/analysis/view_band.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sightline/base.hpp"
#include "sightline/scenario/reach.hpp"
#include "sightline/scenario/read_camera.hpp"
#include "sightline/scenario/read_estimate.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

/// Greatest speed of a body's reference or motion [m/s].
double meant_speed(const Scenario& scenario, BodyId body) {
  for (const UncooperativeBody& one : scenario.uncooperative) {
    if (one.body == body) return one.motion ? top_speed(*one.motion) : 0.0;
  }
  const Agent& agent = scenario.team.agent(body);
  if (agent.x_ref.is_constant()) return 0.0;
  constexpr double step = 0.05;  // [s]
  std::vector<double> x(agent.Q.size()), u(agent.R.size());
  const auto place = [&](double t) {
    agent.x_ref(t, agent.model, x);
    return agent.model.sight(x.data(), u.data()).p;
  };
  double most = 0.0;
  for (double t = 0.0; t + step <= scenario.simulation.duration; t += step) {
    const double speed = norm(place(t + step) - place(t)) / step;
    if (std::isfinite(speed)) most = std::max(most, speed);
  }
  return most;
}

std::vector<ViewAtDistance> rows_of(const ViewFlight& flight, int flights) {
  std::vector<ViewAtDistance> rows;
  for (int k = 1; k <= 400; ++k) {
    const double distance = band_step * k;
    const ViewAtDistance row{.distance = distance, .figures = mean_figures(flight, distance, flights)};
    const bool none = row.figures.found < 0.02;
    if (none && !rows.empty()) break;
    if (!none) rows.push_back(row);
    // Below 4 px no tag is read.
    if (rows.empty() && flight.camera.pixels(flight.tags.size, distance) < 4.0) break;
  }
  return rows;
}

std::optional<DistanceBand> served(const ViewFlight& flight, const std::vector<ViewAtDistance>& rows,
                                   int flights) {
  const auto holds = [&](const ViewAtDistance& row) {
    return row.figures.losses <= band_losses && row.figures.known > 0.99;
  };
  double least = infinity;
  for (const ViewAtDistance& row : rows)
    if (holds(row)) least = std::min(least, row.figures.sigma);
  std::optional<DistanceBand> band;
  for (const ViewAtDistance& row : rows) {
    const bool serves = holds(row) && row.figures.sigma <= band_error * least;
    if (!serves && band) break;
    if (!serves) continue;
    if (!band) {
      const ViewFigures nearer = mean_figures(flight, row.distance - band_sway, flights);
      if (nearer.losses > band_losses || nearer.found < 0.9) continue;
      band = DistanceBand{row.distance, row.distance};
    }
    band->high = row.distance;
  }
  return band;
}

/// Compass of a robot that is localized by vision, and the correlation of its sightings; of another robot what its camera
/// would need.
FilterOptions filter_beside(const Scenario& scenario, BodyId robot) {
  for (const LocalizedRobot& one : scenario.localization.robots)
    if (one.robot == robot)
      return {.compass_noise = one.filter.compass_noise,
              .compass_time = one.filter.compass_time,
              .correlation_time = one.filter.correlation_time};
  const RobotCamera* const camera = scenario.vision.camera_of(robot);
  return {.correlation_time = camera != nullptr ? camera->camera.correlation_time : 0.0};
}

}  // namespace

std::vector<ViewBand> view_bands(const Scenario& scenario, int flights) {
  std::vector<ViewBand> all;
  std::vector<ViewFlight> flown;
  std::set<std::pair<const RobotCamera*, int>> pairs;
  const auto take = [&](const Coupling& coupling) {
    const auto& [observer, target] = coupling.between;
    const RobotCamera* const camera = scenario.vision.camera_of(observer, coupling.term.potential.mount());
    const BodyTags* const tags = scenario.vision.tags_of(target);
    if (coupling.term.potential.mount() == nullptr || camera == nullptr || tags == nullptr) return;
    if (!pairs.emplace(camera, target.index).second) return;
    ViewBand band{.observer = observer,
                  .target = target,
                  .camera = camera_name(*camera, scenario.team),
                  .speed = meant_speed(scenario, target)};
    const ViewFlight flight{.camera = camera->camera,
                            .mount = camera->mount,
                            .tags = tags->tags,
                            .filter = filter_beside(scenario, observer),
                            .target_speed = band.speed};
    for (std::size_t i = 0; i < flown.size() && !band.same_as; ++i) {
      if (!(flown[i] == flight)) continue;
      band.same_as = i, band.rows = all[i].rows, band.serves = all[i].serves;
    }
    if (!band.same_as) {
      band.rows = rows_of(flight, flights);
      band.serves = served(flight, band.rows, flights);
    }
    flown.push_back(flight);
    all.push_back(std::move(band));
  };
  for (const Coupling& coupling : stated_couplings(scenario)) take(coupling);
  return all;
}

std::string to_string(const ViewBand& band, const Team& team) {
  std::string text = fmt::format("{} sees the tags of {}, which moves at up to {:.2g} m/s", band.camera,
                                 team.name(band.target), band.speed);
  if (band.rows.empty()) return text + ": at no distance\n";
  text += "\n  distance  found  error of its place  view lost for 0.5 s\n";
  for (const auto& [distance, figures] : band.rows) {
    const std::string error =
        std::isfinite(figures.sigma) ? fmt::format("{:.0f} mm", 1e3 * figures.sigma) : "unknown";
    text += fmt::format("  {:5.2f} m  {:4.0f} %  {:>18}  {:8.1f} a minute\n", distance, 100 * figures.found,
                        error, figures.losses);
  }
  if (!band.serves) return text + "  no distance serves: tags are too small or too large in its pictures\n";
  return text +
         fmt::format("  it is served best from {:.2f} to {:.2f} m\n", band.serves->low, band.serves->high);
}

std::vector<std::string> unobservable_robots(const Scenario& scenario) {
  SensedTeam team = sensed_team(scenario);
  const auto is_away = [&](const Sees& sees) {
    return scenario.presence[size(sees.target)] == Presence::absent;
  };
  std::erase_if(team.sightings, is_away);
  for (const ViewChoice& choice : scenario.script.choices) {
    for (std::size_t i = 0; i < choice.observers.size(); ++i) {
      const BodyId observer = choice.observers[i];
      if (scenario.presence[at(observer)] == Presence::absent) continue;
      team.robots[at(observer)].position = false;
      team.robots[at(observer)].heading = filter_beside(scenario, observer).compass_noise > 0;
      if (choice.first[i] >= 0)
        team.sightings.push_back({.observer = observer.index,
                                  .target = choice.targets[size(choice.first[i])].index,
                                  .yaw = sees_headings(scenario, observer)});
    }
  }
  std::vector<std::string> sentences;
  for (const Unobservable& what : unobservable_states(team.robots, team.places, team.sightings))
    sentences.push_back(to_string(what, team.robots));
  return sentences;
}

}  // namespace sightline
