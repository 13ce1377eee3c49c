#include "sightline/server/log_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <stdexcept>

#include "sightline/base/index.hpp"
#include "sightline/base/no_value.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/record/cdr.hpp"
#include "sightline/record/mcap.hpp"
#include "sightline/record/recording.hpp"
#include "sightline/server/admission.hpp"
#include "sightline/server/page_files.hpp"
#include "sightline/server/scene_json.hpp"

namespace sightline {
namespace {

/// Predicted places of all robots by the time of the prediction.
using LoggedPaths = std::map<double, std::vector<std::vector<Vec3<double>>>>;

LoggedPaths read_paths(const std::filesystem::path& log, const Recording& run) {
  std::vector<std::string> topics;
  for (const Recording::Body& body : run.bodies)
    if (body.is_agent) topics.push_back("/" + body.name + "/path");
  LoggedPaths all;
  McapReader reader(log);
  reader.visit([&](const McapMessage& message) {
    const auto topic = std::find(topics.begin(), topics.end(), message.topic);
    if (topic == topics.end()) return;
    const auto path = decode_path(message.bytes);
    if (!path) return;
    auto& paths = all[1e-9 * static_cast<double>(message.log_time)];
    paths.resize(topics.size());
    for (const StampedPose& pose : *path)
      paths[static_cast<std::size_t>(topic - topics.begin())].push_back({pose.p[0], pose.p[1], pose.p[2]});
  });
  return all;
}

EventKind kind_named(std::string_view name) {
  for (int i = 0; i < event_kinds; ++i)
    if (to_string(static_cast<EventKind>(i)) == name) return static_cast<EventKind>(i);
  return EventKind::samples_dropped;
}

void check_team(const Recording& run, const Scenario& scenario, const std::filesystem::path& folder) {
  bool same = run.bodies.size() == size(scenario.team.bodies());
  for (std::size_t i = 0; same && i < run.bodies.size(); ++i)
    same = run.bodies[i].name == scenario.team.name(BodyId{static_cast<int>(i)});
  if (!same)
    throw std::runtime_error(
        fmt::format("{}: the log is of another team than its scenario", (folder / "run.mcap").string()));
}

/// Goes through a log in the order of its time.
class LogPlayer {
 public:
  LogPlayer(const Recording& run, LoggedPaths paths, const Scenario& scenario)
      : run_(run),
        paths_(std::move(paths)),
        scene_(scenario),
        script_(scenario.script.events.size()),
        present_(scenario),
        asked_(scene_.asked(present_)) {}

  std::string moments(std::size_t stride) {
    std::string list = "[";
    for (std::size_t row = 0; row < run_.time.size(); row += stride) {
      if (row > 0) list += ",\n";
      list += moment(row, std::min(row + stride, run_.time.size()));
    }
    return list + "]\n";
  }

 private:
  std::string moment(std::size_t row, std::size_t until) {
    ShownState now;
    now.time = run_.time[row];
    const std::vector<Happening> events = follow(now.time);
    now.asked = asked_;
    for (const Recording::Body& body : run_.bodies) {
      const double psi = body.heading[row];
      Sight<double> seen;
      seen.p = body.p[row], seen.d = {std::cos(psi), std::sin(psi)};
      seen.v = body.v[row], seen.lean = body.lean[row];
      now.seen.emplace_back(seen);  // of one that is not there, not a number
      for (const auto& input : body.u) now.u.push_back(input[row]);
      if (!body.barrier.empty()) now.barrier.push_back(body.barrier[row] > 0 ? 1 : 0);
    }
    const Recording::Controller& solver = run_.controllers.front();
    now.status = solver.status[row];
    now.residual = solver.residual[row];
    now.iterations = solver.iterations[row];
    now.solve_us = no_value;
    for (std::size_t i = row; i < std::min(until, run_.solve_us.size()); ++i)
      now.solve_us = std::fmax(now.solve_us, run_.solve_us[i]);
    const auto later = paths_.upper_bound(now.time + same_time);
    if (later != paths_.begin()) now.paths = std::prev(later)->second;
    paths_.erase(paths_.begin(), later);
    return scene_.moment(now, events);
  }

  std::vector<Happening> follow(double time) {
    std::vector<Happening> events;
    while (next_ < run_.events.size() && run_.events[next_].time <= time + same_time) {
      const Recording::Event& event = run_.events[next_];
      events.push_back({static_cast<std::int64_t>(next_), event.time, scene_.words(event.kind, event.value)});
      const EventKind kind = kind_named(event.kind);
      const bool known = event.value >= 0 && event.value < static_cast<double>(script_);
      if (kind == EventKind::event_in_force && known) {
        told_.time = time;
        told_.event_count = 1;
        told_.events[0] = {event.time, kind, event.controller, event.value};
        (void)present_.follow(told_);
        asked_ = scene_.asked(present_);
      }
      ++next_;
    }
    return events;
  }

  const Recording& run_;
  LoggedPaths paths_;
  SceneJson scene_;
  std::size_t script_;  // events of it
  PresentTeam present_;
  std::vector<char> asked_;
  Sample told_;
  std::size_t next_ = 0;  // event
};

}  // namespace

std::string log_moments(const std::filesystem::path& folder, const Scenario& scenario, std::size_t numbers) {
  const Recording run = read_recording(folder);
  check_team(run, scenario, folder);
  constexpr std::size_t said_of_a_body = 7;
  const std::size_t all = run.time.size() * run.bodies.size() * said_of_a_body;
  // No screen shows more than 60 a second.
  const auto least = static_cast<std::size_t>(std::max(1.0, std::floor(1.0 / 60 / run.period)));
  const std::size_t stride = std::max(least, (all + numbers - 1) / std::max<std::size_t>(numbers, 1));
  return LogPlayer(run, read_paths(folder / "run.mcap", run), scenario)
      .moments(std::max<std::size_t>(stride, 1));
}

PageFiles log_page(const std::filesystem::path& folder, const Scenario& scenario) {
  PageFiles files = page_files();
  files["/scene.json"] = {"application/json", SceneJson(scenario).scene(random_token(), false)};
  files["/moments.json"] = {"application/json", log_moments(folder, scenario)};
  return files;
}

}  // namespace sightline
