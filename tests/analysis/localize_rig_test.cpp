#include "sightline/analysis/localization/localize_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <tuple>

#include "sightline/analysis/localization/consistency.hpp"
#include "sightline/import/read_rig.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/mutated_rigs.hpp"
#include "tests/support/recorded_rig.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/rig_bag.hpp"
#include "tests/support/shared_data.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

Column<6> twist_of(double rho, double theta) {
  Column<6> xi;
  for (int i = 0; i < 6; ++i) xi(i, 0) = (i < 3 ? rho : theta) * (1 + 0.3 * i) * (i % 2 == 0 ? 1 : -1);
  return xi;
}

double distance(const RigidPose& a, const RigidPose& b) {
  const Column<6> xi = log_of(inverse(a) * b);
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) sum += square(xi(i, 0));
  return sqrt(sum);
}

TEST(RigidMotion, ExponentialLogarithmAndAdjointAgree) {
  for (const double theta : {0.0, 1e-9, 1e-5, 1e-3, 0.3, 0.7}) {
    const Column<6> xi = twist_of(2.0, theta), back = log_of(exp_of(xi));
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(back(i, 0), xi(i, 0), 1e-9) << theta;
  }
  const RigidPose X = exp_of(twist_of(1.0, 0.4));
  const Column<6> xi = twist_of(0.3, -0.2);
  EXPECT_LT(distance(X * exp_of(xi), exp_of(adjoint(X) * xi) * X), 1e-12);
}

TEST(RigFilter, DerivativesOfCornersAreThoseOfDifferences) {
  constexpr double h = 1e-6;
  for (const Distortion lens : {Distortion::equidistant, Distortion::plumb_bob}) {
    const test::SyntheticRig rig({.lens = lens, .seconds = 0.1});
    const Camera& camera = rig.recording.cameras[0].camera;
    for (const double x : {-0.8, 0.0, 0.5}) {
      const RigidPose T = {{x, 0.3, 2.0}, turn_by({3.0, 0.2 + x, 0.1})};
      const auto at = RigFilter::picture(camera, camera.widest(), 0.4, T);
      ASSERT_TRUE(at);
      for (int j = 0; j < 6; ++j) {
        Column<6> d;
        d(j, 0) = h;
        const auto more = RigFilter::picture(camera, camera.widest(), 0.4, exp_of(d) * T),
                   less = RigFilter::picture(camera, camera.widest(), 0.4, exp_of(-1.0 * d) * T);
        ASSERT_TRUE(more && less);
        for (int i = 0; i < 8; ++i)
          EXPECT_NEAR(at->by_twist(i, j), (more->corners(i, 0) - less->corners(i, 0)) / (2 * h), 1e-3);
      }
    }
  }
}

/// Adds what a gyroscope with a bias and noise measures, 20 times in each step of a recording.
void add_gyroscope(RigRecording& recording, const Vec3<double>& bias, double noise) {
  constexpr int parts = 20;
  Random random(7);
  const auto normal = [&] { return std::normal_distribution<double>()(random); };
  const auto& path = recording.reference;
  for (std::size_t k = 1; k < path.size(); ++k) {
    const double dt = path[k].t - path[k - 1].t, sigma = noise / std::sqrt(dt / parts);
    const Vec3<double> omega = (1 / dt) * vec3(log_of(inverse(path[k - 1].pose) * path[k].pose), 3);
    for (int i = 0; i < parts; ++i)
      recording.turn_rates.push_back(
          {path[k - 1].t + (i + 0.5) * dt / parts,
           omega + bias + Vec3<double>{sigma * normal(), sigma * normal(), sigma * normal()}});
  }
}

/// Mean of the normalised errors squared over seeds, which are independent.
struct MeanNees {
  double filter = 0.0, smoothed = 0.0, rmse = 0.0, smoothed_rmse = 0.0;
};
MeanNees mean_nees(
    test::RecordedRig of, int seeds,
    const std::function<void(RigRecording&)>& change = [](RigRecording&) {}) {
  MeanNees mean;
  for (int k = 1; k <= seeds; ++k) {
    of.seed = static_cast<unsigned>(k);
    test::SyntheticRig rig(of);
    change(rig.recording);
    const RigLocalization result = localize_rig(rig.recording, of.noise);
    // In the frame of the tags, without an alignment. Of a run, the last time of the filter and the
    // middle one of the smoother.
    const auto nees = [&](const RigLocalization::Estimate& one) {
      for (const auto& true_pose : rig.recording.reference)
        if (true_pose.t == one.t) return mahalanobis(log_of(true_pose.pose * inverse(one.pose)), one.P);
      return infinity;
    };
    mean.filter += nees(result.filter.back()) / seeds;
    mean.smoothed += nees(result.smoothed[result.smoothed.size() / 2]) / seeds;
    mean.rmse += result.of_filter.rmse / seeds, mean.smoothed_rmse += result.of_smoother.rmse / seeds;
    EXPECT_EQ(result.restarts, 0U) << k;
    EXPECT_LT(result.rejected, result.fits.size() / 50) << k;
  }
  return mean;
}

constexpr int nees_seeds = 20;
void expect_right_nees(const MeanNees& mean) {
  // 99.9 %, by the same quantile as the bounds of 95 %.
  for (const double nees : {mean.filter, mean.smoothed}) {
    EXPECT_GT(nees, 6 * scaled_chi_squared(6 * nees_seeds, -3.3));
    EXPECT_LT(nees, 6 * scaled_chi_squared(6 * nees_seeds, 3.3));
  }
}

void expect_consistent(const test::RecordedRig& of) {
  const MeanNees mean = mean_nees(of, nees_seeds);
  expect_right_nees(mean);
  EXPECT_LT(mean.rmse, 0.05);
  EXPECT_LT(mean.smoothed_rmse, mean.rmse);
}

TEST(LocalizeRig, IsConsistentWithTwoFisheyesAndOdometry) { expect_consistent({.seconds = 12.0}); }

TEST(LocalizeRig, IsConsistentWithOneRadtanLensWithoutOdometry) {
  test::RecordedRig of{.lens = Distortion::plumb_bob, .cameras = 1, .odometry = false, .seconds = 12.0};
  of.noise.acceleration_walk = 0.3, of.noise.turn_acceleration_walk = 0.2;
  expect_consistent(of);
}

TEST(LocalizeRig, TagsMovedTogetherMoveTheEstimates) {
  const test::SyntheticRig rig({.seconds = 6.0});
  RigRecording moved = rig.recording;
  const RigidPose G = {{30, -20, 5}, turn_by({0.4, -0.3, 1.2})};
  for (RigRecording::Tag& tag : moved.tags) tag.pose = G * tag.pose;
  const RigLocalization a = localize_rig(rig.recording, {}), b = localize_rig(moved, {});
  ASSERT_EQ(a.filter.size(), b.filter.size());
  for (std::size_t k = 0; k < a.filter.size(); ++k) {
    EXPECT_LT(distance(G * a.filter[k].pose, b.filter[k].pose), 1e-6) << k;
    EXPECT_LT(distance(G * a.smoothed[k].pose, b.smoothed[k].pose), 1e-6) << k;
  }
}

/// The tag `tag` hangs in turn at its place and at that of `other`, which is never seen itself.
void swap_places(RigRecording& recording, std::size_t tag, std::size_t other, double period) {
  std::vector<RigRecording::Sighting> kept;
  for (RigRecording::Sighting z : recording.sightings) {
    const bool moved = std::fmod(z.t - recording.start, 2 * period) > period;
    if (z.tag == (moved ? tag : other)) continue;
    if (z.tag == other) z.tag = tag;
    kept.push_back(z);
  }
  recording.sightings = kept;
}

void expect_smoother_more_certain(const RigLocalization& result) {
  EXPECT_EQ(distance(result.filter.back().pose, result.smoothed.back().pose), 0.0);
  for (std::size_t k = 0; k < result.filter.size(); ++k)
    EXPECT_LE(trace(position_covariance(result.smoothed[k])),
              trace(position_covariance(result.filter[k])) * (1 + 1e-3) + 1e-9)
        << k;
}

TEST(LocalizeRig, SmootherEndsAsTheFilterAndIsNeverLessCertain) {
  for (const bool odometry : {true, false}) {
    const test::SyntheticRig rig({.odometry = odometry, .seconds = 6.0});
    expect_smoother_more_certain(localize_rig(rig.recording, {}));
    // Also where the pose starts anew after a gap, and where places are given up.
    test::SyntheticRig lost({.odometry = odometry, .seconds = 24.0});
    std::vector<RigRecording::Sighting>& all = lost.recording.sightings;
    swap_places(lost.recording, 5, 4, 2.0);
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const RigRecording::Sighting& z) {
                               return std::abs(z.t - lost.recording.start - 10.0) < 4.0;
                             }),
              all.end());
    const RigLocalization result = localize_rig(lost.recording, {.position_walk = 1.5});
    EXPECT_GT(result.restarts, 0U);
    expect_smoother_more_certain(result);
  }
}

TEST(LocalizeRig, RejectsWrongCornersAndKeepsItsAccuracy) {
  test::SyntheticRig rig({.seconds = 10.0});
  const double before = localize_rig(rig.recording, {}).of_filter.rmse;
  std::size_t wrong = 0;
  for (std::size_t k = 20; k < rig.recording.sightings.size(); k += 9, ++wrong)
    for (Vec2<double>& corner : rig.recording.sightings[k].corners) corner.x += 60.0;
  const RigLocalization result = localize_rig(rig.recording, {});
  EXPECT_GE(result.rejected, wrong * 9 / 10);
  EXPECT_LT(result.of_filter.rmse, 1.5 * before);
}

/// Greatest distance of the last estimate from the truth, in the frame of the tags.
double last_error(const RigRecording& recording, const RigLocalization& result) {
  return norm(recording.reference.back().pose.p - result.filter.back().pose.p);
}

TEST(LocalizeRig, OneWrongKnownTagDoesNotCaptureTheMapWhereverItIsListed) {
  for (std::size_t wrong = 0; wrong < 3; ++wrong) {
    test::SyntheticRig rig({.known = 3, .seconds = 10.0});
    rig.recording.tags[wrong].pose.p.x += 1.0;
    const RigLocalization result = localize_rig(rig.recording, {});
    EXPECT_LT(last_error(rig.recording, result), 0.1) << wrong;
    EXPECT_LT(result.of_filter.rmse, 0.1) << wrong;
    std::array<std::size_t, 3> accepted{};
    for (std::size_t k = 0; k < result.fits.size(); ++k)
      if (const std::size_t tag = rig.recording.sightings[k].tag; tag < 3)
        accepted[tag] += result.fits[k].verdict != TagVerdict::rejected ? 1 : 0;
    for (std::size_t tag = 0; tag < 3; ++tag) EXPECT_EQ(accepted[tag] == 0, tag == wrong) << tag << wrong;
  }
}

TEST(LocalizeRig, TagThatMovesOftenIsOneTagOfOnePlace) {
  test::SyntheticRig rig({.seconds = 30.0});
  swap_places(rig.recording, 5, 4, 3.0);
  RigFilter filter(rig.recording, {});
  const RigLocalization result = localize_rig(rig.recording, {});
  EXPECT_EQ(result.places, 5U);
  EXPECT_GT(std::count_if(result.fits.begin(), result.fits.end(),
                          [](const TagFit& fit) { return fit.verdict == TagVerdict::introduced; }),
            5);
  std::vector<TagFit> fits(rig.recording.sightings.size());
  for (std::size_t k = 0; k < fits.size();) {
    std::size_t end = k;
    while (end < fits.size() && rig.recording.sightings[end].t == rig.recording.sightings[k].t) ++end;
    filter.take({rig.recording.sightings.data() + k, end - k}, {fits.data() + k, end - k});
    k = end;
  }
  EXPECT_LE(filter.places().size(), 6U);
}

TEST(LocalizeRig, LongestTimeWithoutATagReachesTheEnd) {
  test::SyntheticRig rig({.seconds = 6.0});
  std::vector<RigRecording::Sighting>& all = rig.recording.sightings;
  while (all.back().t > rig.recording.start + 2.0) all.pop_back();
  EXPECT_NEAR(localize_rig(rig.recording, {}).longest_unseen, rig.recording.end - all.back().t, 1e-9);
}

TEST(LocalizeRig, FastOdometryGivesAHundredEstimatesASecondAndTheSameLastOne) {
  test::SyntheticRig rig({.seconds = 3.0, .rate = 400.0});
  std::vector<RigRecording::Sighting>& all = rig.recording.sightings;
  all.erase(
      std::remove_if(all.begin(), all.end(), [&](const auto& z) { return z.t > rig.recording.start + 0.5; }),
      all.end());
  const RigLocalization whole = localize_rig(rig.recording, {});
  rig.recording.reference.clear();
  const RigLocalization fewer = localize_rig(rig.recording, {});
  EXPECT_NEAR(static_cast<double>(fewer.filter.size()), 200 + 250, 2);
  EXPECT_EQ(whole.filter.size(), 1201U);
  EXPECT_EQ(whole.filter.back().t, fewer.filter.back().t);
  EXPECT_LT(distance(whole.filter.back().pose, fewer.filter.back().pose), 1e-9);
}

TEST(LocalizeRig, IdentifiesTheWalkOfTheOdometry) {
  test::RecordedRig of{.seconds = 40.0, .rate = 5.0};
  of.noise.position_walk = 0.08, of.noise.rotation_walk = 0.04;
  const test::SyntheticRig rig(of);
  const RigNoise found = identify_motion(rig.recording, {}).noise;
  EXPECT_GT(found.position_walk, 0.5 * of.noise.position_walk);
  EXPECT_LT(found.position_walk, 2 * of.noise.position_walk);
  EXPECT_GT(found.rotation_walk, 0.5 * of.noise.rotation_walk);
  EXPECT_LT(found.rotation_walk, 2 * of.noise.rotation_walk);
}

TEST(RigRecording, FilesGiveWhatTheyHold) {
  const test::SyntheticRig rig({.seconds = 2.0});
  const std::filesystem::path folder = test::fresh_folder();
  test::write_rig(rig.recording, (folder / "").string());
  test::write_rig(rig.recording, (folder / "a_").string());
  EXPECT_TRUE(is_rig_recording(folder));
  EXPECT_FALSE(is_rig_recording(folder / "b"));
  for (const std::filesystem::path& place : {folder, folder / "a"}) {
    const RigRecording read = read_rig_recording(place);
    ASSERT_EQ(read.sightings.size(), rig.recording.sightings.size());
    ASSERT_EQ(read.odometry.size(), rig.recording.odometry.size());
    EXPECT_EQ(read.tags.size(), rig.recording.tags.size());
    EXPECT_EQ(read.cameras[1].camera.coefficients, rig.recording.cameras[1].camera.coefficients);
    EXPECT_LT(distance(read.cameras[1].mounting, rig.recording.cameras[1].mounting), 1e-8);
    EXPECT_LT(distance(read.tags[0].pose, rig.recording.tags[0].pose), 1e-8);
    EXPECT_LT(distance(read.odometry[5].pose, rig.recording.odometry[5].pose), 1e-7);
  }
}

void replace_in(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  std::ofstream(file) << text;
}

TEST(RigRecording, RefusalsNameFileKeyAndValue) {
  const test::SyntheticRig rig({.seconds = 0.3});
  const std::filesystem::path folder = test::fresh_folder();
  const auto refused = [&](const char* file, const std::string& from, const std::string& to) {
    test::write_rig(rig.recording, (folder / "").string());
    replace_in(folder / file, from, to);
    return refusal_of<std::exception>([&] { read_rig_recording(folder); });
  };
  EXPECT_THAT(refused("cameras.yaml", "equidistant", "fov"),
              HasSubstr("cam0.distortion_model = fov, expected radtan, equidistant or none"));
  EXPECT_EQ(refused("tagslam.yaml", "size: 0.4, pose", "pose"), "") << "the body has a default";
  EXPECT_THAT(refused("tagslam.yaml", "default_tag_size: 0.4\n     tags:\n       - {id: 10, size: 0.4,",
                      "tags:\n       - {id: 10,"),
              HasSubstr("size is missing, expected the side of the tag"));
  EXPECT_THAT(refused("tagslam.yaml", "size: 0.4, pose", "size: -1, pose"),
              HasSubstr("size = -1, expected 0.001"));
  EXPECT_THAT(refused("tagslam.yaml", "is_static: false", "is_static: true"), HasSubstr("a body that moves"));
  EXPECT_THAT(refused("tag_detections.csv", "tag,/cam0/tags,", "tag,/cam0/tags,1,"),
              HasSubstr("tag_detections.csv:1: 13 fields, expected 12: tag, topic, t, id"));
  EXPECT_THAT(refused("tag_detections.csv", "tag,", "tags,"),
              HasSubstr(":1: row tags, expected tag or odom"));
  EXPECT_THAT(refused("reference.csv", "odom,/reference,1000.000000,", "odom,/reference,now,"),
              HasSubstr("reference.csv:1: t = now, expected a number"));
  test::write_rig(rig.recording, (folder / "").string());
  for (const char* camera : {"cam0", "cam1"})
    replace_in(folder / "cameras.yaml", std::string("/") + camera + "/tags", "/seen");
  EXPECT_THAT(refusal_of<std::exception>([&] { read_rig_recording(folder); }),
              HasSubstr("no tag by a camera of the rig, expected some of /seen"));
  EXPECT_THAT(refused("tag_detections.csv", "tag,", "t\x1b[1mag,"), HasSubstr(":1: row t?[1mag, expected"));
  const std::string wall = " - wall:\n     is_static: true\n     default_tag_size: 0.3\n";
  EXPECT_THAT(
      refused("tagslam.yaml", "bodies:\n", "bodies:\n" + wall),
      HasSubstr("bodies[0].wall.pose is missing, expected its pose, as there is another static body"));
  EXPECT_THAT(refused("tagslam.yaml", " - room:\n", " - room:\n     ignore_tags: [10, 11, 12, 13, 14, 15]\n"),
              HasSubstr("tag_detections.csv: every tag by a camera of the rig is an unknown or ignored tag"));
  EXPECT_THAT(refused("tagslam.yaml", "default_body: room", "default_body: rooms"),
              HasSubstr("default_body = rooms, expected a body, the nearest is \"room\""));
  EXPECT_THAT(refused("tagslam.yaml", " - room:\n", " - room:\n     type: board\n"),
              HasSubstr("bodies[0].room.type = board, expected simple"));
  EXPECT_EQ(refused("tagslam.yaml", " - room:\n", " - room:\n     type: simple\n"), "");
  EXPECT_THAT(refused("tagslam.yaml", " - rig:", " - \"rig\\e[1m\":"),
              HasSubstr("expected a body with a name of letters, digits, _ and -"));
  EXPECT_THAT(refused("tagslam.yaml", "bodies:\n", "squash:\n - {tags: [1]}\nbodies:\n"),
              HasSubstr("squash = [... 1 items], expected a file without this key"));
  const std::string remap = "tag_id_remap:\n - {id: 10, remaps: [{remap_id: 11, start_time: 0, end_time: 1";
  EXPECT_EQ(refused("tagslam.yaml", "bodies:\n", remap + "}]}\nbodies:\n"), "");
  EXPECT_THAT(refused("tagslam.yaml", "bodies:\n", remap + ", camera: cam0}]}\nbodies:\n"),
              HasSubstr("camera = cam0, expected a remap of all cameras"));
  EXPECT_THAT(refused("tagslam.yaml", "/odom", "/odon"),
              HasSubstr("odom_topic = /odon, expected some, the nearest is \"/odom\""));
  test::write_rig(rig.recording, (folder / "").string());
  std::ofstream(folder / "cameras.yaml") << "{}\n";
  EXPECT_THAT(refusal_of<std::exception>([&] { read_rig_recording(folder); }),
              HasSubstr("cam0 is missing, expected a camera"));
  std::filesystem::remove(folder / "camera_poses.yaml");
  EXPECT_THAT(refusal_of<std::exception>([&] { read_rig_recording(folder); }),
              HasSubstr("camera_poses.yaml"));
}

TEST(RigRecording, RefusesSightingsAndReferencesThatDoNotFit) {
  const test::SyntheticRig rig({.seconds = 2.0});
  const std::filesystem::path folder = test::fresh_folder();
  const auto refused = [&](const RigRecording& recording) {
    test::write_rig(recording, (folder / "").string());
    return refusal_of<std::exception>([&] { read_rig_recording(folder); });
  };
  RigRecording other = rig.recording;
  for (RigRecording::TimedPose& one : other.reference) one.t -= 900.0;
  EXPECT_THAT(refused(other), HasSubstr("reference.csv: t = 100.000 to 102.000 s, expected times of the "
                                        "sightings, 1000.000 to 1002.000 s"));
  other = rig.recording;
  for (std::size_t k = other.tags.size(); k <= 500; ++k)
    other.tags.push_back({.id = static_cast<int>(10 + k)});
  const RigRecording::Sighting first = other.sightings.front();
  for (const std::size_t tags : {std::size_t{500}, std::size_t{501}}) {
    other.sightings.assign(tags, first);
    for (std::size_t k = 0; k < tags; ++k) other.sightings[k].tag = k;
    EXPECT_EQ(refused(other).empty(), tags == 500) << tags;
  }
  EXPECT_THAT(refused(other), HasSubstr("sightings of 501 tags, expected at most 500"));
}

TEST(RigRecording, ReferencesDoNotExtendIt) {
  const test::SyntheticRig rig({.seconds = 2.0});
  const std::filesystem::path folder = test::fresh_folder();
  RigRecording longer = rig.recording;
  longer.reference.push_back({longer.end + 600.0, longer.reference.back().pose});
  test::write_rig(longer, (folder / "").string());
  const RigRecording read = read_rig_recording(folder);
  EXPECT_NEAR(read.end, rig.recording.end, 1e-6);
  EXPECT_EQ(read.reference.size(), rig.recording.reference.size());
}

TEST(RigRecording, TagsWithoutABodyAreOfTheDefaultBodyAlone) {
  const test::SyntheticRig rig({.seconds = 2.0});
  const std::filesystem::path folder = test::fresh_folder();
  test::write_rig(rig.recording, (folder / "").string());
  EXPECT_EQ(read_rig_recording(folder).left_out, 0U);
  replace_in(folder / "tagslam.yaml", "default_body: room\n", "");
  const RigRecording listed = read_rig_recording(folder);
  EXPECT_EQ(listed.tags.size(), 2U);
  EXPECT_EQ(listed.left_out + listed.sightings.size(), rig.recording.sightings.size());
}

TEST(RigRecording, RowsWithoutATopicAreNoOdometry) {
  const test::SyntheticRig rig({.seconds = 2.0});
  const std::filesystem::path folder = test::fresh_folder();
  test::write_rig(rig.recording, (folder / "").string());
  replace_in(folder / "tagslam.yaml", "     odom_topic: /odom\n", "");
  std::ofstream(folder / "tag_detections.csv", std::ios::app) << "odom,,1001,0,0,0,0,0,0,1\n";
  EXPECT_TRUE(read_rig_recording(folder).odometry.empty());
}

void write_bag(const std::filesystem::path& file, const test::BagWriter& bag) {
  std::ofstream(file, std::ios::binary) << bag.bytes("zstd");
}

/// The bag beside the other files of a folder, without its table.
void bag_in_place_of_table(const std::filesystem::path& folder, const test::BagWriter& bag) {
  std::filesystem::remove(folder / "tag_detections.csv");
  write_bag(folder / "rig_0.mcap", bag);
}

TEST(RigRecording, ABagGivesWhatTheTableGives) {
  const test::SyntheticRig rig({.seconds = 5.0});
  for (const bool stamped : {true, false}) {
    const std::filesystem::path folder = test::fresh_folder();
    test::write_rig(rig.recording, (folder / "").string());
    test::write_rig(rig.recording, (folder / "a_").string());
    const RigRecording table = read_rig_recording(folder);
    write_bag(folder / "a.mcap", test::bag_of(table, stamped));
    EXPECT_TRUE(is_rig_recording(folder / "a.mcap"));
    const RigRecording named = read_rig_recording(folder / "a.mcap");
    bag_in_place_of_table(folder, test::bag_of(table, stamped));
    std::filesystem::remove(folder / "a.mcap");
    for (const RigRecording& bag : {named, read_rig_recording(folder)}) {
      ASSERT_EQ(bag.sightings.size(), table.sightings.size());
      ASSERT_EQ(bag.odometry.size(), table.odometry.size());
      for (std::size_t k = 0; k < table.sightings.size(); ++k) {
        EXPECT_NEAR(bag.sightings[k].t, table.sightings[k].t, 1e-9);
        EXPECT_EQ(bag.sightings[k].camera, table.sightings[k].camera);
        EXPECT_EQ(bag.tags[bag.sightings[k].tag].id, table.tags[table.sightings[k].tag].id);
        for (std::size_t i = 0; i < 4; ++i)
          EXPECT_EQ(bag.sightings[k].corners[i].x, table.sightings[k].corners[i].x);
      }
      EXPECT_LT(distance(bag.odometry[7].pose, table.odometry[7].pose), 1e-12);
    }
  }
}

TEST(RigRecording, CamerasOfABagAreThoseOfItsCameraInfoAndMountings) {
  const test::SyntheticRig rig({.seconds = 1.0});
  const std::filesystem::path folder = test::fresh_folder();
  test::write_rig(rig.recording, (folder / "").string());
  for (const char* file : {"cameras.yaml", "camera_poses.yaml"}) std::filesystem::remove(folder / file);
  bag_in_place_of_table(folder, test::bag_with_cameras(rig.recording, {}));
  const RigRecording read = read_rig_recording(folder);
  ASSERT_EQ(read.cameras.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const RigRecording::RigCamera &is = read.cameras[k], &was = rig.recording.cameras[k];
    EXPECT_EQ(is.name, was.name);
    EXPECT_EQ(is.camera.focal_length, was.camera.focal_length);
    EXPECT_EQ(is.camera.coefficients, was.camera.coefficients);
    EXPECT_LT(distance(is.mounting, was.mounting), 1e-9);
  }
  EXPECT_EQ(read.sightings.size(), rig.recording.sightings.size());
  const auto refused = [&](const char* pixels) {
    return refusal_of<std::exception>([&] { read_rig_recording(folder, pixels); });
  };
  EXPECT_THAT(refused("rectified"),
              HasSubstr("--pixels = rectified, expected raw: /cam0/camera_info has no"));
  EXPECT_THAT(refused("straight"), HasSubstr("--pixels = straight, expected raw or rectified"));

  // Without a word about the pictures either would be a guess.
  bag_in_place_of_table(folder, test::bag_with_cameras(rig.recording, {.rectified = 555.0}));
  EXPECT_THAT(refused(""),
              HasSubstr("/cam0/camera_info has a rectified picture of its own, expected --pixels"));
  EXPECT_EQ(read_rig_recording(folder, "raw").cameras[0].camera.focal_length[1], 610.0);
  const Camera straight = read_rig_recording(folder, "rectified").cameras[0].camera;
  EXPECT_EQ(straight.distortion, Distortion::none);
  EXPECT_EQ(straight.focal_length[1], 555.0);

  bag_in_place_of_table(folder, test::bag_of(rig.recording));
  EXPECT_THAT(refused(""), HasSubstr(": no CameraInfo of the frame cam0, in which /cam0/tags has tags"));
  test::BagWriter loose = test::bag_of(rig.recording);
  for (const RigRecording::RigCamera& one : rig.recording.cameras) {
    loose.add("/info" + one.name, "sensor_msgs/msg/CameraInfo", 0.0,
              test::calibration(one.camera, one.name, {}));
    loose.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, test::transform("b", one.name, {}));
  }
  loose.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, test::transform("cam0", "b", {}));
  bag_in_place_of_table(folder, loose);
  EXPECT_THAT(refused(""), HasSubstr("cam0 is mounted neither on rig nor on the frame of odom_topic"))
      << "a circle";
  loose.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, test::transform("base", "b", {}));
  bag_in_place_of_table(folder, loose);
  EXPECT_EQ(refused(""), "") << "on the body of the odometry";
  test::write_rig(rig.recording, (folder / "").string());
  EXPECT_THAT(refused("raw"), HasSubstr("--pixels = raw, expected none"));
}

/// A folder whose cameras are those of its bag.
std::filesystem::path folder_of(const RigRecording& recording, const test::BagWriter& bag) {
  std::filesystem::path folder = test::fresh_folder();
  test::write_rig(recording, (folder / "").string());
  for (const char* file : {"cameras.yaml", "camera_poses.yaml"}) std::filesystem::remove(folder / file);
  bag_in_place_of_table(folder, bag);
  return folder;
}

TEST(RigRecording, BinnedAndCroppedPicturesAreThoseOfTheWholePicture) {
  const test::SyntheticRig rig({.seconds = 0.3});
  const Camera& whole = rig.recording.cameras[0].camera;
  const RigidPose T = {{0.3, 0.2, 2.0}, turn_by({3.0, 0.2, 0.1})};
  const auto full = RigFilter::picture(whole, whole.widest(), 0.4, T);
  // Binned (b_x, b_y), from the pixel (x, y) on; without a region the whole picture.
  for (const auto& [part, width, height] :
       {std::tuple{std::array{2U, 4U, 0U, 0U, 0U, 0U}, 640, 256},
        std::tuple{std::array{0U, 1U, 100U, 60U, 800U, 900U}, 900, 800},
        std::tuple{std::array{2U, 2U, 100U, 60U, 800U, 900U}, 450, 400}}) {
    const auto folder = folder_of(rig.recording, test::bag_with_cameras(rig.recording, {.part = part}));
    const Camera read = read_rig_recording(folder).cameras[0].camera;
    EXPECT_EQ(read.width, width);
    EXPECT_EQ(read.height, height);
    const auto seen = RigFilter::picture(read, read.widest(), 0.4, T);
    ASSERT_TRUE(full && seen);
    for (int k = 0; k < 8; ++k) {
      const double b = std::max(1U, part[k % 2 == 0 ? 0 : 1]), first = part[k % 2 == 0 ? 2 : 3];
      EXPECT_NEAR(seen->corners(k, 0), (full->corners(k, 0) - first) / b, 1e-9);
    }
  }
  const auto beyond =
      folder_of(rig.recording, test::bag_with_cameras(rig.recording, {.part = {1, 1, 500, 0, 1024, 1000}}));
  EXPECT_THAT(refusal_of<std::exception>([&] { read_rig_recording(beyond); }),
              HasSubstr("on /cam0/camera_info is no sound sensor_msgs/msg/CameraInfo"));
}

TEST(RigRecording, TheFrameOfACameraIsThatOfItsRectifiedPicture) {
  const test::SyntheticRig rig({.seconds = 0.3});
  const Rotation R = turn_by({0.02, -0.03, 0.01});
  const auto folder =
      folder_of(rig.recording, test::bag_with_cameras(rig.recording, {.rectified = 555.0, .R = R}));
  const RigidPose& frame = rig.recording.cameras[0].mounting;
  const Vec3<double> corner = {0.5, 3.0, 0.7};  // in B
  const Vec3<double> in_frame = inverse(frame).R.to_G(corner - frame.p);
  // Raw pixels are those of R^T X, rectified ones those of X.
  for (const bool raw : {true, false}) {
    const RigidPose of = inverse(read_rig_recording(folder, raw ? "raw" : "rectified").cameras[0].mounting);
    EXPECT_LT(norm(of.p + of.R.to_G(corner) - (raw ? R.to_B(in_frame) : in_frame)), 1e-9) << raw;
  }
  const auto refused = [&](const test::CalibrationBeside& beside, const char* pixels) {
    const auto other = folder_of(rig.recording, test::bag_with_cameras(rig.recording, beside));
    return refusal_of<std::exception>([&] { read_rig_recording(other, pixels); });
  };
  EXPECT_EQ(refused({.R = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}, "raw"), "");
  EXPECT_THAT(refused({.R = {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}, "raw"), HasSubstr("expected a rotation"));
  for (const char* pixels : {"raw", "rectified"})
    EXPECT_THAT(refused({.rectified = 555.0, .second = -60.0}, pixels),
                HasSubstr("/cam0/camera_info: P is of the second camera of a pair, expected cameras.yaml"));
}

TEST(RigRecording, AFrameHasOneCalibrationAndOneTopicOfTags) {
  const test::SyntheticRig rig({.seconds = 0.3});
  const RigRecording::RigCamera& first = rig.recording.cameras[0];
  const auto refused = [&](const test::BagWriter& bag) {
    const auto folder = folder_of(rig.recording, bag);
    return refusal_of<std::exception>([&] { read_rig_recording(folder); });
  };
  for (const bool same : {true, false}) {
    test::BagWriter bag = test::bag_with_cameras(rig.recording, {});
    Camera other = first.camera;
    other.focal_length[0] *= same ? 1.0 : 0.5;
    bag.add("/a/camera_info", "sensor_msgs/msg/CameraInfo", 0.0, test::calibration(other, first.name, {}));
    const std::string sentence = refused(bag);
    EXPECT_EQ(sentence.empty(), same);
    if (same) continue;
    EXPECT_THAT(sentence, HasSubstr("/a/camera_info and /cam0/camera_info differ, expected one calibration "
                                    "of the frame cam0"));
  }
  test::BagWriter bag = test::bag_with_cameras(rig.recording, {});
  test::Cdr tags;
  tags << std::int32_t{1000} << std::uint32_t{0} << first.name.c_str() << std::uint32_t{1};
  test::put_tag(tags, "36h11", 10, {});
  bag.add("/others", "apriltag_msgs/msg/AprilTagDetectionArray", 1000.0, tags);
  EXPECT_THAT(refused(bag), HasSubstr("/cam0/tags and /others have tags in the frame cam0, expected"));
}

TEST(RigRecording, SamplesOfABagAreSoundAndThoseOfOtherTopicsDoNotCount) {
  const test::SyntheticRig rig({.seconds = 0.5});
  const auto with = [&](const RigRecording& recording, const std::function<void(test::BagWriter&)>& add) {
    test::BagWriter bag = test::bag_of(recording);
    add(bag);
    const std::filesystem::path folder = test::fresh_folder();
    test::write_rig(rig.recording, (folder / "").string());
    replace_in(folder / "tagslam.yaml", "     is_static: false\n",
               "     is_static: false\n     imu_topic: /imu\n     T_body_imu: {position: {x: 0, y: 0, z: 0}, "
               "rotation: {x: 0, y: 0, z: 0}}\n");
    bag_in_place_of_table(folder, bag);
    return refusal_of<std::exception>([&] { read_rig_recording(folder); });
  };
  const auto imus = [](const char* topic, double begin, double rate, double covariance) {
    return [=](test::BagWriter& bag) {
      for (int k = 0; k <= 10; ++k) {
        const double t = begin + 0.05 * k;
        bag.add(topic, "sensor_msgs/msg/Imu", 1000.0 + 0.05 * k, test::imu(t, {0, 0, rate}, covariance));
      }
    };
  };
  const auto sound = imus("/imu", 1000.0, 0.1, 0.0);
  EXPECT_EQ(with(rig.recording, sound), "");
  EXPECT_THAT(with(rig.recording, imus("/imu", 1000.0, 1e200, 0.0)), HasSubstr("on /imu is no sound"));
  EXPECT_THAT(with(rig.recording, imus("/imu", 1000.0, 0.0, -1.0)),
              HasSubstr("no turn rate of a sensor_msgs/Imu by imu_topic = /imu, expected some"))
      << "-1: there is no measurement";
  RigRecording far = rig.recording;
  far.odometry[3].pose.p.x = 1e300;
  EXPECT_THAT(with(far, sound), HasSubstr("on /odom is no sound nav_msgs/msg/Odometry"));
  // Since the start of another computer, and damaged.
  EXPECT_EQ(with(rig.recording,
                 [&](test::BagWriter& bag) {
                   sound(bag);
                   imus("/other/imu", 201'000.0, 1e200, 0.0)(bag);
                   bag.add("/other/odom", "nav_msgs/msg/Odometry", 1000.0, test::Cdr() << 1.0);
                 }),
            "");
  EXPECT_THAT(with(rig.recording,
                   [&](test::BagWriter& bag) {
                     sound(bag);
                     test::Cdr tags;
                     tags.stamp(1000.0) << std::uint32_t{1};
                     bag.add("/cam0/tags", "apriltag_msgs/msg/AprilTagDetectionArray", 1000.0,
                             test::put_tag(tags, "41h12", 10, {}));
                   }),
              HasSubstr("tags of the families 36h11 and 41h12, expected one"));
}

TEST(RigRecording, CamerasBesideTheOdometryOnACommonFrameAreMountedOnTheBody) {
  const test::SyntheticRig rig({.seconds = 0.3});
  const RigidPose odometry = {{0.2, -0.1, 0.3}, turn_by({0.3, 0.1, -0.2})};
  test::BagWriter bag = test::bag_of(rig.recording);
  bag.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, test::transform("link", "base", odometry));
  for (const RigRecording::RigCamera& one : rig.recording.cameras) {
    bag.add("/info" + one.name, "sensor_msgs/msg/CameraInfo", 0.0,
            test::calibration(one.camera, one.name, {}));
    bag.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0,
            test::transform("link", one.name, odometry * one.mounting));
  }
  const RigRecording read = read_rig_recording(folder_of(rig.recording, bag));
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_LT(distance(read.cameras[k].mounting, rig.recording.cameras[k].mounting), 1e-9);
}

TEST(RigRecording, MutatedRecordingsAreReadOrRefusedInOneSentence) {
  const int accepted = test::read_mutated_rigs(1'600, 1, test::fresh_folder());
  EXPECT_GT(accepted, 200);
  EXPECT_LT(accepted, 1'400);
}

TEST(LocalizeRig, ABagOfTagSlamGivesTheResultOfItsTable) {
  const std::filesystem::path file = test::of_data("tagslam/t22_tagslam.yaml");
  if (file.empty()) return;
  const RigRecording table = read_rig_recording(file.parent_path() / "t22");
  const std::filesystem::path folder = test::fresh_folder();
  for (const char* name : {"tagslam.yaml", "cameras.yaml", "camera_poses.yaml", "reference.csv.gz"})
    std::filesystem::copy_file(file.parent_path() / (std::string("t22_") + name), folder / name);
  RigRecording raw = table;
  // Rows are of the odometry's own frame, T_body_odom.
  const RigidPose of_odometry = {{0, 0.032, 0}, turn_by({1.21793871, -1.20341061, 1.21309601})};
  for (auto& one : raw.odometry) one.pose = one.pose * of_odometry;
  write_bag(folder / "t22.mcap", test::bag_of(raw, true, "/camera/odom/sample"));
  const RigRecording bag = read_rig_recording(folder);
  const RigNoise noise{.corner_noise = table.corner_noise};
  const RigLocalization one = localize_rig(table, noise, false), other = localize_rig(bag, noise, false);
  EXPECT_EQ(one.accepted, other.accepted);
  EXPECT_NEAR(one.of_filter.rmse, other.of_filter.rmse, 1e-4);
  EXPECT_NEAR(one.in_view.rmse, other.in_view.rmse, 1e-4);
}

TEST(LocalizeRig, AGyroscopeTurnsInPlaceOfTheOdometryOrOfAConstantVelocity) {
  for (const bool odometry : {true, false}) {
    test::RecordedRig of{.odometry = odometry, .seconds = 34.0};
    of.noise.rotation_walk = 0.1;
    // Nothing is seen for two thirds of each 6 s, also not at the end and in the middle.
    const auto hide = [](RigRecording& recording) {
      std::erase_if(recording.sightings, [&](const RigRecording::Sighting& z) {
        return std::fmod(z.t - recording.start, 6.0) > 2.0;
      });
    };
    const auto turn = [&](RigRecording& recording) {
      hide(recording);
      add_gyroscope(recording, {0.03, -0.02, 0.04}, of.noise.gyro_noise);
    };
    test::SyntheticRig seen(of), turned(of);
    hide(seen.recording), turn(turned.recording);
    const RigLocalization without = localize_rig(seen.recording, of.noise),
                          with = localize_rig(turned.recording, of.noise);
    EXPECT_LT(with.of_filter.attitude_rmse, 0.5 * without.of_filter.attitude_rmse) << odometry;
    EXPECT_LT(with.of_smoother.attitude_rmse, 0.5 * without.of_smoother.attitude_rmse) << odometry;
    expect_right_nees(mean_nees(of, nees_seeds, turn));
  }
}

TEST(LocalizeRig, AGyroscopeIsFollowedOverGapsWithAReferenceOrWithout) {
  test::RecordedRig of{.odometry = false, .seconds = 30.0};
  of.noise.acceleration_walk = 0.1;
  test::SyntheticRig rig(of);
  add_gyroscope(rig.recording, {0.03, -0.02, 0.04}, of.noise.gyro_noise);
  std::erase_if(rig.recording.sightings, [&](const RigRecording::Sighting& z) {
    return std::fmod(z.t - rig.recording.start, 6.0) > 1.0;
  });
  const RigLocalization with = localize_rig(rig.recording, of.noise);
  rig.recording.reference.clear();
  const RigLocalization without = localize_rig(rig.recording, of.noise);
  ASSERT_EQ(with.fits.size(), without.fits.size());
  for (std::size_t k = 0; k < with.fits.size(); ++k) {
    EXPECT_EQ(with.fits[k].verdict, without.fits[k].verdict) << k;
    if (with.fits[k].verdict == TagVerdict::accepted) {
      EXPECT_NEAR(with.fits[k].squared, without.fits[k].squared, 0.01 * with.fits[k].squared) << k;
    }
  }
}

TEST(LocalizeRig, ABiasOutlastsThePose) {
  test::SyntheticRig rig({.odometry = false, .seconds = 20.0});
  const Vec3<double> bias = {0.06, -0.05, 0.08};
  add_gyroscope(rig.recording, bias, 0.002);
  // Everything is elsewhere from the middle on.
  const double middle = rig.recording.start + 10.0;
  std::vector<RigRecording::Sighting>& all = rig.recording.sightings;
  for (RigRecording::Sighting& z : all)
    if (z.t > middle)
      for (Vec2<double>& corner : z.corners) corner.x -= 200.0;
  RigFilter filter(rig.recording, {});
  double last = rig.recording.start;
  bool anew = false;
  for (std::size_t k = 0; k < all.size() && !anew;) {
    std::size_t end = k;
    while (end < all.size() && all[end].t == all[k].t) ++end;
    const double dt = all[k].t - last;
    const auto at = std::find_if(rig.recording.turn_rates.begin(), rig.recording.turn_rates.end(),
                                 [&](const auto& one) { return one.t > last; });
    if (dt > 0) filter.coast(dt * at->omega, dt, false);
    std::vector<TagFit> fits(end - k);
    anew = filter.take({all.data() + k, end - k}, fits) && k > 0;
    last = all[k].t, k = end;
  }
  ASSERT_TRUE(anew);
  EXPECT_LT(norm(vec3(filter.velocity(), 3) - bias), 0.02);
  for (int i = 9; i < 12; ++i) EXPECT_LT(filter.covariance()(i, i), square(0.02));
}

TEST(RigRecording, AnImuIsReadAboutTheAxesOfTheBody) {
  test::SyntheticRig rig({.seconds = 2.0});
  const std::filesystem::path folder = test::fresh_folder();
  const RigidPose mounting = {{1, 2, 3}, turn_by({0.4, -0.5, 0.6})};
  add_gyroscope(rig.recording, {}, 0.0);
  test::BagWriter bag = test::bag_of(rig.recording);
  const auto add_imu = [&](const RigRecording::TurnRate& one) {
    bag.add("/imu", "sensor_msgs/msg/Imu", one.t, test::imu(one.t, mounting.R.to_B(one.omega)));
  };
  for (const RigRecording::TurnRate& one : rig.recording.turn_rates) add_imu(one);
  const auto with = [&](const std::string& keys) {
    test::write_rig(rig.recording, (folder / "").string());
    replace_in(folder / "tagslam.yaml", "     is_static: false\n", "     is_static: false\n" + keys);
    bag_in_place_of_table(folder, bag);
  };
  const auto refused = [&] { return refusal_of<std::exception>([&] { read_rig_recording(folder); }); };
  with("");
  EXPECT_TRUE(read_rig_recording(folder).turn_rates.empty());
  with("     imu_topic: /imus\n");
  EXPECT_THAT(refused(), HasSubstr("by imu_topic = /imus, expected some, the nearest is \"/imu\""));
  with("     imu_topic: /imu\n");
  EXPECT_THAT(refused(), HasSubstr("map is mounted neither on rig nor on"));
  bag.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, test::transform("rig", "map", mounting));
  with("     imu_topic: /imu\n");
  const RigRecording read = read_rig_recording(folder);
  ASSERT_EQ(read.turn_rates.size(), rig.recording.turn_rates.size());
  for (std::size_t k = 0; k < read.turn_rates.size(); ++k)
    EXPECT_LT(norm(read.turn_rates[k].omega - rig.recording.turn_rates[k].omega), 1e-9);
  with(
      "     imu_topic: /imu\n     T_body_imu: {position: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: "
      "0}}\n");
  EXPECT_LT(norm(mounting.R.to_G(read_rig_recording(folder).turn_rates[9].omega) - read.turn_rates[9].omega),
            1e-9);
  auto& last = rig.recording.odometry.back();
  last.t += 5.0;
  bag = test::bag_of(rig.recording);
  for (const RigRecording::TurnRate& one : rig.recording.turn_rates) add_imu(one);
  bag.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, test::transform("rig", "map", mounting));
  with("     imu_topic: /imu\n");
  EXPECT_THAT(refused(), HasSubstr("no turn rate by imu_topic = /imu from 1001.9"));
}

TEST(LocalizeRig, KeepsItsAccuracyOnTagSlam) {
  struct Expected {
    const char* name;
    double in_view, smoothed;  // [m]
  };
  for (const Expected& one : {Expected{"t22", 0.06, 0.06}, Expected{"t11", 0.17, 0.10},
                              Expected{"t1", 0.08, 0.045}, Expected{"t16", 0.035, 0.03}}) {
    const std::filesystem::path file = test::of_data(std::string("tagslam/") + one.name + "_tagslam.yaml");
    if (file.empty()) return;
    const RigRecording recording = read_rig_recording(file.parent_path() / one.name);
    const RigNoise noise = identify_motion(recording, {.corner_noise = recording.corner_noise}).noise;
    const RigLocalization result = localize_rig(recording, noise);
    EXPECT_LT(result.in_view.rmse, one.in_view) << one.name;
    EXPECT_LT(result.of_smoother.rmse, one.smoothed) << one.name;
    // The reference is made of the same corners, so it may be nearer than an independent one.
    for (const RigAccuracy* of : {&result.of_filter, &result.in_view, &result.of_smoother})
      EXPECT_LT(of->anees, 2 * of->bounds[1]) << one.name;
  }
}

}  // namespace
}  // namespace sightline
