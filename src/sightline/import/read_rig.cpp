#include "sightline/import/read_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <system_error>

#include "sightline/import/kinds.hpp"
#include "sightline/import/yaml_value.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr Range of_rig_place = {-1e5, 1e5, "-1e5 to 1e5 m"}, of_rig_turn = {-100, 100, "-100 to 100 rad"};
constexpr Range of_rig_tag = {1e-3, 10, "0.001 to 10 m"};
constexpr Range of_rig_place_sigma = {0, 1e4, "0 to 1e4 m"}, of_rig_turn_sigma = {0, 1e4, "0 to 1e4 rad"};
constexpr std::int64_t id_max = 1'000'000;
// Deviations below these are those of rounding: the filter would hold them for exact.
constexpr double least_place_sigma = 1e-4, least_turn_sigma = 1e-4;  // [m], [rad]

/// The path of a file of a recording, packed or not.
fs::path file_of(const fs::path& place, std::string_view name) {
  std::error_code none;
  const bool folder = fs::is_directory(place, none);
  fs::path file = folder ? place / name : fs::path(place.native() + "_" + std::string(name));
  if (fs::path packed = file.native() + ".gz"; !fs::exists(file, none) && fs::exists(packed, none))
    return packed;
  return file;
}

YamlValue read_yaml(const fs::path& place, std::string_view name) {
  const fs::path file = file_of(place, name);
  return {read_import_text(file), file.native()};
}

Vec3<double> read_vector(const YamlValue& at, const Range& range) {
  const auto axis = [&](std::string_view key) { return at.at(key, range.expected).number(range); };
  return {axis("x"), axis("y"), axis("z")};
}

/// {position: {x, y, z}, rotation: {x, y, z}}, the rotation as a vector.
RigidPose read_pose(const YamlValue& pose) {
  return {read_vector(pose.at("position", "the position x, y, z in m"), of_rig_place),
          turn_by(read_vector(pose.at("rotation", "the rotation vector x, y, z in rad"), of_rig_turn))};
}

/// The bodies of a tagslam.yaml.
struct RigBodies {
  RigRecording recording{};
  std::map<int, std::size_t> tag_of_id{};
  std::set<int> ignored{};
  double default_size = 0.0;  ///< 0: tags that no body has are left out
  std::string odometry_topic{};
  RigidPose odometry_frame{};  ///< in B
  struct Remap {
    int id, to;
    double start, end;
  };
  std::vector<Remap> remaps{};
};

void read_static_body(const YamlValue& body, RigBodies& all) {
  const auto pose = body.find("pose");
  const RigidPose of_body = pose ? read_pose(*pose) : RigidPose{};
  const auto general = body.find("default_tag_size");
  const double general_size = general ? general->number(of_rig_tag) : 0.0;
  const auto place_noise = body.find("override_tag_position_noise"),
             turn_noise = body.find("override_tag_rotation_noise");
  const auto tags = body.find("tags");
  if (!tags) return;
  for (const YamlValue& tag : tags->items("a list of tags")) {
    const YamlValue id = tag.at("id", "the number of the tag");
    RigRecording::Tag read{.id = static_cast<int>(id.integer(0, id_max))};
    const auto size = tag.find("size");
    if (!size && general_size == 0)
      (void)tag.at("size", "the side of the tag, or default_tag_size of its body");
    read.size = size ? size->number(of_rig_tag) : general_size;
    if (const auto at = tag.find("pose")) {
      read.known = true;
      read.pose = of_body * read_pose(*at);
      const auto sigma = [&](const char* key, const auto& general_noise, const Range& range, double least) {
        const auto own = at->find(key);
        Vec3<double> s{least, least, least};
        if (own) s = read_vector(*own, range);
        if (general_noise) {
          const double same = general_noise->number(range);
          s = {same, same, same};
        }
        return Vec3<double>{std::max(s.x, least), std::max(s.y, least), std::max(s.z, least)};
      };
      const Vec3<double> along = sigma("position_noise", place_noise, of_rig_place_sigma, least_place_sigma);
      // The axes of a body and of G differ by a rotation at most: the larger variance is enough.
      const bool same = along.x == along.y && along.y == along.z;
      const double most = std::max({along.x, along.y, along.z});
      read.p_sigma = same || !pose ? along : Vec3<double>{most, most, most};
      read.turn_sigma = sigma("rotation_noise", turn_noise, of_rig_turn_sigma, least_turn_sigma);
    }
    if (!all.tag_of_id.try_emplace(read.id, all.recording.tags.size()).second)
      id.throw_invalid("a number that no other tag has");
    all.recording.tags.push_back(read);
  }
}

RigBodies read_bodies(const YamlValue& document) {
  RigBodies all;
  std::string general;
  if (const auto word = document.find("default_body")) general = word->text("the name of a body");
  const YamlValue bodies = document.at("bodies", "a list of bodies");
  for (const YamlValue& item : bodies.items("a list of bodies")) {
    for (const auto& [name, body] : item.entries("a body by its name")) {
      if (const auto list = body.find("ignore_tags"))
        for (const YamlValue& id : list->items("a list of numbers of tags"))
          all.ignored.insert(static_cast<int>(id.integer(0, id_max)));
      if (body.at("is_static", "true or false").boolean()) {
        read_static_body(body, all);
        if (const auto size = body.find("default_tag_size"); size && (general.empty() || name == general))
          all.default_size = size->number(of_rig_tag);
        continue;
      }
      if (!all.recording.name.empty())
        body.throw_invalid("one body that moves, " + all.recording.name + " is another");
      all.recording.name = name;
      if (const auto tags = body.find("tags"))
        for (const YamlValue& tag : tags->items("a list of tags"))
          all.ignored.insert(static_cast<int>(tag.at("id", "the number of the tag").integer(0, id_max)));
      if (const auto topic = body.find("odom_topic")) {
        all.odometry_topic = topic->text("the topic of its odometry");
        all.odometry_frame =
            read_pose(body.at("T_body_odom", "the pose of the odometry's frame in the body"));
      }
    }
  }
  if (const auto noise = document.find_path({"tagslam_parameters", "pixel_noise"}))
    all.recording.corner_noise = noise->number({0.01, 100, "0.01 to 100 px"});
  if (all.recording.name.empty()) bodies.throw_invalid("a body that moves, is_static: false");
  const auto& tags = all.recording.tags;
  if (std::none_of(tags.begin(), tags.end(), [](const RigRecording::Tag& tag) { return tag.known; }))
    bodies.throw_invalid("a tag with a pose on a body that does not move");
  if (const auto list = document.find("tag_id_remap"))
    for (const YamlValue& one : list->items("a list of numbers of tags with their remaps")) {
      const auto id = static_cast<int>(one.at("id", "the number of the tag").integer(0, id_max));
      for (const YamlValue& to : one.at("remaps", "a list of remaps").items("a list of remaps")) {
        const auto number = to.at("remap_id", "the other number").integer(0, id_max);
        const double start = to.at("start_time", "a time in s").number({-1e10, 1e10, "a time in s"});
        const double end = to.at("end_time", "a time in s").number({-1e10, 1e10, "a time in s"});
        all.remaps.push_back({id, static_cast<int>(number), start, end});
      }
    }
  return all;
}

void read_cameras(const fs::path& place, RigRecording& recording) {
  const YamlValue cameras = read_yaml(place, "cameras.yaml"), poses = read_yaml(place, "camera_poses.yaml");
  for (const auto& [name, camera] : cameras.entries("the cameras by their names, cam0")) {
    if (const auto body = camera.find("rig_body"))
      if (body->text("the body that moves") != recording.name)
        body->throw_invalid(recording.name + ", the body that moves");
    const auto topic = camera.find("tagtopic");
    recording.cameras.push_back(
        {.name = name,
         .topic =
             topic ? topic->text("the topic of its tags") : camera.at("rostopic", "a topic").text("a topic"),
         .camera = kalibr_camera(camera),
         .mounting = read_pose(poses.at(name, "the pose of this camera on the body")
                                   .at("pose", "the position and the rotation vector"))});
  }
}

template <class Timed>
void sort_by_time(std::vector<Timed>& list) {
  std::stable_sort(list.begin(), list.end(), [](const Timed& a, const Timed& b) { return a.t < b.t; });
}

RigRows read_rows(const fs::path& file) { return parse_rig_rows(file.native(), read_packed_file(file)); }

void add_sighting(const RigRows::TagRow& row, RigBodies& all) {
  RigRecording& recording = all.recording;
  const auto camera =
      std::find_if(recording.cameras.begin(), recording.cameras.end(),
                   [&](const RigRecording::RigCamera& one) { return one.topic == row.topic; });
  int id = row.id;
  for (const RigBodies::Remap& one : all.remaps)
    if (one.id == row.id && row.t >= one.start && row.t <= one.end) id = one.to;
  auto tag = all.tag_of_id.find(id);
  const bool of_default = tag == all.tag_of_id.end() && all.default_size > 0;
  if (camera == recording.cameras.end() || all.ignored.count(id) > 0 ||
      (tag == all.tag_of_id.end() && !of_default)) {
    ++recording.left_out;
    return;
  }
  if (of_default) {
    tag = all.tag_of_id.emplace(id, recording.tags.size()).first;
    recording.tags.push_back({.id = id, .size = all.default_size});
  }
  recording.sightings.push_back({.t = row.t,
                                 .camera = static_cast<std::size_t>(camera - recording.cameras.begin()),
                                 .tag = tag->second,
                                 .corners = row.corners});
}

}  // namespace

bool is_rig_recording(const fs::path& place) {
  std::error_code none;
  return fs::is_regular_file(file_of(place, "tagslam.yaml"), none);
}

RigRecording read_rig_recording(const fs::path& place) {
  RigBodies all = read_bodies(read_yaml(place, "tagslam.yaml"));
  RigRecording& recording = all.recording;
  read_cameras(place, recording);
  const fs::path detections = file_of(place, "tag_detections.csv");
  const RigRows rows = read_rows(detections);
  for (const RigRows::TagRow& row : rows.tags) add_sighting(row, all);
  if (recording.sightings.empty())
    throw std::invalid_argument(fmt::format("{}: no row of a tag by a camera of the rig, expected tag,{},...",
                                            detections.native(), recording.cameras.front().topic));
  const RigidPose to_odometry = inverse(all.odometry_frame);
  for (const RigRows::PoseRow& row : rows.poses)
    if (row.topic == all.odometry_topic) recording.odometry.push_back({row.at.t, row.at.pose * to_odometry});
  std::error_code none;
  if (const fs::path file = file_of(place, "reference.csv"); fs::exists(file, none)) {
    for (const RigRows::PoseRow& row : read_rows(file).poses) recording.reference.push_back(row.at);
    sort_by_time(recording.reference);
  }
  sort_by_time(recording.sightings);
  sort_by_time(recording.odometry);
  recording.start = recording.sightings.front().t, recording.end = recording.sightings.back().t;
  for (const auto* list : {&recording.odometry, &recording.reference})
    if (!list->empty()) recording.end = std::max(recording.end, list->back().t);
  return std::move(all.recording);
}

}  // namespace sightline
