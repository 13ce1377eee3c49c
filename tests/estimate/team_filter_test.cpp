#include "sightline/estimate/team_filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/counted_new.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/synthetic_team.hpp"

namespace sightline {
namespace {

PoseGuess guess(const PlanarPose& pose, double position, double heading) {
  PoseGuess of{pose, {}};
  of.P(0, 0) = of.P(1, 1) = square(position), of.P(2, 2) = square(heading);
  return of;
}

Column<3> error_of(const PlanarPose& of, const PlanarPose& truth) {
  return {{{{of.x - truth.x}, {of.y - truth.y}, {wrap(of.psi - truth.psi)}}}};
}

/// Sums over a drive of a synthetic team.
struct Drive {
  double nees = 0.0, squared = 0.0, constants = 0.0;
  int samples = 0, members = 0, associated = 0, wrong = 0, left_out = 0;

  double anees() const { return nees / samples; }
  double rmse() const { return std::sqrt(squared / samples); }
};

struct Choice {
  double seconds = 60.0;
  bool identities = true;
  int robots = 3, landmarks = 8;
};

void drive(Drive& sums, const TeamNoise& drawn, const TeamNoise& assumed, std::uint64_t seed,
           const Choice& choice = {}) {
  test::SyntheticTeam team(choice.robots, choice.landmarks, drawn, seed);
  TeamFilter filter(std::vector<double>(static_cast<std::size_t>(choice.robots), 0.0), team.marks, assumed,
                    0.0);
  std::vector<std::size_t> taken(team.members.size(), 0);
  for (int i = 0; i < choice.robots; ++i) {
    const PlanarPose& at = team.members[static_cast<std::size_t>(i)].pose;
    filter.start(
        i, guess({at.x + team.drawn(0.05), at.y + team.drawn(0.05), at.psi + team.drawn(0.05)}, 0.05, 0.05));
  }
  double sight = 0.1, judged = 5.0;
  while (team.time() < choice.seconds) {
    team.step();
    for (std::size_t i = 0; i < team.members.size(); ++i)
      while (taken[i] < team.members[i].odometry.size())
        filter.take(static_cast<int>(i), team.members[i].odometry[taken[i]++]);
    filter.advance(team.time());
    if (team.time() >= sight) {
      sight += test::SyntheticTeam::sight_period;
      for (int i = 0; i < choice.robots; ++i) {
        std::vector<TeamSighting> seen = team.sightings(i);
        if (choice.identities) {
          for (const TeamSighting& z : seen) filter.take(z);
          continue;
        }
        std::vector<TeamSighting> unknown = seen;
        for (TeamSighting& z : unknown) z.subject = TeamSighting::unidentified;
        std::vector<TeamFit> fits(seen.size());
        filter.take_unidentified(unknown, fits);
        for (std::size_t k = 0; k < fits.size(); ++k) {
          if (fits[k].subject == TeamSighting::unidentified) {
            ++sums.left_out;
          } else {
            ++sums.associated;
            sums.wrong += fits[k].subject != seen[k].subject ? 1 : 0;
          }
        }
      }
    }
    if (team.time() >= judged) {
      judged += 1.0;
      for (int i = 0; i < choice.robots; ++i) {
        const Column<3> e = error_of(filter.pose(i).pose, team.members[static_cast<std::size_t>(i)].pose);
        sums.nees += mahalanobis(e, filter.pose(i).P);
        sums.squared += square(e(0, 0)) + square(e(1, 0));
        ++sums.samples;
      }
    }
  }
  for (int i = 0; i < choice.robots; ++i) {
    const auto& of = team.members[static_cast<std::size_t>(i)].of;
    for (const auto& [state, truth] : {std::pair{RobotState::speed_scale, of.speed_scale},
                                       {RobotState::turn_scale, of.turn_scale},
                                       {RobotState::turn_loss, of.turn_loss},
                                       {RobotState::yaw_rate_bias, of.yaw_rate_bias},
                                       {RobotState::clock_offset, of.clock_offset},
                                       {RobotState::wheel_turn, of.wheel_turn},
                                       {RobotState::sensor_turn, of.sensor_turn},
                                       {RobotState::range_scale, of.range_scale},
                                       {RobotState::range_depth, of.range_depth},
                                       {RobotState::axis_turn, of.axis_turn},
                                       {RobotState::range_offset, of.range_offset},
                                       {RobotState::bearing_scale, of.bearing_scale}}) {
      sums.constants += square((filter.state(i, state) - truth) / filter.sigma(i, state));
      ++sums.members;
    }
  }
}

TeamNoise synthetic() {
  TeamNoise noise;
  noise.turn_loss = 0.02, noise.sensor_turn = 0.05, noise.clock_offset = 0.05;
  noise.range_error = 0.03, noise.bearing_error = 0.01, noise.bearing_noise = 0.01;
  return noise;
}

/// Noise of sensors without constant errors.
TeamNoise calibrated() {
  TeamNoise noise;
  noise.sensor_turn = noise.range_depth = noise.axis_turn = noise.range_scale = noise.range_offset =
      noise.bearing_scale = 0.0;
  return noise;
}

TEST(TeamFilter, IsConsistentWithErrorsThatLastForAnyTime) {
  for (const double time : {0.5, 2.0, 5.0}) {
    TeamNoise noise = synthetic();
    noise.range_error_time = noise.bearing_error_time = time;
    Drive sums;
    for (std::uint64_t seed = 1; seed <= 30; ++seed) drive(sums, noise, noise, seed);
    EXPECT_GE(sums.anees(), 0.8 * 3) << time;
    EXPECT_LE(sums.anees(), 1.25 * 3) << time;
    EXPECT_LE(sums.constants / sums.members, 1.5) << time << ": constants in units of their sigma, squared";
  }
}

TEST(TeamFilter, IsOverconfidentIfItTakesLastingErrorsForWhiteNoise) {
  TeamNoise drawn = synthetic();
  drawn.range_error_time = drawn.bearing_error_time = 5.0;
  TeamNoise white = drawn;
  white.range_error = white.bearing_error = 0.0;
  white.range_share = std::hypot(drawn.range_share, drawn.range_error);
  white.bearing_noise = std::hypot(drawn.bearing_noise, drawn.bearing_error);
  Drive sums, right;
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    drive(sums, drawn, white, seed), drive(right, drawn, drawn, seed);
  EXPECT_GE(sums.anees(), 1.5 * right.anees());
}

TEST(TeamFilter, FindsTheConstantsOfOdometryAndSensor) {
  TeamNoise noise = synthetic();
  noise.clock_offset = 0.2;
  test::SyntheticTeam team(1, 12, noise, 3);
  TeamFilter filter({0.0}, team.marks, noise, 0.0);
  auto& member = team.members[0];
  member.of = {.speed_scale = 0.06,
               .turn_scale = -0.1,
               .turn_loss = 0.03,
               .yaw_rate_bias = 0.004,
               .clock_offset = 0.3,
               .wheel_turn = 0.06,
               .sensor_turn = 0.07,
               .range_scale = 0.04,
               .range_depth = 1.0,
               .range_offset = 0.05,
               .bearing_scale = 0.05};
  filter.start(0, guess(member.pose, 0.01, 0.01));
  std::size_t taken = 0;
  double sight = 0.0;
  while (team.time() < 240.0) {
    team.step();
    while (taken < member.odometry.size()) filter.take(0, member.odometry[taken++]);
    filter.advance(team.time());
    if (team.time() < sight) continue;
    sight += test::SyntheticTeam::sight_period;
    for (const TeamSighting& z : team.sightings(0)) filter.take(z);
  }
  EXPECT_NEAR(filter.state(0, RobotState::clock_offset), 0.3, 0.05);
  EXPECT_NEAR(filter.state(0, RobotState::sensor_turn), 0.07, 0.03);
  EXPECT_NEAR(filter.state(0, RobotState::wheel_turn), 0.06, 0.03);
  EXPECT_NEAR(filter.state(0, RobotState::range_depth), 1.0, 0.15);
  EXPECT_NEAR(filter.state(0, RobotState::bearing_scale), 0.05, 0.03);
  EXPECT_NEAR(filter.state(0, RobotState::speed_scale), 0.06, 0.05);
  EXPECT_NEAR(filter.state(0, RobotState::turn_scale), -0.1, 0.05);
  EXPECT_LE(filter.sigma(0, RobotState::clock_offset), 0.1 * noise.clock_offset);
  EXPECT_LE(filter.sigma(0, RobotState::sensor_turn), 0.5 * noise.sensor_turn);
}

TEST(TeamFilter, NoNumberOfSightingsAveragesALastingErrorAway) {
  TeamNoise noise = calibrated();
  noise.range_error_time = noise.bearing_error_time = 1e9;
  TeamFilter filter({0.0}, {{2.0, 0.0, 0.0}}, noise, 0.0);
  filter.start(0, guess({}, 1.0, 1e-6));
  TeamSighting z;
  z.subject = 1, z.range = 2.0;
  for (int k = 0; k < 2000; ++k) {
    ASSERT_EQ(filter.take(z).verdict, FitVerdict::accepted);
  }
  const double range_sigma = std::sqrt(filter.pose(0).P(0, 0)), across = std::sqrt(filter.pose(0).P(1, 1));
  EXPECT_NEAR(range_sigma, 2.0 * noise.range_error, 0.05 * 2.0 * noise.range_error);
  EXPECT_NEAR(across, 2.0 * noise.bearing_error, 0.05 * 2.0 * noise.bearing_error);
}

TEST(TeamFilter, TurningTheWorldTurnsTheEstimates) {
  const double angle = 0.7;
  const auto turned = [&](const PlanarPose& p) {
    const double c = std::cos(angle), s = std::sin(angle);
    return PlanarPose{c * p.x - s * p.y + 5.0, s * p.x + c * p.y - 3.0, p.psi + angle};
  };
  test::SyntheticTeam team(2, 6, synthetic(), 7);
  std::vector<TeamFilter::Landmark> marks;
  for (const auto& mark : team.marks) {
    const PlanarPose to = turned({mark.x, mark.y, 0.0});
    marks.push_back({to.x, to.y, 0.0});
  }
  TeamFilter a({0.0, 0.0}, team.marks, synthetic(), 0.0), b({0.0, 0.0}, marks, synthetic(), 0.0);
  for (int i = 0; i < 2; ++i) {
    const PlanarPose& at = team.members[static_cast<std::size_t>(i)].pose;
    a.start(i, guess(at, 0.05, 0.05)), b.start(i, guess(turned(at), 0.05, 0.05));
  }
  std::array<std::size_t, 2> taken{};
  for (int k = 0; k < 1500; ++k) {
    team.step();
    for (std::size_t i = 0; i < 2; ++i)
      for (; taken[i] < team.members[i].odometry.size(); ++taken[i])
        for (TeamFilter* f : {&a, &b}) f->take(static_cast<int>(i), team.members[i].odometry[taken[i]]);
    a.advance(team.time()), b.advance(team.time());
    if (k % 13 != 0) continue;
    for (int i = 0; i < 2; ++i)
      for (const TeamSighting& z : team.sightings(i)) a.take(z), b.take(z);
  }
  for (int i = 0; i < 2; ++i) {
    const Column<3> e = error_of(b.pose(i).pose, turned(a.pose(i).pose));
    for (int l = 0; l < 3; ++l) EXPECT_NEAR(e(l, 0), 0.0, 1e-6);
    EXPECT_NEAR(trace(b.pose(i).P), trace(a.pose(i).P), 1e-6 * trace(a.pose(i).P));
  }
}

TEST(TeamFilter, AssociatesSightingsWithoutIdentityAndLosesLittle) {
  Drive known, unknown;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    drive(known, synthetic(), synthetic(), seed);
    drive(unknown, synthetic(), synthetic(), seed, {.identities = false});
  }
  EXPECT_LE(unknown.rmse(), 1.3 * known.rmse());
  EXPECT_LE(unknown.wrong, 0.02 * unknown.associated);
  EXPECT_GE(unknown.associated, 3 * unknown.left_out);
}

TEST(TeamFilter, LeavesOutWhatTwoBodiesExplain) {
  TeamNoise noise;
  TeamFilter filter({0.0}, {{3.0, 0.02, 0.0}, {3.0, -0.02, 0.0}, {3.0, 1.5, 0.0}}, noise, 0.0);
  filter.start(0, guess({}, 0.05, 0.05));
  std::array<TeamSighting, 2> frame;
  frame[0].range = 3.0, frame[0].bearing = 0.0;
  frame[1].range = norm(3.0, 1.5), frame[1].bearing = std::atan2(1.5, 3.0);
  std::array<TeamFit, 2> fits;
  filter.take_unidentified(frame, fits);
  EXPECT_EQ(fits[0].subject, TeamSighting::unidentified);
  EXPECT_EQ(fits[1].subject, 3);
  EXPECT_EQ(fits[1].verdict, FitVerdict::accepted);
}

TEST(TeamFilter, SharedErrorsOfAFrameDecideTheAssociation) {
  // A heading that is wrong by 0.12 rad shifts both sightings. Alone the first fits landmark 1, on
  // its right, better.
  TeamNoise noise = calibrated();
  const std::vector<TeamFilter::Landmark> marks = {{3.0, 0.0, 0.0}, {3.0, -0.5, 0.0}, {2.0, 2.0, 0.0}};
  TeamFilter filter({0.0}, marks, noise, 0.0);
  filter.start(0, guess({}, 0.01, 0.1));
  const double turn = 0.12;
  std::array<TeamSighting, 2> frame;
  frame[0].range = 3.0, frame[0].bearing = 0.0 - turn;
  frame[1].range = norm(2.0, 2.0), frame[1].bearing = std::atan2(2.0, 2.0) - turn;
  std::array<TeamFit, 2> fits;
  filter.take_unidentified(frame, fits);
  EXPECT_EQ(fits[0].subject, 1);
  EXPECT_EQ(fits[1].subject, 3);
  EXPECT_NEAR(filter.pose(0).pose.psi, turn, 0.03);
}

TEST(TeamFilter, RefusesAMisreadIdentityAndFollowsASlip) {
  TeamNoise noise;
  TeamFilter filter({0.0}, {{3.0, 0.0, 0.0}, {0.0, 3.0, 0.0}}, noise, 0.0);
  filter.start(0, guess({}, 0.01, 0.01));
  TeamSighting z;
  z.subject = 2, z.range = 3.0;
  EXPECT_EQ(filter.take(z).verdict, FitVerdict::rejected);
  EXPECT_NEAR(filter.pose(0).pose.psi, 0.0, 1e-12);
  z.subject = 1, z.bearing = -0.2;  // the robot has turned by 0.2 rad in one place
  EXPECT_EQ(filter.take(z).verdict, FitVerdict::rejected) << "one bearing may be false";
  filter.advance(0.2);
  EXPECT_EQ(filter.take(z).verdict, FitVerdict::accepted);
  EXPECT_NEAR(filter.pose(0).pose.psi, 0.2, 0.03);
}

TeamNoise with_known_clock() {
  TeamNoise noise = calibrated();
  noise.clock_offset = 0.0;
  return noise;
}

/// Drives a robot for 10 s, turning to and fro, and puts it at the origin.
void drive_to_origin(TeamFilter& filter) {
  for (int k = 0; k < 100; ++k) filter.take(0, {0.1 * k, 0.1, k % 20 < 10 ? 0.3 : -0.3});
  filter.take(0, {10.0, 0.0, 0.0});
  filter.advance(10.0);
  filter.start(0, guess({}, 0.01, 0.01));
}

const std::vector<TeamFilter::Landmark> three = {{3.0, 0.0, 0.0}, {2.0, 1.5, 0.0}, {3.5, -1.0, 0.0}};

/// What a robot at a pose sees of a landmark.
TeamSighting sighting_of(int landmark, const PlanarPose& from, double t) {
  const auto& at = three[static_cast<std::size_t>(landmark)];
  TeamSighting z;
  z.stamp = t, z.subject = 1 + landmark;
  z.range = norm(at.x - from.x, at.y - from.y);
  z.bearing = wrap(std::atan2(at.y - from.y, at.x - from.x) - from.psi);
  return z;
}

TEST(TeamFilter, InAGapOfOdometryTheMotionIsAsUncertainAsThatOfTheDrive) {
  TeamFilter filter({0.0}, {}, with_known_clock(), 0.0);
  drive_to_origin(filter);
  filter.advance(11.0);
  EXPECT_LE(filter.sigma(0, RobotState::psi), 0.02) << "shorter than a gap";
  filter.advance(12.0);
  EXPECT_NEAR(filter.sigma(0, RobotState::psi), std::sqrt(2.0) * 0.3 * 2.0, 0.05);
  EXPECT_NEAR(filter.sigma(0, RobotState::x), std::sqrt(2.0) * 0.1 * 2.0, 0.03);
  filter.take(0, {12.0, 0.0, 0.0});
  filter.advance(13.0);
  EXPECT_NEAR(filter.sigma(0, RobotState::psi), std::sqrt(2.0) * 0.3 * 2.0, 0.05) << "the gap is over";
}

TEST(TeamFilter, FalseSightingsDoNotMoveARobot) {
  Random random(5);
  TeamFilter filter({0.0}, three, with_known_clock(), 0.0);
  drive_to_origin(filter);
  for (int k = 0; k < 200; ++k) {
    filter.take(0, {10.0 + 0.05 * k, 0.0, 0.0});
    filter.advance(10.0 + 0.05 * k);
    TeamSighting z = sighting_of(k % 3, {}, filter.time());
    z.range = uniform(random, 4.5, 8.0), z.bearing = uniform(random, -0.5, 0.5);
    EXPECT_NE(filter.take(z).verdict, FitVerdict::accepted);
  }
  EXPECT_LE(norm(filter.pose(0).pose.x, filter.pose(0).pose.y), 0.01);
  EXPECT_LE(filter.sigma(0, RobotState::x), 0.05);
}

TEST(TeamFilter, RefusedSightingsThatAgreeOnAPoseMoveTheRobotThere) {
  TeamFilter filter({0.0}, three, with_known_clock(), 0.0);
  drive_to_origin(filter);
  const PlanarPose truth{0.4, -0.3, 0.1};
  for (int k = 0; k < 40; ++k) {
    filter.take(0, {10.0 + 0.2 * k, 0.0, 0.0});
    filter.advance(10.0 + 0.2 * k);
    filter.take(sighting_of(k % 3, truth, filter.time()));
  }
  EXPECT_LE(norm(filter.pose(0).pose.x - truth.x, filter.pose(0).pose.y - truth.y), 0.15);
}

TEST(TeamFilter, AfterAGapItWaitsUntilSightingsWithoutIdentityAgree) {
  TeamFilter filter({0.0}, three, with_known_clock(), 0.0);
  drive_to_origin(filter);
  filter.advance(12.0);
  const PlanarPose truth{0.1, 0.1, 0.9};
  for (int k = 0; k < 24; ++k) {
    filter.take(0, {12.0 + 0.2 * k, 0.0, 0.0});
    filter.advance(12.0 + 0.2 * k);
    std::array<TeamSighting, 2> frame = {sighting_of(k % 3, truth, filter.time()),
                                         sighting_of((k + 1) % 3, truth, filter.time())};
    std::array<TeamFit, 2> fits;
    for (TeamSighting& z : frame) z.subject = TeamSighting::unidentified;
    filter.take_unidentified(frame, fits);
    if (k < 4) {
      EXPECT_EQ(fits[0].subject, TeamSighting::unidentified) << k;
    }
  }
  const PlanarPose found = filter.pose(0).pose;
  EXPECT_LE(norm(found.x - truth.x, found.y - truth.y), 0.15);
  EXPECT_NEAR(found.psi, truth.psi, 0.1);
}

TEST(TeamFilter, RangesOfSixAntennasLocateABodyFromNowhere) {
  Random random(4);
  TeamNoise noise = calibrated();
  noise.range_noise = 0.02, noise.range_share = 0.0, noise.range_error = 0.002;
  std::array<Vec3<double>, 6> antennas;
  for (int i = 0; i < 6; ++i)
    antennas[static_cast<std::size_t>(i)] = {0.3 * std::cos(1.047 * i), 0.3 * std::sin(1.047 * i), 0.0};
  std::normal_distribution<double> normal;
  double nees = 0.0;
  int located = 0;
  for (int k = 0; k < 20; ++k) {
    TeamFilter filter({0.0, 1.0}, {}, noise, 0.0);
    filter.start(0, guess({1.0, -2.0, 0.4}, 1e-4, 1e-4));
    const PlanarPose truth{1.0 + uniform(random, 1, 3), uniform(random, -1, 2), uniform(random, -3, 3)};
    std::vector<TeamSighting> frame;
    for (const auto& a : antennas)
      for (const auto& b : antennas) {
        TeamSighting z;
        z.of = Sighted::range, z.subject = 1, z.sensor = a, z.point = b;
        const Vec3<double> from = Vec3<double>{1.0, -2.0, 0.0} + turn_z(0.4) * a;
        const Vec3<double> to = Vec3<double>{truth.x, truth.y, 1.0} + turn_z(truth.psi) * b;
        z.range = norm(to - from) + noise.range_noise * normal(random);
        frame.push_back(z);
      }
    const auto found = filter.locate(1, frame);
    if (!found) continue;
    ++located;
    nees += mahalanobis(error_of(found->pose, truth), found->P);
    EXPECT_LE(norm(found->pose.x - truth.x, found->pose.y - truth.y), 0.3);
  }
  EXPECT_GE(located, 19);
  EXPECT_LE(nees / located, 6.0);
}

TEST(TeamFilter, TheErrorOfAnAntennaTowardsOneRobotIsFoundApartFromThatTowardsAnother) {
  TeamNoise noise = calibrated();
  noise.range_noise = 0.02, noise.range_share = 0.0, noise.range_error = 0.0, noise.antenna_error = 0.2;
  TeamFilter filter({0.0, 0.0, 0.0}, {}, noise, 0.0, 2);
  const std::array<PlanarPose, 3> poses = {{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}};
  for (int i = 0; i < 3; ++i) filter.start(i, guess(poses[static_cast<std::size_t>(i)], 1e-6, 1e-6));
  const auto range = [&](int other, int antenna, double error) {
    TeamSighting z;
    z.of = Sighted::range, z.subject = other, z.antenna = antenna;
    z.range = (other == 1 ? 3.0 : 4.0) + error;
    return filter.take(z);
  };
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(range(1, 0, 0.3).verdict, FitVerdict::accepted);
    EXPECT_EQ(range(2, 0, 0.1).verdict, FitVerdict::accepted);
  }
  EXPECT_NEAR(range(1, 0, 0.3).y[0], 0.0, 0.01);
  EXPECT_NEAR(range(2, 0, 0.1).y[0], 0.0, 0.01);
  EXPECT_NEAR(range(1, 1, 0.0).y[0], 0.0, 0.01) << "another antenna has none of it";
}

// On a ring of landmarks x, y and psi are independent, so their variances follow by hand.
TEST(TeamFilter, LocatesARobotWithTheLastingErrorOfEachPairHoweverManyThereAre) {
  constexpr int landmarks = 40;
  constexpr double r = 3.0;
  TeamNoise noise = calibrated();
  noise.range_noise = 1e-4, noise.range_share = 0.0, noise.bearing_noise = 1e-4;
  noise.range_error = 0.05, noise.bearing_error = 0.02;
  std::vector<TeamFilter::Landmark> ring;
  std::vector<TeamSighting> frame;
  for (int i = 0; i < landmarks; ++i) {
    TeamSighting z;
    z.subject = 1 + i, z.range = r, z.bearing = wrap(2 * std::numbers::pi * i / landmarks);
    ring.push_back({r * std::cos(z.bearing), r * std::sin(z.bearing), 0.0});
    for (int repeated = 0; repeated < 3; ++repeated) frame.push_back(z);
  }
  TeamFilter filter({0.0}, ring, noise, 0.0);
  const auto found = filter.locate(0, frame);
  ASSERT_TRUE(found);
  EXPECT_NEAR(norm(found->pose.x, found->pose.y), 0.0, 1e-6);
  const double along = 1 / square(noise.range_error * r), across = 1 / square(noise.bearing_error * r);
  const double place = 1 / (0.5 * landmarks * (along + across));
  EXPECT_NEAR(found->P(0, 0), place, 0.01 * place);
  EXPECT_NEAR(found->P(1, 1), place, 0.01 * place);
  const double heading = square(noise.bearing_error) / landmarks;
  EXPECT_NEAR(found->P(2, 2), heading, 0.01 * heading);
}

TEST(TeamFilter, DoesNotLocateARobotByARangeAlone) {
  TeamFilter filter({0.0}, {{3.0, 0.0, 0.0}}, {}, 0.0);
  TeamSighting z;
  z.of = Sighted::range, z.subject = 1, z.range = 2.0;
  EXPECT_FALSE(filter.locate(0, std::array{z}));
}

TEST(TeamFilter, DoesNotLocateARobotByFalseSightings) {
  Random random(6);
  const std::vector<TeamFilter::Landmark> marks = {{3, 0, 0}, {2, 1.5, 0}, {3.5, -1, 0}, {4, 1, 0}};
  TeamFilter filter({0.0}, marks, calibrated(), 0.0);
  std::array<TeamSighting, 4> frame;
  const auto located = [&](auto&& range, auto&& bearing) {
    for (std::size_t k = 0; k < frame.size(); ++k)
      frame[k].subject = 1 + static_cast<int>(k), frame[k].range = range(marks[k]),
      frame[k].bearing = bearing(marks[k]);
    return filter.locate(0, frame).has_value();
  };
  EXPECT_TRUE(located([](const auto& at) { return norm(at.x, at.y); },
                      [](const auto& at) { return std::atan2(at.y, at.x); }));
  for (int k = 0; k < 50; ++k)
    EXPECT_FALSE(located([&](const auto&) { return uniform(random, 0.5, 5); },
                         [&](const auto&) { return uniform(random, -0.5, 0.5); }));
}

TEST(TeamFilter, BadInputLeavesTheEstimateFiniteAndUnchanged) {
  TeamFilter filter({0.0, 0.0}, {{3.0, 0.0, 0.0}}, {}, 0.0);
  filter.start(0, guess({}, 0.1, 0.1));
  filter.start(1, guess({1.0, 0.0, 0.0}, 0.1, 0.1));
  filter.take(0, {0.0, no_value, 0.0});
  filter.take(0, {infinity, 0.0, 0.0});
  filter.advance(no_value);
  filter.advance(-1.0);
  TeamSighting z;
  for (const auto& [range, bearing, observer, subject] : {std::tuple{no_value, 0.0, 0, 2},
                                                          {1.0, infinity, 0, 2},
                                                          {-1.0, 0.0, 0, 2},
                                                          {1.0, 0.0, 0, 0},
                                                          {1.0, 0.0, 0, 3},
                                                          {1.0, 0.0, 5, 2},
                                                          {1.0, 0.0, 0, TeamSighting::unidentified}}) {
    z.range = range, z.bearing = bearing, z.observer = observer, z.subject = subject;
    EXPECT_EQ(filter.take(z).verdict, FitVerdict::unusable);
  }
  EXPECT_EQ(filter.pose(0).pose.x, 0.0);
  EXPECT_DOUBLE_EQ(filter.pose(0).P(0, 0), square(0.1));
  EXPECT_EQ(filter.time(), 0.0);
}

TEST(TeamFilter, NothingAllocatesOnceItIsMade) {
  test::SyntheticTeam team(3, 8, synthetic(), 9);
  TeamFilter filter({0.0, 0.0, 0.0}, team.marks, synthetic(), 0.0);
  std::vector<std::vector<TeamSighting>> frames;
  for (int i = 0; i < 3; ++i) {
    filter.start(i, guess(team.members[static_cast<std::size_t>(i)].pose, 0.05, 0.05));
    frames.push_back(team.sightings(i));
  }
  std::array<TeamFit, 16> fits;
  const std::int64_t before = allocations_here();
  filter.take(0, {0.0, 0.2, 0.1});
  filter.advance(1.0);
  for (auto& frame : frames) {
    for (const TeamSighting& z : frame) filter.take(z);
    for (TeamSighting& z : frame) z.subject = TeamSighting::unidentified;
    filter.take_unidentified(frame, std::span(fits).first(frame.size()));
  }
  filter.take_pose(0, filter.pose(0));
  filter.advance(200.0);
  EXPECT_EQ(allocations_here(), before);
  EXPECT_EQ(filter.states(), 3 * robot_states) << "pairs end when their errors have faded";
}

TEST(TeamFilter, RefusesNoiseThatMeansNothing) {
  TeamNoise noise;
  noise.range_share = 0.0;
  EXPECT_EQ(refusal_of([&] { noise.check(); }),
            "localize.range_noise = 0 m and range_share = 0, expected one of them > 0");
  noise = {};
  noise.range_error_time = 0.0;
  EXPECT_THAT(refusal_of([&] { TeamFilter({0.0}, {}, noise, 0.0); }),
              testing::StartsWith("localize.range_error_time = 0"));
  EXPECT_EQ(refusal_of([&] { TeamFilter({}, {}, {}, 0.0); }), "robots = 0, expected at least 1");
}

}  // namespace
}  // namespace sightline
