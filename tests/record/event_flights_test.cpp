/// The shipped scenarios whose teams change, event by event: who is near notices gently, who is far
/// does not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <queue>

#include "sightline/judge/present_team.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/scenario_flight.hpp"

namespace sightline {
namespace {

Scenario shipped(const std::string& name) {
  return read_scenario(std::string(SIGHTLINE_SOURCE_DIR "/scenarios/") + name + ".toml");
}

struct InForce {
  std::size_t event, period;
};
std::vector<InForce> in_force(const TeamFlight& flight) {
  std::vector<InForce> list;
  for (std::size_t k = 0; k < flight.flown.size(); ++k) {
    for (const Event& event : flight.flown[k].events) {
      EXPECT_NE(event.kind, EventKind::event_ignored);
      EXPECT_NE(event.kind, EventKind::team_late);
      if (event.kind == EventKind::event_in_force) list.push_back({static_cast<std::size_t>(event.value), k});
    }
  }
  return list;
}

/// Bodies that an event is about.
struct About {
  std::vector<BodyId> operator()(const RemoveBody& a) const { return {a.body}; }
  std::vector<BodyId> operator()(const AddBody& a) const { return {a.body}; }
  std::vector<BodyId> operator()(const Observe& a) const { return {a.observer, a.target}; }
  std::vector<BodyId> operator()(const RetuneTerm& a) const {
    for (const Coupling& c : couplings) {
      if (c.name == a.name) return {c.between.first, c.between.second};
    }
    return {};
  }
  template <class Other>
  std::vector<BodyId> operator()(const Other&) const {
    return {};
  }
  const std::vector<Coupling>& couplings;
};

/// Couplings between each body and the nearest that the event is about.
std::vector<int> couplings_away(const Scenario& scenario, std::size_t event) {
  const std::vector<Coupling> couplings = all_couplings(scenario);
  std::vector<int> away(static_cast<std::size_t>(scenario.team.bodies()), 1000);
  std::queue<BodyId> next;
  for (const Action& action : scenario.script.events[event].actions) {
    for (const BodyId body : std::visit(About{couplings}, action)) {
      away[static_cast<std::size_t>(body.index)] = 0;
      next.push(body);
    }
  }
  for (; !next.empty(); next.pop()) {
    const int reached = away[static_cast<std::size_t>(next.front().index)] + 1;
    for (const Coupling& c : couplings) {
      for (const auto& [here, there] :
           {std::pair{c.between.first, c.between.second}, {c.between.second, c.between.first}}) {
        int& other = away[static_cast<std::size_t>(there.index)];
        if (here != next.front() || other <= reached) continue;
        other = reached;
        next.push(there);
      }
    }
  }
  return away;
}

class EventFlights : public testing::TestWithParam<const char*> {};

TEST_P(EventFlights, CommandsDoNotJumpAndThoseFarAwayDoNotNotice) {
  constexpr double most_jump = 0.3, most_far = 0.02;
  const Scenario scenario = shipped(GetParam());
  const TeamFlight flight = fly_scenario(scenario, true);
  EXPECT_TRUE(flight.outcome.finite);
  EXPECT_EQ(flight.outcome.refused, 0);
  const std::vector<InForce> events = in_force(flight);
  ASSERT_EQ(events.size(), scenario.script.events.size());
  double jump = 0.0, far = 0.0, kkt = 0.0;
  for (std::size_t e = 0; e < events.size(); ++e) {
    const std::size_t from = events[e].period,
                      to = e + 1 < events.size() ? events[e + 1].period : flight.flown.size();
    for (std::size_t k = from; k < std::min(to, from + 200); ++k) {
      for (std::size_t i = 0; i < flight.flown[k].u.size(); ++i) {
        jump = std::max(jump, std::abs(flight.flown[k].u[i] - flight.flown[k - 1].u[i]));
      }
    }
    const FlownPeriod& third = flight.flown[from + 3];
    kkt = std::max(kkt, third.kkt);

    Scenario without = scenario;
    without.script.events.resize(events[e].event);
    without.simulation.duration = flight.flown[to - 1].time + scenario.horizon.dt;
    const TeamFlight quiet = fly_scenario(without);
    const std::vector<int> away = couplings_away(scenario, events[e].event);
    for (std::size_t k = from; k < to; ++k) {
      for (int b = 0; b < scenario.team.bodies(); ++b) {
        if (away[static_cast<std::size_t>(b)] < 2 || !scenario.team.is_agent(BodyId{b})) continue;
        const auto u = static_cast<std::size_t>(scenario.team.input_offset(BodyId{b}));
        for (std::size_t i = u; i < u + 4; ++i) {
          far = std::max(far, std::abs(flight.flown[k].u[i] - quiet.flown[k].u[i]));
        }
      }
    }
  }
  EXPECT_LE(jump, most_jump);
  EXPECT_LT(far, most_far);
  EXPECT_LE(kkt, 1e-4);
  RecordProperty("jump", fmt::format("{}", jump));
  RecordProperty("far", fmt::format("{}", far));
  RecordProperty("kkt", fmt::format("{}", kkt));
}

INSTANTIATE_TEST_SUITE_P(Shipped, EventFlights, testing::Values("handover", "join_and_leave"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace sightline
