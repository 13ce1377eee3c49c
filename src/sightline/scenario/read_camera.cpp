#include "sightline/scenario/read_camera.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "sightline/sensors.hpp"

namespace sightline {
namespace {

/// Reads `render`, which requires a world with a renderer.
bool read_render(const TomlTable& at, const std::string& world) {
  constexpr std::string_view key = "render";
  if (!at.has(key) || !at.boolean(key)) return false;
  const WorldList& worlds = at.registry().worlds;
  if (worlds.find(world)->renders()) return true;
  const auto able = worlds.names(&WorldPart::renders);
  if (able.empty())
    at.throw_invalid(key, fmt::format("false in the world \"{}\": no world here renders pictures", world));
  at.throw_invalid(key, fmt::format("false in the world \"{}\", only world.kind = \"{}\" renders pictures",
                                    world, fmt::join(able, "\" or \"")));
}

constexpr std::size_t tf_frame_max = 128;  // [bytes]

bool is_tf_frame(const std::string& name) {
  return !name.empty() && name.size() <= tf_frame_max &&
         std::none_of(name.begin(), name.end(), [](unsigned char c) { return c <= ' ' || c == 127; });
}

/// Name in /tf of the optical frame of a robot's camera.
std::string read_optical_frame(const TomlTable& at, std::string frame, const CameraOptions& vision) {
  constexpr std::string_view key = "optical_frame";
  const std::string own = fmt::format("a frame of its own on /tf, of 1 to {} bytes", tf_frame_max);
  const std::string expected = at.has(key) ? own : fmt::format("{}, \"{}\" is none", own, frame);
  if (at.has(key)) frame = at.text(key, expected);
  const bool taken = std::any_of(vision.cameras.begin(), vision.cameras.end(),
                                 [&](const RobotCamera& one) { return one.frame == frame; });
  if (taken || !is_tf_frame(frame)) at.throw_invalid(key, expected);
  return frame;
}

/// Names in /tf of the tags of a body; by default those of apriltag_ros, with numbers in the order
/// of the file.
std::vector<std::string> read_tag_frames(const TomlTable& at, const Tags& tags, const CameraOptions& vision) {
  constexpr std::string_view key = "frames";
  std::vector<std::string> frames;
  if (at.has(key)) frames = at.texts(key, static_cast<std::size_t>(tags.faces), "frames on /tf, one a face");
  int number = 0;
  for (const BodyTags& before : vision.tags) number += before.tags.faces;
  while (frames.size() < static_cast<std::size_t>(tags.faces))
    frames.push_back(fmt::format("{}:{}", tag_families[static_cast<std::size_t>(tags.family)], number++));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto before = frames.begin() + static_cast<std::ptrdiff_t>(i);
    bool taken = std::find(frames.begin(), before, frames[i]) != before;
    for (const auto& others : vision.tag_frames)
      taken = taken || std::find(others.begin(), others.end(), frames[i]) != others.end();
    if (taken || !is_tf_frame(frames[i]))
      at.throw_invalid(key, fmt::format("a frame of its own on /tf for each tag, {} is none", frames[i]));
  }
  return frames;
}

/// ", equidistant to 2.10 rad"
std::string lens_words(const Camera& camera) {
  if (camera.distortion == Distortion::none) return "";
  return fmt::format(", {} to {:.2f} rad", distortions[static_cast<std::size_t>(camera.distortion)],
                     camera.widest());
}

/// @param beside  further keys that the table may have
SensorMount read_mounting(const TomlTable& at, std::span<const std::string_view> beside = {}) {
  constexpr std::string_view key = "offset";
  auto mount = read_part<SensorMount>(TableSource(at), beside);
  if (!at.has(key)) return mount;
  const std::string of_one = mount_offsets.expected("m"), expected = of_one + ", ahead or [ahead, left, up]";
  if (at.value(key, expected).is_array()) {
    const std::vector<double> d = at.numbers(key, 3, {mount_offsets.low, mount_offsets.high, of_one});
    mount.offset = {d[0], d[1], d[2]};
  } else {
    mount.offset = at.number(key, {mount_offsets.low, mount_offsets.high, expected});
  }
  return mount;
}

/// Reads the camera of a sensor, whose name is empty for [agent.NAME.sensor].
void read_one_camera(const TomlTable& camera, BodyId robot, const NamedSensor& sensor,
                     ScenarioSpec& scenario) {
  constexpr std::array<std::string_view, 2> beside = {"render", "optical_frame"};
  RobotCamera read{
      .observer = robot, .mount = sensor.mount, .camera = read_part<Camera>(TableSource(camera), beside)};
  camera.checked([&] { read.camera.check(); });
  if (camera.has("field_of_view") && camera.has("focal_length"))
    camera.throw_invalid("field_of_view", "no such key beside focal_length");
  read.render = read_render(camera, scenario.world);
  if (read.render && !read.camera.is_plain())
    camera.throw_invalid("render", "false with a focal_length, a principal_point or a distortion");
  if (read.render && read.camera.correlation_time > 0)
    camera.throw_invalid("correlation_time",
                         "0 s of a rendered camera, whose errors are those of its pictures");
  const std::string_view name = scenario.team.name(robot);
  read.sensor = sensor.name;
  read.frame = read_optical_frame(
      camera, fmt::format("{}{}{}_camera_optical_frame", name, sensor.name.empty() ? "" : "_", sensor.name),
      scenario.vision);
  scenario.vision.cameras.push_back(read);
}

/// Rejects a further camera whose sightings cannot be given as those of the first.
void check_beside_first(const TomlTable& sensor, const RobotCamera& first, const RobotCamera& further) {
  if (first.mount.frame != further.mount.frame)
    sensor.throw_invalid("frame", "that of the sensor of the robot's first camera");
  if (first.camera.correlation_time > 0 || further.camera.correlation_time > 0)
    sensor.table("camera").throw_invalid("correlation_time", "0 s of each of several cameras of a robot");
}

/// The cameras by which a coupling's first robot sees the second body: that of its own sensor, or those of the
/// pair's couplings with a sensor, or if they have none, that of the robot.
std::vector<const RobotCamera*> cameras_of(const ScenarioSpec& scenario, const Coupling& coupling) {
  std::vector<const RobotCamera*> cameras;
  const auto add = [&](const SensorMount* mount) {
    const RobotCamera* const camera = scenario.vision.camera_of(coupling.between.first, mount);
    if (camera != nullptr && std::find(cameras.begin(), cameras.end(), camera) == cameras.end())
      cameras.push_back(camera);
  };
  if (const SensorMount* const own = coupling.term.potential.mount(); own != nullptr) {
    add(own);
    return cameras;
  }
  for (const Coupling& other : scenario.team.couplings())
    if (other.between.first == coupling.between.first && other.between.second == coupling.between.second &&
        other.term.potential.mount() != nullptr)
      add(other.term.potential.mount());
  if (cameras.empty()) add(nullptr);
  return cameras;
}

}  // namespace

std::optional<SensorMount> read_mount(const TomlTable& agent) {
  return agent.has("sensor") ? std::optional(read_mounting(agent.table("sensor"))) : std::nullopt;
}

std::vector<NamedSensor> read_sensors(const TomlTable& agent) {
  constexpr std::string_view key = "sigmas";
  constexpr std::array<std::string_view, 1> beside = {"camera"};
  std::vector<NamedSensor> sensors;
  for (const auto& [name, at] : agent.named_tables("sensors")) {
    sensors.push_back({name, read_mounting(at, beside)});
    // A robot knows the uncertainty of one view, that of its last sighting.
    if (sensors.back().mount.sigmas > 0)
      at.throw_invalid(key, fmt::format("0 of a further sensor, [{}.sensor] may have it", agent.path()));
  }
  return sensors;
}

void read_sight(const TomlTable& at, BodyId body, const Observer& sensors, ScenarioSpec& scenario) {
  CameraOptions& vision = scenario.vision;
  if (at.has("camera")) {
    const TomlTable camera = at.table("camera");
    if (!sensors.mount)
      at.throw_invalid("camera", fmt::format("a robot with a mounting for it, [{}.sensor]", at.path()));
    read_one_camera(camera, body, {"", *sensors.mount}, scenario);
  }
  for (const NamedSensor& sensor : sensors.sensors) {
    const TomlTable mounted = at.table("sensors").table(sensor.name);
    if (!mounted.has("camera")) continue;
    read_one_camera(mounted.table("camera"), body, sensor, scenario);
    const RobotCamera &first = *vision.camera_of(body), &last = vision.cameras.back();
    if (&first != &last) check_beside_first(mounted, first, last);
  }
  if (at.has("tags")) {
    const TomlTable table = at.table("tags");
    const Tags tags = read_part<Tags>(TableSource(table), std::array<std::string_view, 1>{"frames"});
    vision.tag_frames.push_back(read_tag_frames(table, tags, vision));
    vision.tags.push_back({body, tags});
  }
  if (at.has("hull")) vision.hulls.push_back({body, read_part<Hull>(TableSource(at.table("hull")))});
}

CameraOptions camera_options(const ScenarioSpec& scenario) {
  CameraOptions options = scenario.vision;
  options.seed = scenario.simulation.seed;
  for (const RobotVehicle& one : scenario.vehicles) {
    const auto is_its = [&](const BodyHull& hull) { return hull.body == one.robot; };
    if (std::none_of(options.hulls.begin(), options.hulls.end(), is_its))
      options.hulls.push_back({one.robot, {.radius = one.vehicle.radius, .height = one.vehicle.height}});
  }
  return options;
}

bool renders_pictures(const CameraOptions& options) {
  const auto renders = [](const RobotCamera& one) { return one.render; };
  return !options.tags.empty() && std::any_of(options.cameras.begin(), options.cameras.end(), renders);
}

std::vector<TagReading> tag_readings(const ScenarioSpec& scenario) {
  constexpr double half_found = SyntheticDetections::half_found;
  std::vector<TagReading> all;
  for (const Coupling& coupling : scenario.team.couplings()) {
    const BodyTags* const tags = scenario.vision.tags_of(coupling.between.second);
    if (tags == nullptr) continue;
    const double between_faces = tags->tags.faces >= 3 ? std::numbers::pi / tags->tags.faces : 0.0;
    const auto add = [&](std::string_view key, const std::optional<double>& distance) {
      if (!distance) return;
      for (const RobotCamera* const camera : cameras_of(scenario, coupling)) {
        const auto same = [&](const TagReading& one) {
          return one.camera == camera && one.target == tags->body && one.distance == *distance;
        };
        if (std::any_of(all.begin(), all.end(), same)) continue;
        all.push_back({camera, tags->body, std::string(key), *distance,
                       camera->camera.pixels(tags->tags.size, *distance), half_found,
                       half_found / SyntheticDetections::readable(cos(between_faces))});
      }
    };
    add("d_min", coupling.term.potential.d_min());
    add("d_max", coupling.term.potential.d_max());
  }
  return all;
}

std::string camera_name(const RobotCamera& camera, const Team& team) {
  return fmt::format("{}{}{}", team.name(camera.observer), camera.sensor.empty() ? "" : " ", camera.sensor);
}

std::string camera_words(const ScenarioSpec& scenario) {
  const Team& team = scenario.team;
  std::string text;
  for (const RobotCamera& one : scenario.vision.cameras) {
    const Camera& c = one.camera;
    fmt::format_to(std::back_inserter(text),
                   "camera      {}: {} x {} px, focal length {:.1f} px{}, {} Hz, latency {} to {} s, {}{}\n",
                   camera_name(one, team), c.width, c.height, c.focal(), lens_words(c), c.rate, c.latency[0],
                   c.latency[1], one.render ? "rendered" : "detections drawn by their noise",
                   c.correlation_time > 0 ? fmt::format(", correlated over {} s", c.correlation_time) : "");
  }
  for (const BodyTags& one : scenario.vision.tags)
    fmt::format_to(std::back_inserter(text), "tags        {}: {} faces of {}, {} m\n", team.name(one.body),
                   one.tags.faces, tag_families[static_cast<std::size_t>(one.tags.family)], one.tags.size);
  for (const BodyHull& one : scenario.vision.hulls)
    fmt::format_to(
        std::back_inserter(text), "hull        {}: {} of {} m\n", team.name(one.body),
        one.hull.height > 0 ? fmt::format("cylinder of {} m, radius", one.hull.height) : "sphere, radius",
        one.hull.radius);
  for (const TagReading& one : tag_readings(scenario))
    fmt::format_to(std::back_inserter(text), "pixels      {} sees a tag of {} with {:.1f} px at {} = {} m\n",
                   camera_name(*one.camera, team), team.name(one.target), one.pixels, one.key, one.distance);
  return text;
}

}  // namespace sightline
