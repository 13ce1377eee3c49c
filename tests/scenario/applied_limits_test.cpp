// Whatever is measured and whatever plans, what is applied is finite and within the limits in
// force, limits before rates.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/scenario_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

constexpr double control_period = 0.01, rate_max = 0.5;

struct Way {
  std::string solver, barrier;
  bool supervised = false, compensated = false, faulty = false, scripted = false;
  double narrowed = 0.2;  // limits from 1.5 s on

  std::string text() const {
    std::string t = fmt::format("[solver]\nname = \"{}\"\n[simulation]\nduration = 2.5\n", solver);
    for (const bool first : {true, false}) {
      t += fmt::format(
          "[agent.{}]\nrobot = \"multirotor\"\nstart = {{ p = [0.0, {}, 1.0], heading = 0.0 }}\n"
          "Q = [4.0, 4.0, 4.0, 0.2, 0.2, 0.0, 0.0]\nR = [0.01, 0.01, 0.01, 0.01]\n"
          "reference = {{ constant = {{ p = [{}, {}, 8.0], heading = 2.0 }} }}\n"
          "rate_max = [{}, {}, {}, {}]\n",
          first ? "a" : "b", first ? 0.0 : 3.0, first ? 30.0 : -30.0, first ? 3.0 : 0.0, rate_max, rate_max,
          rate_max, rate_max);
      if (compensated) t += "disturbance_time = 0.5\ncommand_delay = 0.1\n";
      const std::string low = fmt::format("[-{0}, -{0}, -{0}, -{0}]", narrowed),
                        high = fmt::format("[{0}, {0}, {0}, {0}]", narrowed);
      if (!scripted)
        t += fmt::format(
            "limits = {{ times = [0.0, 1.5], u_min = [[-0.6, -0.6, -0.6, -0.6], {}], u_max = [[0.6, 0.6, "
            "0.6, 0.6], {}] }}\n",
            low, high);
      else
        t += fmt::format("[[event]]\nat = 1.5\nretune = {{ agent = \"{}\", u_min = {}, u_max = {} }}\n",
                         first ? "a" : "b", low, high);
    }
    t += fmt::format("[safety]\nd_hard = 0.6\nbarrier = \"{}\"\n", barrier);
    if (supervised) t += "[safety.supervisor]\n";
    if (faulty)
      t += "[[simulation.fault]]\nkind = \"nan\"\nfrom = 0.5\nuntil = 0.55\n"
           "[[simulation.fault]]\nkind = \"nan\"\nfrom = 1.48\nuntil = 1.56\n";
    return t;
  }
};

TEST(AppliedLimits, HoldInEachPeriodOnEveryPath) {
  std::vector<Way> ways;
  for (const std::string solver : {"newton_riccati", "cmscgmres", "cgmres"}) {
    for (const std::string barrier : {"off", "report", "on"}) {
      for (int mask = 0; mask < 16; ++mask) {
        const Way way{.solver = solver,
                      .barrier = barrier,
                      .supervised = (mask & 1) != 0,
                      .compensated = (mask & 2) != 0,
                      .faulty = (mask & 4) != 0,
                      .scripted = (mask & 8) != 0 && solver == "newton_riccati",
                      .narrowed = (mask & 1) != 0 ? 0.2 : 0.9};
        if ((mask & 8) == 0 || way.scripted) ways.push_back(way);
      }
    }
  }
  for (const Way& way : ways) {
    const std::string text = way.text();
    const TeamFlight flight = fly_scenario(test::scenario_of(text));
    ASSERT_EQ(flight.flown.size(), 250U) << text;
    ASSERT_EQ(flight.outcome.max_allocations, 0) << text;
    double most = way.scripted ? 1.0 : 0.6;
    std::vector<double> before(8, 0.0);
    for (const FlownPeriod& now : flight.flown) {
      const bool in_force =
          way.scripted ? std::any_of(now.events.begin(), now.events.end(),
                                     [](const Event& e) { return e.kind == EventKind::event_in_force; })
                       : now.time >= 1.5 - 1e-9;
      if (in_force) most = way.narrowed;
      for (std::size_t i = 0; i < now.u.size(); ++i) {
        ASSERT_LE(std::abs(now.u[i]), most) << now.time << " s, input " << i << "\n" << text;
        // Where an input may not move as little as its rate asks, it moves no further than the
        // limit. The barrier may jump.
        if (way.barrier == "on") continue;
        const double nearest = std::clamp(before[i], -most, most);
        ASSERT_LE(std::abs(now.u[i] - nearest), rate_max * control_period + 1e-9)
            << now.time << " s, input " << i << "\n"
            << text;
      }
      before = now.u;
    }
  }
}

}  // namespace
}  // namespace sightline
