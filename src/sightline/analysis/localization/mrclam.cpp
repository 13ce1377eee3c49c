#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "sightline/analysis/localization/team_recording.hpp"
#include "sightline/readers/number_table.hpp"
#include "sightline/readers/recorded_motion.hpp"

namespace sightline {
namespace {

constexpr double far = 1e5;  // [m]
constexpr std::size_t landmarks_max = 4096;
constexpr Bounds any_subject = {1, 1e6, "1 to 1000000"};
constexpr Bounds any_place = {-far, far, "-100000 to 100000"};
constexpr Bounds any_angle = {-100, 100, "-100 to 100"};
constexpr Bounds any_range = {1e-3, far, "0.001 to 100000"};
constexpr NumberColumn time_column{"time", "s", {-1e10, 1e10, "-1e10 to 1e10"}};

/// The files of one recording by their roles.
struct MrclamFiles {
  struct Table {
    std::string file;
    std::string_view text;
  };
  struct RobotTables {
    std::optional<Table> odometry, measurement, truth;
  };
  std::map<int, RobotTables> robots;
  std::optional<Table> barcodes, landmarks;
};

MrclamFiles files_of(const RecordingTexts& texts) {
  MrclamFiles files;
  for (const auto& [file, text] : texts) {
    const std::string name = std::filesystem::path(file).filename().native();
    const MrclamFiles::Table table{file, text};
    if (name.starts_with("Barcodes")) files.barcodes = table;
    if (name.starts_with("Landmark")) files.landmarks = table;
    if (!name.starts_with("Robot")) continue;
    int number = 0;
    const auto [end, error] = std::from_chars(name.data() + 5, name.data() + name.size(), number);
    const std::string_view role(end, static_cast<std::size_t>(name.data() + name.size() - end));
    if (error != std::errc() || number < 1)
      throw std::invalid_argument(fmt::format("{}: a robot without a number, expected Robot1, ...", file));
    MrclamFiles::RobotTables& robot = files.robots[number];
    if (role.starts_with("_Odometry")) robot.odometry = table;
    if (role.starts_with("_Measurement")) robot.measurement = table;
    if (role.starts_with("_Groundtruth")) robot.truth = table;
  }
  return files;
}

/// Passes the rows of a table that begin with a time, all within a day of the first.
template <class Take>
void each_timed(const MrclamFiles::Table& of, std::span<const NumberColumn> columns, Take&& take) {
  NumberTable table(of.file, of.text);
  std::optional<double> first;
  while (table.next()) {
    const std::vector<double> row = table.numbers(columns);
    if (!first) first = row[0];
    if (!(std::abs(row[0] - *first) <= recording_max))
      table.refuse(fmt::format("time = {:.3f} s, expected within {:.0f} s of the first time, {:.3f} s",
                               row[0], recording_max, *first));
    take(row);
  }
}

struct CodedSighting {
  double t;
  int observer, code;
  double range, bearing;
};

}  // namespace

TeamRecording parse_mrclam(const RecordingTexts& texts, const std::string& place) {
  const MrclamFiles files = files_of(texts);
  const auto missing = [&](std::string_view file) {
    throw std::invalid_argument(fmt::format("{}: no {}, expected it in a folder of MRCLAM", place, file));
  };
  if (files.robots.empty()) missing("Robot1_Odometry.dat");
  if (files.robots.size() > recorded_robots_max)
    throw std::invalid_argument(
        fmt::format("{}: {} robots, expected at most {}", place, files.robots.size(), recorded_robots_max));
  if (!files.barcodes) missing("Barcodes.dat");

  TeamRecording recording{.kind = "MRCLAM"};
  std::map<int, int> body_of_subject, subject_of_code;
  std::vector<CodedSighting> coded;
  for (const auto& [number, tables] : files.robots) {
    if (!tables.odometry) missing(fmt::format("Robot{}_Odometry.dat", number));
    if (!tables.measurement) missing(fmt::format("Robot{}_Measurement.dat", number));
    const int robot = static_cast<int>(recording.robots.size());
    body_of_subject[number] = robot;
    TeamRecording::Robot read{.name = fmt::format("robot{}", number)};
    const std::array odometry = {time_column, NumberColumn{"forward velocity", "m/s", any_angle},
                                 NumberColumn{"angular velocity", "rad/s", any_angle}};
    each_timed(*tables.odometry, odometry, [&](const std::vector<double>& row) {
      read.odometry.push_back({row[0], row[1], row[2]});
    });
    sort_by_time(read.odometry);
    if (read.odometry.empty())
      throw std::invalid_argument(
          fmt::format("{}: no rows, expected time, velocity, angular velocity", tables.odometry->file));
    const std::array sighting = {time_column, NumberColumn{"subject", "", any_subject},
                                 NumberColumn{"range", "m", any_range},
                                 NumberColumn{"bearing", "rad", any_angle}};
    each_timed(*tables.measurement, sighting, [&](const std::vector<double>& row) {
      coded.push_back({row[0], robot, static_cast<int>(row[1]), row[2], row[3]});
    });
    if (tables.truth) {
      const std::array truth = {time_column, NumberColumn{"x", "m", any_place},
                                NumberColumn{"y", "m", any_place},
                                NumberColumn{"orientation", "rad", any_angle}};
      each_timed(*tables.truth, truth, [&](const std::vector<double>& row) {
        read.truth.push_back({row[0], {row[1], row[2], wrap(row[3])}});
      });
      sort_by_time(read.truth);
    }
    recording.robots.push_back(std::move(read));
  }

  if (files.landmarks) {
    const std::array columns = {NumberColumn{"subject", "", any_subject}, NumberColumn{"x", "m", any_place},
                                NumberColumn{"y", "m", any_place}, NumberColumn{"x std-dev", "m", from_zero},
                                NumberColumn{"y std-dev", "m", from_zero}};
    NumberTable table(files.landmarks->file, files.landmarks->text);
    while (table.next()) {
      const std::vector<double> row = table.numbers(columns);
      const int subject = static_cast<int>(row[0]);
      const int body = static_cast<int>(recording.robots.size() + recording.landmarks.size());
      if (recording.landmarks.size() == landmarks_max)
        table.refuse(fmt::format("another landmark, expected at most {}", landmarks_max));
      if (!body_of_subject.try_emplace(subject, body).second)
        table.refuse(fmt::format("subject = {}, expected one that no line before has", subject));
      recording.landmarks.push_back({fmt::format("landmark{}", subject), {row[1], row[2], 0.0}});
    }
  }
  const std::array columns = {NumberColumn{"subject", "", any_subject},
                              NumberColumn{"barcode", "", any_subject}};
  NumberTable table(files.barcodes->file, files.barcodes->text);
  while (table.next()) {
    const std::vector<double> row = table.numbers(columns);
    if (!subject_of_code.try_emplace(static_cast<int>(row[1]), static_cast<int>(row[0])).second)
      table.refuse(fmt::format("barcode = {}, expected one that no line before has", row[1]));
  }

  recording.start = infinity, recording.end = infinity;
  for (const TeamRecording::Robot& robot : recording.robots) {
    recording.start = std::min(recording.start, robot.odometry.front().t);
    recording.end = std::min(recording.end, robot.odometry.back().t);
  }
  // The recording is where all true poses are known: before and after it robots are carried.
  for (const TeamRecording::Robot& robot : recording.robots) {
    if (robot.truth.empty()) continue;
    recording.start = std::max(recording.start, robot.truth.front().t);
    recording.end = std::min(recording.end, robot.truth.back().t);
  }
  if (!(recording.end > recording.start && recording.end - recording.start <= recording_max))
    throw std::invalid_argument(
        fmt::format("{}: the odometry of all robots ends {:.3f} s after its start, expected > 0 to {:.0f} s",
                    place, recording.end - recording.start, recording_max));
  std::stable_sort(coded.begin(), coded.end(), [](const CodedSighting& a, const CodedSighting& b) {
    return a.t != b.t ? a.t < b.t : a.observer < b.observer;
  });
  for (const CodedSighting& one : coded) {
    if (one.t < recording.start || one.t > recording.end) continue;
    const auto subject = subject_of_code.find(one.code);
    const auto body =
        subject == subject_of_code.end() ? body_of_subject.end() : body_of_subject.find(subject->second);
    if (body == body_of_subject.end() || body->second == one.observer) {
      ++recording.unknown_codes;
      continue;
    }
    recording.sightings.push_back({.stamp = one.t,
                                   .observer = one.observer,
                                   .subject = body->second,
                                   .range = one.range,
                                   .bearing = one.bearing});
  }
  return recording;
}

}  // namespace sightline
