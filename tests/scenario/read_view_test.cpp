// Scenarios with [[certify_view]]: the certificate that is read, and flights by the whole loop.
#include "sightline/scenario/read_view.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

#include "sightline/events.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/safety/view_filter.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"
#include "tests/support/view_set.hpp"

namespace sightline {
namespace {

/// A robot that is to be at `place`, which no view allows, and a ball that circles.
std::string leaving_robot(double rate, const std::string& place, const std::string& rest) {
  return fmt::format(R"(
[simulation]
duration = 8.0
[agent.uav0]
robot = "multirotor"
start = {{ p = [-0.8, 0.0, 1.55], heading = 0.0 }}
sensor = {{ pitch = 0.5, offset = 0.17 }}
Q = [4.0, 4.0, 4.0, 0.2, 0.2, 0.0, 0.0]
reference = {{ constant = {{ p = {} }} }}
[target.ball]
motion = {{ circle = {{ centre = [0.0, 0.0, 1.0], radius = 0.5, rate = {} }} }}
[[couple]]
potential = {{ sensor_cone = {{ alpha = 0.5 }} }}
between = ["uav0", "ball"]
weight = 0.4
{}{})",
                     place, rate, test::ball_distances, rest);
}

constexpr const char* certified = R"([[certify_view]]
observer = "uav0"
target = "ball"
speed_max = 0.5
)";

struct Flown {
  int updates = 0, certified = 0, active = 0, lost = 0;
  double least = infinity;    // of the set's inequalities at certified samples, by the checker [m]
  bool announced = true;      // no sample out of view before one that is not certified
  double nearest = infinity;  // to the third body [m]
  double cost = 0.0;          // sum of l
  std::vector<std::string> changes{};
  ViewReserve missed{};  // of the last sample that is not certified
};

/// Flies a scenario; the view is judged by the limits themselves at the true states, the cost is
/// that of the team `counted`.
Flown fly(const Scenario& scenario, const Team& counted) {
  const Team& team = scenario.team;
  Flown flown;
  std::optional<test::ViewChecker> checker;
  if (!scenario.certified_views.empty()) checker.emplace(scenario.certified_views[0].filter->certificate());
  const auto sight_of = [&](int body, const Sample& sample) {
    return true_sight(team, BodyId{body}, sample);
  };
  bool uncertified = scenario.certified_views.empty();
  for (const Sample& sample : test::samples_of(scenario)) {
    const Sight<double> robot = sight_of(0, sample), ball = sight_of(1, sample);
    const auto& couplings = team.couplings();
    const bool out = std::any_of(couplings.begin(), couplings.begin() + 3, [&](const Coupling& coupling) {
      return coupling.term.potential.violation(robot, ball) > 0;
    });
    flown.lost += out;
    flown.announced = flown.announced && (!out || uncertified);
    if (team.bodies() > 2) flown.nearest = std::min(flown.nearest, norm(robot.p - sight_of(2, sample).p));
    if (sample.of != Sample::Of::update) continue;
    ++flown.updates;
    flown.cost += stage_cost(counted, sample.time, sample.x, sample.u);
    if (sample.views.empty()) continue;
    const ViewRecord& record = sample.views[0];
    flown.certified += record.certified;
    flown.active += record.active;
    if (!record.certified) uncertified = true, flown.missed = record.least;
    if (record.certified && checker)
      flown.least = std::min(flown.least, checker->least(robot, ball.p, {ball.v.x, ball.v.y}));
    for (int i = 0; i < sample.event_count; ++i) {
      const EventKind kind = sample.events[static_cast<std::size_t>(i)].kind;
      if (kind == EventKind::view_certified || kind == EventKind::view_uncertified)
        flown.changes.emplace_back(to_string(kind));
    }
  }
  return flown;
}
Flown fly(const std::string& text) {
  const Scenario scenario = test::scenario_of(text);
  return fly(scenario, scenario.team);
}

using TableChanges = std::vector<std::string>;

TEST(CertifiedViews, KeepTheTargetThatTheSolverWouldLeave) {
  for (const char* place : {"[-4.0, 0.0, 1.5]", "[0.0, 0.0, 1.6]", "[0.0, 3.0, 0.2]"}) {
    const Flown flown = fly(leaving_robot(0.9, place, certified));
    EXPECT_EQ(flown.lost, 0) << place;
    EXPECT_EQ(flown.certified, flown.updates) << place;
    EXPECT_EQ(flown.changes, TableChanges{"view_certified"}) << place;
    EXPECT_GE(flown.least, -2e-6) << place;
    EXPECT_GT(flown.active, 0) << place;
    EXPECT_GT(fly(leaving_robot(0.9, place, "")).lost, 100) << place;
  }
}

TEST(CertifiedViews, KeepAnotherRobotOfTheTeamInView) {
  std::string text = leaving_robot(0.9, "[-4.0, 0.0, 1.5]", certified);
  const std::string ball = "[target.ball]\nmotion = { circle";
  text.replace(text.find(ball), ball.size(),
               "[agent.ball]\nrobot = \"multirotor\"\nstart = { p = [0.5, 0.0, 1.0] }\n"
               "Q = [2.0, 2.0, 2.0, 0.2, 0.2, 0.0, 0.0]\nreference = { circle");
  text.replace(text.find("rate = 0.9"), 10, "rate = 0.3");
  const Flown flown = fly(text);
  EXPECT_EQ(flown.lost, 0);
  EXPECT_EQ(flown.certified, flown.updates);
}

TEST(CertifiedViews, AreNotCertifiedForATargetBeyondItsBound) {
  const Flown flown = fly(leaving_robot(2.0, "[-4.0, 0.0, 1.5]", certified));
  EXPECT_LT(flown.certified, flown.updates / 2);
  EXPECT_EQ(flown.changes.front(), "view_certified");  // the first period knows no speed
  EXPECT_EQ(flown.changes[1], "view_uncertified");
  EXPECT_TRUE(flown.announced);
}

// The estimate moves no faster than the bound. It falls behind such a target.
TEST(CertifiedViews, AreNotCertifiedForAnEstimateThatTheTargetLeaves) {
  const std::string view =
      "[[certify_view]]\nobserver = \"uav0\"\ntarget = \"ball\"\nspeed_max = 0.5\nerror = 0.02\n";
  const Flown slow = fly(leaving_robot(0.4, "[-4.0, 0.0, 1.5]", view));
  EXPECT_EQ(slow.certified, slow.updates);
  EXPECT_EQ(slow.lost, 0);
  const Flown fast = fly(leaving_robot(2.0, "[-4.0, 0.0, 1.5]", view));
  EXPECT_LT(fast.certified, fast.updates / 2);
  EXPECT_TRUE(fast.announced);
}

TEST(CertifiedViews, AreNotCertifiedFromMeasurementsOlderThanStated) {
  const std::string late =
      "[[simulation.fault]]\nkind = \"delay\"\nbody = \"ball\"\ndelay = 0.1\nfrom = 0.5\n";
  const Flown unstated = fly(leaving_robot(0.9, "[-4.0, 0.0, 1.5]", certified + late));
  EXPECT_LT(unstated.certified, unstated.updates / 2);
  EXPECT_EQ(unstated.missed, ViewReserve::age);
  EXPECT_TRUE(unstated.announced);
  const Flown stated =
      fly(leaving_robot(0.9, "[-4.0, 0.0, 1.5]", std::string(certified) + "age = 0.1\n" + late));
  EXPECT_GE(stated.certified, stated.updates - 20);  // the measurement jumps when the delay begins
  EXPECT_EQ(stated.lost, 0);
}

// The supervisor predicts the own state to now. In wind that the bounds have, the view is kept;
// more wind leaves the filter's state behind.
TEST(CertifiedViews, OfAnObserverWhoseOwnStateIsLateNeedAgeSupervisorAndBoundedWind) {
  const auto late = [](const std::string& bounds, double wind, const std::string& supervisor) {
    return fly(
        leaving_robot(0.9, "[-4.0, 0.0, 1.5]",
                      fmt::format("{}{}[[simulation.fault]]\nkind = \"delay\"\nbody = \"uav0\"\ndelay = "
                                  "0.05\nfrom = 0.5\n[simulation.disturbance]\nwind = [{}, 0.0, 0.0]\n{}",
                                  certified, bounds, wind, supervisor)));
  };
  constexpr const char* supervisor = "[safety.supervisor]\n";
  const Flown stated = late("age = 0.06\nwind = 0.3\n", 0.29, supervisor);
  EXPECT_EQ(stated.certified, stated.updates);
  EXPECT_EQ(stated.lost, 0);
  EXPECT_GT(stated.active, 0);
  for (const Flown& flown : {late("", 0.0, supervisor), late("age = 0.06\nwind = 0.3\n", 0.29, "")}) {
    EXPECT_LT(flown.certified, flown.updates / 2);
    EXPECT_EQ(flown.missed, ViewReserve::age);
    EXPECT_TRUE(flown.announced);
  }
  const Flown windy = late("age = 0.06\nwind = 0.05\n", 0.6, supervisor);
  EXPECT_LT(windy.certified, windy.updates / 2);
  EXPECT_EQ(windy.missed, ViewReserve::motion);
  EXPECT_TRUE(windy.announced);
}

TEST(CertifiedViews, OfAFleetStateTheAgeOfWhatComesOverLinks) {
  const auto desk = [](const std::string& keys) {
    return read_scenario(SIGHTLINE_SOURCE_DIR "/fleets/desk.toml", with_links(),
                         {R"(certify_view=[{observer="uav0",target="uav1",speed_max=0.2)" + keys + "}]"});
  };
  EXPECT_TRUE(
      refusal_of<ScenarioError>([&] { desk(""); })
          .ends_with("certify_view[0].age is missing, expected above 0 beside a [fleet], whose states "
                     "arrive late"));
  const Scenario scenario = desk(",age=0.05,wind=0.2");
  EXPECT_EQ(
      warnings_of_views(scenario).front(),
      "the certified view of uav1 by uav0 assumes that the vehicle accelerates within wind = 0.2 m/s^2 of "
      "its model");
}

// The solver knows the set, so that the filter acts rarely.
TEST(CertifiedViews, ActOnFewCommandsOfASolverThatHasTheSetAsSoftLimits) {
  const auto paper = [](const std::vector<std::string>& set) {
    std::vector<std::string> all = {"simulation.duration=20.0"};
    all.insert(all.end(), set.begin(), set.end());
    return read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml", built_in_registry(), all);
  };
  const Scenario alone = paper({});
  const Flown flown =
      fly(paper({R"(certify_view=[{observer="uav0",target="uav1",speed_max=0.5}])"}), alone.team);
  EXPECT_LT(10 * flown.active, flown.updates);
  EXPECT_GT(flown.certified, 0.9 * flown.updates);
  EXPECT_LT(flown.cost, 1.03 * fly(alone, alone.team).cost);
}

// A body that comes as near as it can: the hard distance has priority.
TEST(CertifiedViews, GiveWayToTheHardDistanceAndReportItFirst) {
  const std::string ram =
      "[obstacle.ram]\nmotion = { path = { points = [[-0.9, 5.0, 1.5], [-0.9, -5.0, 1.5]], speed = 1.5 } }\n"
      "[safety]\nbarrier = \"on\"\nd_hard = 0.6\nfloor = 0.1\n";
  const Flown flown = fly(leaving_robot(0.9, "[-0.8, 0.0, 1.5]", certified + ram));
  EXPECT_GE(flown.nearest, 0.6);
  EXPECT_LT(flown.certified, flown.updates);
  EXPECT_TRUE(flown.announced);
}

TEST(CertifiedViews, BeginOutsideTheSetByTheSolverOrByTheNearestCommand) {
  for (const bool returns : {false, true}) {
    std::string text = leaving_robot(0.0, "[-3.2, 0.0, 2.0]",
                                     std::string(certified) + (returns ? "outside = \"return\"\n" : ""));
    text.replace(text.find("-0.8, 0.0, 1.55"), 15, "-3.0, 0.0, 2.00");
    const Flown flown = fly(text);
    EXPECT_EQ(flown.changes.front(), "view_uncertified");
    EXPECT_EQ(flown.certified > 0, returns);
    EXPECT_EQ(flown.active > 0, returns);
  }
}

TEST(CertifiedViews, ReadTheLimitsOfThePairAndStateWhatTheyCertify) {
  const Scenario scenario = test::scenario_of(leaving_robot(0.9, "[-4.0, 0.0, 1.5]", certified));
  ASSERT_EQ(scenario.certified_views.size(), 1U);
  const CertifiedView& view = scenario.certified_views[0];
  EXPECT_GE(view.speed_most, 0.96);
  EXPECT_EQ(view.limited_by, "the range corridor");
  const ViewCertificate& z = view.filter->certificate();
  EXPECT_GT(z.near, 0.6);
  EXPECT_LT(z.far, 2.0);
  EXPECT_TRUE(describe(view, scenario.team)
                  .starts_with("certify     view of ball by uav0 is certified up to 0.98 m/s; the range "
                               "corridor limits it\n"));
  EXPECT_TRUE(warnings_of_views(scenario).empty());
}

// A tighter limit from the start, or by an event at any time, makes the same certificate.
TEST(CertifiedViews, KeepTheLimitsThatEventsGiveThePair) {
  const auto speed = [](const std::string& cone, const std::string& rest) {
    std::string text = leaving_robot(0.9, "[-4.0, 0.0, 1.5]", std::string(certified) + rest);
    text.replace(text.find("[[couple]]"), 10, "[[couple]]\nname = \"sees\"");
    const std::string wide = "sensor_cone = { alpha = 0.5 }";
    text.replace(text.find(wide), wide.size(), cone);
    return test::scenario_of(text).certified_views.at(0).speed_most;
  };
  const auto event = [](const std::string& action) { return "[[event]]\nat = 3.0\n" + action; };
  const std::string wide = "sensor_cone = { alpha = 0.5 }", narrow = "sensor_cone = { alpha = 0.3 }";
  const double by_narrow = speed(narrow, "");
  EXPECT_LT(by_narrow, speed(wide, ""));
  EXPECT_EQ(speed(wide, event("retune = { couple = \"sees\", potential = { " + narrow + " } }\n")),
            by_narrow);
  EXPECT_EQ(speed(narrow, event("retune = { couple = \"sees\", potential = { " + wide + " } }\n")),
            by_narrow);
  const std::string far = "{ potential = { keep_out = { d_min = 1.2 } }, between = [\"ball\", \"uav0\"] }";
  EXPECT_EQ(
      speed(wide, event("add = { couple = " + far + " }\n")),
      speed(wide,
            "[[couple]]\npotential = { keep_out = { d_min = 1.2 } }\nbetween = [\"ball\", \"uav0\"]\n"));
}

/// The view of the ball by a robot that observes the cube at first, `before` the events.
std::string turning_robot(const std::string& before, const std::string& events) {
  std::string text = leaving_robot(0.9, "[-4.0, 0.0, 1.5]", std::string(certified) + before + events);
  text.insert(text.find("[target.ball]"),
              "[target.cube]\np = [0.5, 0.4, 1.0]\n[target.post]\np = [0.5, -0.4, 1.0]\n");
  for (std::size_t at = text.find("\"ball\""); at < text.find("[[certify_view]]"); at = text.find("\"ball\""))
    text.replace(at, 6, "\"cube\"");
  return text;
}

/// The numbers of the certificate of the first view.
std::vector<double> certificate_of(const std::string& text) {
  const Scenario scenario = test::scenario_of(text);
  const CertifiedView& view = scenario.certified_views.at(0);
  const ViewCertificate& z = view.filter->certificate();
  std::vector<double> numbers = {view.speed_most, z.near,     z.far,    z.theta, z.climb,
                                 z.turn,          z.sideward, z.push.x, z.push.y};
  numbers.insert(numbers.end(), z.low.begin(), z.low.end());
  numbers.insert(numbers.end(), z.high.begin(), z.high.end());
  return numbers;
}

std::string event_at(double t, const std::string& action) {
  return fmt::format("[[event]]\nat = {}\n{}\n", t, action);
}

// Each of these gives the pair a limit on its way. The certificate is that of the limit from the start.
TEST(CertifiedViews, KeepTheLimitsThatTheirObserverTakesAlong) {
  const auto couple = [](const char* potential, const char* target) {
    return fmt::format("potential = {{ {} }}, between = [\"uav0\", \"{}\"]", potential, target);
  };
  const auto turn = [](double t, const char* target) {
    return event_at(t, fmt::format("observe = {{ observer = \"uav0\", target = \"{}\" }}", target));
  };
  const std::string to_ball = turn(4.0, "ball");
  const auto stated = [&](const char* potential, const std::string& turns) {
    return certificate_of(turning_robot(
        fmt::format("[[couple]]\npotential = {{ {} }}\nbetween = [\"uav0\", \"cube\"]\n", potential), turns));
  };
  const std::vector<double> alone = certificate_of(turning_robot("", to_ball));
  for (const char* limit :
       {"cohesion = { d_max = 1.6 }", "keep_out = { d_min = 1.1 }", "sensor_cone = { alpha = 0.35 }"}) {
    const std::vector<double> from_start = stated(limit, to_ball);
    EXPECT_NE(from_start, alone) << limit;
    const std::string to_cube = "add = { couple = { " + couple(limit, "cube") + " } }",
                      named = "add = { couple = { name = \"near\", " +
                              couple("cohesion = { d_max = 9.0 }", "cube") + " } }",
                      retune = fmt::format("retune = {{ couple = \"near\", potential = {{ {} }} }}", limit);
    // The coupling is added to the other target, before or in the event that turns the observer.
    EXPECT_EQ(certificate_of(turning_robot("", event_at(2.0, to_cube) + to_ball)), from_start) << limit;
    // The times of two signals are unknown: the order of the file has no meaning.
    const std::string on_signal =
        "[[simulation.signal]]\nname = \"turn\"\n[[simulation.signal]]\nname = \"add\"\n"
        "[[event]]\nsignal = \"turn\"\nobserve = { observer = \"uav0\", target = \"ball\" }\n"
        "[[event]]\nsignal = \"add\"\n" +
        to_cube + "\n";
    EXPECT_EQ(certificate_of(turning_robot("", on_signal)), from_start) << limit;
    // It takes a way over a third body.
    const std::string over_post =
        turn(1.0, "post") + event_at(2.0, "add = { couple = { " + couple(limit, "post") + " } }");
    EXPECT_EQ(certificate_of(turning_robot("", over_post + to_ball)),
              stated(limit, turn(1.0, "post") + to_ball))
        << limit;
    // It is added, and given its potential before or after the turn.
    for (const double t : {3.0, 5.0})
      EXPECT_EQ(certificate_of(turning_robot("", event_at(2.0, named) + event_at(t, retune) + to_ball)),
                from_start)
          << limit << t;
  }
  // A coupling with a body that the robot never observes stays there.
  const std::string elsewhere = "add = { couple = { " + couple("cohesion = { d_max = 1.6 }", "post") + " } }";
  EXPECT_EQ(certificate_of(turning_robot("", event_at(2.0, elsewhere) + to_ball)), alone);
}

// Beside a view, every kind of event is counted, does not concern the certificate, or ends it in flight.
TEST(CertifiedViews, CountEveryKindOfEventOrReportThatItEndsThem) {
  const std::string others =
      "[agent.uav1]\nrobot = \"multirotor\"\nstart = { p = [6.0, 0.0, 1.0] }\n[target.post]\np = [6.0, 4.0, "
      "1.0]\npresent = false\n[target.cube]\np = [4.0, 4.0, 1.0]\n";
  const auto robot = [&](const std::string& rest) {
    std::string text = leaving_robot(0.9, "[-4.0, 0.0, 1.5]", std::string(certified) + rest);
    text.insert(text.find("[target.ball]"), others);
    text.replace(text.find("duration = 8.0"), 14, "duration = 4.0");
    return text;
  };
  struct Kind {
    const char* action;
    const char* from_start;  // what makes the same certificate without the event
    bool ends = false;       // the view, in flight
  };
  const std::vector<Kind> kinds = {
      {"remove = \"cube\"", ""},
      {"remove = \"ball\"", "", true},
      {"remove = { agent = \"uav0\", then = \"hold\" }", "", true},
      {"remove = { couple = \"couple[1]\" }", ""},
      {"remove = { couple = \"couple[0]\" }", "", true},
      {"add = \"post\"", ""},
      {"add = { couple = { potential = { cohesion = { d_max = 1.6 } }, between = [\"uav0\", \"ball\"] } }",
       "[[couple]]\npotential = { cohesion = { d_max = 1.6 } }\nbetween = [\"uav0\", \"ball\"]\n"},
      {"add = { constrain = { agent = \"uav0\", potential = { altitude_band = { z_max = 4.5 } } } }", ""},
      {"retune = { agent = \"uav0\", u_min = [-0.6, -0.6, -0.6, -0.6], u_max = [0.6, 0.6, 0.6, 0.6] }",
       "[[event]]\nat = 0.0\nretune = { agent = \"uav0\", u_min = [-0.6, -0.6, -0.6, -0.6], u_max = [0.6, "
       "0.6, "
       "0.6, 0.6] }\n"},
      {"retune = { couple = \"couple[0]\", potential = { sensor_cone = { alpha = 0.4 } } }",
       "[[couple]]\npotential = { sensor_cone = { alpha = 0.4 } }\nbetween = [\"uav0\", \"ball\"]\n"},
      {"observe = { observer = \"uav0\", target = \"cube\" }", "", true},
      {"reference = { agent = \"uav0\", reference = { constant = { p = [0.0, 0.0, 2.0] } } }", ""},
      {"move = { target = \"ball\", p = [3.0, 3.0, 1.0] }", "", true},
      {"wind = { acceleration = [2.0, 0.0, 0.0] }", "", true},
      {"fault = { kind = \"dropout\", body = \"ball\", for = 1.0 }", "", true},
      {"fault = { kind = \"jump\", body = \"ball\", for = 1.0, offset = [0.3, 0.0, 0.0] }", "", true},
  };
  const std::vector<double> alone = certificate_of(robot(""));
  std::array<bool, std::variant_size_v<Action>> seen{};
  for (const auto& [action, from_start, ends] : kinds) {
    const std::string text = robot(event_at(2.0, action));
    for (const Action& one : test::scenario_of(text).script.events.at(0).actions) seen[one.index()] = true;
    const std::vector<double> counted = certificate_of(text);
    EXPECT_EQ(counted, certificate_of(robot(from_start))) << action;
    EXPECT_EQ(counted == alone, from_start[0] == 0) << action;
    const Flown flown = fly(text);
    const bool ended =
        std::find(flown.changes.begin(), flown.changes.end(), "view_uncertified") != flown.changes.end();
    EXPECT_EQ(ended, ends) << action;
    EXPECT_EQ(flown.certified == flown.updates, !ends) << action;
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), std::ssize(seen));
}

// No event turns the couplings with another target to that of the view.
TEST(CertifiedViews, AreNotOfCouplingsThatEventsRetuneWithAnotherTarget) {
  const auto speed = [](const std::string& other, const std::string& retuned) {
    std::string text =
        leaving_robot(0.9, "[-4.0, 0.0, 1.5]", certified) +
        fmt::format(
            "[[couple]]\nname = \"other\"\nbetween = [\"uav0\", \"post\"]\n{}\n[[event]]\nat = "
            "3.0\nretune = {{ couple = \"other\", {} }}\n",
            other, retuned);
    text.insert(text.find("[target.ball]"),
                "[agent.uav0.sensors.back]\nyaw = 3.0\n[target.post]\np = [-3.0, 0.0, 1.0]\n");
    return test::scenario_of(text).certified_views.at(0).speed_most;
  };
  const std::string near = "potential = { cohesion = { d_max = 9.0 } }",
                    sees = "potential = { bearing = { alpha = 0.8 } }\nsensor = \"back\"";
  const double alone = speed(near, "weight = 2.0");
  EXPECT_EQ(speed(near, "potential = { cohesion = { d_max = 0.9 } }"), alone);
  EXPECT_EQ(speed(sees, "potential = { bearing = { alpha = 0.6 } }"), alone);
}

TEST(CertifiedViews, BelongToThePartOfTheirObserver) {
  std::string text = leaving_robot(0.9, "[-4.0, 0.0, 1.5]", certified);
  text.insert(text.find("[agent.uav0]"),
              "[agent.other]\nrobot = \"multirotor\"\nstart = { p = [9.0, 0.0, 1.0] }\n");
  const std::string parts = "[partition]\nfront = [\"other\"]\nrear = [\"uav0\"]\npart = ";
  EXPECT_TRUE(test::scenario_of(text + parts + "\"front\"\n").certified_views.empty());
  const Scenario rear = test::scenario_of(text + parts + "\"rear\"\n");
  ASSERT_EQ(rear.certified_views.size(), 1U);
  EXPECT_EQ(rear.team.name(rear.certified_views[0].observer), "uav0");
  EXPECT_EQ(rear.team.name(rear.certified_views[0].target), "ball");
}

TEST(CertifiedViews, WarnWhereAnotherPartOfTheScenarioEndangersThem) {
  const auto warnings = [](double rate, const std::string& rest) {
    return warnings_of_views(test::scenario_of(leaving_robot(rate, "[-4.0, 0.0, 1.5]", certified + rest)));
  };
  EXPECT_EQ(
      warnings(1.6, ""),
      std::vector<std::string>{"the certified view of ball by uav0 assumes speed_max = 0.5 m/s, the target "
                               "moves at up to 0.8 m/s"});
  const std::vector<std::string> near = warnings(0.9, "[safety]\nbarrier = \"on\"\nd_hard = 0.95\n");
  ASSERT_EQ(near.size(), 2U);
  EXPECT_EQ(near[0],
            "the certified view of ball by uav0 assumes speed_max = 0.5 m/s, and the barrier may break it, "
            "which assumes 1.5 m/s of the target");
  EXPECT_NE(near[1].find("the barrier may break it with d_hard = 0.95 m"), std::string::npos);
}

TEST(CertifyView, SeveralCouplingsOfOneEventTurnItsObserverOnce) {
  const std::string text = leaving_robot(0.3, "[-0.8, 0.0, 1.5]", certified) + R"([[event]]
at = 1.0
add = [{ couple = { potential = { bearing = { alpha = 0.5 } }, between = ["uav0", "ball"] } },
       { couple = { potential = { sensor_cone = { alpha = 0.6 } }, between = ["uav0", "ball"] } }]
)";
  EXPECT_EQ(test::scenario_refusal(text), "");
}

// Of two couplings that observe the target, each is removed first.
TEST(CertifyView, ASetStaysInTheCostAsLongAsACouplingObservesItsTarget) {
  const Scenario scenario =
      test::scenario_of(leaving_robot(0.3, "[-0.8, 0.0, 1.5]", certified) + R"([[couple]]
name = "second"
potential = { bearing = { alpha = 0.5 } }
between = ["uav0", "ball"]
[[event]]
at = 1.0
remove = { couple = "couple[0]" }
[[event]]
at = 2.0
remove = { couple = "second" }
)");
  const auto& events = scenario.script.events;
  for (const auto& order : {std::array<std::size_t, 2>{0, 1}, std::array<std::size_t, 2>{1, 0}}) {
    ActiveTeam active(scenario.team, scenario.presence);
    const auto sets = [&] {
      const std::vector<Coupling>& all = active.couplings();
      return std::count_if(all.begin(), all.end(), [](const Coupling& c) {
        return c.term.potential.name() == "certified_view" && c.ramp.lasts();
      });
    };
    ASSERT_EQ(sets(), 1);
    for (const Action& action : events[order[0]].actions) EXPECT_EQ(active.apply(action, 1.0, 0.5), "");
    EXPECT_EQ(sets(), 1) << order[0];
    for (const Action& action : events[order[1]].actions) EXPECT_EQ(active.apply(action, 2.0, 0.5), "");
    EXPECT_EQ(sets(), 0) << order[0];
  }
}

// A second sensor turns; the view of the first, and its set, stay.
TEST(CertifyView, AnotherSensorThatTurnsLeavesTheSetOfTheView) {
  std::string text = leaving_robot(0.3, "[-0.8, 0.0, 1.5]", certified) + R"([[couple]]
potential = { bearing = { alpha = 0.8 } }
between = ["uav0", "here"]
sensor = "back"
[[event]]
at = 1.0
observe = { observer = "uav0", target = "there", sensor = "back" }
)";
  text.insert(text.find("[target.ball]"),
              "[agent.uav0.sensors.back]\nyaw = 3.0\n[target.here]\np = [-3.0, 0.0, 1.0]\n"
              "[target.there]\np = [-3.0, 1.0, 1.0]\n");
  const Scenario scenario = test::scenario_of(text);
  ActiveTeam active(scenario.team, scenario.presence);
  for (const Action& action : scenario.script.events.at(0).actions)
    EXPECT_EQ(active.apply(action, 1.0, 0.0), "");
  std::vector<std::string> lasting;
  for (const Coupling& c : active.couplings())
    if (c.ramp.lasts() && (observes(c.term.potential) || c.term.potential.name() == "certified_view"))
      lasting.push_back(fmt::format("{} {}", c.term.potential.name(), scenario.team.name(c.between.second)));
  std::sort(lasting.begin(), lasting.end());
  EXPECT_EQ(lasting, (std::vector<std::string>{"bearing there", "certified_view ball", "sensor_cone ball"}));
}

/// The limits of a view; the keys `last` are of the coupling that observes.
std::string views_of(const std::string& robot, const std::string& target, const std::string& last) {
  std::string couples;
  for (const char* potential :
       {"cohesion = { d_max = 3.0 }", "keep_out = { d_min = 0.8 }", "sensor_cone = { alpha = 0.6 }"})
    couples += fmt::format("[[couple]]\npotential = {{ {} }}\nbetween = [\"{}\", \"{}\"]\n", potential, robot,
                           target);
  return couples + last;
}

/// Two robots on opposite sides of a ball and of a cube, with certified views of these pairs.
std::string two_observers(const std::string& rest, const std::vector<std::array<const char*, 2>>& views) {
  std::string text =
      "[simulation]\nduration = 1.0\n[target.ball]\np = [0.0, 0.0, 1.1]\n[target.cube]\np = [0.0, 0.4, "
      "1.1]\n";
  for (const auto& [name, x, heading] : {std::tuple("uav0", -1.6, 0.0), std::tuple("uav1", 1.6, 3.14)})
    text += fmt::format(R"([agent.{}]
robot = "multirotor"
start = {{ p = [{}, 0.0, 1.4], heading = {} }}
sensor = {{ pitch = 0.2, offset = 0.17 }}
)",
                        name, x, heading);
  for (const auto& [observer, target] : views)
    text += fmt::format("[[certify_view]]\nobserver = \"{}\"\ntarget = \"{}\"\nspeed_max = 0.1\n", observer,
                        target);
  return text + rest;
}

/// The pairs of the sets in the cost after the events with these ends of their names.
std::vector<std::string> sets_after(const std::string& text, const std::vector<std::string>& names) {
  const Scenario scenario = test::scenario_of(text);
  ActiveTeam active(scenario.team, scenario.presence);
  std::size_t happened = 0;
  for (const std::string& name : names) {
    for (const TeamEvent& event : scenario.script.events) {
      if (!event.name.ends_with(name)) continue;
      ++happened;
      for (const Action& action : event.actions) EXPECT_EQ(active.apply(action, 1.0, 0.5), "") << name;
    }
  }
  EXPECT_EQ(happened, names.size());
  std::vector<std::string> sets;
  const Team team = active.team(3.0);
  for (const Coupling& c : team.couplings())
    if (c.term.potential.name() == "certified_view")
      sets.push_back(fmt::format("{} {}", team.name(c.between.first), team.name(c.between.second)));
  std::sort(sets.begin(), sets.end());
  return sets;
}

// The first action of each event ends a view before the next one begins another.
TEST(CertifyView, TheSetsOfAnEventAreThoseOfThePairsObservedAfterIt) {
  const std::string couples = views_of("uav0", "ball", "name = \"sees\"\n") + views_of("uav1", "cube", "");
  using Sets = std::vector<std::string>;
  const auto after = [&](const std::string& actions, const std::vector<std::array<const char*, 2>>& begun) {
    std::vector<std::array<const char*, 2>> views = {{"uav0", "ball"}, {"uav1", "cube"}};
    views.insert(views.end(), begun.begin(), begun.end());
    return sets_after(two_observers(couples + "[[event]]\nname = \"turn\"\nat = 1.0\n" + actions, views),
                      {"turn"});
  };
  const std::string remove = "remove = { couple = \"sees\" }\n";
  EXPECT_EQ(after(remove, {}), Sets{"uav1 cube"});
  EXPECT_EQ(after(remove + "add = { couple = { potential = { bearing = { alpha = 0.5 } }, "
                           "between = [\"uav0\", \"ball\"] } }\n",
                  {}),
            (Sets{"uav0 ball", "uav1 cube"}));
  EXPECT_EQ(after("observe = [{ observer = \"uav0\", target = \"cube\" }, "
                  "{ observer = \"uav1\", target = \"ball\" }]\n",
                  {{"uav0", "cube"}, {"uav1", "ball"}}),
            (Sets{"uav0 cube", "uav1 ball"}));
}

// The other coupling moves with the one that observes, or is added and given a sensor by two
// events.
TEST(CertifyView, ACouplingThatIsGivenASensorBeginsTheSetOfItsPair) {
  using Sets = std::vector<std::string>;
  const auto event = [](const char* name, double at, const std::string& actions) {
    return fmt::format("[[event]]\nname = \"{}\"\nat = {}\n{}\n", name, at, actions);
  };
  const auto retune = [&](const char* name, double at, const char* potential) {
    return event(name, at, fmt::format("retune = {{ couple = \"near\", potential = {{ {} }} }}", potential));
  };
  const std::string near =
                        "[[couple]]\nname = \"near\"\npotential = { cohesion = { d_max = 2.5 } }\n"
                        "between = [\"uav0\", \"ball\"]\n",
                    others =
                        "[[couple]]\npotential = { cohesion = { d_max = 3.0 } }\nbetween = [\"uav0\", "
                        "\"ball\"]\n" +
                        views_of("uav1", "cube", ""),
                    cone = retune("retune", 3.0, "sensor_cone = { alpha = 0.6 }");
  const auto after = [&](const std::string& rest, const std::vector<std::string>& names,
                         const char* target = "ball") {
    return sets_after(two_observers(rest, {{"uav0", target}, {"uav1", "cube"}}), names);
  };
  const Sets both = {"uav0 ball", "uav1 cube"};
  EXPECT_EQ(after(near + others + cone, {}), Sets{"uav1 cube"});
  EXPECT_EQ(after(near + others + cone, {"retune"}), both);
  const std::string add = event("add", 1.0,
                                "add = { couple = { name = \"near\", potential = { cohesion = { d_max "
                                "= 2.5 } }, between = [\"uav0\", \"ball\"] } }");
  EXPECT_EQ(after(others + add + cone, {"add"}), Sets{"uav1 cube"});
  EXPECT_EQ(after(others + add + cone, {"add", "retune"}), both);
  const std::string sees =
                        "[[couple]]\nname = \"sees\"\npotential = { bearing = { alpha = 0.7 } }\n"
                        "between = [\"uav0\", \"ball\"]\n",
                    turn = event("turn", 1.0, "observe = { observer = \"uav0\", target = \"cube\" }") +
                           event("end", 2.0, "remove = { couple = \"sees\" }");
  const Sets moved = {"uav0 cube", "uav1 cube"};
  EXPECT_EQ(after(near + others + sees + turn + cone, {"turn"}, "cube"), moved);
  EXPECT_EQ(after(near + others + sees + turn + cone, {"turn", "end"}, "cube"), Sets{"uav1 cube"});
  EXPECT_EQ(after(near + others + sees + turn + cone, {"turn", "end", "retune"}, "cube"), moved);
  const std::string blind = retune("blind", 4.0, "cohesion = { d_max = 2.0 }");
  EXPECT_EQ(after(near + others + cone + blind, {"retune", "blind"}), Sets{"uav1 cube"});
}

TEST(CertifyView, TheSetOfARelayIsThatOfItsObserver) {
  const std::string text = two_observers(R"([[shape]]
nearest = { target = "ball", observers = ["uav0", "uav1"] }
potentials = [{ sensor_cone = { alpha = 0.6 } }, { cohesion = { d_max = 3.0 } }, { keep_out = { d_min = 0.8 } }]
)",
                                         {{"uav0", "ball"}, {"uav1", "ball"}});
  EXPECT_EQ(sets_after(text, {}), std::vector<std::string>{"uav0 ball"});
  EXPECT_EQ(sets_after(text, {"uav1 takes over from uav0"}), std::vector<std::string>{"uav1 ball"});
}

TEST(CertifyView, ASetStaysWhereAnotherTargetOfItsObserverChanges) {
  const std::string first =
      "[[couple]]\npotential = { bearing = { alpha = 0.8 } }\nbetween = [\"uav0\", \"cube\"]\n";
  const std::string turn = R"([target.post]
p = [0.0, 0.8, 1.1]
[[event]]
name = "turn"
at = 1.0
observe = { observer = "uav0", target = "post" }
)";
  const std::string choice = R"([agent.uav0.camera]
[target.cube.tags]
[target.post]
p = [0.0, 0.8, 1.1]
tags = {}
[[shape]]
best = { target = ["cube", "post"], observers = ["uav0"] }
potential = { bearing = { alpha = 0.8 } }
)";
  const std::string couples = views_of("uav0", "ball", "");
  const std::vector<std::string> sets = {"uav0 ball"};
  EXPECT_EQ(sets_after(two_observers(first + couples + turn, {{"uav0", "ball"}}), {"turn"}), sets);
  EXPECT_EQ(sets_after(two_observers(couples + choice, {{"uav0", "ball"}}), {"uav0 turns to post"}), sets);
}

}  // namespace
}  // namespace sightline
