#include "sightline/import/read_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <system_error>

#include "sightline/base/nearest.hpp"
#include "sightline/import/kinds.hpp"
#include "sightline/import/yaml_value.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/readers/recorded_motion.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr Range of_rig_place = {-1e5, 1e5, "-1e5 to 1e5 m"}, of_rig_turn = {-100, 100, "-100 to 100 rad"};
constexpr Range of_rig_tag = {1e-3, 10, "0.001 to 10 m"};
constexpr Range of_rig_place_sigma = {0, 1e4, "0 to 1e4 m"}, of_rig_turn_sigma = {0, 1e4, "0 to 1e4 rad"};
constexpr std::int64_t id_max = 1'000'000;
constexpr std::size_t tags_max = 500;  // of sightings: the filter's time grows with their cube
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

void read_remaps(const YamlValue& document, RigBodies& all) {
  const auto list = document.find("tag_id_remap");
  if (!list) return;
  for (const YamlValue& one : list->items("a list of numbers of tags with their remaps")) {
    const auto id = static_cast<int>(one.at("id", "the number of the tag").integer(0, id_max));
    for (const YamlValue& to : one.at("remaps", "a list of remaps").items("a list of remaps")) {
      if (const auto camera = to.find("camera")) camera->throw_invalid("a remap of all cameras");
      const auto number = to.at("remap_id", "the other number").integer(0, id_max);
      const double start = to.at("start_time", "a time in s").number({-1e10, 1e10, "a time in s"});
      const double end = to.at("end_time", "a time in s").number({-1e10, 1e10, "a time in s"});
      all.remaps.push_back({id, static_cast<int>(number), start, end});
    }
  }
}

RigBodies read_bodies(const YamlValue& document) {
  RigBodies all;
  const auto general = document.find("default_body");
  const std::string of_unlisted = general ? general->text("the name of a body") : "";
  std::vector<std::string> names;
  std::vector<YamlValue> fixed;
  const YamlValue bodies = document.at("bodies", "a list of bodies");
  for (const YamlValue& item : bodies.items("a list of bodies")) {
    for (const auto& [name, body] : item.entries("a body by its name")) {
      if (!is_robot_name(name)) body.throw_invalid("a body with a name of letters, digits, _ and -");
      names.push_back(name);
      if (const auto type = body.find("type"); type && type->text("simple") != "simple")
        type->throw_invalid("simple");
      if (const auto list = body.find("ignore_tags"))
        for (const YamlValue& id : list->items("a list of numbers of tags"))
          all.ignored.insert(static_cast<int>(id.integer(0, id_max)));
      if (body.at("is_static", "true or false").boolean()) {
        fixed.push_back(body);
        read_static_body(body, all);
        if (const auto size = body.find("default_tag_size"); size && name == of_unlisted)
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
  if (all.recording.name.empty()) bodies.throw_invalid("a body that moves, is_static: false");
  const std::vector<std::string_view> known(names.begin(), names.end());
  if (general && std::find(names.begin(), names.end(), of_unlisted) == names.end())
    general->throw_invalid("a body" + hint(of_unlisted, known));
  // A body alone may be the frame of the places itself.
  if (fixed.size() > 1)
    for (const YamlValue& body : fixed) (void)body.at("pose", "its pose, as there is another static body");
  if (const auto noise = document.find_path({"tagslam_parameters", "pixel_noise"}))
    all.recording.corner_noise = noise->number({0.01, 100, "0.01 to 100 px"});
  const auto& tags = all.recording.tags;
  if (std::none_of(tags.begin(), tags.end(), [](const RigRecording::Tag& tag) { return tag.known; }))
    bodies.throw_invalid("a tag with a pose on a body that does not move");
  if (const auto squash = document.find("squash")) squash->throw_invalid("a file without this key");
  read_remaps(document, all);
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
  if (recording.cameras.empty()) (void)cameras.at("cam0", "a camera");
}

RigRows read_rows(const fs::path& file) { return parse_rig_rows(file.native(), read_packed_file(file)); }

auto camera_of(const RigRows::TagRow& row, const RigRecording& recording) {
  return std::find_if(recording.cameras.begin(), recording.cameras.end(),
                      [&](const RigRecording::RigCamera& one) { return one.topic == row.topic; });
}

void add_sighting(const RigRows::TagRow& row, RigBodies& all) {
  RigRecording& recording = all.recording;
  const auto camera = camera_of(row, recording);
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

void add_sightings(const std::string& file, const std::vector<RigRows::TagRow>& rows, RigBodies& all) {
  RigRecording& recording = all.recording;
  for (const RigRows::TagRow& row : rows) add_sighting(row, all);
  if (recording.sightings.empty()) {
    const auto seen = std::find_if(rows.begin(), rows.end(), [&](const RigRows::TagRow& row) {
      return camera_of(row, recording) != recording.cameras.end();
    });
    if (seen == rows.end())
      throw std::invalid_argument(
          fmt::format("{}: no row of a tag by a camera of the rig, expected tag,{},...", file,
                      recording.cameras.front().topic));
    throw std::invalid_argument(fmt::format(
        "{}: every row by a camera of the rig is of an unknown or ignored tag, the first has id = {}, "
        "expected tags of a static body",
        file, seen->id));
  }
  std::set<std::size_t> tags;
  for (const RigRecording::Sighting& one : recording.sightings) tags.insert(one.tag);
  if (tags.size() > tags_max)
    throw std::invalid_argument(
        fmt::format("{}: sightings of {} tags, expected at most {}", file, tags.size(), tags_max));
  sort_by_time(recording.sightings);
}

void add_odometry(const std::string& file, const std::vector<RigRows::PoseRow>& rows, RigBodies& all) {
  if (all.odometry_topic.empty()) return;
  const RigidPose to_odometry = inverse(all.odometry_frame);
  std::set<std::string> topics;
  for (const RigRows::PoseRow& row : rows) {
    topics.insert(one_line(shortened(row.topic, name_size_max)));
    if (row.topic == all.odometry_topic)
      all.recording.odometry.push_back({row.at.t, row.at.pose * to_odometry});
  }
  if (all.recording.odometry.empty()) {
    const std::vector<std::string_view> known(topics.begin(), topics.end());
    throw std::invalid_argument(fmt::format("{}: no row of odometry by odom_topic = {}, expected one{}", file,
                                            all.odometry_topic, hint(all.odometry_topic, known)));
  }
  sort_by_time(all.recording.odometry);
}

/// Poses beyond the sightings and the odometry are left out: an estimate there would be a guess.
void add_reference(const std::string& file, const std::vector<RigRows::PoseRow>& rows,
                   RigRecording& recording) {
  std::vector<RigRecording::TimedPose> all;
  for (const RigRows::PoseRow& row : rows) all.push_back(row.at);
  sort_by_time(all);
  const double first = recording.sightings.front().t, last = recording.sightings.back().t;
  if (!all.empty() && std::none_of(all.begin(), all.end(), [&](const RigRecording::TimedPose& one) {
        return one.t >= first && one.t <= last;
      }))
    throw std::invalid_argument(
        fmt::format("{}: t = {:.3f} to {:.3f} s, expected times of the sightings, {:.3f} to {:.3f} s", file,
                    all.front().t, all.back().t, first, last));
  std::copy_if(
      all.begin(), all.end(), std::back_inserter(recording.reference),
      [&](const RigRecording::TimedPose& one) { return one.t >= recording.start && one.t <= recording.end; });
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
  add_sightings(detections.native(), rows.tags, all);
  add_odometry(detections.native(), rows.poses, all);
  recording.start = recording.sightings.front().t, recording.end = recording.sightings.back().t;
  if (!recording.odometry.empty()) recording.end = std::max(recording.end, recording.odometry.back().t);
  std::error_code none;
  if (const fs::path file = file_of(place, "reference.csv"); fs::exists(file, none))
    add_reference(file.native(), read_rows(file).poses, recording);
  return std::move(all.recording);
}

}  // namespace sightline
