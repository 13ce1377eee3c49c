#include "sightline/analysis/localization/team_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sightline/readers/packed_file.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/random.hpp"
#include "tests/support/recorded_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TeamRecording small_recording() {
  return test::recorded(
      {.robots = 2, .landmarks = 3, .seconds = 4.0, .noise = test::noise_of_recordings(), .start = 1000.0});
}

/// A table of MURP: two agents, of which the second turns.
std::string murp_text(int rows) {
  std::string text = "t,x,A_x,A_y,A_z,A_roll,A_pitch,A_yaw,B_x,B_y,B_z,B_roll,B_pitch,B_yaw";
  for (int i = 1; i <= 6; ++i)
    for (int j = 1; j <= 6; ++j) text += fmt::format(",{}_{}", i, j);
  for (int k = 0; k < rows; ++k) {
    const double yaw = 30.0 * k;
    text +=
        fmt::format("\n{}.0,0,0,0,1.5,0,0,0,3,1,0.5,0,0,{}", k, yaw - 360 * std::floor((yaw + 180) / 360));
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) {
        const double a = (30 + 60 * i) * std::numbers::pi / 180,
                     b = (30 + 60 * j + yaw) * std::numbers::pi / 180;
        const double x = 3 + 0.32 * (std::cos(b) - std::cos(a)), y = 1 + 0.32 * (std::sin(b) - std::sin(a));
        text += fmt::format(",{:.6f}", std::sqrt(x * x + y * y + 1.0));
      }
  }
  return text + "\n";
}

TEST(TeamRecording, FilesOfMrclamGiveWhatTheyHold) {
  const TeamRecording written = small_recording();
  const TeamRecording read = parse_mrclam(test::mrclam_texts(written, "d"), "d");
  ASSERT_EQ(read.robots.size(), 2U);
  ASSERT_EQ(read.landmarks.size(), 3U);
  EXPECT_EQ(read.robots[1].name, "robot2");
  EXPECT_EQ(read.landmarks[0].name, "landmark3");
  ASSERT_EQ(read.sightings.size(), written.sightings.size());
  for (std::size_t k = 0; k < read.sightings.size(); ++k) {
    EXPECT_EQ(read.sightings[k].observer, written.sightings[k].observer);
    EXPECT_EQ(read.sightings[k].subject, written.sightings[k].subject);
    EXPECT_NEAR(read.sightings[k].range, written.sightings[k].range, 1e-6);
  }
  const auto between = read.truth(1, 1002.51), there = written.truth(1, 1002.51);
  ASSERT_TRUE(between && there);
  EXPECT_NEAR(between->x, there->x, 1e-6);
  EXPECT_FALSE(read.truth(0, 999.0));
}

TEST(TeamRecording, CodesOfNoBodyAreCounted) {
  RecordingTexts texts = test::mrclam_texts(small_recording(), "d");
  const std::size_t before = parse_mrclam(texts, "d").sightings.size();
  texts["d/Robot1_Measurement.dat"] += "1001.0 999 2.0 0.1\n1001.0 101 2.0 0.1\n";
  const TeamRecording read = parse_mrclam(texts, "d");
  EXPECT_EQ(read.unknown_codes, 2U) << "a robot does not see itself";
  EXPECT_EQ(read.sightings.size(), before);
}

TEST(TeamRecording, RangesOfMurpFitTheirTruth) {
  const TeamRecording read = parse_murp({{"02_base-1_targ-2_win-1.csv", murp_text(10)}}, "m");
  ASSERT_EQ(read.robots.size(), 2U);
  EXPECT_EQ(read.robots[0].name, "agent1");
  EXPECT_EQ(read.sightings.size(), 360U);
  EXPECT_TRUE(read.relative);
  for (const TeamSighting& z : read.sightings) {
    const auto a = read.truth(0, z.stamp), b = read.truth(1, z.stamp);
    ASSERT_TRUE(a && b);
    const Vec3<double> from = Vec3<double>{a->x, a->y, read.robots[0].height} + turn_z(a->psi) * z.sensor;
    const Vec3<double> to = Vec3<double>{b->x, b->y, read.robots[1].height} + turn_z(b->psi) * z.point;
    EXPECT_NEAR(z.range, norm(to - from), 1e-5);
  }
}

TEST(TeamRecording, RefusalsNameFileLineAndValue) {
  const RecordingTexts good = test::mrclam_texts(small_recording(), "d");
  const auto refused = [&](const std::string& file, const std::string& line) {
    RecordingTexts texts = good;
    texts["d/" + file] = "# head\n" + line + "\n" + texts["d/" + file];
    return refusal_of([&] { parse_mrclam(texts, "d"); });
  };
  EXPECT_EQ(refused("Robot1_Odometry.dat", "1.0 2.0"),
            "d/Robot1_Odometry.dat:2: 2 fields, expected 3: time, forward velocity, angular velocity");
  EXPECT_EQ(refused("Robot1_Odometry.dat", "1000.0 fast 0"),
            "d/Robot1_Odometry.dat:2: forward velocity = fast, expected a number");
  EXPECT_EQ(refused("Robot2_Measurement.dat", "1000.0 103 -2 0"),
            "d/Robot2_Measurement.dat:2: range = -2, expected 0.001 to 100000 m");
  EXPECT_THAT(refused("Robot2_Measurement.dat", "1000.0 103 nan 0"), HasSubstr(":2: range = nan, expected"));
  EXPECT_THAT(refused("Robot1_Groundtruth.dat", "9e9 0 0 0"),
              HasSubstr("expected within 86400 s of the first"));
  EXPECT_EQ(refused("Landmark_Groundtruth.dat", "1 0 0 0 0"),
            "d/Landmark_Groundtruth.dat:2: subject = 1, expected one that no line before has");
  EXPECT_THAT(refused("Barcodes.dat", "1 101"),
              HasSubstr("barcode = 101, expected one that no line before has"));
  RecordingTexts without = good;
  without.erase("d/Barcodes.dat");
  EXPECT_EQ(refusal_of([&] { parse_mrclam(without, "d"); }),
            "d: no Barcodes.dat, expected it in a folder of MRCLAM");
  EXPECT_THAT(refusal_of([&] {
                parse_murp({{"base-1_targ-2.csv", "t,A_x\n"}}, "m");
              }),
              HasSubstr("base-1_targ-2.csv:1: no column A_y, expected it"));
  EXPECT_THAT(refusal_of([&] {
                parse_murp({{"base-1_targ-1.csv", murp_text(2)}}, "m");
              }),
              HasSubstr("one agent, expected two"));
}

TEST(TeamRecording, PlacesThatHoldNoneAreRefused) {
  const std::filesystem::path folder = test::fresh_folder();
  EXPECT_THAT(refusal_of([&] { read_team_recording(folder); }),
              HasSubstr("no recording of a known kind, expected a folder of MRCLAM"));
  EXPECT_THAT(refusal_of([&] { read_team_recording(folder / "none"); }), HasSubstr("not there"));
  std::ofstream(folder / "x.ulg") << "ULog\x01\x12\x35";
  EXPECT_THAT(refusal_of([&] { read_team_recording(folder / "x.ulg"); }),
              HasSubstr("x.ulg: this is a PX4 ULog, expected a folder of MRCLAM"));
  const std::filesystem::path archive = folder / "MRCLAM.tar.gz";
  std::ofstream(archive) << "x";
  EXPECT_THAT(refusal_of([&] { read_team_recording(archive); }), HasSubstr("expected its folder: tar xzf"));
  std::ofstream(folder / "base-1_targ-2.csv.gz") << "\x1f\x8b\x08 damaged";
  EXPECT_THAT(refusal_of([&] { read_team_recording(folder); }),
              HasSubstr("damaged, expected a file that is plain or packed by gzip"));
}

TEST(TeamRecording, MutatedFilesAreReadOrRefusedInOneSentence) {
  Random random(1);
  const RecordingTexts mrclam =
      test::mrclam_texts(test::recorded({.robots = 2, .landmarks = 2, .seconds = 0.6}), "d");
  const RecordingTexts murp = {{"m_base-1_targ-2.csv", murp_text(2)}};
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  int refusals = 0;
  const int inputs = runs(100'000, 33);
  for (int k = 0; k < 2 * inputs; ++k) {
    RecordingTexts texts = k % 2 == 0 ? mrclam : murp;
    auto chosen = texts.begin();
    std::advance(chosen, below(texts.size()));
    std::string& text = chosen->second;
    for (std::size_t n = 1 + below(3); n > 0 && !text.empty(); --n) {
      const std::size_t at = below(text.size());
      switch (below(5)) {
        case 0:
          text[at] = static_cast<char>(below(256));
          break;
        case 1:
          text.erase(at, 1 + below(20));
          break;
        case 2:
          text.insert(at, text.substr(below(text.size()), 1 + below(40)));
          break;
        case 3:
          text[at] = "0123456789.-+e, \n"[below(17)];
          break;
        default:
          text.resize(at);
          break;
      }
    }
    const std::string sentence =
        refusal_of([&] { k % 2 == 0 ? parse_mrclam(texts, "d") : parse_murp(texts, "m"); });
    if (sentence.empty()) continue;
    ++refusals;
    EXPECT_THAT(sentence, HasSubstr("expected")) << k;
    EXPECT_EQ(sentence.find('\n'), std::string::npos) << k;
  }
  EXPECT_GE(refusals, inputs / 2);
  EXPECT_LE(refusals, 2 * inputs - inputs / 10);
}

}  // namespace
}  // namespace sightline
