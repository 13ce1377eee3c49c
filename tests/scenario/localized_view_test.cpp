// Certified views of a robot that is localized by vision, flown by the whole loop.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "sightline/registry.hpp"
#include "sightline/safety/view_filter.hpp"
#include "sightline/scenario/read_view.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/sampled_flight.hpp"

namespace sightline {
namespace {

using Settings = std::vector<std::string>;

Scenario localized_view(const Settings& set) {
  return read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/certified_view.toml", built_in_registry(), set);
}

/// Three standard deviations of uav1's position relative to uav0, in its heading frame [m].
double three_sigma(const PoseEstimate& pose, const Vec3<double>& p) {
  const double c = std::cos(pose.psi), s = std::sin(pose.psi), x = p.x - pose.p.x, y = p.y - pose.p.y;
  // Derivatives of (c x + s y, -s x + c y, z) over position and heading.
  const std::array<std::array<double, 4>, 3> J = {
      {{-c, -s, 0, -s * x + c * y}, {s, -c, 0, -c * x - s * y}, {0, 0, -1, 0}}};
  double variance = 0.0;
  for (const auto& row : J)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) variance += row[size(i)] * pose.P(i, j) * row[size(j)];
  return 3 * std::sqrt(variance);
}

struct LocalizedFlown {
  int updates = 0, certified = 0;  // after the first 3 s, in which the estimate settles
  int lost = 0, unsure = 0;        // certified: out of a limit; with a covariance beyond `error`
  double withdrawn = infinity, searched = infinity, found = infinity;  // first events after 3 s [s]
  bool is_certified = false;                                           // at the end
};

LocalizedFlown fly_localized(const Scenario& scenario) {
  const Team& team = scenario.team;
  const CertifiedView& view = scenario.certified_views[0];
  LocalizedFlown flown;
  for (const Sample& sample : test::samples_of(scenario)) {
    if (sample.of != Sample::Of::update || sample.time < 3.0) continue;
    const ViewRecord& record = sample.views[0];
    const Sight<double> robot = true_sight(team, view.observer, sample),
                        target = true_sight(team, view.target, sample);
    const bool out =
        std::any_of(team.couplings().begin(), team.couplings().begin() + 3,
                    [&](const Coupling& c) { return c.term.potential.violation(robot, target) > 0; });
    ++flown.updates, flown.certified += record.certified;
    flown.lost += record.certified && out;
    const PoseEstimate& pose = sample.estimates[at(view.observer)];
    flown.unsure += record.certified && three_sigma(pose, target.p) > view.bounds.error + 1e-9;
    flown.is_certified = record.certified;
    for (int i = 0; i < sample.event_count; ++i) {
      const Event& event = sample.events[size(i)];
      const auto note = [&](EventKind kind, double& when) {
        if (event.kind == kind) when = std::min(when, event.time);
      };
      note(EventKind::view_uncertified, flown.withdrawn);
      note(EventKind::search, flown.searched), note(EventKind::found, flown.found);
    }
  }
  return flown;
}

TEST(LocalizedView, IsKeptWhileTheCovarianceKeepsTheStatedErrors) {
  const LocalizedFlown flown = fly_localized(localized_view({"simulation.duration=20.0"}));
  EXPECT_GT(flown.certified, 0.99 * flown.updates);
  EXPECT_EQ(flown.lost, 0);
  EXPECT_EQ(flown.unsure, 0);
  EXPECT_EQ(flown.withdrawn, infinity);
}

// Fewer pictures make the covariance grow: less is certified, and that holds.
TEST(LocalizedView, OfLostDetectionsIsCertifiedLess) {
  int before = 1 << 20;
  for (const char* dropout : {"0.3", "0.8", "0.97"}) {
    const LocalizedFlown flown = fly_localized(
        localized_view({"simulation.duration=20.0", std::string("agent.uav0.camera.dropout=") + dropout}));
    EXPECT_LE(flown.certified, before) << dropout;
    EXPECT_EQ(flown.lost, 0) << dropout;
    EXPECT_EQ(flown.unsure, 0) << dropout;
    before = flown.certified;
  }
  EXPECT_LT(before, 1000);
}

// A pillar hides the target for seconds. The certificate ends before the view counts as lost, and
// the search leads back into the set.
TEST(LocalizedView, EndsBeforeTheViewIsLostAndTheSearchEndsInTheSet) {
  const LocalizedFlown flown =
      fly_localized(localized_view({"simulation.duration=40.0", "agent.uav1.reference.circle.rate=0.0",
                                    "obstacle.pillar={d_hard=0.01,speed_max=0.1,hull={radius=0.4,height=6.0},"
                                    "motion={path={points=[[1.1,1.5,1.0],[1.1,-9.0,1.0]],speed=0.1}}}"}));
  EXPECT_GT(flown.certified, 500);
  EXPECT_LT(flown.withdrawn, flown.searched);
  EXPECT_LT(flown.searched, flown.found);
  EXPECT_LT(flown.found, infinity);
  EXPECT_TRUE(flown.is_certified);
  EXPECT_EQ(flown.lost, 0);
  EXPECT_EQ(flown.unsure, 0);
}

TEST(LocalizedView, IsStatedWithItsConditions) {
  const Scenario scenario = localized_view({});
  const CertifiedView& view = scenario.certified_views[0];
  const ViewTask& task = view.filter->certificate().task;
  EXPECT_NE(describe(view, scenario.team)
                .find("uav0 is localized by vision: while three standard deviations are "
                      "within 0.05 m relative to uav1, 0.1 m/s and 0.03 rad/s"),
            std::string::npos);
  EXPECT_GT(task.bounds.speed, view.bounds.speed + task.odometry.velocity);
  for (const char* more : {"error=0.07", "velocity_error=0.15", "turn_error=0.06"})
    EXPECT_LT(localized_view({std::string("certify_view[0].") + more}).certified_views[0].speed_most,
              view.speed_most)
        << more;
}

TEST(LocalizedView, IsRefusedWhereTheEstimateDoesNotBoundIt) {
  const auto refused = [](const Settings& set) {
    return refusal_of<ScenarioError>([&] { localized_view(set); });
  };
  EXPECT_TRUE(
      refused({"estimate.filter=\"heading\""})
          .ends_with("certify_view[0].observer = \"uav0\", expected a robot with localization = \"global\", "
                     "or with estimate.filter = \"attitude\", which estimates its velocity"));
  EXPECT_TRUE(
      refused({"certify_view[0].error=0.0"})
          .ends_with(
              "certify_view[0].error = 0, expected above 0 for an observer that is localized by vision"));
  EXPECT_TRUE(refused({"certify_view[0].velocity_error=0.0"}).ends_with("expected > 0 m/s"));
  EXPECT_TRUE(refused({"agent.uav0.localization=\"global\""})
                  .ends_with("expected no such key for an observer whose own state is measured"));
  EXPECT_TRUE(refused({"certify_view[0].age=0.05"})
                  .ends_with("certify_view[0].age = 0.05, expected 0 for an observer that is localized by "
                             "vision"));
  // A robot whose climb lags, and one whose velocity is along the axes of G.
  for (const std::string& text : std::vector<std::string>{
           R"~(states=["x","y","z","psi","v","w","c"],heading="psi",f={x="v*cos(psi) - w*sin(psi)",)~"
           R"~(y="v*sin(psi) + w*cos(psi)",z="c",psi="turn",v="a - 0.5*v",w="b - 0.5*w",c="(up - c)/0.3"})~",
           R"~(states=["x","y","z","d","e","v","w"],heading=["d","e"],f={x="v",y="w",z="up",)~"
           R"~(d="-(e*turn)",e="d*turn",v="a*d - b*e - 0.5*v",w="a*e + b*d - 0.5*w"})~"}) {
    const std::string refusal = refused(
        {R"(agent.uav0.robot={text={inputs=["a","b","up","turn"],position=["x","y","z"],)" + text + "}}",
         "agent.uav0.parameters={}"});
    EXPECT_TRUE(refusal.ends_with(
        "expected a robot whose climb and yaw rate follow its commands at once, with its velocity along its "
        "heading as states, as it is localized by vision"))
        << refusal;
  }
  EXPECT_TRUE(refused({"certify_view[0].observer=\"uav1\"", "certify_view[0].target=\"uav0\"",
                       "certify_view[0].speed_unrequested=0.5"})
                  .ends_with("expected no such key for a target that is localized by vision"));
  EXPECT_NE(
      refused({"certify_view[0].speed_max=0.6"}).find("the range corridor limits what can be certified"),
      std::string::npos);
}

}  // namespace
}  // namespace sightline
