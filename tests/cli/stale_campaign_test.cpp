// Old, lost and wrong data: compensated, slowed, held, landed; never a command that is not finite
// or too large.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "sightline/judge/summary.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline {
namespace {

constexpr double settle = 10.0;  // [s]

// The observer of scenarios/cooperative_localization.toml and a target that circles at 0.3 m/s:
// another robot, or uncooperative bodies whose motion nobody tells.
Scenario scenario(bool uncooperative, const std::string& more) {
  const std::string robot = "robot = \"multirotor\"\n";
  std::string text = "[agent.a]\n" + robot +
                     "start = { p = [-0.6, -0.3, 0.6] }\nR = [0.1, 0.1, 0.1, 0.1]\nsensor = { pitch = 0.5, "
                     "offset = 0.17 }\n";
  text +=
      uncooperative
          ? "[target.t]\nmotion = { circle = { centre = [0.0, 0.0, 1.0], radius = 1.0, rate = 0.3 } "
            "}\nspeed_max = 0.3\n"
          : "[agent.t]\n" + robot +
                "start = { p = [1.0, 0.0, 1.0], heading = 1.57 }\nQ = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]\n"
                "reference = { circle = { centre = [0.0, 0.0, 1.0], radius = 1.0, rate = 0.3 } }\n";
  const auto couple = [&](std::string_view potential, double weight) {
    text += fmt::format(
        "[[couple]]\npotential = {{ {} }}\nbetween = [\"a\", \"t\"]\nfelt_by = [\"a\"]\nweight = {}\n",
        potential, weight);
  };
  couple("bearing = { alpha = 0.5, width = 0.1, tilt = 0.2 }", 1.0);
  couple("too_near = { d_min = 1.0, kappa = 10.0 }", 4.0);
  couple("too_far = { d_max = 2.0, kappa = 10.0 }", 1.0);
  couple("relative_velocity = { v_0 = 1.0 }", 0.1);
  return parse_scenario(text + "[safety]\nbarrier = \"on\"\nd_hard = 0.6\n[safety.supervisor]\n" + more,
                        "a.toml");
}

struct Flight {
  std::vector<double> distance, angle;                                   // after settle
  bool in_view = true;                                                   // always, after settle
  double nearest = 1e9, largest_input = 0.0, height = 0.0, speed = 0.0;  // the last two: of a, at the end
  std::vector<Event> events;
  LoopOutcome outcome;
};

class Watch final : public test::SampleSink {
 public:
  Watch(const Scenario& scenario, Sample prototype)
      : SampleSink(std::move(prototype)),
        scenario_(scenario),
        seen_(observations(scenario.team.couplings()).at(0)) {}
  void publish() noexcept override {
    const Team& team = scenario_.team;
    const auto sight = [&](BodyId body) {
      return team.model(body).sight(sample_.x.data() + team.state_offset(body),
                                    sample_.u.data() + team.input_offset(body));
    };
    const Sight<double> a = sight(BodyId{0}), t = sight(BodyId{1});
    flight.nearest = std::min(flight.nearest, norm(a.p - t.p));
    for (const double u : sample_.u) {
      flight.largest_input = std::isfinite(u) ? std::max(flight.largest_input, std::abs(u)) : INFINITY;
    }
    flight.height = a.p.z;
    flight.speed = norm(a.v);
    flight.events.insert(flight.events.end(), sample_.events.begin(),
                         sample_.events.begin() + sample_.event_count);
    if (sample_.time < settle) return;
    flight.distance.push_back(norm(a.p - t.p));
    flight.angle.push_back(view_angle(seen_.mount, a, t.p));
    flight.in_view = flight.in_view && seen_.potential.violation(a, t, sample_.time) <= 0;
  }

  Flight flight;

 private:
  const Scenario& scenario_;
  Observation seen_;
};

Flight fly(Scenario flown, double duration) {
  flown.simulation.duration = duration;
  const auto solver = make_solver(flown.solver, flown.team, flown.horizon);
  const Controllers controllers = {*solver};
  SimulatedClock clock;
  Watch watch(flown, sized_sample(flown.team, controllers));
  watch.flight.outcome = ClosedLoop(flown, *make_world(flown), controllers, clock, watch).fly();
  EXPECT_TRUE(watch.flight.outcome.finite);
  EXPECT_LE(watch.flight.largest_input, 1.0);
  return watch.flight;
}

// A fault in the measurements of all bodies.
std::string fault(const std::string& keys) { return "[[simulation.fault]]\n" + keys; }
std::string late_by(double delay) { return fault(fmt::format("kind = \"delay\"\ndelay = {}\n", delay)); }

std::set<EventKind> kinds(const Flight& flight) {
  std::set<EventKind> found;
  for (const Event& event : flight.events) found.insert(event.kind);
  return found;
}

class StaleData : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Targets, StaleData, testing::Bool(),
                         [](const auto& target) { return target.param ? "UncooperativeBody" : "Robot"; });

TEST_P(StaleData, UpToAFifthOfASecondFlyAsIfTheyWereFresh) {
  const double duration = whole_campaign() ? 60.0 : 20.0;
  const Flight fresh = fly(scenario(GetParam(), ""), duration);
  EXPECT_TRUE(fresh.in_view);
  double distance = 0.0, angle = 0.0;
  for (int late = 1; late <= 20; late += whole_campaign() ? 1 : 19) {
    const Flight flight = fly(scenario(GetParam(), late_by(0.01 * late)), duration);
    for (std::size_t k = 0; k < fresh.distance.size(); ++k) {
      distance = std::max(distance, std::abs(flight.distance[k] - fresh.distance[k]));
      angle = std::max(angle, std::abs(flight.angle[k] - fresh.angle[k]));
    }
    EXPECT_FALSE(kinds(flight).contains(EventKind::slowed)) << late;
  }
  EXPECT_LE(distance, 0.05);
  EXPECT_LE(angle, 0.03);
  RecordProperty("distance_um", static_cast<int>(1e6 * distance));
  RecordProperty("angle_urad", static_cast<int>(1e6 * angle));
}

TEST_P(StaleData, UpToHalfASecondAreFlownSlowlyWithTheTargetInView) {
  for (int late = 21; late <= 50; late += whole_campaign() ? 1 : 29) {
    const Flight flight = fly(scenario(GetParam(), late_by(0.01 * late)), whole_campaign() ? 60.0 : 20.0);
    EXPECT_TRUE(flight.in_view) << late;
    EXPECT_TRUE(kinds(flight).contains(EventKind::slowed)) << late;
    EXPECT_FALSE(kinds(flight).contains(EventKind::hold)) << late;
    EXPECT_GE(flight.nearest, 0.6);
  }
}

TEST_P(StaleData, BeyondHalfASecondTheRobotHolds) {
  for (const double late : {0.51, 1.0, 1.99}) {
    const Flight flight = fly(scenario(GetParam(), late_by(late)), 20.0);
    EXPECT_LT(flight.speed, 0.02) << late;
    EXPECT_GT(flight.height, 0.2);
    EXPECT_TRUE(kinds(flight).contains(EventKind::hold)) << late;
    EXPECT_FALSE(kinds(flight).contains(EventKind::land)) << late;
  }
}

TEST_P(StaleData, BeyondTwoSecondsTheRobotLandsAndStaysOnTheGround) {
  for (const std::string& lost :
       {late_by(2.5), fault("kind = \"dropout\"\nfrom = 8.0\n"), fault("kind = \"nan\"\nfrom = 8.0\n"),
        fault("kind = \"dropout\"\nfrom = 8.0\nuntil = 14.0\n")}) {
    const Flight flight = fly(scenario(GetParam(), lost), 30.0);
    EXPECT_TRUE(kinds(flight).contains(EventKind::grounded)) << lost;
    EXPECT_NEAR(flight.height, 0.0, 0.05) << lost;
    EXPECT_LT(flight.speed, 1e-3) << lost;
  }
}

TEST_P(StaleData, AfterAnyPassingFaultTheTargetIsInViewAgainWithinTenSeconds) {
  for (const std::string& passing :
       {fault("kind = \"dropout\"\nfrom = 2.0\nuntil = 3.5\n"),
        fault("kind = \"dropout\"\nprobability = 0.7\n"),
        fault("kind = \"freeze\"\nfrom = 2.0\nuntil = 3.5\n"), fault("kind = \"nan\"\nprobability = 0.3\n"),
        fault("kind = \"nan\"\nfrom = 2.0\nuntil = 3.5\n"),
        fault("kind = \"jump\"\nbody = \"t\"\noffset = [0.4, 0.0, 0.0]\nfrom = 2.0\nuntil = 4.0\n"),
        fault("kind = \"jump\"\noffset = [0.0, 3.0, 1.0]\nprobability = 0.2\n"), late_by(0.15),
        fault("kind = \"late_plan\"\ndelay = 0.15\n"),
        fault("kind = \"late_plan\"\ndelay = 1.5\nfrom = 2.0\nuntil = 3.0\n")}) {
    const Flight flight = fly(scenario(GetParam(), passing), 25.0);
    EXPECT_TRUE(flight.in_view) << passing;
    EXPECT_GE(flight.nearest, 0.6) << passing;
    EXPECT_FALSE(kinds(flight).contains(EventKind::land)) << passing;
    EXPECT_FALSE(flight.events.empty()) << passing;
  }
}

TEST_P(StaleData, NoFlightTakesAnEdgeThatTheLadderDoesNotHave) {
  for (int trial = 0; trial < (whole_campaign() ? 60 : 6); ++trial) {
    Scenario flown =
        scenario(GetParam(), fault("kind = \"dropout\"\nprobability = 0.97\n") +
                                 fault("kind = \"nan\"\nprobability = 0.2\n") +
                                 fault("kind = \"late_plan\"\ndelay = 0.3\nfrom = 3.0\nuntil = 5.0\n"));
    flown.simulation.seed = static_cast<std::uint64_t>(trial);
    std::map<double, EventKind> last;  // of each body
    for (const Event& event : fly(flown, 15.0).events) {
      if (event.kind < EventKind::valid || event.kind > EventKind::grounded) continue;
      const EventKind before = last.contains(event.value) ? last[event.value] : EventKind::valid;
      EXPECT_NE(before, event.kind);
      EXPECT_NE(before, EventKind::grounded);
      EXPECT_EQ(before == EventKind::land, event.kind == EventKind::grounded);
      last[event.value] = event.kind;
    }
    EXPECT_FALSE(last.empty());
  }
}

// Every field of a message by every bad value, alone and in pairs, between good ones.
TEST_P(StaleData, NoMessageMakesACommandThatIsNotFiniteOrTooLarge) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> bad = {nan,  infinity, -infinity, 1e300, -1e300, 5e-324, -5e-324, 1e-310,
                                   -0.0, 1e160,    2.0,       -1.0,  1e-3,   99.9,   -101.0,  1e9};
  const Scenario flown = scenario(GetParam(), "");
  const Team& team = flown.team;
  const auto nx = static_cast<std::size_t>(team.nx()), nu = static_cast<std::size_t>(team.nu());
  const auto solver = make_solver(flown.solver, team, flown.horizon);
  Guard guard(team, *guard_options(flown));
  Plant plant(team, flown.x0);
  const std::vector<double> plan_ages(2, 0.0);
  std::vector<double> measured, u(nu), stamps(2);
  RandomStream chance(1, StreamId::fault, 0);
  const auto pick = [&](std::size_t n) {
    return std::min(n - 1, static_cast<std::size_t>(chance.uniform() * static_cast<double>(n)));
  };
  const int messages = whole_campaign() ? 1'000'000 : 60'000;
  double t = 0.0;
  for (int k = 0; k < messages; ++k, t += 0.01) {
    if (k % 500 == 0) {
      std::destroy_at(&guard);
      std::construct_at(&guard, team, *guard_options(flown));
      plant = Plant(team, flown.x0);
      t = 0.0;
    }
    measured.assign(plant.x().begin(), plant.x().end());
    stamps.assign(2, t);
    const auto field = static_cast<std::size_t>(k) % (nx + 2);
    const auto spoil = [&](std::size_t at, double value) {
      (at < nx ? measured[at] : stamps[at - nx]) = value;
    };
    if (k % 2 == 0) spoil(field, bad[(static_cast<std::size_t>(k) / (nx + 2)) % bad.size()]);
    if (k % 4 == 0) spoil(pick(nx + 2), bad[pick(bad.size())]);
    const ValidStates& estimated = guard.accept_measurement(t, measured, stamps);
    ASSERT_TRUE(all_finite(estimated));
    if (guard.knows_all()) {
      const auto plan = solver->solve(t, estimated).u;
      u.assign(plan.begin(), plan.end());
    }
    guard.fall_back(t, estimated, plan_ages, std::vector<double>(u.size()), u);
    guard.keep_distances(t, estimated, std::vector<double>(u.size()), u);
    guard.record(t, u);
    for (const double value : u) ASSERT_TRUE(std::abs(value) <= 1.0) << k;
    ASSERT_TRUE(plant.step(u, 0.01));
  }
}

}  // namespace
}  // namespace sightline
