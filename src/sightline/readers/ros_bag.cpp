#include "sightline/readers/ros_bag.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "sightline/base/now.hpp"
#include "sightline/mcap.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/world.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr double slope_reach = 0.05;                    // [s]
constexpr double disorder_max = 0.05;                   // part of the samples of a body that are left out
constexpr double place_max = 1e5, turn_rate_max = 1e3;  // of a rig [m], [rad/s]
constexpr std::size_t bodies_max = 4096, topic_shown = 80, name_max = 1024, coefficients_max = 64;
constexpr std::size_t transform_bytes = 8 + 5 + 5 + 7 * sizeof(double);  // header, child, transform, at least
constexpr std::string_view pose_type = "geometry_msgs/msg/PoseStamped",
                           uncertain_pose_type = "geometry_msgs/msg/PoseWithCovarianceStamped",
                           transform_type = "geometry_msgs/msg/TransformStamped",
                           odometry_type = "nav_msgs/msg/Odometry", tf_type = "tf2_msgs/msg/TFMessage",
                           named_type = "motion_capture_tracking_interfaces/msg/NamedPoseArray",
                           stamped_twist_type = "geometry_msgs/msg/TwistStamped",
                           twist_type = "geometry_msgs/msg/Twist", camera_type = "sensor_msgs/msg/CameraInfo",
                           tags_type = "apriltag_msgs/msg/AprilTagDetectionArray",
                           imu_type = "sensor_msgs/msg/Imu";

/// A sample of one body; `name` is empty where the topic has one body.
struct NamedSample {
  std::string_view name;
  RecordedSample sample;
};

class MessageDecoder {
 public:
  explicit MessageDecoder(const McapMessage& message) : from_(message.bytes) {}

  /// Time of the header [s]; 0 where it has none.
  double header() {
    const auto seconds = from_.number<std::int32_t>();
    const auto nanoseconds = from_.number<std::uint32_t>();
    frame_ = name();
    return seconds + to_seconds(nanoseconds);
  }
  /// @param most  of a sound message; what is not finite is unknown
  Vec3<double> vector(double most = infinity) {
    const auto x = from_.number<double>(), y = from_.number<double>(), z = from_.number<double>();
    for (const double one : {x, y, z}) fits_ = fits_ && !(std::isfinite(one) && std::abs(one) > most);
    return {x, y, z};
  }
  std::optional<Rotation> attitude() {
    const Vec3<double> axis = vector();
    return recorded_attitude({from_.number<double>(), axis.x, axis.y, axis.z});
  }
  RecordedSample pose(double t) {
    RecordedSample sample{.t = t, .p = vector()};
    return with_heading(sample, attitude());
  }
  static RecordedSample with_heading(RecordedSample sample, const std::optional<Rotation>& R) {
    if (!R) return sample;
    const Vec2<double> d = heading(*R);
    sample.heading = std::atan2(d.y, d.x);
    return sample;
  }
  /// The frame of the last header, as tf2 names it.
  std::string frame() const { return frame_name(frame_); }
  static std::string frame_name(std::string_view frame) {
    return std::string(frame.substr(frame.starts_with('/') ? 1 : 0));
  }
  /// A name, of a length that memory for all of them bears.
  std::string_view name() {
    const std::string_view text = from_.string();
    fits_ = fits_ && text.size() <= name_max;
    return text;
  }
  bool ok() const { return fits_ && from_.ok(); }
  CdrDecoder& from() { return from_; }

 private:
  CdrDecoder from_;
  std::string_view frame_;
  bool fits_ = true;
};

/// The samples of a body, or the commands of a topic, as they were recorded. One whose `value` is not
/// finite is left out.
template <auto value, class Sample>
class Timed {
 public:
  void add(const Sample& sample, const McapMessage& message) {
    const Vec3<double>& v = sample.*value;
    if (!std::isfinite(v.x + v.y + v.z)) return;
    all_.push_back(sample);
    recorded_.push_back(to_seconds(message.log_time));
    stamped_ = stamped_ || sample.t != 0;
  }
  /// Passes those on whose times rise. Times are those of the recording if all headers are 0: in
  /// simulated time one header is 0 as well.
  /// @throws std::invalid_argument if that leaves more than disorder_max of them out
  template <class Take>
  void each(const std::string& place, std::string_view name, Take&& take) {
    std::size_t late = 0;
    const Sample* last = nullptr;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (!stamped_) all_[i].t = recorded_[i];
      if (last == nullptr || all_[i].t > last->t) {
        last = &all_[i];
        take(*last);
      } else if (all_[i].t < last->t || norm(all_[i].*value - last->*value) > 0) {
        ++late;  // and is no repetition
      }
    }
    if (static_cast<double>(late) > disorder_max * static_cast<double>(all_.size()))
      throw_invalid("{}: {} of {} messages of {} are not later than those before, expected at most {:.0f} %",
                    place, late, all_.size(), one_line(shortened(name, topic_shown)), 100 * disorder_max);
  }

 private:
  std::vector<Sample> all_;
  std::vector<double> recorded_;  // [s]
  bool stamped_ = false;
};

/// The samples of a message; empty if it is of no such type, or is damaged.
std::optional<std::vector<NamedSample>> samples_in(const McapMessage& message) {
  MessageDecoder read(message);
  std::vector<NamedSample> samples;
  if (message.schema == pose_type || message.schema == uncertain_pose_type) {
    samples.push_back({"", read.pose(read.header())});
  } else if (message.schema == transform_type) {
    const double t = read.header();
    const std::string_view child = read.name();
    samples.push_back({child, read.pose(t)});
  } else if (message.schema == odometry_type) {
    RecordedSample sample{.t = read.header()};
    read.from().string();  // frame of the body, which has the velocity
    sample.p = read.vector();
    const std::optional<Rotation> R = read.attitude();
    for (int i = 0; i < 36; ++i) read.from().number<double>();  // covariance
    const Vec3<double> v = read.vector();
    if (R) sample.v = R->to_G(v);
    samples.push_back({"", MessageDecoder::with_heading(sample, R)});
  } else if (message.schema == tf_type) {
    for (std::size_t left = read.from().length(transform_bytes); left > 0 && read.ok(); --left) {
      const double t = read.header();
      const std::string_view child = read.name();
      samples.push_back({child, read.pose(t)});
    }
  } else if (message.schema == named_type) {
    const double t = read.header();
    constexpr std::size_t least = 5 + 7 * sizeof(double);  // name and pose [bytes]
    for (std::size_t left = read.from().length(least); left > 0 && read.ok(); --left) {
      const std::string_view name = read.name();
      samples.push_back({name, read.pose(t)});
    }
  }
  if (!read.ok()) return {};
  return samples;
}

std::optional<VelocityCommand> command_in(const McapMessage& message) {
  MessageDecoder read(message);
  VelocityCommand command;
  if (message.schema == stamped_twist_type) command.t = read.header();
  command.v = read.vector();
  command.yaw_rate = read.vector().z;
  if (!read.ok()) return {};
  return command;
}

bool is_command(const McapMessage& message) {
  return message.schema == stamped_twist_type || message.schema == twist_type;
}

/// Takes the matrices of a whole picture for one whose first pixel is at (x, y) of it, and whose pixels are
/// (b_x, b_y) of it wide and high.
void take_part(BagCamera& camera, const Vec2<double>& at, const Vec2<double>& b) {
  const auto scale = [&](auto& matrix, std::size_t columns) {
    if (std::all_of(matrix.begin(), matrix.end(), [](double one) { return one == 0; })) return;
    matrix[2] -= at.x, matrix[columns + 2] -= at.y;
    for (std::size_t i = 0; i < columns; ++i) matrix[i] /= b.x, matrix[columns + i] /= b.y;
  };
  scale(camera.K, 3), scale(camera.P, 4);
}

std::optional<BagCamera> camera_in(const McapMessage& message) {
  MessageDecoder read(message);
  read.header();
  BagCamera camera{.topic = one_line(message.topic), .frame = read.frame()};
  camera.height = read.from().number<std::uint32_t>();
  camera.width = read.from().number<std::uint32_t>();
  camera.distortion_model = read.name();
  camera.D.resize(read.from().length(sizeof(double)));
  for (double& d : camera.D) d = read.from().number<double>();
  for (double& k : camera.K) k = read.from().number<double>();
  for (double& r : camera.R) r = read.from().number<double>();
  for (double& p : camera.P) p = read.from().number<double>();
  const auto number = [&] { return read.from().number<std::uint32_t>(); };
  const std::uint32_t b_x = std::max(1U, number()), b_y = std::max(1U, number());
  const std::uint32_t left = number(), top = number(), height = number(), width = number();
  const bool inside =
      std::uint64_t{left} + width <= camera.width && std::uint64_t{top} + height <= camera.height;
  if (height > 0) camera.height = height;  // 0: all of them
  if (width > 0) camera.width = width;
  camera.height /= b_y, camera.width /= b_x;
  take_part(camera, {static_cast<double>(left), static_cast<double>(top)},
            {static_cast<double>(b_x), static_cast<double>(b_y)});
  if (!read.ok() || !inside || camera.D.size() > coefficients_max) return {};
  return camera;
}

/// The first CameraInfo of each topic.
class CamerasOfTopics {
 public:
  /// @return whether the message is sound, if it is the first of its topic
  bool take(const McapMessage& message) {
    if (message.schema != camera_type || found_.size() >= bodies_max || found_.contains(message.topic))
      return true;
    const auto camera = camera_in(message);
    if (camera) found_.emplace(message.topic, *camera);
    return camera.has_value();
  }
  std::vector<BagCamera> all() && {
    std::vector<BagCamera> cameras;
    for (auto& [topic, camera] : found_) cameras.push_back(std::move(camera));
    return cameras;
  }

 private:
  std::map<std::string, BagCamera, std::less<>> found_;
};

/// Adds the sightings of a message. @return whether it is sound
bool add_tags(const McapMessage& message, BagRig& rig) {
  constexpr std::size_t least = 5 + 4 * 4 + 2 * 8 + 8 * 8 + 9 * 8;  // of one detection [bytes]
  constexpr double corner_max = 1e5;                                // [px]
  MessageDecoder read(message);
  const double t = read.header();
  const std::string topic(message.topic);
  rig.frames.try_emplace(topic, read.frame());
  for (std::size_t left = read.from().length(least); left > 0 && read.ok(); --left) {
    if (const std::string_view family = read.name(); rig.families.size() < 2)
      rig.families.insert(std::string(family));
    RigRows::TagRow row{topic, t, read.from().number<std::int32_t>(), {}};
    bool sound = row.id >= 0 && row.id <= rig_tag_id_max;
    read.from().number<std::int32_t>();  // corrected bits
    for (int i = 0; i < 2; ++i) read.from().number<float>();
    for (int i = 0; i < 2; ++i) read.from().number<double>();  // centre
    for (Vec2<double>& corner : row.corners) {
      corner.x = read.from().number<double>(), corner.y = read.from().number<double>();
      sound = sound && std::abs(corner.x) <= corner_max && std::abs(corner.y) <= corner_max;
    }
    for (int i = 0; i < 9; ++i) read.from().number<double>();  // homography
    if (!sound) return false;
    rig.rows.tags.push_back(std::move(row));
  }
  return read.ok();
}

/// Adds the pose of an odometry; one without an attitude is left out. @return whether it is sound
bool add_odometry_pose(const McapMessage& message, BagRig& rig) {
  MessageDecoder read(message);
  const double t = read.header();
  const std::string child = MessageDecoder::frame_name(read.name());
  const Vec3<double> p = read.vector(place_max);
  const auto R = read.attitude();
  if (!read.ok()) return false;
  if (!R || !std::isfinite(p.x + p.y + p.z)) return true;
  const std::string topic(message.topic);
  rig.frames.try_emplace(topic, child);
  rig.rows.poses.push_back({topic, {t, {p, *R}}});
  return true;
}

/// Adds the angular velocity of an IMU; one that is unknown is left out. @return whether it is sound
bool add_turn_rate(const McapMessage& message, BagRig& rig) {
  MessageDecoder read(message);
  const double t = read.header();
  for (int i = 0; i < 4 + 9; ++i) read.from().number<double>();  // attitude and its covariance
  const Vec3<double> omega = read.vector(turn_rate_max);
  const bool measured = read.from().number<double>() != -1;  // first number of the covariance
  if (!read.ok()) return false;
  if (!measured || !std::isfinite(omega.x + omega.y + omega.z)) return true;
  const std::string topic(message.topic);
  rig.frames.try_emplace(topic, read.frame());
  rig.rows.rates.push_back({topic, {t, omega}});
  return true;
}

/// Adds the transforms of /tf_static. @return whether the message is sound
bool add_mountings(const McapMessage& message, BagRig& rig) {
  MessageDecoder read(message);
  for (std::size_t left = read.from().length(transform_bytes); left > 0 && read.ok(); --left) {
    read.header();
    const std::string child = MessageDecoder::frame_name(read.name());
    const Vec3<double> p = read.vector();
    const auto R = read.attitude();
    if (R && norm(p) <= place_max && rig.mountings.size() < bodies_max)
      rig.mountings.insert_or_assign(child, BagRig::Mounting{read.frame(), {p, *R}});
  }
  return read.ok();
}

std::string body_name(const McapMessage& message, std::string_view name) {
  const std::string_view topic = message.topic;
  return one_line(name.empty() ? std::string(topic) : fmt::format("{}:{}", topic, name));
}

/// Passes the messages in CDR of all files on.
template <class Take>
void each_message(const std::vector<fs::path>& files, Take&& take) {
  for (const fs::path& file : files) {
    McapReader reader(file);
    if (reader.ok()) {
      std::size_t index = 0;
      reader.visit([&](const McapMessage& message) {
        ++index;
        if (message.topic.size() > name_max)
          throw_invalid("{}: message {} on a topic with a name of {} bytes, expected at most {}",
                        file.native(), index, message.topic.size(), name_max);
        if (message.encoding == "cdr" && !take(message))
          throw_invalid("{}: message {} on {} is no sound {}", file.native(), index,
                        one_line(shortened(message.topic, topic_shown)), message.schema);
      });
    }
    if (!reader.ok()) throw_invalid("{}", reader.error());
  }
}

[[noreturn]] void refuse_unknown(const std::string& place, std::string_view key, const std::string& name,
                                 std::vector<std::string> known) {
  constexpr std::size_t shown = 12;
  const bool more = known.size() > shown;
  known.resize(std::min(known.size(), shown));
  throw_invalid("{}: no {} {}, expected {}{}", place, key, name,
                known.empty() ? "a bag with some" : fmt::format("one of {}", fmt::join(known, ", ")),
                more ? ", ..." : "");
}

/// Sets each velocity that is unknown to the slope of the positions around it.
void add_velocities(RecordedMotion& motion) {
  std::size_t first = 0, end = 0;
  for (RecordedSample& at : motion) {
    if (std::isfinite(at.v.x + at.v.y + at.v.z)) continue;
    while (motion[first].t < at.t - slope_reach) ++first;
    while (end < motion.size() && motion[end].t <= at.t + slope_reach) ++end;
    const double n = static_cast<double>(end - first);
    double time = 0.0, spread = 0.0;
    Vec3<double> middle{}, slope{};
    for (std::size_t i = first; i < end; ++i)
      time += (motion[i].t - at.t) / n, middle = middle + (1 / n) * motion[i].p;
    for (std::size_t i = first; i < end; ++i) {
      const double off = motion[i].t - at.t - time;
      spread += off * off;
      slope = slope + off * (motion[i].p - middle);
    }
    if (spread > 0) at.v = (1 / spread) * slope;
  }
}

}  // namespace

std::optional<RigidPose> BagRig::pose_in(const std::string& frame, const std::string& other) const {
  // The frame that one is mounted on at last, and its pose there. As many steps as there are mountings lead
  // to it, unless they form a circle.
  const auto on_root = [&](const std::string& one) {
    std::pair<std::string, RigidPose> root = {one, {}};
    for (std::size_t left = mountings.size() + 1; left > 0; --left) {
      const auto mounted = mountings.find(root.first);
      if (mounted == mountings.end()) return std::optional(root);
      root = {mounted->second.parent, mounted->second.pose * root.second};
    }
    return std::optional<std::pair<std::string, RigidPose>>();
  };
  const auto a = on_root(frame), b = on_root(other);
  if (!a || !b || a->first != b->first) return {};
  return inverse(a->second) * b->second;
}

RosBag::RosBag(const fs::path& place) : place_(place.native()) {
  std::error_code error;
  if (!fs::is_directory(place, error)) {
    files_ = {place};
    return;
  }
  // What else is in the folder of a run was made of its log.
  if (const fs::path run = place / "run.mcap"; fs::is_regular_file(run, error)) {
    files_ = {run};
    return;
  }
  bool sqlite = false, packed = false;
  for (fs::directory_iterator one(place, error), none; !error && one != none; one.increment(error)) {
    if (one->path().extension() == ".mcap") files_.push_back(one->path());
    sqlite = sqlite || one->path().extension() == ".db3";
    packed = packed || one->path().extension() == ".zstd";
  }
  if (error) throw_invalid("{}: {}, expected the folder of a rosbag2", place_, error.message());
  if (files_.empty() && sqlite)
    throw_invalid(
        "{}: a rosbag2 in SQLite (.db3), expected MCAP: ros2 bag convert with storage_id: mcap writes it",
        place_);
  if (files_.empty() && packed)
    throw_invalid("{}: a rosbag2 whose files are packed (.zstd), expected plain ones: zstd -d unpacks them",
                  place_);
  if (files_.empty()) throw_invalid("{}: no .mcap, expected the folder of a rosbag2", place_);
  // bag_2.mcap comes before bag_10.mcap.
  std::sort(files_.begin(), files_.end(), [](const fs::path& a, const fs::path& b) {
    const std::string &one = a.native(), &other = b.native();
    return one.size() != other.size() ? one.size() < other.size() : one < other;
  });
}

BagTopics RosBag::topics() const {
  std::set<std::string> bodies, commands;
  each_message(files_, [&](const McapMessage& message) {
    if (is_command(message)) {
      commands.insert(body_name(message, ""));
      return true;
    }
    const auto samples = samples_in(message);
    if (!samples) return false;
    for (const NamedSample& one : *samples)
      if (bodies.size() < bodies_max) bodies.insert(body_name(message, one.name));
    return true;
  });
  return {{bodies.begin(), bodies.end()}, {commands.begin(), commands.end()}};
}

std::string RosBag::body_called(const std::string& name) const {
  if (name.starts_with('/')) return name;
  const std::vector<std::string> all = topics().bodies;
  if (std::find(all.begin(), all.end(), name) != all.end()) return name;
  std::vector<std::string> fit;
  for (const std::string& one : all)
    if (one == fmt::format("/{}/pose", name) || one.ends_with(":" + name)) fit.push_back(one);
  if (fit.size() != 1) refuse_unknown(place_, "body", one_line(name), fit.empty() ? all : fit);
  return fit.front();
}

RecordedMotion RosBag::motion(const std::string& called) const {
  const std::string body = body_called(called);
  Timed<&RecordedSample::p, RecordedSample> read;
  each_message(files_, [&](const McapMessage& message) {
    if (!body.starts_with(message.topic)) return true;
    const auto samples = samples_in(message);
    if (!samples) return false;
    for (const NamedSample& one : *samples)
      if (body_name(message, one.name) == body) read.add(one.sample, message);
    return true;
  });
  RecordedMotion motion;
  read.each(place_, body, [&](const RecordedSample& sample) { append_sample(motion, sample); });
  if (motion.empty()) refuse_unknown(place_, "body", one_line(body), topics().bodies);
  add_velocities(motion);
  return motion;
}

std::vector<VelocityCommand> RosBag::commands(const std::string& topic) const {
  Timed<&VelocityCommand::v, VelocityCommand> read;
  each_message(files_, [&](const McapMessage& message) {
    if (message.topic != topic || !is_command(message)) return true;
    const auto command = command_in(message);
    if (!command) return false;
    if (std::isfinite(command->yaw_rate)) read.add(*command, message);
    return true;
  });
  std::vector<VelocityCommand> commands;
  read.each(place_, topic, [&](const VelocityCommand& command) { commands.push_back(command); });
  if (commands.empty()) refuse_unknown(place_, "commands", one_line(topic), topics().commands);
  return commands;
}

std::vector<BagCamera> RosBag::cameras() const {
  CamerasOfTopics found;
  each_message(files_, [&](const McapMessage& message) { return found.take(message); });
  return std::move(found).all();
}

BagRig RosBag::rig(const std::string& odometry_topic, const std::string& imu_topic, bool with_cameras) const {
  BagRig rig;
  CamerasOfTopics cameras;
  // When the messages of each row were recorded [s].
  std::vector<double> tags_recorded, poses_recorded, rates_recorded;
  each_message(files_, [&](const McapMessage& message) {
    bool sound = true;
    if (with_cameras) sound = cameras.take(message);
    if (message.schema == tags_type) sound = add_tags(message, rig);
    if (message.schema == odometry_type) {
      rig.odometries.emplace(message.topic);
      if (message.topic == odometry_topic) sound = add_odometry_pose(message, rig);
    }
    if (message.schema == imu_type) {
      rig.imus.emplace(message.topic);
      if (message.topic == imu_topic) sound = add_turn_rate(message, rig);
    }
    if (message.schema == tf_type && message.topic.ends_with("/tf_static"))
      sound = add_mountings(message, rig);
    const double recorded = to_seconds(message.log_time);
    tags_recorded.resize(rig.rows.tags.size(), recorded);
    poses_recorded.resize(rig.rows.poses.size(), recorded);
    rates_recorded.resize(rig.rows.rates.size(), recorded);
    return sound;
  });
  rig.cameras = std::move(cameras).all();
  if (rig.families.size() > 1)
    throw_invalid("{}: tags of the families {} and {}, expected one: tags are known by their numbers alone",
                  place_, one_line(shortened(*rig.families.begin(), topic_shown)),
                  one_line(shortened(*rig.families.rbegin(), topic_shown)));
  std::optional<double> first;
  const auto set_times = [&](auto& rows, const std::vector<double>& recorded, const auto& time_of) {
    std::set<std::string> stamped;
    for (auto& row : rows)
      if (time_of(row) != 0) stamped.insert(row.topic);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      double& t = time_of(rows[i]);
      if (!stamped.contains(rows[i].topic)) t = recorded[i];
      if (!first) first = t;
      if (!(std::abs(t - *first) <= rig_recording_max))
        throw_invalid("{}: t = {:.3f} s on {}, expected within {:.0f} s of the first, {:.3f} s", place_, t,
                      one_line(shortened(rows[i].topic, topic_shown)), rig_recording_max, *first);
    }
  };
  set_times(rig.rows.tags, tags_recorded, [](RigRows::TagRow& row) -> double& { return row.t; });
  set_times(rig.rows.poses, poses_recorded, [](RigRows::PoseRow& row) -> double& { return row.at.t; });
  set_times(rig.rows.rates, rates_recorded, [](RigRows::RateRow& row) -> double& { return row.at.t; });
  return rig;
}

}  // namespace sightline
