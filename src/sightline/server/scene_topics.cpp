#include "sightline/server/scene_topics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/log.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/solver.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr double scene_step = 0.1;  // [s]
constexpr std::string_view between_definitions =
    "================================================================================\n";

/// Definitions of Header, Time, Pose, Point and Quaternion, as in poses; and of Vector3.
std::string pose_definitions() {
  const std::string pose = pose_schema().text;
  return pose.substr(pose.find(between_definitions)) + std::string(between_definitions) +
         "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
}

std::string with_definitions(std::string first, std::initializer_list<std::string_view> others) {
  for (const std::string_view other : others) first += fmt::format("{}MSG: {}", between_definitions, other);
  return first + pose_definitions();
}

RosSchema transforms_schema() {
  return {"tf2_msgs/msg/TFMessage",
          with_definitions("geometry_msgs/TransformStamped[] transforms\n",
                           {"geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
                            "geometry_msgs/Transform transform\n",
                            "geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
                            "geometry_msgs/Quaternion rotation\n"})};
}

RosSchema markers_schema() {
  return {"visualization_msgs/msg/MarkerArray",
          with_definitions(
              "visualization_msgs/Marker[] markers\n",
              {"visualization_msgs/Marker\nstd_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 "
               "action\n"
               "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
               "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
               "std_msgs/ColorRGBA[] colors\nstring texture_resource\nsensor_msgs/CompressedImage texture\n"
               "visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n"
               "visualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
               "std_msgs/ColorRGBA\nfloat32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
               "builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n",
               "sensor_msgs/CompressedImage\nstd_msgs/Header header\nstring format\nuint8[] data\n",
               "visualization_msgs/UVCoordinate\nfloat32 u\nfloat32 v\n",
               "visualization_msgs/MeshFile\nstring filename\nuint8[] data\n"})};
}

RosSchema diagnostics_schema() {
  return {"diagnostic_msgs/msg/DiagnosticArray",
          with_definitions(
              "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
              {"diagnostic_msgs/DiagnosticStatus\nbyte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n"
               "byte level\nstring name\nstring message\nstring hardware_id\n"
               "diagnostic_msgs/KeyValue[] values\n",
               "diagnostic_msgs/KeyValue\nstring key\nstring value\n"})};
}

void put_vector(CdrEncoder& to, const Vec3<double>& v) { to.put(v.x).put(v.y).put(v.z); }
void put_turn(CdrEncoder& to, const Quaternion& q) { to.put(q.x).put(q.y).put(q.z).put(q.w); }
void put_count(CdrEncoder& to, std::size_t count) { to.put(static_cast<std::uint32_t>(count)); }

/// A marker; it stays until one with the same group and id replaces it.
void put_marker(CdrEncoder& to, std::uint64_t time, const Drawn& drawn, std::int32_t action) {
  put_header(to, time, frame_of_G);
  to.put(drawn.group);
  to.put(static_cast<std::int32_t>(drawn.id)).put(static_cast<std::int32_t>(drawn.form)).put(action);
  put_vector(to, drawn.p);
  put_turn(to, drawn.q);
  put_vector(to, drawn.size);
  to.put(drawn.colour.r).put(drawn.colour.g).put(drawn.colour.b).put(drawn.colour.a);
  to.put(std::int32_t{0}).put(std::uint32_t{0}).put(std::uint8_t{0});  // lifetime, frame_locked
  put_count(to, drawn.points.size());
  for (const Vec3<double>& point : drawn.points) put_vector(to, point);
  put_count(to, 0);                              // colors
  to.put(std::string_view());                    // texture_resource
  put_header(to, 0, "");                         // texture
  to.put(std::string_view()), put_count(to, 0);  // its format and data
  put_count(to, 0);                              // uv_coordinates
  to.put(std::string_view(drawn.words));
  to.put(std::string_view());                    // mesh_resource
  to.put(std::string_view()), put_count(to, 0);  // mesh_file
  to.put(std::uint8_t{0});
}

struct Reported {
  std::uint8_t level = 0;  // 0 OK, 1 WARN, 2 ERROR
  std::string name, message, hardware;
  std::vector<std::pair<std::string, std::string>> values{};
};

Reported reported_of_solver(const ShownState& state) {
  Reported reported = {
      .name = "sightline: solver", .message = std::string(state.status), .hardware = "controller"};
  for (int i = 0; i < status_count; ++i)
    if (to_string(static_cast<Status>(i)) == state.status && !gives_plan(static_cast<Status>(i)))
      reported.level = 2;
  reported.values = {{"status", reported.message},
                     {"residual [1/s]", fmt::format("{:.3g}", state.residual)},
                     {"iterations", fmt::format("{}", state.iterations)}};
  return reported;
}

/// @param robot  its index among the robots
Reported reported_of_robot(const ShownState& state, BodyId body, std::size_t robot, const std::string& name) {
  const std::string_view level = size(body.index) < state.levels.size() ? state.levels[size(body.index)]
                                                                        : to_string(FallbackLevel::valid);
  Reported reported = {.name = "sightline: " + name, .message = std::string(level), .hardware = name};
  if (level != to_string(FallbackLevel::valid)) reported.level = 1;
  reported.values = {{"level", reported.message}};
  if (robot < state.barrier.size())
    reported.values.emplace_back("barrier", state.barrier[robot] != 0 ? "acts" : "rests");
  return reported;
}

}  // namespace

SceneTopics::SceneTopics(const Scenario& scenario, MessageSink& to) : scene_(scenario), to_(to) {
  for (int i = 0; i < scenario.team.bodies(); ++i) {
    names_.emplace_back(scenario.team.name(BodyId{i}));
    if (scenario.team.is_agent(BodyId{i})) robots_.push_back(BodyId{i});
  }
  const auto open = [&](const RosSchema& schema, std::string_view topic) {
    return McapChannel{to.channel(to.schema(schema.name, "ros2msg", schema.text), topic, "cdr", {})};
  };
  transforms_ = open(transforms_schema(), "/tf");
  markers_ = open(markers_schema(), "/scene");
  diagnostics_ = open(diagnostics_schema(), "/diagnostics");
}

void SceneTopics::add(const ShownState& state) {
  seen_ = state.seen;
  for (auto& seen : seen_)
    if (seen && !std::isfinite(seen->p.x + seen->p.y + seen->p.z + seen->d.x + seen->d.y)) seen.reset();
  send_transforms(state);
  const auto now = static_cast<std::int64_t>(std::floor(state.time / scene_step + same_time));
  if (std::exchange(tenth_, now) == now) return;
  send_scene(state);
  send_diagnostics(state);
}

void SceneTopics::send_transforms(const ShownState& state) {
  CdrEncoder to(bytes_);
  put_count(to, static_cast<std::size_t>(
                    std::count_if(seen_.begin(), seen_.end(), [](const auto& seen) { return bool(seen); })));
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!seen_[i]) continue;
    put_header(to, nanoseconds(state.time), frame_of_G);
    to.put(std::string_view(names_[i]));
    put_vector(to, seen_[i]->p);
    put_turn(to, leaning(seen_[i]->d, seen_[i]->lean));
  }
  send(transforms_, state.time);
}

void SceneTopics::send_scene(const ShownState& state) {
  constexpr std::int32_t action_add = 0, action_delete_all = 3;
  const std::vector<Drawn> drawn = scene_.draw(seen_, state.time);
  CdrEncoder to(bytes_);
  put_count(to, drawn.size() + 1);
  put_marker(to, nanoseconds(state.time), {}, action_delete_all);  // removes the previous markers
  for (const Drawn& one : drawn) put_marker(to, nanoseconds(state.time), one, action_add);
  send(markers_, state.time);
}

void SceneTopics::send_diagnostics(const ShownState& state) {
  std::vector<Reported> all = {reported_of_solver(state)};
  for (std::size_t i = 0; i < robots_.size(); ++i)
    all.push_back(reported_of_robot(state, robots_[i], i, names_[size(robots_[i].index)]));
  CdrEncoder to(bytes_);
  put_header(to, nanoseconds(state.time), "");
  put_count(to, all.size());
  for (const Reported& one : all) {
    to.put(one.level);
    to.put(std::string_view(one.name)).put(std::string_view(one.message)).put(std::string_view(one.hardware));
    put_count(to, one.values.size());
    for (const auto& [key, value] : one.values) to.put(std::string_view(key)).put(std::string_view(value));
  }
  send(diagnostics_, state.time);
}

void SceneTopics::send(McapChannel& channel, double time) {
  to_.message(channel.id, channel.sequence++, nanoseconds(time), bytes_);
}

}  // namespace sightline
