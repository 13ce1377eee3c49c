#include "sightline/record/log_topics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/judge/tracking_error.hpp"
#include "sightline/record/log_table.hpp"

namespace sightline {
namespace {

constexpr double reference_step = 0.1;  // [s]

// Yaw rate d x d' about z [rad/s]; 0 for a body without a heading.
double turn_rate(const Model& model, const StateRoles& roles, const double* x, const double* u) {
  if (!roles.has_heading()) return 0.0;
  std::vector<double> rate(size(model.nx()));
  model.f(x, u, rate.data());
  if (roles.angle >= 0) return rate[size(roles.angle)];
  const std::size_t d_x = size(roles.direction[0]), d_y = size(roles.direction[1]);
  return x[d_x] * rate[d_y] - x[d_y] * rate[d_x];
}

}  // namespace

LogTopics::LogTopics(const Scenario& scenario, std::size_t controllers, MessageSink& to)
    : team_(scenario.team), to_(to), no_input_(size(team_.nu())) {
  schemas_.pose = log_topic("/BODY/pose").add_schema(to_, pose_schema().text);
  schemas_.twist = log_topic("/BODY/twist").add_schema(to_, twist_schema().text);
  schemas_.path = log_topic("/ROBOT/path").add_schema(to_, path_schema().text);
  schemas_.state = log_topic("/BODY/state").add_schema(to_);
  schemas_.input = log_topic("/ROBOT/input").add_schema(to_);
  schemas_.reference = log_topic("/ROBOT/reference").add_schema(to_);
  LogTopic solver = log_topic("/solver");
  std::string fields(solver.fields);
  constexpr std::string_view pairs = "pairs: integer, ";
  if (team_.swarms().empty()) fields.erase(fields.find(pairs), pairs.size());
  solver.fields = fields;
  schemas_.solver = solver.add_schema(to_);
  schemas_.event = log_topic("/events").add_schema(to_);

  if (!scenario.certified_views.empty()) schemas_.view = log_topic("/ROBOT/view").add_schema(to_);
  const bool has_barrier = scenario.safety && scenario.safety->barrier != BarrierMode::off;
  if (has_barrier) schemas_.barrier = log_topic("/ROBOT/barrier").add_schema(to_);
  const bool is_measured = scenario.simulation.disturbances.spoil_measurements() ||
                           !scenario.simulation.faults.empty() ||
                           std::any_of(scenario.vehicles.begin(), scenario.vehicles.end(), has_imu);
  for (int i = 0; i < team_.bodies(); ++i) open_body(BodyId{i}, is_measured, has_barrier);
  open_attitudes(scenario);
  for (const CertifiedView& view : scenario.certified_views) {
    auto& channel = bodies_[size(view.observer.index)].view;
    if (!channel) channel = log_topic("/ROBOT/view").open(to_, *schemas_.view, team_.name(view.observer));
  }
  for (std::size_t c = 0; c < controllers; ++c)
    solvers_.push_back(
        solver.open(to_, schemas_.solver, controllers > 1 ? fmt::format("controller{}", c) : ""));
  events_ = log_topic("/events").open(to_, schemas_.event);
  measurements_.emplace(team_, to_, scenario.goals);
  localization_.emplace(scenario, to_);
  cameras_.emplace(scenario, to_);
  tuned_.emplace(scenario, to_);
}

void LogTopics::open_body(BodyId body, bool is_measured, bool has_barrier) {
  const auto open = [&](SchemaId schema, const LogTopic& topic) {
    return topic.open(to_, schema, team_.name(body));
  };
  BodyChannels channels{body, roles_of(team_.model(body)), open(schemas_.state, log_topic("/BODY/state")),
                        open(schemas_.pose, log_topic("/BODY/pose")),
                        open(schemas_.twist, log_topic("/BODY/twist"))};
  if (is_measured) channels.measured = open(schemas_.pose, log_topic("/BODY/measured"));
  if (team_.is_agent(body)) {
    channels.input = open(schemas_.input, log_topic("/ROBOT/input"));
    channels.path = open(schemas_.path, log_topic("/ROBOT/path"));
    if (has_barrier) channels.barrier = open(schemas_.barrier, log_topic("/ROBOT/barrier"));
    channels.robot = robots_++;
    const Agent& agent = team_.agent(body);
    if (tracks_position(agent, channels.roles) || tracks_heading(agent, channels.roles)) {
      channels.reference = open(schemas_.reference, log_topic("/ROBOT/reference"));
    }
  }
  bodies_.push_back(channels);
}

/// Opens attitude topics for vehicles and for robots with a body-fixed camera.
void LogTopics::open_attitudes(const Scenario& scenario) {
  const std::vector<bool> leans = leaning_bodies(scenario);
  for (BodyChannels& channels : bodies_) {
    if (!leans[size(channels.body.index)]) continue;
    constexpr LogTopic topic = log_topic("/BODY/attitude");
    if (!schemas_.attitude) schemas_.attitude = topic.add_schema(to_, attitude_schema().text);
    channels.attitude = topic.open(to_, *schemas_.attitude, team_.name(channels.body));
  }
}

bool LogTopics::add(const Sample& sample, const PresentTeam& present, double cost) {
  const auto now = static_cast<std::int64_t>(std::floor(sample.time / reference_step + same_time));
  const bool first = std::exchange(tenth_, now) != now;
  for (BodyChannels& channels : bodies_) {
    add_body(channels, sample);
    if (!team_.is_agent(channels.body)) continue;
    add_agent(channels, sample);
    if (channels.reference && first) add_reference(channels, present, sample.time);
  }
  measurements_->add(sample);
  localization_->add(sample);
  cameras_->add(sample.time);
  tuned_->add(sample);
  add_records(sample, cost);
  return first;
}

void LogTopics::add_states(const Sample& sample) {
  for (BodyChannels& channels : bodies_) add_place(channels, sample);
  add_events(sample);
}

void LogTopics::add_body(BodyChannels& channels, const Sample& sample) {
  add_place(channels, sample);
  if (sample.presence[size(channels.body.index)] == Presence::absent) return;
  const Model& model = team_.model(channels.body);
  const std::size_t offset = size(team_.state_offset(channels.body));
  const double *x = sample.x.data() + offset, *u = sample.u.data() + team_.input_offset(channels.body);
  if (channels.measured) add_pose(*channels.measured, model, sample.measured.data() + offset, sample.time);
  const bool finite = all_finite({x, size(model.nx())}) && all_finite({u, size(model.nu())});
  if (finite && channels.attitude) add_attitude(channels, sample);
}

/// Adds state, pose and twist.
void LogTopics::add_place(BodyChannels& channels, const Sample& sample) {
  const Model& model = team_.model(channels.body);
  const std::size_t nx = size(model.nx()), offset = size(team_.state_offset(channels.body));
  const double *x = sample.x.data() + offset, *u = sample.u.data() + team_.input_offset(channels.body);
  message_.begin(sample.time);
  message_.put("x", {x, nx});
  message_.send(channels.state, sample.time);
  if (sample.presence[size(channels.body.index)] == Presence::absent) return;
  add_pose(channels.pose, model, x, sample.time);
  if (!all_finite({x, nx}) || !all_finite({u, size(model.nu())})) return;
  const Vec3<double> v = model.sight(x, u).v;
  encode_twist(bytes_, frame_of_G,
               {nanoseconds(sample.time), {v.x, v.y, v.z}, {0, 0, turn_rate(model, channels.roles, x, u)}});
  send_bytes(channels.twist, sample.time);
}

void LogTopics::add_attitude(BodyChannels& channels, const Sample& sample) {
  const auto body = size(channels.body.index);
  Quaternion q = body < sample.attitudes.size() ? sample.attitudes[body] : no_attitude;
  if (q == no_attitude) {
    const Sight<double> seen = true_sight(team_, channels.body, sample);
    q = leaning(seen.d, seen.lean);
  }
  encode_attitude(bytes_, frame_of_G, {nanoseconds(sample.time), {q.x, q.y, q.z, q.w}});
  send_bytes(*channels.attitude, sample.time);
}

void LogTopics::add_pose(McapChannel& channel, const Model& model, const double* x, double time) {
  const Pose<double> pose = model.sight(x, no_input_.data());
  if (!all_finite({x, size(model.nx())}) || (pose.d.x == 0 && pose.d.y == 0)) return;
  encode_pose(bytes_, frame_of_G, {nanoseconds(time), {pose.p.x, pose.p.y, pose.p.z}, {pose.d.x, pose.d.y}});
  send_bytes(channel, time);
}

void LogTopics::add_agent(BodyChannels& channels, const Sample& sample) {
  const std::size_t nu = size(team_.model(channels.body).nu());
  const std::size_t offset = size(team_.input_offset(channels.body));
  message_.begin(sample.time);
  message_.put("u", std::span(sample.u).subspan(offset, nu));
  message_.put("raw", std::span(sample.raw_u).subspan(offset, nu));
  message_.send(*channels.input, sample.time);
  if (sample.has_path) add_path(channels, sample);
  if (channels.barrier && channels.robot < sample.barriers.size()) add_barrier(channels, sample);
  if (channels.view && channels.robot < sample.views.size()) add_view(channels, sample);
}

void LogTopics::add_barrier(BodyChannels& channels, const Sample& sample) {
  const BarrierRecord& record = sample.barriers[channels.robot];
  message_.begin(sample.time);
  message_.put("active", record.active);
  message_.put("conflict", record.conflict);
  message_.put("reserve", record.reserve);
  message_.send(*channels.barrier, sample.time);
}

void LogTopics::add_view(BodyChannels& channels, const Sample& sample) {
  const ViewRecord& record = sample.views[channels.robot];
  message_.begin(sample.time);
  message_.put("certified", record.certified);
  message_.put("active", record.active);
  message_.put("reserve", record.reserve);
  message_.put("least", to_string(record.least));
  message_.put("target", record.target.index < 0 ? "" : team_.name(record.target));
  message_.put("requests", record.requests);
  message_.send(*channels.view, sample.time);
}

void LogTopics::add_path(BodyChannels& channels, const Sample& sample) {
  const Model& model = team_.model(channels.body);
  const bool leans = channels.attitude && !sample.path_u.empty();
  path_.clear();
  for (std::size_t i = 0; i < sample.path.size() / sample.x.size(); ++i) {
    const double* x = &sample.path[i * sample.x.size() + size(team_.state_offset(channels.body))];
    const double* u = leans ? &sample.path_u[i * sample.u.size() + size(team_.input_offset(channels.body))]
                            : no_input_.data();
    const Sight<double> seen = model.sight(x, u);
    if (!all_finite({x, size(model.nx())}) || (seen.d.x == 0 && seen.d.y == 0)) return;
    const double time = sample.path_time + sample.path_step * static_cast<double>(i);
    path_.push_back({nanoseconds(time), {seen.p.x, seen.p.y, seen.p.z}, {seen.d.x, seen.d.y}});
    if (leans) path_.back().lean = {seen.lean.x, seen.lean.y};
  }
  encode_path(bytes_, frame_of_G, nanoseconds(sample.time), path_);
  send_bytes(*channels.path, sample.time);
}

void LogTopics::add_reference(BodyChannels& channels, const PresentTeam& present, double time) {
  const StateRoles& roles = channels.roles;
  const Agent* const steered = present.agent(channels.body);
  if (steered == nullptr) return;
  const Agent& agent = *steered;
  x_ref_.resize(agent.Q.size());
  agent.x_ref(time, agent.model, x_ref_);
  const Pose<double> pose = agent.model.sight(x_ref_.data(), no_input_.data());
  message_.begin(time);
  if (tracks_position(agent, roles)) message_.put("p", std::array{pose.p.x, pose.p.y, pose.p.z});
  if (tracks_heading(agent, roles) && !(pose.d.x == 0 && pose.d.y == 0)) {
    message_.put("d", std::array{pose.d.x, pose.d.y});
  }
  message_.send(*channels.reference, time);
}

void LogTopics::add_records(const Sample& sample, double cost) {
  for (std::size_t c = 0; c < solvers_.size(); ++c) {
    const SolverRecord& record = sample.solvers[c];
    message_.begin(sample.time);
    message_.put("status", to_string(record.status));
    message_.put("residual", record.residual);
    message_.put("iterations", record.iterations);
    if (!team_.swarms().empty()) message_.put("pairs", record.pairs);
    message_.put("cost", cost);
    message_.send(solvers_[c], sample.time);
  }
  add_events(sample);
}

void LogTopics::add_events(const Sample& sample) {
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[size(i)];
    message_.begin(event.time);
    message_.put("kind", to_string(event.kind));
    message_.put("controller", event.controller);
    message_.put("value", event.value);
    message_.send(events_, sample.time);
  }
}

}  // namespace sightline
