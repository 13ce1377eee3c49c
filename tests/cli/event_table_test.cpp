/// Every kind of event beside every feature of a flight: a row for each action, trigger and
/// measure, a column for each feature. A kind without a row does not compile.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <type_traits>

#include "cli/allocations.hpp"
#include "cli/partition.hpp"
#include "sightline/judge/event_description.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_event.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline {
namespace {

/// uav1 observes uav0, uav2 and uav3 stand by themselves; uav4, the drone and the box may come
/// later.
constexpr std::string_view team_text = R"(
[horizon]
duration = 0.5
stages = 10
period = 0.02
[simulation]
duration = 1.4
signal = [ { at = 0.3, name = "go" } ]
[agent.uav0]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }
Q = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]
reference = { circle = { centre = [0.0, 0.0, 1.0], radius = 0.1, rate = 0.3 } }
[agent.uav1]
robot = "multirotor"
start = { p = [-1.5, 0.0, 1.4], heading = 0.0 }
sensor = { pitch = 0.3, offset = 0.17 }
[agent.uav2]
robot = "multirotor"
start = { p = [0.0, 1.5, 1.0], heading = 1.57 }
sensor = { pitch = 0.0, offset = 0.17 }
[agent.uav3]
robot = "multirotor"
start = { p = [0.0, -1.6, 1.0], heading = 1.0 }
[agent.uav4]
robot = "multirotor"
start = { p = [2.0, 0.0, 1.2], heading = 3.0 }
present = false
[target.lamp]
p = [1.0, 3.0, 1.0]
[target.drone]
p = [-1.0, 4.0, 1.0]
present = false
[obstacle.box]
p = [3.0, 3.0, 1.0]
[[couple]]
name = "sees"
potential = { bearing = { alpha = 0.6, width = 0.1, tilt = 0.2 } }
between = ["uav1", "uav0"]
felt_by = ["uav1"]
[[couple]]
name = "far"
potential = { too_far = { d_max = 2.0 } }
between = ["uav1", "uav0"]
felt_by = ["uav1"]
[[constrain]]
name = "band"
potential = { altitude_band = { z_min = 0.6, z_max = 2.0 } }
agent = "uav2"
)";

constexpr std::string_view keep_out = R"(
[[couple]]
name = "off"
potential = { too_near = { d_min = 1.0 } }
between = ["uav1", "uav0"]
felt_by = ["uav1"]
)";

struct Column {
  std::string name, text;
};
std::vector<Column> columns() {
  const std::string off(keep_out);
  const std::string supervisor = "[safety.supervisor]\n", safety = "[safety]\nd_hard = 0.6\nfloor = 0.3\n";
  return {
      {"alone", off},
      {"supervisor", off + safety + supervisor},
      {"barrier", off + safety + "barrier = \"on\"\n"},
      {"both", off + safety + "barrier = \"on\"\n" + supervisor},
      {"keep_apart", off + "[[keep_apart]]\nagents = \"all\"\npotential = { too_near = { d_min = 0.9 } }\n"},
      {"shape",
       off + "[[shape]]\nchain = [\"uav0\", \"uav3\"]\npotential = { too_far = { d_max = 2.5 } }\n"
             "[[shape]]\nname = \"lamp\"\nnearest = { target = \"lamp\", observers = [\"uav2\", \"uav3\"], "
             "margin = 0.3, dwell = 0.1, ramp = 0.2 }\npotential = { too_far = { d_max = 4.0 } }\n"},
      {"text",
       "[[couple]]\nname = \"off\"\npotential = { region = { inside = \"range > 1 m\", slope = { softplus = "
       "{} }, "
       "kappa_A = 10.0 } }\n"
       "between = [\"uav1\", \"uav0\"]\nfelt_by = [\"uav1\"]\n" +
           safety + "barrier = \"on\"\n" + supervisor},
  };
}

struct Row {
  std::string name, trigger, action;
  std::vector<std::string> lands{};  ///< told to
};

std::string couple(const std::string& name) {
  return fmt::format(
      "{{ couple = {{ name = \"{}\", potential = {{ too_near = {{ d_min = 0.8 }} }}, between = [\"uav2\", "
      "\"uav0\"] }} }}",
      name);
}

/// What is done, at a time.
struct Actions {
  const std::string at = "at = 0.3";

  std::vector<Row> operator()(std::type_identity<RemoveBody>) const {
    return {{"vanish", at, "remove = \"uav0\""},
            {"vanish_slowly", at + "\nramp = 0.4", "remove = \"uav0\""},
            {"hold", at, "remove = { agent = \"uav0\", then = \"hold\" }"},
            {"hold_observer", at, "remove = { agent = \"uav1\", then = \"hold\" }"},
            {"land", at, "remove = { agent = \"uav3\", then = \"land\" }", {"uav3"}},
            {"remove_target", at, "remove = { target = \"lamp\" }"},
            {"remove_obstacle", at, "remove = { obstacle = \"box\" }"}};
  }
  std::vector<Row> operator()(std::type_identity<AddBody>) const {
    return {{"add", at, "add = \"uav4\""},
            {"add_target", at, "add = { target = \"drone\" }"},
            {"return", at, "remove = \"uav3\"\n[[event]]\nat = 0.6\nadd = \"uav3\""},
            {"return_from_hold", at,
             "remove = { agent = \"uav3\", then = \"hold\" }\n[[event]]\nat = 0.6\nadd = \"uav3\""}};
  }
  std::vector<Row> operator()(std::type_identity<AddCoupling>) const {
    return {{"add_couple", at, "add = " + couple("more")}};
  }
  std::vector<Row> operator()(std::type_identity<AddConstraint>) const {
    return {{"add_constrain", at,
             "add = { constrain = { agent = \"uav0\", potential = { altitude_band = { z_min = 0.5, z_max = "
             "2.0 } } } }"}};
  }
  std::vector<Row> operator()(std::type_identity<RemoveTerm>) const {
    return {{"remove_couple", at, "remove = { couple = \"far\" }"},
            {"remove_constrain", at, "remove = { constrain = \"band\" }"}};
  }
  std::vector<Row> operator()(std::type_identity<RetuneTerm>) const {
    return {
        {"retune_couple", at, "retune = { couple = \"sees\", weight = 0.5 }"},
        {"retune_potential", at, "retune = { couple = \"far\", potential = { too_far = { d_max = 3.0 } } }"},
        {"retune_constrain", at, "retune = { constrain = \"band\", weight = 2.0 }"}};
  }
  std::vector<Row> operator()(std::type_identity<RetuneAgent>) const {
    return {
        {"retune_agent", at, "retune = { agent = \"uav0\", R = [2.0, 2.0, 2.0, 2.0] }"},
        {"retune_limits", at,
         "retune = { agent = \"uav1\", u_min = [-0.2, -0.2, -0.2, -0.2], u_max = [0.2, 0.2, 0.2, 0.2] }"},
        {"retune_limits_and_hold", at,
         "retune = { agent = \"uav0\", u_min = [-0.05, -0.1, -0.1, -0.1], u_max = [0.05, 0.1, 0.1, 0.1] }\n"
         "[[event]]\nat = 0.5\nremove = { agent = \"uav0\", then = \"hold\" }"}};
  }
  std::vector<Row> operator()(std::type_identity<SetReference>) const {
    return {{"reference", at + "\nramp = 0.5",
             "reference = { agent = \"uav0\", reference = { circle = { centre = [0.1, 0.0, 1.1], radius = "
             "0.1, rate = 0.2 } } }"}};
  }
  std::vector<Row> operator()(std::type_identity<HandOver>) const { return {}; }  // shape `best`
  std::vector<Row> operator()(std::type_identity<Observe>) const {
    return {{"observe", at, "observe = { observer = \"uav1\", target = \"uav2\" }"},
            {"observe_target", at, "observe = { observer = \"uav1\", target = \"lamp\" }"},
            {"observe_nobody", at,
             "observe = { observer = \"uav1\", target = \"lamp\" }\n[[event]]\nat = 0.6\nremove = \"lamp\""}};
  }
  std::vector<Row> operator()(std::type_identity<MoveBody>) const {
    return {{"move_obstacle", at, "move = { obstacle = \"box\", p = [2.5, 3.0, 1.0] }"},
            {"move_target", at + "\nramp = 0.4", "move = { target = \"lamp\", p = [1.2, 3.2, 1.2] }"},
            {"move_and_return", at,
             "move = { obstacle = \"box\", p = [2.5, 3.0, 1.0] }\n[[event]]\nat = 0.5\nremove = \"box\"\n"
             "[[event]]\nat = 0.7\nadd = \"box\""}};
  }
  std::vector<Row> operator()(std::type_identity<SetWind>) const {
    return {{"wind", at, "wind = { acceleration = [0.1, 0.0, 0.0] }"}};
  }
  std::vector<Row> operator()(std::type_identity<InjectFault>) const {
    return {
        {"dropout", at, "fault = { kind = \"dropout\", body = \"uav0\", for = 0.06 }"},
        {"freeze", at, "fault = { kind = \"freeze\", body = \"uav1\", for = 0.06 }"},
        {"jump", at, "fault = { kind = \"jump\", body = \"lamp\", for = 0.06, offset = [0.02, 0.0, 0.0] }"}};
  }
};

/// When it is done: a trigger that comes about within the flight.
struct Triggers {
  const std::string change = "observe = { observer = \"uav1\", target = \"uav2\" }";

  std::vector<Row> operator()(std::type_identity<AtTime>) const { return {{"at", "at = 0.2", change}}; }
  std::vector<Row> operator()(std::type_identity<AfterTime>) const {
    return {
        {"after", "after = 0.2", change},
        {"after_stage", "at = 0.2", "enter = \"next\"\n[[event]]\nstage = \"next\"\nafter = 0.2\n" + change}};
  }
  std::vector<Row> operator()(std::type_identity<Signal>) const {
    return {{"signal", "signal = \"go\"", change}};
  }
  std::vector<Row> operator()(std::type_identity<Condition>) const { return {}; }  // by measure

  std::vector<Row> operator()(std::type_identity<DistanceOf>) const {
    return {{"distance", "when = { distance = [\"uav0\", \"uav1\"], below = 5.0 }", change}};
  }
  std::vector<Row> operator()(std::type_identity<ViewAngleOf>) const {
    return {{"angle", "when = { angle = [\"uav1\", \"uav0\"], below = 3.0 }", change}};
  }
  std::vector<Row> operator()(std::type_identity<ExcessOf>) const {
    return {{"seen", "seen = { observer = \"uav1\", target = \"uav0\", dwell = 0.1 }", change},
            {"lost", "lost = { observer = \"uav1\", target = \"uav0\", alpha = 0.001 }", change},
            {"region",
             "when = { region = { all_of = [\"range < 6 m\", \"bearing < 2\"] }, between = [\"uav1\", "
             "\"uav0\"] }",
             change},
            {"formula", "when = { formula = \"target.p_z\", between = [\"uav1\", \"uav0\"], above = 0.2 }",
             change}};
  }
  std::vector<Row> operator()(std::type_identity<AgeOf>) const {
    return {{"age", "when = { age = \"lamp\", above = 0.1 }",
             change + "\n[[simulation.fault]]\nkind = \"dropout\"\nbody = \"lamp\"\nfrom = 0.2"}};
  }
  std::vector<Row> operator()(std::type_identity<NearerThan>) const { return {}; }  // `nearest`
  std::vector<Row> operator()(std::type_identity<TurnedTo>) const { return {}; }    // shape `best`
};

template <class Kinds, class... Alternative>
void append(std::vector<Row>& rows, const Kinds& kinds, std::type_identity<std::variant<Alternative...>>) {
  const auto add = [&](std::vector<Row> more) { rows.insert(rows.end(), more.begin(), more.end()); };
  (add(kinds(std::type_identity<Alternative>())), ...);
}

std::vector<Row> all_rows() {
  std::vector<Row> rows;
  append(rows, Actions{}, std::type_identity<Action>());
  append(rows, Triggers{}, std::type_identity<Trigger>());
  append(rows, Triggers{}, std::type_identity<Measure>());
  rows.push_back({"stage", "at = 0.3", "enter = \"watch\""});
  return rows;
}

Scenario cell(const Row& row, const Column& column) {
  const std::string text =
      fmt::format("{}{}\n[[event]]\n{}\n{}\n", team_text, column.text, row.trigger, row.action);
  return parse_scenario(text, fmt::format("{}_{}.toml", row.name, column.name));
}

/// Judges each sample as it comes, from what the samples say alone and beside what the loop knows.
class RunEvaluator final : public test::SampleSink {
 public:
  RunEvaluator(const Scenario& scenario, const Controllers& controllers, const Row& row,
               TeamSwitcher* team_switcher)
      : SampleSink(sized_sample(scenario.team, controllers, team_switcher)),
        scenario_(scenario),
        row_(row),
        team_switcher_(team_switcher),
        log_team_(scenario),
        summary_(scenario, controllers.size()) {}

  void publish() noexcept override {
    summary_.add(sample_);
    (void)log_team_.follow(sample_);
    tell_events();
    compare_teams();
    judge_inputs();
    judge_places();
  }

  const Summary& summary() const { return summary_; }
  std::vector<std::size_t> in_force;

 private:
  static std::size_t at(BodyId body) { return static_cast<std::size_t>(body.index); }
  bool is_there(BodyId body) const { return sample_.presence[at(body)] != Presence::absent; }
  bool is_told_to_land(BodyId body) const {
    return std::count(row_.lands.begin(), row_.lands.end(), scenario_.team.name(body)) > 0;
  }

  void tell_events() {
    for (int i = 0; i < sample_.event_count; ++i) {
      const Event& event = sample_.events[static_cast<std::size_t>(i)];
      if (event.kind == EventKind::event_in_force) in_force.push_back(static_cast<std::size_t>(event.value));
      const bool bad = event.kind == EventKind::event_ignored || event.kind == EventKind::land ||
                       event.kind == EventKind::hold || event.kind == EventKind::barrier_conflict ||
                       event.kind == EventKind::input_refused || event.kind == EventKind::added_too_near;
      EXPECT_FALSE(bad) << sample_.time << " " << to_string(event.kind) << " " << event.value;
    }
  }
  void compare_teams() {
    const Phase& phase = team_switcher_->present();
    const Team &loop = phase.solver->ocp().team(), &log = log_team_.team();
    ASSERT_EQ(phase.membership.presence, sample_.presence) << sample_.time;
    ASSERT_EQ(loop.bodies(), log.bodies()) << sample_.time;
    for (int i = 0; i < loop.bodies(); ++i) ASSERT_EQ(loop.name(BodyId{i}), log.name(BodyId{i}));
    for (std::size_t i = 0; i < loop.agents().size(); ++i) {
      ASSERT_EQ(loop.agents()[i].limits.u_max(), log.agents()[i].limits.u_max());
      ASSERT_EQ(loop.agents()[i].R, log.agents()[i].R);
    }
    // The loop leaves out what has faded away once it settles; what lasts is the same.
    const auto lasting = [](const Team& team) {
      std::vector<std::string> names;
      for (const Coupling& c : team.couplings()) {
        if (c.ramp.to > 0)
          names.push_back(fmt::format("{} {} {} {}", c.term.potential.name(), c.between.first.index,
                                      c.between.second.index, c.term.weight));
      }
      return names;
    };
    ASSERT_EQ(lasting(loop), lasting(log)) << sample_.time;
  }
  void judge_inputs() {
    const Team& team = scenario_.team;
    for (std::size_t r = 0; r < team.agents().size(); ++r) {
      const BodyId robot = team.find(team.agents()[r].name);
      std::vector<double> low(4), high(4);
      team_switcher_->present().membership.limits[r].at(sample_.time, low, high);
      for (std::size_t i = 0; i < 4; ++i) {
        const double u = sample_.u[static_cast<std::size_t>(team.input_offset(robot)) + i];
        ASSERT_TRUE(u >= low[i] && u <= high[i]) << team.name(robot) << " " << sample_.time << " " << u;
      }
    }
  }
  void judge_places() {
    const Team& team = scenario_.team;
    const auto place = [&](BodyId body) {
      const double* const x = &sample_.x[static_cast<std::size_t>(team.state_offset(body))];
      return Vec3<double>{x[0], x[1], x[2]};
    };
    for (int i = 0; i < static_cast<int>(team.agents().size()); ++i) {
      if (!is_there(BodyId{i})) continue;
      if (!is_told_to_land(BodyId{i})) {
        ASSERT_GE(place(BodyId{i}).z, 0.3) << team.name(BodyId{i});
      }
      for (int j = i + 1; j < team.bodies(); ++j) {
        if (!is_there(BodyId{j})) continue;
        ASSERT_GE(norm(place(BodyId{i}) - place(BodyId{j})), 0.6)
            << team.name(BodyId{i}) << " " << team.name(BodyId{j}) << " " << sample_.time;
      }
    }
  }

  const Scenario& scenario_;
  const Row& row_;
  TeamSwitcher* team_switcher_;
  PresentTeam log_team_;
  Summary summary_;
};

void PrintTo(const Column& column, std::ostream* to) { *to << column.name; }

class EventTable : public testing::TestWithParam<Column> {};

TEST_P(EventTable, EveryKindOfEventKeepsEveryLaw) {
  std::set<std::string> said;
  for (const Row& row : all_rows()) {
    SCOPED_TRACE(row.name);
    const Scenario scenario = cell(row, GetParam());
    std::string words;
    for (const TeamEvent& event : scenario.script.events) words += describe(event, scenario.team);
    EXPECT_TRUE(said.insert(words).second) << "no two events have one description: " << words;
    const Controls controls(scenario);
    SimulatedClock clock;
    const Controllers controllers = controls.controllers();
    RunEvaluator judge(scenario, controllers, row, controls.team_switcher());
    const auto world = make_world(scenario);
    ClosedLoop loop(scenario, *world, controllers, clock, judge, cli::allocations, controls.team_switcher());
    const LoopOutcome outcome = loop.fly();
    EXPECT_TRUE(outcome.finite);
    EXPECT_EQ(outcome.refused, 0);
    EXPECT_EQ(outcome.max_allocations, 0);
    const std::size_t of_shapes =
        cell({"", "at = 1.0", "enter = \"x\""}, GetParam()).script.events.size() - 1;
    EXPECT_EQ(judge.in_force.size(), scenario.script.events.size() - of_shapes);
    EXPECT_EQ(judge.summary().applied_violations(), 0);
    EXPECT_TRUE(judge.summary().finite());
    EXPECT_TRUE(judge.summary().safety().broken().empty());
    EXPECT_FALSE(summary_lines(judge.summary().json()).empty());
    EXPECT_EQ(judge.summary().values().idle_observers.size(),
              row.name == "observe_nobody" || row.name == "vanish" || row.name == "vanish_slowly" ? 1U : 0U);
  }
}

TEST_P(EventTable, InPartsATeamThatChangesIsRefused) {
  const Scenario scenario = cell(all_rows().front(), GetParam());
  EXPECT_THROW((void)cli::read_partition(scenario, "uav0,uav1,uav2 | uav3,uav4", "jacobi", 1),
               std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Columns, EventTable, testing::ValuesIn(columns()));

}  // namespace
}  // namespace sightline
