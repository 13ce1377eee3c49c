#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "sightline/base.hpp"
#include "sightline/import/kinds.hpp"

namespace sightline {
namespace {

constexpr double takeoff_height = 0.5;                    // [m]
constexpr double usual_d_hard = 0.6, least_apart = 0.25;  // [m]
constexpr double share_of_distance = 0.8;  // d_hard over the distance of the two nearest starts
constexpr double pose_rate_least = 50;     // of poses by the radio [Hz]
constexpr double imu_rate_least = 50;      // of the log of its IMU [Hz]
constexpr std::size_t crazyflies_max = 200;
// Of the log of an IMU, in this order if a fleet file has no other.
constexpr std::array<std::string_view, 6> imu_vars = {"gyro.x", "gyro.y", "gyro.z",
                                                      "acc.x",  "acc.y",  "acc.z"};
constexpr std::size_t imu_vars_max = 8;  // as a link reads them

/// Values of Crazyswarm2 are looked up in the robot, its type, and then in `all`.
class CrazyflieSettings {
 public:
  CrazyflieSettings(const YamlValue& robot, const std::optional<YamlValue>& type, const YamlValue& file)
      : layers_{robot} {
    if (type) layers_.push_back(*type);
    if (const auto all = file.find("all")) layers_.push_back(*all);
  }
  std::optional<double> number(std::initializer_list<std::string_view> keys) const {
    for (const YamlValue& layer : layers_)
      if (const auto value = layer.find_path(keys)) return value->number();
    return std::nullopt;
  }
  /// The names of the custom topics of its firmware, with their variables in force; the robot's first.
  std::vector<std::pair<std::string, std::vector<std::string>>> custom_topics() const {
    std::vector<std::pair<std::string, std::vector<std::string>>> topics;
    for (const YamlValue& layer : layers_) {
      const auto custom = layer.find_path({"firmware_logging", "custom_topics"});
      if (!custom) continue;
      for (const auto& [topic, value] : custom->entries("topics by their names")) {
        const auto vars = value.find("vars");
        const auto is_set = [&topic = topic](const auto& other) { return other.first == topic; };
        if (!vars || std::any_of(topics.begin(), topics.end(), is_set)) continue;
        auto& names = topics.emplace_back(topic, std::vector<std::string>{}).second;
        for (const YamlValue& name : vars->items("variables of the log"))
          names.push_back(name.text("a variable of the log"));
      }
    }
    return topics;
  }

 private:
  std::vector<YamlValue> layers_;
};

struct Crazyflie {
  std::string name, uri, type;
  Vec3<double> p;  // of its initial_position [m]
  bool motion_capture = false;
  double battery_min = 3.7;            // [V]
  std::string imu{};                   // topic of the log of its IMU; empty: none
  std::vector<std::string> logged{};   // variables of that log
  std::vector<std::string> remarks{};  // that others may share
};

/// Whether it is one level of a name of ROS.
bool is_ros_word(const std::string& name) {
  return !name.empty() && name.size() <= name_size_max &&
         std::isdigit(static_cast<unsigned char>(name[0])) == 0 &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return c < 128 && (std::isalnum(c) != 0 || c == '_'); });
}

/// A name that is a robot of ours and a namespace of ROS.
std::string read_name(const YamlValue& robot, const std::string& name) {
  if (!is_ros_word(name))
    robot.throw_invalid(
        fmt::format("a name of 1 to {} letters, digits and _, not a digit first", name_size_max));
  return name;
}

Vec3<double> read_place(const YamlValue& robot, const std::vector<Crazyflie>& others) {
  constexpr Range across = {-90, 90, "-90 to 90 m"}, up = {-0.1, 5, "-0.1 to 5 m"};
  const YamlValue at = robot.at("initial_position", "its place on the ground, [x, y, z] in m");
  const std::vector<YamlValue> place = at.items("[x, y, z] in m");
  if (place.size() != 3) at.throw_invalid("[x, y, z] in m");
  const Vec3<double> p = {place[0].number(across), place[1].number(across), place[2].number(up)};
  for (const Crazyflie& other : others) {
    if (norm(p - other.p) < least_apart)
      at.throw_invalid(fmt::format("a place at least {} m from that of {}, [{}, {}, {}]", least_apart,
                                   other.name, other.p.x, other.p.y, other.p.z));
  }
  return p;
}

bool is_measured_by_motion_capture(const std::optional<YamlValue>& type) {
  const std::optional<YamlValue> capture = type ? type->find("motion_capture") : std::nullopt;
  if (!capture) return false;
  if (const auto enabled = capture->find("enabled")) return enabled->boolean();
  return capture->find("tracking").has_value();
}

/// Notes on keys of a table that are not `known`.
void note_others(const YamlValue& at, std::span<const std::string_view> known,
                 std::vector<std::string>& notes) {
  for (const auto& [key, value] : at.entries("a mapping")) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      notes.push_back(fmt::format("{} has no counterpart", one_line(value.path())));
  }
}

bool is_of_log(const std::string& name) {
  return std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return c < 128 && (std::isalnum(c) != 0 || c == '_' || c == '.');
  });
}

/// The first custom topic with all of imu_vars is the log of its IMU.
void take_imu(Crazyflie& robot, const CrazyflieSettings& settings) {
  for (const auto& [topic, vars] : settings.custom_topics()) {
    const bool whole = std::all_of(imu_vars.begin(), imu_vars.end(), [&vars = vars](std::string_view name) {
      return std::count(vars.begin(), vars.end(), name) == 1;
    });
    if (!whole || !is_ros_word(topic) || vars.size() > imu_vars_max ||
        !std::all_of(vars.begin(), vars.end(), is_of_log))
      continue;
    robot.imu = fmt::format("/{}/{}", robot.name, topic);
    robot.logged = vars;
    const auto rate = settings.number({"firmware_logging", "custom_topics", topic, "frequency"});
    if (!rate || *rate < imu_rate_least)
      robot.remarks.push_back(
          fmt::format("its IMU by the radio {}, expected firmware_logging.custom_topics.{}.frequency = 100",
                      rate ? fmt::format("at {} Hz", *rate) : "has no frequency", one_line(topic)));
    return;
  }
}

/// What the firmware is set to, where it matters to a flight.
void remark_settings(Crazyflie& robot, const CrazyflieSettings& settings) {
  if (!robot.motion_capture) {
    const auto rate = settings.number({"firmware_logging", "default_topics", "pose", "frequency"});
    if (!rate || *rate < pose_rate_least)
      robot.remarks.push_back(
          fmt::format("poses by the radio {}, expected firmware_logging.default_topics.pose.frequency = 100",
                      rate ? fmt::format("at {} Hz", *rate) : "are not logged"));
  }
  if (settings.number({"firmware_params", "stabilizer", "estimator"}) == 1.0)
    robot.remarks.emplace_back("complementary estimator, expected stabilizer.estimator = 2 (Kalman)");
  if (settings.number({"firmware_params", "stabilizer", "controller"}) == 1.0)
    robot.remarks.emplace_back(
        "the PID controller follows 0.5 s late, stabilizer.controller = 2 (Mellinger) does not");
}

/// Each remark once, with the robots that it is about.
void note_remarks(const std::vector<Crazyflie>& robots, std::vector<std::string>& notes) {
  std::vector<std::pair<std::string, std::vector<std::string>>> shared;
  for (const Crazyflie& robot : robots) {
    for (const std::string& remark : robot.remarks) {
      auto known =
          std::find_if(shared.begin(), shared.end(), [&](const auto& one) { return one.first == remark; });
      if (known == shared.end()) known = shared.insert(shared.end(), {remark, {}});
      known->second.push_back(robot.name);
    }
  }
  for (const auto& [remark, names] : shared)
    notes.push_back(fmt::format("{}: {}", fmt::join(names, ", "), remark));
}

Crazyflie read_crazyflie(const YamlValue& robot, const std::string& name, const YamlValue& file,
                         const std::vector<Crazyflie>& others, std::vector<std::string>& notes) {
  constexpr std::array<std::string_view, 6> of_robot = {
      "enabled", "uri", "initial_position", "type", "firmware_params", "firmware_logging"};
  Crazyflie one{
      .name = read_name(robot, name),
      .uri = robot.at("uri", "its address, as radio://0/80/2M/E7E7E7E7E7").text("an address of a radio"),
      .type = robot.at("type", "one of robot_types").text("one of robot_types"),
      .p = read_place(robot, others)};
  note_others(robot, of_robot, notes);
  const YamlValue types = file.at("robot_types", "the types of the robots");
  const std::optional<YamlValue> type = types.find(one.type);
  if (!type) robot.at("type", "a type").throw_invalid("one of robot_types");
  one.motion_capture = is_measured_by_motion_capture(type);
  if (const auto critical = type->find_path({"battery", "voltage_critical"}))
    one.battery_min = critical->number({2.5, 30, "2.5 to 30 V"});
  if (const auto big = type->find("big_quad"); big && big->boolean())
    one.remarks.emplace_back("big_quad has no counterpart; the simulated vehicle is a Crazyflie");
  const CrazyflieSettings settings(robot, type, file);
  remark_settings(one, settings);
  take_imu(one, settings);
  return one;
}

/// "radio://0" of "radio://0/80/2M/E7E7E7E7E7"
std::string radio_of(const std::string& uri) {
  const std::size_t begin = uri.find("://");
  return begin == std::string::npos ? uri : uri.substr(0, uri.find('/', begin + 3));
}

void note_radios(const std::vector<Crazyflie>& robots, std::vector<std::string>& notes) {
  std::map<std::string, int> shared;
  for (const Crazyflie& one : robots) ++shared[radio_of(one.uri)];
  for (const auto& [radio, count] : shared) {
    if (count > 2)
      notes.push_back(
          fmt::format("{} Crazyflies share {}: fly sends set-points each n-th period", count, radio));
  }
}

/// A distance that the nearest starts keep, at most the usual one [m].
double d_hard_of(const std::vector<Crazyflie>& robots, std::vector<std::string>& notes) {
  double nearest = infinity;
  for (const Crazyflie& a : robots)
    for (const Crazyflie& b : robots)
      if (&a != &b) nearest = std::min(nearest, norm(a.p - b.p));
  const double d_hard = std::min(usual_d_hard, std::floor(100 * share_of_distance * nearest) / 100);
  if (d_hard < usual_d_hard)
    notes.push_back(fmt::format("safety.d_hard = {} m: two robots start {:.3g} m apart", d_hard, nearest));
  return d_hard;
}

std::string agent_text(const Crazyflie& one) {
  const std::array<double, 3> start = {one.p.x, one.p.y, one.p.z + takeoff_height};
  std::string text = fmt::format(
      "\n[agent.{0}]\nrobot = \"multirotor\"\n"
      "start = {{ p = {1}, heading = 0.0 }}  # its initial_position, at takeoff_height\n"
      "Q = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]\n"
      "reference = {{ constant = {{ p = {1}, heading = 0.0 }} }}  # its task: it holds at its start\n"
      "\n[agent.{0}.link]  # type {2}, {3}\nkind = \"crazyswarm2\"\nnamespace = \"/{0}\"\n"
      "takeoff_height = {4}\nbattery_min = {5}  # [V]\n",
      one.name, toml_numbers(start), one.type, one.uri, toml_number(takeoff_height),
      toml_number(one.battery_min));
  if (!one.imu.empty())
    text += fmt::format("imu = \"{}\"  # with its gyroscope and accelerometer\nimu_vars = [\"{}\"]\n",
                        one.imu, fmt::join(one.logged, "\", \""));
  text += one.motion_capture
              ? fmt::format("poses = \"mocap\"\npose_topic = \"/poses\"\npose_name = \"{}\"\n", one.name)
              : "poses = \"odometry\"\norigin = { p = [0.0, 0.0, 0.0], heading = 0.0 }  # of its frame world "
                "in G\n";
  return text;
}

}  // namespace

Imported import_crazyflies(const YamlValue& robots, const std::string& file, const YamlValue* server) {
  constexpr std::array<std::string_view, 4> of_file = {"fileversion", "robots", "robot_types", "all"};
  Imported made;
  note_others(robots, of_file, made.notes);
  std::vector<Crazyflie> all;
  std::vector<std::string> left_out;
  const YamlValue list = robots.at("robots", "the robots by their names");
  for (const auto& [name, robot] : list.entries("the robots by their names")) {
    if (!robot.at("enabled", "true or false").boolean()) {
      left_out.push_back(one_line(name));
      continue;
    }
    if (all.size() == crazyflies_max)
      list.throw_invalid(fmt::format("at most {} enabled robots", crazyflies_max));
    all.push_back(read_crazyflie(robot, name, robots, all, made.notes));
  }
  if (all.empty()) list.throw_invalid("at least one robot with enabled: true");
  if (!left_out.empty())
    made.notes.push_back(fmt::format("not enabled, left out: {}", fmt::join(left_out, ", ")));
  note_remarks(all, made.notes);
  note_radios(all, made.notes);
  if (server != nullptr) note_others(*server, {}, made.notes);

  made.what = fmt::format("a fleet of {} Crazyflies", all.size());
  made.text = fmt::format(
      "# Of {}, by `sightline import`. The server of Crazyswarm2 keeps uri, firmware_params and "
      "firmware_logging.\n"
      "# Each robot holds at its start until its reference, or couplings, give it a task: docs/flying.md.\n"
      "\n[fleet]\ndomain = 0           # the server's ROS_DOMAIN_ID\ninterfaces = [\"lo\"]  # by which "
      "messages leave: "
      "the server runs on this machine\n",
      file_name(file));
  for (const Crazyflie& one : all) made.text += agent_text(one);
  made.text += fmt::format(
      "\n[safety]\nbarrier = \"on\"\nd_hard = {}  # centre to centre [m]\nposition_sigma = "
      "0.01\nheading_sigma = 0.01\n"
      "\n[safety.supervisor]\nfresh = 0.05  # messages arrive every 0.01 s [s]\n",
      toml_number(d_hard_of(all, made.notes)));
  return made;
}

}  // namespace sightline
