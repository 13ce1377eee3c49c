#include "sightline/analysis/identification/recorded_flight_motion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/base/quantile.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/readers/px4_flight.hpp"

namespace sightline {
namespace {

constexpr double recorded_period = 0.02, samples_gap = 0.2;  // [s]
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

FlownMotion recorded_motion(const std::filesystem::path& file, RecordingKind kind, std::string robot,
                            std::vector<std::string> columns) {
  if (robot.empty()) {
    robot = file.filename().native();
    robot.resize(std::min(robot.find('.', 1), robot.size()));
  }
  if (kind == RecordingKind::table) {
    const CsvColumns table = read_csv(read_packed_file(file), file.native(), std::move(columns));
    return motion_of(table, robot);
  }
  if (!columns.empty()) throw_invalid("--columns of a recording that has names itself, expected none");
  return motion_of(read_ulog(file), robot);
}

}  // namespace sightline
