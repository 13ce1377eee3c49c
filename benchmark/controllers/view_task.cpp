#include "benchmark/controllers/view_task.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::benchmark {
namespace {

bool acts_on(const Coupling& coupling, BodyId robot) {
  return std::any_of(coupling.felt_by.begin(), coupling.felt_by.end(),
                     [&](AgentId id) { return id.index == robot.index; });
}

/// The other end of a coupling.
BodyId other_end(const Coupling& coupling, BodyId body) {
  return coupling.between.first == body ? coupling.between.second : coupling.between.first;
}

bool is_end(const Coupling& coupling, BodyId body) {
  return coupling.between.first == body || coupling.between.second == body;
}

void read_distances(const Team& team, ViewTask& task) {
  double d_min = 0.0, d_max = std::numeric_limits<double>::infinity();
  for (const Coupling& coupling : team.couplings()) {
    if (!is_end(coupling, task.robot) || !acts_on(coupling, task.robot)) continue;
    const BodyId other = other_end(coupling, task.robot);
    const std::optional<double> least = coupling.term.potential.d_min(),
                                most = coupling.term.potential.d_max();
    if (other == task.target) {
      if (least) d_min = std::max(d_min, *least);
      if (most) d_max = std::min(d_max, *most);
    } else if (least) {
      task.others.push_back({other, *least});
    }
  }
  task.d_min = d_min > 0 ? d_min : std::min(1.0, 0.5 * d_max);
  task.d_max = std::isfinite(d_max) ? d_max : 2 * task.d_min;
  if (!(task.d_min < task.d_max))
    throw_invalid("{} keeps {} at {} m and at most {} m, expected d_min < d_max", team.name(task.robot),
                  team.name(task.target), task.d_min, task.d_max);
}

}  // namespace

std::vector<ViewTask> view_tasks(const Team& team) {
  std::vector<ViewTask> tasks;
  for (const Coupling& coupling : team.couplings()) {
    const Potential& potential = coupling.term.potential;
    const BodyId robot = coupling.between.first;
    if (!potential.alpha() || potential.mount() == nullptr || !acts_on(coupling, robot)) continue;
    if (std::any_of(tasks.begin(), tasks.end(), [&](const ViewTask& task) { return task.robot == robot; }))
      throw_invalid("{} observes two bodies, expected one target for each robot", team.name(robot));
    tasks.push_back(
        {AgentId{robot}, coupling.between.second, *potential.mount(), *potential.alpha(), 0.0, 0.0, {}});
    read_distances(team, tasks.back());
  }
  if (tasks.empty())
    throw_invalid("no robot observes another body, expected a coupling with a sensor: bearing, sensor_cone");
  return tasks;
}

Team without_observers(const Team& team, const std::vector<ViewTask>& tasks) {
  Team rest;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (team.is_agent(body))
      rest.add(team.agent(body));
    else
      rest.add(Obstacle{std::string(team.name(body)), team.model(body).turns()});
  }
  for (Coupling coupling : team.couplings()) {
    std::erase_if(coupling.felt_by, [&](AgentId id) {
      return std::any_of(tasks.begin(), tasks.end(), [&](const ViewTask& task) { return task.robot == id; });
    });
    if (!coupling.felt_by.empty()) rest.couple(coupling);
  }
  for (const Constraint& constraint : team.constraints()) rest.constrain(constraint);
  for (const BarrierTerm& term : team.barriers()) rest.constrain(term.barrier, term.agent);
  return rest;
}

Relative relative(const Pose<double>& robot, const Sight<double>& body) {
  const Vec2<double> back = {robot.d.x, -robot.d.y};
  const Vec3<double> r = body.p - robot.p;
  const Vec2<double> q = rotate<double>(back, {r.x, r.y}), w = rotate<double>(back, {body.v.x, body.v.y});
  return {{q.x, q.y, r.z}, {w.x, w.y, body.v.z}};
}

Vec3<double> best_place(const ViewTask& task) {
  return task.mount.point_in_F({task.mount.depth_at(0.5 * (task.d_min + task.d_max)), 0, 0});
}

}  // namespace sightline::benchmark
