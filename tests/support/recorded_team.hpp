/// Recordings of synthetic teams, also as the files of MRCLAM.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "sightline/analysis/localization/team_recording.hpp"
#include "tests/support/synthetic_team.hpp"

namespace sightline::test {

struct RecordedTeam {
  int robots = 3, landmarks = 8;
  double seconds = 60.0;
  TeamNoise noise{};
  std::uint64_t seed = 1;
  double start = 0.0;      ///< of all stamps [s]
  bool staggered = false;  ///< the robots' pictures are at different times
};

inline TeamNoise noise_of_recordings() {
  TeamNoise noise;
  noise.turn_loss = 0.02, noise.sensor_turn = 0.05, noise.clock_offset = 0.05;
  noise.range_error = 0.03, noise.bearing_error = 0.01, noise.bearing_noise = 0.01;
  noise.range_error_time = noise.bearing_error_time = 2.0;
  return noise;
}

inline TeamRecording recorded(const RecordedTeam& of) {
  SyntheticTeam team(of.robots, of.landmarks, of.noise, of.seed);
  TeamRecording recording{.kind = "MRCLAM", .start = of.start, .noise = of.noise};
  for (int i = 0; i < of.robots; ++i) recording.robots.push_back({.name = fmt::format("robot{}", i + 1)});
  for (std::size_t k = 0; k < team.marks.size(); ++k)
    recording.landmarks.push_back(
        {fmt::format("landmark{}", of.robots + static_cast<int>(k) + 1), team.marks[k]});
  const auto truths = [&] {
    for (std::size_t i = 0; i < team.members.size(); ++i)
      recording.robots[i].truth.push_back({of.start + team.time(), team.members[i].pose});
  };
  truths();
  std::vector<double> due(team.members.size(), 0.1);
  if (of.staggered)
    for (std::size_t i = 0; i < due.size(); ++i) due[i] += 0.04 * static_cast<double>(i);
  while (team.time() < of.seconds) {
    team.step();
    truths();
    for (std::size_t i = 0; i < due.size(); ++i) {
      if (team.time() < due[i]) continue;
      due[i] += SyntheticTeam::sight_period;
      for (TeamSighting z : team.sightings(static_cast<int>(i))) {
        z.stamp += of.start;
        recording.sightings.push_back(z);
      }
    }
  }
  for (std::size_t i = 0; i < team.members.size(); ++i)
    for (WheelOdometry u : team.members[i].odometry) {
      u.t += of.start;
      recording.robots[i].odometry.push_back(u);
    }
  recording.end = of.start + team.time();
  return recording;
}

/// The files of MRCLAM that hold a recording; barcodes are 100 + the subject.
inline RecordingTexts mrclam_texts(const TeamRecording& recording, const std::string& folder) {
  RecordingTexts texts;
  const auto number = [&](std::size_t body) { return body + 1; };
  std::string codes = "# Subject # Barcode #\n", marks = "# Subject x y\n";
  for (std::size_t i = 0; i < recording.robots.size() + recording.landmarks.size(); ++i)
    codes += fmt::format("  {} \t {} \n", number(i), 100 + number(i));
  for (std::size_t k = 0; k < recording.landmarks.size(); ++k)
    marks +=
        fmt::format("  {} \t {:.8f} \t {:.8f} \t 0.0001 \t 0.0001 \n", number(recording.robots.size() + k),
                    recording.landmarks[k].place.x, recording.landmarks[k].place.y);
  texts[folder + "/Barcodes.dat"] = codes;
  texts[folder + "/Landmark_Groundtruth.dat"] = marks;
  for (std::size_t i = 0; i < recording.robots.size(); ++i) {
    const TeamRecording::Robot& robot = recording.robots[i];
    std::string odometry = "# Time v w\n", sightings = "# Time subject range bearing\n",
                truth = "# Time x y psi\n";
    for (const WheelOdometry& u : robot.odometry)
      odometry += fmt::format("{:.3f} \t {:.6f} \t {:.6f} \n", u.t, u.v, u.yaw_rate);
    if (!robot.odometry.empty())
      odometry += fmt::format("{:.3f} \t {:.6f} \t {:.6f} \n", recording.end, robot.odometry.back().v,
                              robot.odometry.back().yaw_rate);
    for (const auto& one : robot.truth)
      truth +=
          fmt::format("{:.3f} \t {:.8f} \t {:.8f} \t {:.8f} \n", one.t, one.pose.x, one.pose.y, one.pose.psi);
    for (const TeamSighting& z : recording.sightings)
      if (z.observer == static_cast<int>(i))
        sightings +=
            fmt::format("{:.3f} \t {} \t {:.6f} \t {:.6f} \n", z.stamp, 101 + z.subject, z.range, z.bearing);
    const std::string name = fmt::format("{}/Robot{}_", folder, number(i));
    texts[name + "Odometry.dat"] = odometry;
    texts[name + "Measurement.dat"] = sightings;
    texts[name + "Groundtruth.dat"] = truth;
  }
  return texts;
}

inline void write_mrclam(const TeamRecording& recording, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto& [file, text] : mrclam_texts(recording, folder.native())) std::ofstream(file) << text;
}

}  // namespace sightline::test
