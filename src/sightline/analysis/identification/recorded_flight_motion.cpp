#include "sightline/analysis/identification/recorded_flight_motion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "sightline/base/quantile.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/readers/px4_flight.hpp"

namespace sightline {
namespace {

constexpr double recorded_period = 0.02, samples_gap = 0.2;  // [s]
constexpr double seconds_most =
    36'000;  // of a flight: longer ones have times in another unit, or a clock that jumps
constexpr double held_most = 0.05;   // greatest time between commands that stay in force until the next [s]
constexpr double least_limit = 0.1;  // of an input [m/s], [rad/s]

SeenMotion seen_at(const RecordedMotion& motion, double t) {
  const std::optional<RecordedSample> sample = sample_at(motion, t, samples_gap);
  if (!sample) return {{no_value, no_value, no_value}, no_value, no_value, no_value};
  const SinCos<double> d = sincos(sample->heading);
  const Vec2<double> v = rotate<double>({d.cos, -d.sin}, {sample->v.x, sample->v.y});
  return {sample->p, sample->heading, v.x, v.y};
}

/// The command in force at a time between the first and the last.
VelocityCommand command_at(const std::vector<VelocityCommand>& commands, double t, bool held) {
  const auto after = std::upper_bound(commands.begin(), commands.end(), t,
                                      [](double time, const VelocityCommand& one) { return time < one.t; });
  const VelocityCommand& a = *(after - 1);
  if (held || after == commands.end()) return a;
  const double share = (t - a.t) / (after->t - a.t);
  return {t, a.v + share * (after->v - a.v), a.yaw_rate + share * (after->yaw_rate - a.yaw_rate)};
}

}  // namespace

FlownMotion motion_of(const std::string& robot, const std::vector<VelocityCommand>& commands,
                      const RecordedMotion& measured, const RecordedMotion& truth) {
  if (commands.size() < 2)
    throw_invalid("{} commands of velocity, expected at least 5 s of them", commands.size());
  std::vector<double> gaps;
  for (std::size_t i = 1; i < commands.size(); ++i) gaps.push_back(commands[i].t - commands[i - 1].t);
  const bool held = quantile(gaps, 0.5) <= held_most;
  FlownMotion motion;
  motion.robot = robot;
  motion.model = "velocity_multirotor";
  motion.commands = Commands::velocity;
  motion.period = recorded_period;
  motion.u_max.fill(least_limit);
  const double seconds = commands.back().t - commands.front().t;
  if (!(seconds <= seconds_most))
    throw_invalid("commands over {:.4g} s, expected at most {} s: times in seconds, of one clock", seconds,
                  seconds_most);
  SinCos<double> d{0.0, 1.0};
  for (std::size_t k = 0; static_cast<double>(k) * recorded_period <= seconds; ++k) {
    const double t = commands.front().t + static_cast<double>(k) * recorded_period;
    motion.measured.push_back(seen_at(measured, t));
    if (!truth.empty()) motion.truth.push_back(seen_at(truth, t));
    // Commands are in G, the inputs in V; without a measurement the heading stays.
    if (std::isfinite(motion.measured.back().psi)) d = sincos(motion.measured.back().psi);
    const VelocityCommand command = command_at(commands, t, held);
    const Vec2<double> level = rotate<double>({d.cos, -d.sin}, {command.v.x, command.v.y});
    motion.u.push_back({level.x, level.y, command.v.z, command.yaw_rate});
    for (std::size_t i = 0; i < motion.u_max.size(); ++i)
      motion.u_max[i] = std::max(motion.u_max[i], std::abs(motion.u.back()[i]));
  }
  if (std::none_of(motion.measured.begin(), motion.measured.end(), is_seen))
    throw_invalid("no pose with velocity and heading while {} was commanded, expected some", robot);
  return motion;
}

FlownMotion motion_of(const ULog& log, const std::string& robot) {
  const std::vector<VelocityCommand> commands = px4_velocity_commands(log);
  if (commands.empty())
    throw_invalid(
        "no set-points of velocity while the vehicle was in Offboard, expected trajectory_setpoint without a "
        "position");
  constexpr std::string_view of_truth = "vehicle_local_position_groundtruth";
  return motion_of(robot, commands, px4_motion(log, "vehicle_local_position"),
                   log.find(of_truth) != nullptr ? px4_motion(log, of_truth) : RecordedMotion());
}

FlownMotion motion_of(const CsvColumns& table, const std::string& robot) {
  constexpr std::array<std::string_view, 12> names = {"t",  "x",  "y",  "z",  "heading", "vx",
                                                      "vy", "vz", "ux", "uy", "uz",      "ur"};
  std::array<const std::vector<double>*, names.size()> of{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    of[i] = table.find(names[i]);
    if (of[i] == nullptr)
      throw_invalid("no column \"{}\", expected the columns {}", names[i], fmt::join(names, ", "));
  }
  const auto number = [&](std::size_t column, std::size_t row) { return (*of[column])[row]; };
  RecordedMotion measured;
  std::vector<VelocityCommand> commands;
  for (std::size_t k = 0; k < of[0]->size(); ++k) {
    const double t = number(0, k);
    if (k > 0 && !(t > number(0, k - 1)))
      throw_invalid("t = {} in row {} of numbers after {}, expected times that rise [s]", t, k + 1,
                    number(0, k - 1));
    append_sample(measured, {t,
                             {number(1, k), number(2, k), number(3, k)},
                             {number(5, k), number(6, k), number(7, k)},
                             number(4, k)});
    commands.push_back({t, {number(8, k), number(9, k), number(10, k)}, number(11, k)});
  }
  return motion_of(robot, commands, measured, {});
}

FlownMotion motion_of(const RosBag& bag, const std::string& robot, std::string body, std::string commands) {
  const BagTopics topics = body.empty() || commands.empty() ? bag.topics() : BagTopics();
  const auto choose = [](std::string& name, std::string_view option, const std::vector<std::string>& known) {
    if (!name.empty()) return;
    if (known.size() != 1)
      throw_invalid("{} is missing, expected {}", option,
                    known.empty() ? "a bag with one" : fmt::format("one of {}", fmt::join(known, ", ")));
    name = known.front();
  };
  choose(body, "--body", topics.bodies);
  choose(commands, "--commands", topics.commands);
  const RecordedMotion measured = bag.motion(body);
  std::vector<VelocityCommand> of_G;
  for (VelocityCommand command : bag.commands(commands)) {
    const std::optional<RecordedSample> at = sample_at(measured, command.t, samples_gap);
    if (!at || !std::isfinite(at->heading)) continue;
    const SinCos<double> d = sincos(at->heading);
    const Vec2<double> v = rotate<double>({d.cos, d.sin}, {command.v.x, command.v.y});
    command.v = {v.x, v.y, command.v.z};
    of_G.push_back(command);
  }
  return motion_of(robot, of_G, measured, {});
}

FlownMotion recorded_motion(const std::filesystem::path& file, RecordingKind kind, RecordedRobot robot) {
  if (robot.name.empty()) {
    robot.name = (file.has_filename() ? file : file.parent_path()).filename().native();
    robot.name.resize(std::min(robot.name.find('.', 1), robot.name.size()));
  }
  if (kind != RecordingKind::table && !robot.columns.empty())
    throw_invalid("--columns of a recording that has names itself, expected none");
  if (kind != RecordingKind::bag && !(robot.body + robot.commands).empty())
    throw_invalid("--body and --commands, expected them for a bag of ROS 2 alone");
  if (kind == RecordingKind::bag) return motion_of(RosBag(file), robot.name, robot.body, robot.commands);
  if (kind == RecordingKind::ulog) return motion_of(read_ulog(file), robot.name);
  return motion_of(read_csv(read_packed_file(file), file.native(), std::move(robot.columns)), robot.name);
}

}  // namespace sightline
