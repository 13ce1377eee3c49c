#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include "bridges/dds/fleet/link.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

constexpr std::size_t link_text_max = 128, network_texts_max = 16;
constexpr std::size_t log_vars_max = 8;  // six floats, and two bytes of the 26 that a log has

bool is_network_name(const std::string& text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == ':' || c == '_' || c == '-' || c == '%';
  });
}

/// "/a/b_2": parts of letters, digits and _, none of which begins with a digit.
bool is_ros_name(std::string_view text) {
  if (text.size() < 2 || text.size() > link_text_max || text[0] != '/') return false;
  char before = '\0';
  for (const char c : text) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_',
               digit = c >= '0' && c <= '9';
    if (!letter && !digit && c != '/') return false;
    if (before == '/' && !letter) return false;
    before = c;
  }
  return before != '/';
}

std::string read_ros_name(const TomlTable& at, std::string_view key, std::string_view what) {
  const std::string expected = fmt::format("{}, as \"/a/b\": letters, digits and _", what);
  std::string name = at.text(key, expected);
  if (!is_ros_name(name)) at.throw_invalid(key, expected);
  return name;
}

/// A frame or a body by its external name: any text that fits in a line.
std::string read_frame(const TomlTable& at, std::string_view key, std::string_view what) {
  std::string name = at.text(key, what);
  if (name.empty() || name.size() > link_text_max)
    at.throw_invalid(key, fmt::format("{} of 1 to {} bytes", what, link_text_max));
  return name;
}

std::vector<std::string> read_network_names(const TomlTable& at, std::string_view key,
                                            std::string_view what) {
  std::vector<std::string> names = at.texts(key, TomlTable::any_length, what);
  if (names.size() > network_texts_max)
    at.throw_invalid(key, fmt::format("at most {} {}", network_texts_max, what));
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!is_network_name(names[i]))
      at.throw_invalid(key, i, fmt::format("{}: letters, digits and .:_-%", what));
  return names;
}

// Keys of every kind of link, beside the parameters of the kind.
constexpr std::array<std::string_view, 10> common = {"kind",       "origin",     "poses",      "pose_topic",
                                                     "pose_name",  "pose_frame", "goal_topic", "path_topic",
                                                     "goal_frame", "goal_speed"};

template <class Kind>
Kind read_kind(const TomlTable& at, std::initializer_list<std::string_view> texts) {
  std::vector<std::string_view> beside(common.begin(), common.end());
  beside.insert(beside.end(), texts);
  return read_part<Kind>(TableSource(at), beside);
}

/// The variables of a log in their order; each of crazyflie_imu once.
std::vector<std::string> read_imu_vars(const TomlTable& at) {
  if (!at.has("imu")) at.throw_invalid("imu_vars", "no such key, only with imu");
  std::vector<std::string> vars = at.texts("imu_vars", TomlTable::any_length, "variables of the log");
  const bool whole = std::all_of(crazyflie_imu.begin(), crazyflie_imu.end(), [&](std::string_view name) {
    return std::count(vars.begin(), vars.end(), name) == 1;
  });
  if (!whole || vars.size() > log_vars_max)
    at.throw_invalid("imu_vars", fmt::format("at most {} variables of the log, each of {} once", log_vars_max,
                                             fmt::join(crazyflie_imu, ", ")));
  return vars;
}

}  // namespace

Px4Link Px4Link::read(const TomlTable& at, const std::string&) {
  Px4Link link = read_kind<Px4Link>(at, {"namespace"});
  if (!at.has("release")) at.throw_invalid("release", "the release of its firmware, \"1.14\" to \"1.18\"");
  if (at.has("namespace")) link.name_space = read_ros_name(at, "namespace", "the namespace of its topics");
  return link;
}

Crazyswarm2Link Crazyswarm2Link::read(const TomlTable& at, const std::string& agent) {
  Crazyswarm2Link link = read_kind<Crazyswarm2Link>(at, {"namespace", "imu", "imu_vars"});
  link.name_space = at.has("namespace") ? read_ros_name(at, "namespace", "the namespace of its topics")
                                        : fmt::format("/{}", agent);
  if (!is_ros_name(link.name_space))
    at.throw_invalid("namespace", "the namespace of its topics: the robot's name cannot be one");
  if (at.has("imu")) link.imu = read_ros_name(at, "imu", "the topic of the log with its IMU");
  if (at.has("imu_vars")) link.imu_vars = read_imu_vars(at);
  return link;
}

Ros2Link Ros2Link::read(const TomlTable& at, const std::string&) {
  Ros2Link link = read_kind<Ros2Link>(
      at, {"odometry", "cmd_vel", "stamped", "frame", "body_frame", "takeoff", "land", "state"});
  // A robot whose poses come from mocap or tf needs no odometry.
  const std::string source = at.has("poses") ? at.text("poses", "where its poses come from") : "";
  if (source == "mocap" || source == "tf") {
    for (const std::string_view key : {"odometry", "frame", "body_frame"})
      if (at.has(key)) at.throw_invalid(key, "no such key, only with poses = \"odometry\" or \"estimate\"");
  } else {
    link.odometry = read_ros_name(at, "odometry", "the topic of its odometry");
  }
  link.cmd_vel = read_ros_name(at, "cmd_vel", "the topic of its velocity commands");
  if (at.has("stamped")) link.stamped = at.boolean("stamped");
  if (at.has("frame")) link.frame = read_frame(at, "frame", "the frame of its odometry");
  if (at.has("body_frame")) link.body_frame = read_frame(at, "body_frame", "the frame of its body");
  if (at.has("takeoff") || at.has("land")) {
    link.takeoff = read_ros_name(at, "takeoff", "what takes it off, a topic or a service");
    link.land = read_ros_name(at, "land", "what lands it, a topic or a service");
    if (at.has("state")) link.state = read_ros_name(at, "state", "the topic of its state");
  } else {
    for (const std::string_view key : {"calls", "commands", "state"})
      if (at.has(key)) at.throw_invalid(key, "no such key, only with takeoff and land");
  }
  return link;
}

namespace {

using ReadKind = LinkKind (*)(const TomlTable&, const std::string&);
template <class... Kind>
constexpr auto readers_of(const std::variant<Kind...>*) {
  return std::array{Named<ReadKind>{
      Kind::name,
      [](const TomlTable& at, const std::string& agent) -> LinkKind { return Kind::read(at, agent); }}...};
}
constexpr auto link_kinds = readers_of(static_cast<const LinkKind*>(nullptr));

PosesFrom read_poses(const TomlTable& at, PoseSource fallback) {
  PosesFrom poses{.source = fallback};
  if (at.has("poses")) {
    const std::string_view word = at.word("poses", pose_sources);
    poses.source = static_cast<PoseSource>(std::find(pose_sources.begin(), pose_sources.end(), word) -
                                           pose_sources.begin());
  }
  const bool mocap = poses.source == PoseSource::mocap, others = poses.by_others();
  if (at.has("pose_topic") && !mocap)
    at.throw_invalid("pose_topic", "no such key, only with poses = \"mocap\"");
  for (const std::string_view key : {"pose_name", "pose_frame"}) {
    if (at.has(key) && !others) at.throw_invalid(key, "no such key, only with poses = \"mocap\" or \"tf\"");
  }
  if (mocap) poses.topic = read_ros_name(at, "pose_topic", "the topic of its poses");
  if (others && (at.has("pose_name") || !mocap))
    poses.name = read_frame(at, "pose_name", "what motion capture or /tf calls it");
  if (at.has("pose_frame")) poses.frame = read_frame(at, "pose_frame", "the frame that is G");
  if (poses.source == PoseSource::tf && poses.name == poses.frame)
    at.throw_invalid("pose_name", fmt::format("another frame than pose_frame, \"{}\"", poses.frame));
  return poses;
}

/// The folder of the DDS keys; for a log's fleet it may be missing.
std::filesystem::path read_keys(const TomlTable& at) {
  at.expect_only({"folder"});
  const std::string expected = "a folder with flyer/ or vehicles/ in it, as scripts/dds_keys.sh makes it";
  const std::string name = at.text("folder", expected);
  if (name.empty() || name.size() > link_text_max || name.find_first_of("\"$\n") != std::string::npos)
    at.throw_invalid("folder", expected);
  std::filesystem::path keys = at.file_folder(name + "/");
  if (!at.from_disk()) return keys;
  bool any = false;
  for (const std::string_view owner : key_owners) {
    std::error_code ignored;
    if (!std::filesystem::is_directory(keys / owner, ignored)) continue;
    any = true;
    for (const std::string_view file : key_files)
      if (!std::filesystem::is_regular_file(keys / owner / file, ignored))
        at.throw_invalid("folder", fmt::format("{}/{} in it, which is missing", owner, file));
  }
  if (!any) at.throw_invalid("folder", expected);
  return keys;
}

FleetNetwork read_network(const TomlTable& at) {
  at.expect_only({"domain", "interfaces", "discovery", "security", "fault", "node", "topics"});
  FleetNetwork network;
  if (at.has("domain")) network.domain = static_cast<int>(at.integer("domain", 0, domain_max));
  if (at.has("interfaces")) network.interfaces = read_network_names(at, "interfaces", "names of interfaces");
  if (at.has("node")) network.node = read_ros_name(at, "node", "the name of the flyer");
  if (at.has("topics")) network.topics = at.boolean("topics");
  const TomlTable discovery = at.table_or_empty("discovery");
  discovery.expect_only({"peers", "multicast", "participants"});
  if (discovery.has("multicast") && discovery.boolean("multicast")) network.multicast = Multicast::on;
  if (discovery.has("participants"))
    network.participants = static_cast<int>(discovery.integer("participants", 2, 120));
  if (discovery.has("peers")) {
    network.peers = read_network_names(discovery, "peers", "addresses");
  } else if (network.interfaces != FleetNetwork{}.interfaces && network.multicast == Multicast::off) {
    discovery.throw_invalid("peers", "the addresses of the other machines, since multicast is off");
  }
  if (at.has("security")) network.keys = read_keys(at.table("security"));
  return network;
}

/// Of the kind of this link.
auto commanded_by(const Link& link) {
  return std::visit([](const auto& kind) { return kind.commanded_by(); }, link.kind);
}

/// Goals in the table of a link.
GoalsFrom read_goals_from(const TomlTable& at, const Agent& robot) {
  GoalsFrom goals;
  const bool any = at.has("goal_topic") || at.has("path_topic");
  for (const std::string_view key : {"goal_frame", "goal_speed"})
    if (at.has(key) && !any) at.throw_invalid(key, "no such key, only with goal_topic or path_topic");
  if (!any) return goals;
  if (at.has("goal_topic")) goals.goal_topic = read_ros_name(at, "goal_topic", "the topic of its goals");
  if (at.has("path_topic")) goals.path_topic = read_ros_name(at, "path_topic", "the topic of its paths");
  if (at.has("goal_frame")) goals.frame = read_frame(at, "goal_frame", "the frame that is G");
  if (at.has("goal_speed"))
    goals.speed = at.number("goal_speed", {0.01, GoalTrack::path_speed, "0.01 to 5 m/s"});
  const StateRoles roles = roles_of(robot.model);
  const bool weighs = std::any_of(roles.position.begin(), roles.position.end(), [&](int state) {
    const auto i = static_cast<std::size_t>(state);
    return state >= 0 && (robot.Q[i] > 0 || robot.Q_f[i] > 0);
  });
  const std::string_view key = at.has("goal_topic") ? "goal_topic" : "path_topic";
  if (!weighs) at.throw_invalid(key, "a robot whose Q weighs its position: this one would not follow");
  if (robot.model.nx() > Reference::max_states)
    at.throw_invalid(key, fmt::format("a robot of at most {} states", Reference::max_states));
  return goals;
}

void read_link(const TomlTable& agent, const Agent& robot, BodyId body, FleetPlan& fleet) {
  const TomlTable at = agent.table("link", "a table with the link of the robot, as for each of a [fleet]");
  Link& link = fleet.links.emplace_back();
  link.robot = body;
  link.goals = read_goals_from(at, robot);
  link.kind = find(link_kinds, at.word("kind", names(link_kinds)))(at, robot.name);
  const auto* const crazyflie = std::get_if<Crazyswarm2Link>(&link.kind);
  for (const Link& other : std::span(fleet.links).first(fleet.links.size() - 1)) {
    if (other.kind_name() == link.kind_name() && commanded_by(other) == commanded_by(link))
      at.throw_invalid(commanded_by(link).first, "topics of its own: another robot has these");
    const auto* const theirs = std::get_if<Crazyswarm2Link>(&other.kind);
    if (crazyflie != nullptr && theirs != nullptr && !theirs->imu.empty() && theirs->imu == crazyflie->imu)
      at.throw_invalid("imu", "a topic of its own: another robot has it");
  }
  link.has_camera = agent.has("camera");
  const bool by_view = agent.has("localization") && agent.text("localization", "a word") == "vision";
  link.poses = read_poses(at, by_view ? PoseSource::estimate : PoseSource::odometry);
  if (link.poses.estimated() && !by_view)
    at.throw_invalid("poses", "\"odometry\", \"mocap\" or \"tf\", or localization = \"vision\" of the robot");
  if (!link.poses.estimated() && by_view)
    at.throw_invalid("poses", "\"estimate\" of a robot with localization = \"vision\"");
  const bool has_frame = link.has_local_frame(), own = link.poses.source == PoseSource::odometry;
  if (at.has("origin")) {
    if (link.poses.estimated())
      at.throw_invalid("origin",
                       "no such key with poses = \"estimate\": the origin of its odometry is unknown");
    if (!own && !has_frame)
      at.throw_invalid("origin", "no such key, only with poses = \"odometry\": those of others are in G");
    const TomlTable origin = at.table("origin", "a table with p and heading");
    origin.read({{"heading",
                  &link.origin.heading,
                  {-2 * std::numbers::pi, 2 * std::numbers::pi, "-2 pi to 2 pi rad"}}},
                {"p"});
    link.origin.p = origin.vec3("p");
  } else if (has_frame && own) {
    at.throw_invalid("origin",
                     "a table with p and heading: where in G its estimator starts, its local frame's origin");
  }
}

void read_body_link(const TomlTable& at, BodyId body, FleetPlan& fleet) {
  at.expect_only({"poses", "pose_topic", "pose_name", "pose_frame"});
  BodyLink& link = fleet.bodies.emplace_back();
  link.body = body;
  link.poses = read_poses(at, PoseSource::odometry);
  if (!link.poses.by_others()) at.throw_invalid("poses", "\"mocap\" or \"tf\": where others see it");
}

constexpr std::size_t link_faults_most = 1000;

LinkFault read_link_fault(const TomlTable& at, const Team& team, const FleetPlan& fleet) {
  at.expect_only({"robot", "kind", "since", "at", "duration", "size"});
  std::vector<std::string_view> kinds;
  for (const LinkFaultText& text : link_faults) kinds.push_back(text.name);
  LinkFault fault;
  const std::string robot = read_name(at, "robot", team, Among::robots, "the robot that has it");
  fault.robot = team.find(robot);
  const auto place = std::find(kinds.begin(), kinds.end(), at.word("kind", kinds)) - kinds.begin();
  fault.kind = static_cast<LinkFaultKind>(place);
  const LinkFaultText& text = text_of(fault.kind);
  const auto link = std::find_if(fleet.links.begin(), fleet.links.end(),
                                 [&](const Link& one) { return one.robot == fault.robot; });
  if (link != fleet.links.end() && !can_have(*link, fault.kind))
    at.throw_invalid("kind",
                     fmt::format("a fault of robots behind {}, {} is not", link->kind_name(), text.name));
  if (at.has("since") && at.word("since", fault_clocks) == fault_clocks[1]) fault.since = FaultClock::flight;
  constexpr Range seconds = {0.0, 1e6, "0 to 1e6 s"};
  fault.at = at.number("at", seconds);
  if (at.has("duration")) fault.duration = at.number("duration", {1e-3, 1e6, "0.001 to 1e6 s"});
  if (at.has("size") && text.size.empty())
    at.throw_invalid("size", fmt::format("no such key for {}", text.name));
  fault.size = text.fallback;
  if (at.has("size")) fault.size = TableSource(at).number("size", text.bounds, text.size);
  return fault;
}

void read_link_faults(const TomlTable& at, const Team& team, FleetPlan& fleet) {
  const std::vector<TomlTable> tables = at.tables("fault");
  if (tables.size() > link_faults_most)
    at.throw_invalid("fault", fmt::format("at most {}", link_faults_most));
  for (const TomlTable& one : tables) fleet.faults.push_back(read_link_fault(one, team, fleet));
}

class FleetReader final : public LinkReader {
 public:
  std::optional<double> read_goal_speed(const TomlTable& agent, const Agent& robot) const override {
    const GoalsFrom goals = read_goals_from(agent.table("link"), robot);
    if (goals.goal_topic.empty() && goals.path_topic.empty()) return std::nullopt;
    return goals.speed;
  }
  std::shared_ptr<const Links> read_links(const TomlTable& root,
                                          const ScenarioSpec& scenario) const override {
    const TomlTable at = root.table("fleet");
    auto fleet = std::make_shared<FleetPlan>();
    fleet->network = read_network(at);
    for (const auto& [name, agent] : root.named_tables("agent")) {
      const BodyId robot = scenario.team.find(name);
      read_link(agent, scenario.team.agent(robot), robot, *fleet);
    }
    for (const std::string_view section : {"target", "obstacle"})
      for (const auto& [name, body] : root.named_tables(section))
        if (body.has("link")) read_body_link(body.table("link"), scenario.team.find(name), *fleet);
    read_link_faults(at, scenario.team, *fleet);
    return fleet;
  }
};

}  // namespace

Registry with_links(Registry parts) {
  if (!parts.links) parts.links = std::make_shared<FleetReader>();
  return parts;
}

}  // namespace sightline
