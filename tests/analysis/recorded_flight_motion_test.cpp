#include "sightline/analysis/identification/recorded_flight_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "sightline/analysis/identification/identify.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/lagging_flight.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/ros_bag.hpp"
#include "tests/support/shared_data.hpp"

namespace sightline::test {
namespace {

using testing::HasSubstr;

FlownMotion motion_in(const std::string& log) { return motion_of(ULog(log, "x.ulg"), "uav0"); }

// The model that flew is in the family: its lags are found.
TEST(RecordedFlightMotion, TheLagsOfAVehicleAreFoundInItsLog) {
  const FlownMotion motion = motion_in(ulog_of(LaggingFlight(30.0), 5));
  EXPECT_TRUE(motion.truth.empty());
  const Identification found = identify(motion);
  EXPECT_TRUE(found.best.structure.coriolis);
  EXPECT_GT(found.error().r2, 0.999);
  for (const FoundNumber& one : found.best.found) {
    const bool is_lag = one.number.unit == "s" && one.number.key != "delay";
    const double lag = one.number.key == "tau_z"     ? LaggingFlight::tau_z
                       : one.number.key == "tau_psi" ? LaggingFlight::tau_psi
                                                     : LaggingFlight::tau;
    const double expected = is_lag ? lag : 0.0;
    EXPECT_NEAR(one.value, expected, 0.012) << one.number.key;
  }
}

TEST(RecordedFlightMotion, AreInTheFrameGWithCommandsInV) {
  const LaggingFlight flight(8.0);
  const FlownMotion motion = motion_in(ulog_of(flight, 5));
  ASSERT_EQ(motion.size(), 401U);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const LaggingFlight::Row& row = flight.rows[10 * k];
    const SeenMotion& seen = motion.measured[k];
    const double c = std::cos(row.psi), s = std::sin(row.psi);
    EXPECT_LE(norm(seen.p - row.p), 2e-3);
    EXPECT_NEAR(seen.psi, row.psi, 1e-3) << "without jumps";
    EXPECT_NEAR(seen.v_f, c * row.v.x + s * row.v.y, 0.02);
    EXPECT_NEAR(seen.v_s, -s * row.v.x + c * row.v.y, 0.02);
    if (k % 35 == 0) continue;
    EXPECT_NEAR(motion.u[k][0], c * row.u.x + s * row.u.y, 2e-3);
    EXPECT_NEAR(motion.u[k][3], row.u_psi, 1e-6);
  }
}

// At 5 Hz the log has samples of a stream, between which commands are interpolated.
TEST(RecordedFlightMotion, CommandsThatWereRecordedSeldomAreInterpolated) {
  const LaggingFlight flight(8.0);
  const FlownMotion seldom = motion_in(ulog_of(flight, 100));
  bool between = false;
  for (std::size_t k = 0; k + 10 < seldom.size(); k += 10) {
    const double a = seldom.u[k][2], b = seldom.u[k + 10][2];
    EXPECT_NEAR(seldom.u[k + 5][2], 0.5 * (a + b), 1e-6);
    between = between || std::abs(a - b) > 0.1;
  }
  EXPECT_TRUE(between);
}

TEST(RecordedFlightMotion, OnlySetPointsThatTheVehicleFollowedCount) {
  const LaggingFlight flight(8.0);
  EXPECT_THAT(refusal_of([&] { motion_in(ulog_of(flight, 5, {.arming = 1})); }),
              HasSubstr("no set-points of velocity while the vehicle was in Offboard"));
  EXPECT_THAT(refusal_of([&] { motion_in(ulog_of(flight, 5, {.mode = 4})); }),
              HasSubstr("no set-points of velocity while the vehicle was in Offboard"));
  // A reset of the estimate divides the flight; the longer part counts.
  const FlownMotion longer = motion_in(ulog_of(flight, 5, {.reset_at = 102.0}));
  EXPECT_NEAR(longer.seconds(), 6.0, 0.05);
  EXPECT_LE(norm(longer.measured.front().p - flight.rows[1005].p), 0.02);
}

TEST(RecordedFlightMotion, ATableHasTheSameMotionAsALog) {
  const LaggingFlight flight(8.0);
  CsvColumns table{.names = {"t", "x", "y", "z", "heading", "vx", "vy", "vz", "ux", "uy", "uz", "ur"},
                   .values = {}};
  table.values.resize(table.names.size());
  for (std::size_t k = 0; k < flight.rows.size(); k += 5) {
    const LaggingFlight::Row& r = flight.rows[k];
    const std::array<double, 12> numbers = {r.t,   r.p.x, r.p.y, r.p.z, wrap(r.psi), r.v.x,
                                            r.v.y, r.v.z, r.u.x, r.u.y, r.u.z,       r.u_psi};
    for (std::size_t i = 0; i < numbers.size(); ++i) table.values[i].push_back(numbers[i]);
  }
  const FlownMotion of_table = motion_of(table, "uav0"), of_log = motion_in(ulog_of(flight, 5));
  ASSERT_EQ(of_table.size(), of_log.size());
  for (std::size_t k = 0; k < of_table.size(); ++k) {
    EXPECT_LE(norm(of_table.measured[k].p - of_log.measured[k].p), 2e-3);
    EXPECT_NEAR(of_table.measured[k].v_f, of_log.measured[k].v_f, 0.02);
    if (k % 35 == 0) continue;
    EXPECT_NEAR(of_table.u[k][1], of_log.u[k][1], 2e-3);
  }
  table.values[0][7] = table.values[0][6];
  EXPECT_THAT(refusal_of([&] { motion_of(table, "uav0"); }), HasSubstr("in row 8 of numbers after 100.06"));
  table.names[11] = "rate";
  EXPECT_THAT(
      refusal_of([&] { motion_of(table, "uav0"); }),
      HasSubstr("no column \"ur\", expected the columns t, x, y, z, heading, vx, vy, vz, ux, uy, uz, ur"));
}

TEST(RecordedFlightMotion, ABagHasTheSameMotionAsALog) {
  const LaggingFlight flight(8.0);
  const std::filesystem::path file = fresh_folder() / "flight.mcap";
  std::ofstream(file, std::ios::binary) << bag_of(flight).bytes("zstd");
  const RosBag bag(file);
  const FlownMotion of_bag = motion_of(bag, "uav0", "/odom", ""), of_log = motion_in(ulog_of(flight, 5));
  ASSERT_EQ(of_bag.size(), of_log.size());
  for (std::size_t k = 0; k < of_bag.size(); ++k) {
    EXPECT_LE(norm(of_bag.measured[k].p - of_log.measured[k].p), 2e-3);
    EXPECT_NEAR(of_bag.measured[k].v_f, of_log.measured[k].v_f, 0.02);
    if (k % 35 == 0) continue;
    EXPECT_NEAR(of_bag.u[k][0], of_log.u[k][0], 2e-3);
    EXPECT_NEAR(of_bag.u[k][1], of_log.u[k][1], 2e-3);
  }
  EXPECT_EQ(refusal_of([&] { motion_of(bag, "uav0", "", "/cmd"); }),
            "--body is missing, expected one of /odom, /pose, /poses:cf1, /tf:tag, /tf:uav0");
  EXPECT_EQ(refusal_of([&] { recorded_motion(file, RecordingKind::bag, {.columns = {"t"}}); }),
            "--columns of a recording that has names itself, expected none");
  EXPECT_EQ(refusal_of([&] { recorded_motion(file, RecordingKind::ulog, {.body = "/odom"}); }),
            "--body and --commands, expected them for a bag of ROS 2 alone");
}

TEST(RecordedFlightMotion, ALogOfPx4IsAFlightOrSaysWhyNot) {
  const std::filesystem::path brief = of_data("px4/identify_short.ulg.zst"),
                              flown = of_data("px4/flight_vision_uav0.ulg.zst");
  if (brief.empty() || flown.empty()) return;
  const FlownMotion motion = recorded_motion(flown, RecordingKind::ulog, {});
  EXPECT_EQ(motion.robot, "flight_vision_uav0");
  EXPECT_NEAR(motion.seconds(), 61.8, 0.1);
  EXPECT_EQ(motion.truth.size(), motion.size());
  // The position drifts, for it comes from a camera; velocity and heading show that frames and
  // times agree.
  double velocity = 0.0, heading = 0.0;
  for (std::size_t k = 0; k < motion.size(); ++k) {
    velocity += square(motion.truth[k].v_f - motion.measured[k].v_f);
    heading = std::max(heading, std::abs(wrap(motion.truth[k].psi - motion.measured[k].psi)));
  }
  EXPECT_LE(std::sqrt(velocity / static_cast<double>(motion.size())), 0.08);
  EXPECT_LE(heading, 0.1);
  // Its offboard flight was over after 2 s.
  EXPECT_EQ(refusal_of([&] { identify(recorded_motion(brief, RecordingKind::ulog, {.name = "uav0"})); }),
            "uav0: 2 s of flight, expected at least 5 s");
}

}  // namespace
}  // namespace sightline::test
