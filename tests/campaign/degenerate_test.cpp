// Starts from which a controller may well not find its way: each ends as it should.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/judge/run_evaluator.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using std::numbers::pi;
constexpr double far_flight = 45.0;  // towards a target out of reach, in the 25 s of a run [m]

/// What must come of a start.
enum class End {
  recovered,   ///< in view within 20 s and at the end
  separated,   ///< and further than 0.5 m apart within 5 s
  approached,  ///< nearer at the end by as much as it flies at its cruising speed
  held,        ///< out of the world: its measurements are refused, it holds, and both are told
};

struct Start {
  std::string name;
  Vec3<double> p;  ///< of the observer, seen from the target, [m]
  double heading = 0.0;
  double v_f = 0.0, v_s = 0.0;
  double target_heading = 0.0;
  End end = End::recovered;
};

std::vector<Start> starts() {
  std::vector<Start> list;
  const auto add = [&](Start start) { list.push_back(std::move(start)); };
  // Target exactly behind, near and far, from above and below, flying towards it, away and past it.
  for (const double range : {0.6, 1.0, 1.7, 3.0, 6.0}) {
    for (const double height : {-1.0, 0.0, 0.755, 2.0}) {
      for (const double v : {-1.0, 0.0, 1.0}) {
        if (range < 1.5 && v < 0) continue;
        add({.name = fmt::format("behind {} m, {} m above, {} m/s", range, height, v),
             .p = {range, 0.0, height},
             .v_f = v});
      }
    }
  }
  // A hair beside straight behind, to both sides.
  for (const double off :
       {1e-16, 1e-12, 1e-8, 1e-4, 1e-2, 0.05, 0.17, -1e-16, -1e-12, -1e-8, -1e-4, -1e-2, -0.05, -0.17})
    add({.name = fmt::format("behind but for {} rad", off), .p = {2.0, 0.0, 0.5}, .heading = off});
  // Headings that are opposed, equal and across, whichever the target has.
  for (const double heading : {0.0, pi / 2, pi, -pi / 2}) {
    for (const double target_heading : {0.0, pi / 2, pi, -pi / 2}) {
      for (const double x : {-1.7, 3.0}) {
        add({.name = fmt::format("at {} m, headings {:.2f} and {:.2f}", x, heading, target_heading),
             .p = {x, 0.0, 0.0},
             .heading = heading,
             .target_heading = target_heading});
      }
    }
  }
  // In one place, or as good as that: the first thing is to part.
  for (const double heading : {0.0, 1.0, pi, -2.0}) {
    for (const double off : {0.0, 1e-300, 1e-12, 1e-6, 1e-2}) {
      add({.name = fmt::format("coincident but for {} m, heading {}", off, heading),
           .p = {off, 0.0, 0.0},
           .heading = heading,
           .end = End::separated});
    }
  }
  // On one line with the vertical: straight above and below.
  for (const double height : {-2.0, -1.0, -0.3, 0.3, 1.0, 2.0, 3.0, 4.0}) {
    for (const double heading : {0.0, pi / 3, pi}) {
      add({.name = fmt::format("{} m above, heading {:.2f}", height, heading),
           .p = {0.0, 0.0, height},
           .heading = heading});
    }
  }
  // On the optical axis, which is pitched down by 0.5 rad, and on its extension behind.
  for (const double range : {0.5, 1.0, 1.7, 2.5, 4.0}) {
    for (const double turn : {0.0, pi}) {
      add({.name = fmt::format("on the axis at {} m, turned by {:.2f}", range, turn),
           .p = {-range * std::cos(0.5) - 0.17, 0.0, range * std::sin(0.5)},
           .heading = turn});
    }
  }
  // Where sigmoids of squares overflow, and far beyond: 15.4, 40 and 355 m and what a robot never
  // reaches.
  for (const double range : {15.4, 20.0, 30.0, 40.0}) {
    for (const double bearing : {0.0, pi / 2, pi, -pi / 2})
      add({.name = fmt::format("{} m at {:.2f}", range, bearing),
           .p = {-range, 0.0, 0.0},
           .heading = -bearing});
  }
  for (const double range : {100.0, 355.0, 1e3, 1e4, 1e6}) {
    for (const double bearing : {0.0, pi / 2, pi, -pi / 2}) {
      add({.name = fmt::format("{} m at {:.2f}", range, bearing),
           .p = {-range, 0.0, 0.0},
           .heading = -bearing,
           .end = range > 100.0 ? End::held : End::approached});
    }
  }
  for (const double range : {1e9, 1e12, 1e50, 1e100, 1e160, 1e300}) {
    for (const double bearing : {0.0, pi})
      add({.name = fmt::format("{} m at {:.2f}", range, bearing),
           .p = {-range, 0, 0},
           .heading = bearing,
           .end = End::held});
  }
  return list;
}

/// Judges, and remembers how far the two are apart and what was told of the observer.
class Watch final : public Sink<Sample> {
 public:
  Watch(const Scenario& scenario, const CampaignPlan& plan, const Sample& sample)
      : judge_(scenario, plan, sample), period_(scenario.horizon.dt) {}
  Sample* claim() noexcept override { return sample_ = judge_.claim(); }
  void publish() noexcept override {
    const auto& x = sample_->x;
    distances.push_back(std::hypot(x[0] - x[7], x[1] - x[8], x[2] - x[9]));
    for (int i = 0; i < sample_->event_count; ++i) {
      const Event& event = sample_->events[static_cast<std::size_t>(i)];
      refused = refused || (event.kind == EventKind::measurement_world && event.value == 0.0);
      holds = holds || (event.kind == EventKind::hold && event.value == 0.0);
    }
    judge_.publish();
  }
  void close() noexcept override {}

  double after(double seconds) const {
    return distances[static_cast<std::size_t>(std::lround(seconds / period_))];
  }
  RunResult result(const LoopOutcome& outcome) const { return judge_.result(outcome); }

  std::vector<double> distances;
  bool refused = false, holds = false;

 private:
  RunEvaluator judge_;
  Sample* sample_ = nullptr;
  double period_;
};

TEST(Degenerate, EachStartEndsAsItShould) {
  Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml");
  CampaignPlan plan = *scenario.campaign;
  plan.d_hard = 0.0;
  scenario.simulation.duration = plan.duration;
  scenario.log.prediction_period = 0;
  const auto solver = make_solver(scenario.solver, scenario.team, scenario.horizon);
  const Controllers controllers = {*solver};
  for (const Start& start : starts()) {
    const Vec3<double> target = {0.5, 0.0, 1.0};
    scenario.x0 = {target.x + start.p.x,
                   target.y + start.p.y,
                   target.z + start.p.z,
                   std::cos(start.heading),
                   std::sin(start.heading),
                   start.v_f,
                   start.v_s,
                   target.x,
                   target.y,
                   target.z,
                   std::cos(start.target_heading),
                   std::sin(start.target_heading),
                   0.0,
                   0.0};
    solver->restart();
    SimulatedClock clock;
    Watch watch(scenario, plan, sized_sample(scenario.team, controllers));
    const RunResult result =
        watch.result(ClosedLoop(scenario, *make_world(scenario), controllers, clock, watch).fly());
    // Whoever holds beyond the bounds of the world never comes within.
    EXPECT_EQ(result.outcome == Outcome::failed, start.end == End::held) << start.name;
    EXPECT_EQ(result.violations, 0) << start.name;
    const bool finds = start.end == End::recovered || start.end == End::separated;
    const double flown = watch.distances.front() - watch.distances.back();
    EXPECT_TRUE(!finds || result.outcome == Outcome::recovered)
        << start.name << ": first view " << result.time_to_first_view << " s";
    EXPECT_TRUE(start.end != End::separated || watch.after(5.0) > 0.5)
        << start.name << ": " << watch.after(5.0) << " m";
    EXPECT_TRUE(start.end != End::approached || flown > far_flight) << start.name << ": " << flown << " m";
    const bool reported = watch.refused && watch.holds;
    EXPECT_EQ(reported, start.end == End::held) << start.name;
    EXPECT_TRUE(start.end != End::held || !(std::abs(flown) > 0.5)) << start.name << ": " << flown << " m";
  }
}

}  // namespace
}  // namespace sightline
