// Sensors that sit and look anywhere, also several on a robot: views by quaternions of the test's
// own, two set-ups that are one, and flights.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/analysis/field.hpp"
#include "sightline/estimator.hpp"
#include "sightline/events.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/log.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/potentials.hpp"
#include "sightline/sensors.hpp"
#include "sightline/world/sighting.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/random.hpp"
#include "tests/support/replayed_flight.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/two_robots.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

/// Hamilton product.
Quaternion times(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
Quaternion about(const Vec3<double>& axis, double angle) {
  const double s = std::sin(0.5 * angle);
  return {std::cos(0.5 * angle), s * axis.x, s * axis.y, s * axis.z};
}
/// q v q*, or q* v q for `back`.
Vec3<double> turned(Quaternion q, const Vec3<double>& v, bool back = false) {
  if (back) q = {q.w, -q.x, -q.y, -q.z};
  const Quaternion r = times(times(q, {0, v.x, v.y, v.z}), {q.w, -q.x, -q.y, -q.z});
  return {r.x, r.y, r.z};
}

constexpr Vec3<double> x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1};

/// The target in the sensor frame: yaw, pitch and roll of the robot, the lever arm, and those of
/// the sensor.
Vec3<double> in_sensor(const SensorMount& mount, const Sight<double>& robot, const Vec3<double>& p_G) {
  Quaternion q = about(z_axis, std::atan2(robot.d.y, robot.d.x));
  if (mount.frame == MountFrame::body) {
    const double pitch = std::atan(robot.lean.x), roll = -std::atan(robot.lean.y * std::cos(pitch));
    q = times(times(q, about(y_axis, pitch)), about(x_axis, roll));
  }
  const Vec3<double> from_sensor = p_G - robot.p - turned(q, mount.offset);
  q = times(times(times(q, about(z_axis, mount.yaw)), about(y_axis, mount.pitch)), about(x_axis, mount.roll));
  return turned(q, from_sensor, true);
}
double angle_to(const SensorMount& mount, const Sight<double>& robot, const Vec3<double>& p_G) {
  const Vec3<double> p = in_sensor(mount, robot, p_G);
  return std::atan2(std::hypot(p.y, p.z), p.x);
}

SensorMount any_mount(Random& random) {
  SensorMount mount = random_mount(random, random() % 2 == 0 ? MountFrame::level : MountFrame::body);
  if (random() % 8 == 0) mount.pitch = pi / 2;
  return mount;
}

TEST(MountedSensor, BearingAndRangeAreThoseOfQuaternions) {
  Random random(1);
  const Region near("range < 2 m"), seen("bearing < 0.4"), left("azimuth < 0"), above("elevation < 0");
  for (int k = 0; k < 3000; ++k) {
    const SensorMount mount = any_mount(random);
    const Sight<double> a = random_sight(random, 3), b = random_sight(random, 3);
    const Vec3<double> p = in_sensor(mount, a, b.p);
    const double angle = angle_to(mount, a, b.p), level = std::hypot(p.x, p.y);
    EXPECT_NEAR(near.seen_from(mount).violation(a, b, 0), norm(p) - 2, 1e-13);
    EXPECT_NEAR(seen.seen_from(mount).violation(a, b, 0), angle - 0.4, 1e-12);
    EXPECT_NEAR(view_angle(mount, a, b.p), angle, 1e-12);
    EXPECT_NEAR(Bearing({.alpha = 0.3, .mount = mount}).violation(a, b), angle - 0.3, 1e-12);
    EXPECT_NEAR(SensorCone({.alpha = 0.3, .mount = mount}).violation(a, b), angle - 0.3, 1e-12);
    if (level < 0.1) continue;
    EXPECT_NEAR(std::remainder(left.seen_from(mount).violation(a, b, 0) - std::atan2(p.y, p.x), 2 * pi), 0,
                1e-12);
    EXPECT_NEAR(above.seen_from(mount).violation(a, b, 0), std::atan2(p.z, level), 1e-12);
  }
}

/// Numbers of both sights and the time, as a formula takes them.
std::array<double, 2 * sight_size + 1> numbers_of(const Sight<double>& a, const Sight<double>& b) {
  std::array<double, 2 * sight_size + 1> all{};
  write_sight(a, std::span(all));
  write_sight(b, std::span(all).subspan(sight_size));
  return all;
}

/// The derivatives of the recorded formula, by which solvers see it, against central differences of
/// `l`.
template <class Own>
void expect_derivatives(const Potential& potential, const Sight<double>& a, const Sight<double>& b,
                        const Own& l) {
  constexpr double h = 1e-5;
  Graph graph;
  const std::vector<Symbol> in = variables(graph, 0, 2 * sight_size + 1);
  const Symbol of =
      potential(sight_from<Symbol>(in.data()), sight_from<Symbol>(in.data() + sight_size), in.back());
  std::vector<Term> by;
  for (int i = 0; i < 2 * sight_size; ++i) by.push_back(graph.input(i));
  const auto here = numbers_of(a, b);
  const std::vector<double> slopes =
      evaluate(Program(graph, gradient(graph, of.in(graph), by), 2 * sight_size + 1), here);
  for (std::size_t i = 0; i < 2 * sight_size; ++i) {
    if (i % sight_size == 3 || i % sight_size == 4) continue;  // a heading has one freedom
    const auto moved = [&](double step) {
      auto there = here;
      there[i] += step;
      return l(sight_from<double>(there.data()), sight_from<double>(there.data() + sight_size));
    };
    EXPECT_NEAR(slopes[i], (moved(h) - moved(-h)) / (2 * h), 1e-6 * (1 + std::abs(slopes[i]))) << i;
  }
  const auto by_turn = [&](double step) {
    Sight<double> other = a;
    other.d = rotate<double>({std::cos(step), std::sin(step)}, a.d);
    return l(other, b);
  };
  EXPECT_NEAR(a.d.x * slopes[4] - a.d.y * slopes[3], (by_turn(h) - by_turn(-h)) / (2 * h), 1e-6);
}

TEST(MountedSensor, SolversSeeTheDerivativesOfTheQuaternionsView) {
  Random random(2);
  for (int k = 0; k < 100; ++k) {
    const SensorMount mount = any_mount(random);
    const Sight<double> a = random_sight(random, 2);
    Sight<double> b = random_sight(random, 2);
    if (norm(in_sensor(mount, a, b.p)) < 0.7) continue;
    expect_derivatives(Bearing{.width = 1e-7, .tilt = 0.0, .mount = mount}, a, b,
                       [&](const Sight<double>& c, const Sight<double>& d) {
                         return 1 - std::cos(angle_to(mount, c, d.p));
                       });
    // A soft limit of the range: the sigmoid of kappa_A c.
    const Potential range = Region("range < 2 m").sigmoid(3.0).smoothed_over(1e-9).seen_from(mount);
    expect_derivatives(range, a, b, [&](const Sight<double>& c, const Sight<double>& d) {
      return 1 / (1 + std::exp(-3.0 * (norm(in_sensor(mount, c, d.p)) - 2)));
    });
  }
}

TEST(MountedSensor, ADistanceOfTheSensorKeepsApartWhereverItSits) {
  const SensorMount mount = {.offset = {0.1, -0.4, 0.3}, .yaw = 1.0, .roll = 2.0};
  EXPECT_TRUE(keeps_apart(Region("range > 0.7 m").seen_from(mount)));
  EXPECT_FALSE(keeps_apart(Region("range < 0.7 m").seen_from(mount)));
}

/// The mount on a robot whose heading is turned back by a quarter, so that the sensor is where it
/// was.
SensorMount on_the_left(SensorMount mount) {
  mount.yaw += pi / 2;
  mount.offset = {-mount.offset.y, mount.offset.x, mount.offset.z};
  return mount;
}
Sight<double> turned_right(Sight<double> robot) {
  robot.d = {robot.d.y, -robot.d.x};
  return robot;
}

TEST(MountedSensor, OnTheLeftOfARobotTurnedRightCostsAndJudgesAlike) {
  Random random(3);
  int seen = 0;
  for (int k = 0; k < 2000; ++k) {
    SensorMount mount = random_mount(random);
    mount.yaw = uniform(random, -1.5, 1.5);
    const SensorMount left = on_the_left(mount);
    const Sight<double> a = random_sight(random, 2), b = random_sight(random, 2), right = turned_right(a);
    const Region text =
        Region(all_of({"abs(y) < x * tan(40 deg)", "abs(z) < x * tan(20 deg)", "range > 0.3 m"}));
    for (const Potential& potential :
         {Potential(SensorCone{}), Potential(Bearing{.width = 0.02}), Potential(text.sigmoid(4.0))}) {
      const Potential ahead = potential.seen_from(mount), aside = potential.seen_from(left);
      EXPECT_NEAR(ahead(a, b, 0.0), aside(right, b, 0.0), 1e-11);
      const Observation one{BodyId{0}, BodyId{1}, ahead, mount, potential.alpha().value_or(no_value),
                            no_value,  no_value},
          other{BodyId{0}, BodyId{1}, aside, left, potential.alpha().value_or(no_value), no_value, no_value};
      if (std::abs(ahead.violation(a, b, 0.0)) < 1e-9) continue;
      EXPECT_EQ(is_in_view(one, a, b, 0.0), is_in_view(other, right, b, 0.0));
      seen += is_in_view(one, a, b, 0.0);
    }
  }
  EXPECT_GT(seen, 100);
}

/// Sightings of a body by a robot at `p` with this heading, and what its filter makes of them in 2
/// s.
struct Localized {
  std::vector<Detection> pictures{};
  PoseEstimate estimate{};
};
Localized localized(const SensorMount& mount, FilterKind kind, double heading) {
  const Team team = test::two_robots();
  CameraOptions options{.seed = 4};
  options.cameras.push_back({.observer = BodyId{0}, .mount = mount});
  options.tags.push_back({BodyId{1}, {}});
  SyntheticDetections camera(team, options);
  const FilterOptions errors{.filter = kind};
  const auto filter = make_pose_filter(errors, mount);
  Localized all;
  for (int k = 0; k < 200; ++k) {
    const double t = 0.01 * k;
    std::array<ExposedBody, 2> bodies;
    bodies[0].now = {{0.1, -0.2, 1.5}, turn_by({0, 0, heading})};
    bodies[1].now = {{1.3 + 0.1 * std::sin(t), 0.1, 1.0}, turn_by({0, 0, 2.5 + 0.2 * t})};
    for (ExposedBody& body : bodies) body.before = body.now;
    filter->advance({.t = t, .dt = 0.01, .force = {0, 0, gravity}});
    std::array<Detection, 1> found;
    if (camera.find({0, t, 0.0, bodies}, found) == 0) continue;
    found[0].stamp = found[0].arrival = t;
    Measurement z = sighting_of(found[0], mount, {});
    z.p_other = bodies[1].now.p, z.psi_other = 2.5 + 0.2 * t, z.P_other = identity<4>(1e-4);
    filter->take(z);
    all.pictures.push_back(found[0]);
  }
  all.estimate = filter->estimate();
  return all;
}

TEST(MountedSensor, OnTheLeftOfARobotTurnedRightSeesAndLocalizesAlike) {
  for (const MountFrame frame : {MountFrame::level, MountFrame::body}) {
    const SensorMount mount{
        .pitch = 0.3, .offset = {0.1, 0.05, 0.02}, .frame = frame, .yaw = 0.1, .roll = -0.5};
    for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
      const Localized ahead = localized(mount, kind, 0.2),
                      aside = localized(on_the_left(mount), kind, 0.2 - pi / 2);
      ASSERT_EQ(ahead.pictures.size(), aside.pictures.size());
      ASSERT_GT(ahead.pictures.size(), 100U);
      for (std::size_t i = 0; i < ahead.pictures.size(); ++i) {
        const Detection &one = ahead.pictures[i], &other = aside.pictures[i];
        EXPECT_LE(norm(one.p - other.p), 1e-9);
        EXPECT_NEAR(
            std::abs(one.q.w * other.q.w + one.q.x * other.q.x + one.q.y * other.q.y + one.q.z * other.q.z),
            1.0, 1e-9);
      }
      ASSERT_TRUE(ahead.estimate.known && aside.estimate.known);
      EXPECT_LE(norm(ahead.estimate.p - Vec3<double>{0.1, -0.2, 1.5}), 0.05);
      EXPECT_NEAR(wrap(ahead.estimate.psi - 0.2), 0.0, 0.05);
      // Of a robot that is tilted by an estimated error, headings add up to second order in that.
      EXPECT_LE(norm(ahead.estimate.p - aside.estimate.p), 1e-5);
      EXPECT_NEAR(wrap(ahead.estimate.psi - aside.estimate.psi), pi / 2, 1e-5);
      EXPECT_NEAR(ahead.estimate.position_sigma(), aside.estimate.position_sigma(), 1e-5);
    }
  }
}

/// A robot that watches a ball on a circle.
std::string watcher(std::string_view start, std::string_view sensor, std::string_view potential,
                    std::string_view rest = "") {
  return fmt::format(R"(
[simulation]
duration = 12.0
[agent.uav0]
robot = "multirotor"
start = {{ {} }}
sensor = {{ {} }}
[target.ball]
motion = {{ circle = {{ centre = [0.0, 0.0, 1.0], radius = 0.5, rate = 0.5 }} }}
[[couple]]
potential = {{ {} }}
between = ["uav0", "ball"]
weight = 2.0
{}{})",
                     start, sensor, potential, test::ball_distances, rest);
}

Scenario watched(std::string_view start, std::string_view sensor, std::string_view potential) {
  return test::scenario_of(watcher(start, sensor, potential));
}

/// Share of the samples from 4 s on in which the ball is within 0.5 rad of the axis, by
/// quaternions.
double share_in_view(const Scenario& scenario, const SensorMount& mount) {
  const auto& observed = observations(scenario.team.couplings());
  EXPECT_EQ(observed.at(0).mount, mount) << "as in the file";
  double in_view = 0, all = 0;
  for (const Sample& sample : test::samples_of(scenario)) {
    if (sample.time < 4.0) continue;
    const Sight<double> robot = true_sight(scenario.team, BodyId{0}, sample),
                        ball = true_sight(scenario.team, BodyId{1}, sample);
    in_view += angle_to(mount, robot, ball.p) <= 0.5, ++all;
  }
  return in_view / all;
}

TEST(MountedSensor, ThatLooksAsideRolledAndDisplacedKeepsItsTarget) {
  constexpr std::string_view sensor = "yaw = 1.57, pitch = 0.4, roll = 0.6, offset = [0.05, -0.1, 0.03]";
  const SensorMount mount{.pitch = 0.4, .offset = {0.05, -0.1, 0.03}, .yaw = 1.57, .roll = 0.6};
  constexpr std::string_view start = "p = [-0.8, 0.0, 1.6], heading = -1.57";
  for (const char* potential :
       {"bearing = { alpha = 0.5 }", "sensor_cone = { alpha = 0.5 }",
        "region = { inside = \"bearing < 0.5\", kappa_A = 10.0, slope = { softplus = {} } }"}) {
    EXPECT_GE(share_in_view(watched(start, sensor, potential), mount), 0.99) << potential;
  }
  // One that begins with its target behind the sensor turns to it.
  EXPECT_GE(share_in_view(watched("p = [-0.8, 0.0, 1.6], heading = 1.2", sensor, "bearing = { alpha = 0.5 }"),
                          mount),
            0.99);
}

TEST(MountedSensor, ThatLooksStraightDownOrUpKeepsItsTarget) {
  EXPECT_GE(
      share_in_view(watched("p = [0.5, 0.0, 2.4], heading = 0.3", "pitch = 1.5707963267948966, offset = 0.1",
                            "sensor_cone = { alpha = 0.5 }"),
                    {.pitch = pi / 2, .offset = 0.1}),
      0.99);
  EXPECT_GE(share_in_view(watched("p = [0.5, 0.0, -0.4], heading = 0.3",
                                  "pitch = -1.5707, offset = [0.0, 0.0, 0.1]", "bearing = { alpha = 0.5 }"),
                          {.pitch = -1.5707, .offset = {0.0, 0.0, 0.1}}),
            0.99);
}

// Wherever it looks, its set has the target there. The robot begins where that is so.
TEST(MountedSensor, OfACertifiedViewMayLookAsideOrBack) {
  constexpr std::string_view certified =
      "[[certify_view]]\nobserver = \"uav0\"\ntarget = \"ball\"\nspeed_max = 0.3\n";
  const auto keeps = [&](const SensorMount& mount) {
    const std::string sensor =
        fmt::format("yaw = {}, pitch = {}, roll = {}, offset = [{}, {}, {}]{}", mount.yaw, mount.pitch,
                    mount.roll, mount.offset.x, mount.offset.y, mount.offset.z,
                    mount.frame == MountFrame::body ? ", frame = \"body\"" : "");
    const Scenario scenario =
        test::scenario_of(watcher(fmt::format("p = [-0.85, 0.0, 1.6], heading = {}", -mount.yaw), sensor,
                                  "sensor_cone = { alpha = 0.5 }", certified));
    EXPECT_EQ(share_in_view(scenario, mount), 1.0) << sensor;
    int uncertified = 0;
    for (const Sample& sample : test::samples_of(scenario))
      uncertified += sample.of == Sample::Of::update && !sample.views[0].certified;
    EXPECT_EQ(uncertified, 0) << sensor;
  };
  keeps({.pitch = 0.5, .offset = {0.1, 0.05, 0.03}, .yaw = 0.15, .roll = 1.2});
  keeps({.offset = {0.02, -0.15, 0.05}, .frame = MountFrame::body, .yaw = -1.5708});
  keeps({.offset = {-0.15, 0.0, 0.0}, .frame = MountFrame::body, .yaw = 3.1415});
  keeps({.pitch = 0.4, .offset = {-0.1, 0.1, -0.02}, .yaw = 2.4, .roll = -0.6});
}

/// A robot between a ball on its left and a post on its right, which looks both ways.
std::string two_way_watcher(std::string_view rest = "") {
  return fmt::format(R"(
[simulation]
duration = 8.0
settle = 4.0
[agent.uav0]
robot = "multirotor"
start = {{ p = [0.1, 0.0, 1.4], heading = 0.5 }}
sensor = {{ pitch = 0.5, offset = 0.17 }}
Q = [1.0, 1.0, 1.0, 0.1, 0.1, 0.0, 0.0]
reference = {{ constant = {{ p = [0.0, 0.0, 1.4] }} }}
[agent.uav0.sensors.left]
yaw = 1.5
pitch = 0.2
roll = 0.3
offset = [0.02, 0.1, -0.03]
[agent.uav0.sensors.right]
yaw = -1.6
pitch = 0.1
offset = [0.0, -0.1, 0.0]
[target.ball]
motion = {{ circle = {{ centre = [0.0, 1.5, 1.0], radius = 0.2, rate = 0.5 }} }}
[target.post]
p = [0.0, -1.5, 1.1]
[[couple]]
name = "to the left"
potential = {{ bearing = {{ alpha = 0.5 }} }}
between = ["uav0", "ball"]
sensor = "left"
[[couple]]
name = "to the right"
potential = {{ sensor_cone = {{ alpha = 0.5 }} }}
between = ["uav0", "post"]
sensor = "right"
{})",
                     rest);
}
constexpr SensorMount left_mount{.pitch = 0.2, .offset = {0.02, 0.1, -0.03}, .yaw = 1.5, .roll = 0.3},
    right_mount{.pitch = 0.1, .offset = {0.0, -0.1, 0.0}, .yaw = -1.6};

TEST(SeveralSensors, KeepATargetEachAndTheSummaryHasTheirAngles) {
  const Scenario scenario = test::scenario_of(two_way_watcher());
  const std::vector<Observation> views = observations(scenario.team.couplings());
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[0].mount, left_mount);
  EXPECT_EQ(views[1].mount, right_mount);
  const std::array<SensorMount, 2> mounts = {left_mount, right_mount};
  std::array<double, 2> most{};
  Summary summary(scenario, 1);
  for (const Sample& sample : test::samples_of(scenario)) {
    summary.add(sample);
    if (sample.time < 4.0 - 1e-9) continue;
    const Sight<double> robot = true_sight(scenario.team, BodyId{0}, sample);
    for (std::size_t k = 0; k < 2; ++k)
      most[k] =
          std::max(most[k], angle_to(mounts[k], robot, true_sight(scenario.team, views[k].target, sample).p));
  }
  const SummaryValues values = summary.values();
  ASSERT_EQ(values.pairs.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_LT(most[k], std::atan(std::sin(0.5))) << k;
    EXPECT_NEAR(values.pairs[k].view_angle_max, most[k], 1e-9) << k;
    EXPECT_EQ(values.pairs[k].in_view_fraction, 1.0) << k;
  }
  EXPECT_FALSE(summary.target_lost_at_end());
}

TEST(SeveralSensors, OfALogGiveEachCommandAgainAndTheLogHasTheirMounts) {
  SimulatedClock clock;
  const test::ReplayedFlight flown(test::scenario_of(two_way_watcher()), 1.0, clock);
  RecordedFlight flight = flown.flight();
  const CommandComparison compared = test::replayed(flown.scenario, flight);
  EXPECT_GT(compared.updates(), 50);
  EXPECT_EQ(compared.differing(), 0);
  const Recording run = read_recording(flown.folder.path());
  ASSERT_EQ(run.pairs.size(), 2U);
  EXPECT_EQ(run.pairs[0].mount, left_mount);
  EXPECT_EQ(run.pairs[1].mount, right_mount);
}

/// The views in force after the only event of a scenario.
std::vector<Observation> views_after(std::string_view event) {
  const Scenario scenario = test::scenario_of(two_way_watcher(event));
  ActiveTeam active(scenario.team, scenario.presence);
  for (const Action& action : scenario.script.events.at(0).actions)
    EXPECT_EQ(active.apply(action, 1.0, 0.0), "");
  std::vector<Coupling> lasting = active.couplings();
  std::erase_if(lasting, [](const Coupling& c) { return !c.ramp.lasts(); });
  return observations(lasting);
}

TEST(SeveralSensors, ByEventsChangeOneAtATime) {
  const BodyId ball{1}, post{2};
  // The coupling that is removed takes its own view along, the other stays.
  std::vector<Observation> views = views_after("[[event]]\nat = 1.0\nremove = { couple = \"to the left\" }");
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].mount, right_mount);
  // Another potential of a coupling looks through the coupling's sensor.
  views = views_after(
      "[[event]]\nat = 1.0\nretune = { couple = \"to the right\", potential = { bearing = { alpha = 0.3 } } "
      "}");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[1].potential.name(), "bearing");
  EXPECT_EQ(views[1].mount, right_mount);
  // The sensor that is named turns; the other stays on its target.
  const std::string turn = "[target.other]\np = [1.5, 0.0, 1.0]\n[[event]]\nat = 1.0\n";
  views = views_after(turn + "observe = { observer = \"uav0\", target = \"other\", sensor = \"right\" }");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[0].target, ball);
  EXPECT_EQ(views[0].mount, left_mount);
  EXPECT_EQ(views[1].target, BodyId{3});
  EXPECT_EQ(views[1].mount, right_mount);
  // Both may turn at one time, in one event or in two.
  const std::string both = "[target.other]\np = [1.5, 0.0, 1.0]\n";
  const std::string left = "{ observer = \"uav0\", target = \"other\", sensor = \"left\" }",
                    right = "{ observer = \"uav0\", target = \"ball\", sensor = \"right\" }";
  views = views_after(both + "[[event]]\nat = 1.0\nobserve = [" + left + ", " + right + "]");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views[0].target, BodyId{3});
  EXPECT_EQ(views[0].mount, left_mount);
  EXPECT_EQ(views[1].target, ball);
  EXPECT_EQ(views[1].mount, right_mount);
  const std::string at = "\n[[event]]\nat = 1.0\nobserve = ";
  EXPECT_EQ(test::scenario_refusal(two_way_watcher(both + at + left + at + right)), "");
  EXPECT_NE(test::scenario_refusal(two_way_watcher(both + at + left + at + left)).find("is changed twice"),
            std::string::npos);
  // Two of one pair are two views.
  views = views_after(
      "[[event]]\nat = 1.0\nadd = { couple = { potential = { bearing = { alpha = 2.0 } }, "
      "between = [\"uav0\", \"post\"] } }");
  ASSERT_EQ(views.size(), 3U);
  EXPECT_EQ(views[1].target, post);
  EXPECT_EQ(views[2].target, post);
  EXPECT_EQ(views[2].mount, (SensorMount{.pitch = 0.5, .offset = 0.17}));
}

TEST(SeveralSensors, AShapeLooksThroughTheSensorsOfItsName) {
  const auto shape = [](std::string_view potentials) {
    return two_way_watcher(
        fmt::format("[[shape]]\nstar = {{ centre = \"ball\", observers = [\"uav0\"] }}\n"
                    "sensor = \"right\"\npotentials = [{}]\n",
                    potentials));
  };
  const Scenario scenario =
      test::scenario_of(shape("{ keep_out = { d_min = 0.5 } }, { bearing = { alpha = 0.3 } }"));
  const std::vector<Coupling>& couplings = scenario.team.couplings();
  ASSERT_EQ(couplings.size(), 4U);
  EXPECT_EQ(couplings[2].term.potential.mount(), nullptr);
  EXPECT_EQ(*couplings[3].term.potential.mount(), right_mount);
  EXPECT_NE(test::scenario_refusal(shape("{ keep_out = { d_min = 0.5 } }"))
                .find("shape[0].sensor = \"right\", expected no such key: no potential of the shape looks"),
            std::string::npos);
}

TEST(SeveralSensors, ConditionsMeasureThroughTheCouplingsSensorOrTheNamedOne) {
  const auto mount_of = [](const std::string& trigger) {
    const Scenario scenario = test::scenario_of(two_way_watcher("[[event]]\nenter = \"next\"\n" + trigger));
    const auto& condition = std::get<Condition>(scenario.script.events.at(0).trigger);
    if (const auto* angle = std::get_if<ViewAngleOf>(&condition.measure)) return angle->mount;
    return *std::get<ExcessOf>(condition.measure).potential.mount();
  };
  EXPECT_EQ(mount_of("lost = { observer = \"uav0\", target = \"ball\" }"), left_mount);
  EXPECT_EQ(mount_of("seen = { observer = \"uav0\", target = \"post\", alpha = 0.2 }"), right_mount);
  EXPECT_EQ(mount_of("seen = { observer = \"uav0\", target = \"post\", alpha = 0.2, sensor = \"left\" }"),
            left_mount);
  EXPECT_EQ(mount_of("when = { angle = [\"uav0\", \"ball\"], above = 1.0 }"), left_mount);
  EXPECT_EQ(mount_of("when = { formula = \"bearing\", between = [\"uav0\", \"post\"], above = 1.0 }"),
            right_mount);
}

/// Attitude of the sensor in G on an upright robot, by quaternions.
Quaternion attitude_of(const SensorMount& mount, double heading) {
  return times(times(times(about(z_axis, heading), about(z_axis, mount.yaw)), about(y_axis, mount.pitch)),
               about(x_axis, mount.roll));
}

TEST(SeveralCameras, GiveTheirSightingsInTheFrameOfTheFirstWithTheirCovariance) {
  const SensorMount front{.pitch = 0.5, .offset = 0.17};
  const double heading = 0.4;
  Sight<double> robot;
  robot.p = {0.2, -0.1, 1.2}, robot.d = {std::cos(heading), std::sin(heading)};
  Random random(5);
  for (int k = 0; k < 6; ++k) {
    SensorMount left = random_mount(random);
    left.yaw = uniform(random, 1.2, 1.9), left.pitch = uniform(random, -0.2, 0.2);
    // Tags that the further camera alone sees, each of its faces turned off its axis.
    const Vec3<double> on_axis = robot.p + turned(attitude_of(left, heading), {2.0, 0.0, 0.0}) +
                                 turned(about(z_axis, heading), left.offset);
    const double psi = uniform(random, -3.1, 3.1);
    CameraOptions options{.seed = 7};
    for (const SensorMount& mount : {front, left})
      options.cameras.push_back(
          {.observer = BodyId{0}, .mount = mount, .camera = {.outliers = 0.0, .flips = 0.0}});
    options.tags.push_back({BodyId{1}, {}});
    const Team team = test::two_robots();
    const std::vector<double> x = {robot.p.x, robot.p.y, robot.p.z, robot.d.x,     robot.d.y,     0, 0,
                                   on_axis.x, on_axis.y, on_axis.z, std::cos(psi), std::sin(psi), 0, 0};
    CameraWorld world(std::make_unique<ModelWorld>(team, x), options,
                      std::make_unique<SyntheticDetections>(team, options));
    const Vec3<double> p = in_sensor(front, robot, on_axis);
    const Quaternion in_G = attitude_of(front, heading);
    const Quaternion q = times({in_G.w, -in_G.x, -in_G.y, -in_G.z}, about(z_axis, psi));
    const std::vector<double> u(8, 0.0);
    double squares = 0.0;
    int count = 0;
    for (int period = 0; period < 1500; ++period) {
      const Measured now = world.measure(0.01 * period);
      for (const Detection& one : now.detections) {
        const Quaternion d = times(q, {one.q.w, -one.q.x, -one.q.y, -one.q.z});
        const double sign = d.w < 0 ? -2.0 : 2.0;
        const std::array<double, 6> errors = {p.x - one.p.x, p.y - one.p.y, p.z - one.p.z,
                                              sign * d.x,    sign * d.y,    sign * d.z};
        if (std::hypot(errors[3], errors[4], errors[5]) > 0.5) continue;  // a tag's mirrored pose
        Column<6> e;
        for (int i = 0; i < 6; ++i) e(i, 0) = errors[static_cast<std::size_t>(i)];
        const Column<6> y = Cholesky<6>(one.covariance_matrix()).forward(e);
        for (int i = 0; i < 6; ++i) squares += y(i, 0) * y(i, 0);
        ++count;
      }
      ASSERT_TRUE(test::apply(world, 0.01 * period, now.measured, u, 0.01, 1));
    }
    ASSERT_GT(count, 300) << k;
    EXPECT_NEAR(squares / count, 6.0, 0.8) << k;
  }
}

TEST(SeveralCameras, LocalizeARobotByTheTagsThatEachSees) {
  const Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/two_cameras.toml",
                                          built_in_registry(), {"simulation.duration=8.0"});
  const LocalizedRobot& localized = scenario.localization.robots.at(0);
  EXPECT_EQ(localized.mount.yaw, 1.57) << "of the first camera";
  EXPECT_EQ(localized.observes, (std::vector{BodyId{1}, BodyId{2}}));
  EXPECT_EQ(localized.camera_rate, 60.0);
  SimulatedClock clock;
  const test::ReplayedFlight flown(scenario, 8.0, clock);
  RecordedFlight flight = flown.flight();
  const CommandComparison compared = test::replayed(flown.scenario, flight);
  EXPECT_EQ(compared.differing(), 0);
  EXPECT_GT(compared.estimates(), 700);
  EXPECT_EQ(compared.differing_estimates(), 0);
  Summary summary(scenario, 1);
  for (const Sample& sample : test::samples_of(scenario)) summary.add(sample);
  const RobotLocalization of = summary.localization().robots().at(0);
  EXPECT_GT(of.detections, 8 * 30 + 100) << "more than one camera has pictures";
  EXPECT_LT(of.rejected, 0.05 * static_cast<double>(of.detections));
  EXPECT_LT(of.rmse, 0.03);
  EXPECT_LT(of.anees, 8.0);
}

TEST(SeveralCameras, ThatCannotBeToldAsOneAreRefused) {
  const auto refusal = [](std::string_view first, std::string_view camera, std::string_view rest = "") {
    std::string text = two_way_watcher(rest);
    text.insert(text.find("[agent.uav0.sensors.right]"), "[agent.uav0.sensors.left.camera]\n");
    text.insert(text.find("Q = [1.0"), first);
    const std::size_t right = text.find("[target.ball]");
    text.insert(right, camera);
    return test::scenario_refusal(text);
  };
  EXPECT_NE(refusal("", "frame = \"body\"\ncamera = {}\n")
                .find("agent.uav0.sensors.right.frame = \"body\", expected that of the sensor of the robot's "
                      "first camera"),
            std::string::npos);
  EXPECT_NE(
      refusal("", "camera = { correlation_time = 1.0 }\n")
          .find("agent.uav0.sensors.right.camera.correlation_time = 1, expected 0 s of each of several"),
      std::string::npos);
  EXPECT_NE(
      refusal("localization = \"vision\"\nestimate = { filter = \"attitude\", camera_turn = 0.01 }\n",
              "camera = {}\n", "[target.ball.tags]\n")
          .find("agent.uav0.localization = \"vision\", expected \"global\", or a robot with one camera"),
      std::string::npos);
  EXPECT_NE(refusal("", "camera = {}\n", "[fleet]\n")
                .find("fleet = {}, expected robots with one camera each, uav0 has several"),
            std::string::npos);
  // A choice compares views of cameras, and its potential looks through [agent.uav0.sensor].
  EXPECT_NE(refusal("", "",
                    "[target.ball.tags]\n[[shape]]\nbest = { target = [\"ball\"], observers = [\"uav0\"] }\n"
                    "potential = { bearing = {} }\n")
                .find("shape[0].best.observers = [\"uav0\"], expected robots with a camera at their sensor"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline
