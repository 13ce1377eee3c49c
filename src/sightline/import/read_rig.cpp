#include "sightline/import/read_rig.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>
#include <tuple>

#include "sightline/base/nearest.hpp"
#include "sightline/import/kinds.hpp"
#include "sightline/import/yaml_value.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/readers/recorded_motion.hpp"
#include "sightline/readers/ros_bag.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr Range of_rig_place = {-1e5, 1e5, "-1e5 to 1e5 m"}, of_rig_turn = {-100, 100, "-100 to 100 rad"};
constexpr Range of_rig_tag = {1e-3, 10, "0.001 to 10 m"};
constexpr Range of_rig_place_sigma = {0, 1e4, "0 to 1e4 m"}, of_rig_turn_sigma = {0, 1e4, "0 to 1e4 rad"};
constexpr std::int64_t id_max = rig_tag_id_max;
constexpr std::size_t tags_max = 500;  // of sightings: the filter's time grows with their cube
// Deviations below these are those of rounding: the filter would hold them for exact.
constexpr double least_place_sigma = 1e-4, least_turn_sigma = 1e-4;  // [m], [rad]

constexpr std::string_view of_bags = ".mcap";

/// The path of a file of a recording, packed or not.
fs::path file_of(const fs::path& place, std::string_view name) {
  std::error_code none;
  const bool folder = fs::is_directory(place, none);
  const fs::path prefix = place.extension() == of_bags ? fs::path(place).replace_extension() : place;
  fs::path file = folder ? place / name : fs::path(prefix.native() + "_" + std::string(name));
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
  std::string imu_topic{};
  std::optional<RigidPose> imu_frame{};  ///< in B; empty: /tf_static has it
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
      if (const auto topic = body.find("imu_topic")) {
        all.imu_topic = topic->text("the topic of its IMU in a bag");
        if (const auto pose = body.find("T_body_imu")) all.imu_frame = read_pose(*pose);
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

bool has_file(const fs::path& place, std::string_view name) {
  std::error_code none;
  return fs::exists(file_of(place, name), none);
}

/// The bag of a recording; empty if it has none, or a table instead.
fs::path bag_of(const fs::path& place) {
  std::error_code none;
  const bool folder = fs::is_directory(place, none), named = !folder && place.extension() == of_bags;
  if (named || has_file(place, "tag_detections.csv")) return named ? place : fs::path();
  fs::path bag = folder ? place : fs::path(place.native() + std::string(of_bags));
  if (!folder) return fs::exists(bag, none) ? bag : fs::path();
  for (fs::directory_iterator one(place, none), end; !none && one != end; one.increment(none))
    if (one->path().extension() == of_bags || one->path().filename() == "metadata.yaml") return bag;
  return {};
}

/// The pose of a frame of a bag in the body that moves.
RigidPose mounting_of(const std::string& file, const std::string& frame, const BagRig& bag,
                      const RigBodies& all, std::string_view expected) {
  if (const auto on_body = bag.pose_in(all.recording.name, frame)) return *on_body;
  const auto odometry = bag.frames.find(all.odometry_topic);
  if (odometry != bag.frames.end())
    if (const auto on_odometry = bag.pose_in(odometry->second, frame))
      return all.odometry_frame * *on_odometry;
  throw std::invalid_argument(
      fmt::format("{}: {} is mounted neither on {} nor on the frame of odom_topic, expected {}", file,
                  one_line(shortened(frame, name_size_max)), all.recording.name, expected));
}

/// The calibration of a frame, in which a topic has tags.
BagCamera calibration_in(const std::string& file, const std::vector<BagCamera>& calibrated,
                         const std::string& frame, const std::string& topic) {
  const BagCamera* found = nullptr;
  for (const BagCamera& one : calibrated) {
    if (one.frame != frame) continue;
    const auto numbers = [](const BagCamera& of) {
      return std::tie(of.width, of.height, of.distortion_model, of.D, of.K, of.R, of.P);
    };
    if (found != nullptr && numbers(*found) != numbers(one))
      throw std::invalid_argument(
          fmt::format("{}: {} and {} differ, expected one calibration of the frame {}, or cameras.yaml", file,
                      found->topic, one.topic, one_line(shortened(frame, name_size_max))));
    if (found == nullptr) found = &one;
  }
  if (found == nullptr)
    throw std::invalid_argument(fmt::format(
        "{}: no CameraInfo of the frame {}, in which {} has tags, expected one, or cameras.yaml", file,
        one_line(shortened(frame, name_size_max)), one_line(shortened(topic, name_size_max))));
  return *found;
}

/// The attitude of a raw picture's optical frame in that of the rectified one, to which the frame of a
/// CameraInfo belongs: the matrix R, all 0 if there is no other.
Rotation raw_attitude(const std::string& file, const BagCamera& camera) {
  constexpr double rounding = 1e-4, turn_min = 1e-6;  // of files with 5 digits; [rad]
  const auto& r = camera.R;
  if (std::all_of(r.begin(), r.end(), [](double one) { return one == 0; })) return {};
  const Rotation R = {{r[0], r[3], r[6]}, {r[1], r[4], r[7]}, {r[2], r[5], r[8]}};
  if (!(std::abs(norm(R.x) - 1) < rounding && std::abs(norm(R.y) - 1) < rounding &&
        norm(cross(R.x, R.y) - R.z) < rounding && norm(cross(R.y, R.z) - R.x) < rounding))
    throw std::invalid_argument(fmt::format("{}: {}: R = [{}], expected a rotation, or cameras.yaml", file,
                                            camera.topic, fmt::join(r, ", ")));
  const Vec3<double> turn = rotation_vector(R);
  return norm(turn) < turn_min ? Rotation() : turn_by(turn);
}

/// The cameras of a bag whose pictures have tags.
void read_cameras(const fs::path& place, const BagRig& bag, std::string_view pixels, RigBodies& all) {
  const std::string& file = place.native();
  std::set<std::string> topics;
  for (const RigRows::TagRow& row : bag.rows.tags) topics.insert(row.topic);
  std::map<std::string, std::string> topic_of_frame;
  for (const std::string& topic : topics) {
    const std::string& frame = bag.frames.find(topic)->second;
    const std::string shown = one_line(shortened(frame, name_size_max));
    if (const auto [other, is_new] = topic_of_frame.try_emplace(frame, topic); !is_new)
      throw std::invalid_argument(
          fmt::format("{}: {} and {} have tags in the frame {}, expected a frame for each, or cameras.yaml",
                      file, one_line(shortened(other->second, name_size_max)),
                      one_line(shortened(topic, name_size_max)), shown));
    BagCamera camera = calibration_in(file, bag.cameras, frame, topic);
    const Rotation raw = raw_attitude(file, camera);
    const std::array<double, 9> rectified = {camera.P[0], camera.P[1], camera.P[2], camera.P[4], camera.P[5],
                                             camera.P[6], camera.P[8], camera.P[9], camera.P[10]};
    // By P the frame is that of the other camera, by many drivers it is this camera's own.
    if (camera.P[3] != 0 || camera.P[7] != 0)
      throw std::invalid_argument(fmt::format(
          "{}: {}: P is of the second camera of a pair, expected cameras.yaml", file, camera.topic));
    const bool distorted = std::any_of(camera.D.begin(), camera.D.end(), [](double d) { return d != 0; });
    const bool turned = norm(rotation_vector(raw)) > 0;
    const bool differ =
        rectified != std::array<double, 9>{} && (distorted || turned || rectified != camera.K);
    if (differ && pixels.empty())
      throw std::invalid_argument(fmt::format(
          "{}: {} has a rectified picture of its own, expected --pixels raw or rectified: in which "
          "one the tags were found, apriltag_ros takes image_rect",
          file, camera.topic));
    RigidPose mounting =
        mounting_of(file, frame, bag, all, "/tf_static, or cameras.yaml and camera_poses.yaml");
    if (pixels == "rectified") {
      if (!differ && (distorted || turned))
        throw std::invalid_argument(
            fmt::format("{}: --pixels = rectified, expected raw: {} has no matrix P", file, camera.topic));
      if (differ) camera.K = rectified, camera.D.clear(), camera.distortion_model.clear();
    } else {
      mounting.R = compose(mounting.R, raw);
    }
    all.recording.cameras.push_back({.name = shown,
                                     .topic = topic,
                                     .camera = ros_camera(calibration_of(file, camera)),
                                     .mounting = mounting});
  }
  if (topics.empty())
    throw std::invalid_argument(
        fmt::format("{}: no apriltag_msgs/AprilTagDetectionArray with a tag, expected some", file));
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
      throw std::invalid_argument(fmt::format("{}: no tag by a camera of the rig, expected some of {}", file,
                                              recording.cameras.front().topic));
    throw std::invalid_argument(fmt::format(
        "{}: every tag by a camera of the rig is an unknown or ignored tag, the first has id = {}, "
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

void add_odometry(const std::string& file, const BagRig& bag, RigBodies& all) {
  if (all.odometry_topic.empty()) return;
  const RigidPose to_odometry = inverse(all.odometry_frame);
  std::set<std::string> topics;
  for (const std::string& topic : bag.odometries) topics.insert(one_line(shortened(topic, name_size_max)));
  for (const RigRows::PoseRow& row : bag.rows.poses) {
    topics.insert(one_line(shortened(row.topic, name_size_max)));
    if (row.topic == all.odometry_topic)
      all.recording.odometry.push_back({row.at.t, row.at.pose * to_odometry});
  }
  if (all.recording.odometry.empty()) {
    const std::vector<std::string_view> known(topics.begin(), topics.end());
    throw std::invalid_argument(fmt::format("{}: no odometry by odom_topic = {}, expected some{}", file,
                                            all.odometry_topic, hint(all.odometry_topic, known)));
  }
  sort_by_time(all.recording.odometry);
}

/// Turn rates of the body from those of its IMU, about whose axes they are.
void add_turn_rates(const std::string& file, const BagRig& bag, RigBodies& all) {
  constexpr double gap_max = 0.5;  // [s]
  if (all.imu_topic.empty()) return;
  RigRecording& recording = all.recording;
  for (const RigRows::RateRow& row : bag.rows.rates) recording.turn_rates.push_back(row.at);
  if (recording.turn_rates.empty()) {
    std::vector<std::string> topics;
    for (const std::string& topic : bag.imus)
      if (topic != all.imu_topic) topics.push_back(one_line(shortened(topic, name_size_max)));
    const std::vector<std::string_view> known(topics.begin(), topics.end());
    throw std::invalid_argument(
        fmt::format("{}: no turn rate of a sensor_msgs/Imu by imu_topic = {}, expected some{}", file,
                    all.imu_topic, known.empty() ? "" : hint(all.imu_topic, known)));
  }
  const Rotation R = all.imu_frame ? all.imu_frame->R
                                   : mounting_of(file, bag.frames.find(all.imu_topic)->second, bag, all,
                                                 "/tf_static, or T_body_imu")
                                         .R;
  std::vector<RigRecording::TurnRate>& rates = recording.turn_rates;
  sort_by_time(rates);
  const auto same = [](const RigRecording::TurnRate& a, const RigRecording::TurnRate& b) {
    return a.t == b.t;
  };
  rates.erase(std::unique(rates.begin(), rates.end(), same), rates.end());
  double last = recording.start;
  const auto check = [&](double t) {
    if (std::min(t, recording.end) - last > gap_max)
      throw std::invalid_argument(fmt::format(
          "{}: no turn rate by imu_topic = {} from {:.3f} s for {:.1f} s, expected gaps of at most "
          "{} s while the rig moves",
          file, all.imu_topic, last, std::min(t, recording.end) - last, gap_max));
    last = std::max(last, t);
  };
  for (RigRecording::TurnRate& one : rates) {
    one.omega = R.to_G(one.omega);
    check(one.t);
  }
  check(recording.end);
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

RigRecording read_rig_recording(const fs::path& place, std::string_view pixels) {
  RigBodies all = read_bodies(read_yaml(place, "tagslam.yaml"));
  RigRecording& recording = all.recording;
  const fs::path bag = bag_of(place);
  const bool has_cameras = bag.empty() || has_file(place, "cameras.yaml");
  if (has_cameras) read_cameras(place, recording);
  if (!pixels.empty() && (has_cameras || (pixels != "raw" && pixels != "rectified")))
    throw std::invalid_argument(
        fmt::format("--pixels = {}, expected {}", pixels,
                    has_cameras ? "none: cameras.yaml is of raw pictures" : "raw or rectified"));
  const fs::path detections = bag.empty() ? file_of(place, "tag_detections.csv") : bag;
  BagRig rig;
  if (bag.empty()) {
    rig.rows = read_rows(detections);
  } else {
    rig = RosBag(bag).rig(all.odometry_topic, all.imu_topic, !has_cameras);
    if (!has_cameras) read_cameras(bag, rig, pixels, all);
  }
  add_sightings(detections.native(), rig.rows.tags, all);
  add_odometry(detections.native(), rig, all);
  recording.start = recording.sightings.front().t, recording.end = recording.sightings.back().t;
  if (!recording.odometry.empty()) recording.end = std::max(recording.end, recording.odometry.back().t);
  add_turn_rates(detections.native(), rig, all);
  if (has_file(place, "reference.csv")) {
    const fs::path file = file_of(place, "reference.csv");
    add_reference(file.native(), read_rows(file).poses, recording);
  }
  return std::move(all.recording);
}

}  // namespace sightline
