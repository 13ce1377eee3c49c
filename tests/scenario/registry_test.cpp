#include "sightline/registry.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/model.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/potentials.hpp"
#include "sightline/scenario/read_part.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;

/// A potential somebody else wrote, with a sensor of the observer.
struct Gaze {
  double alpha = 0.4, kappa = 1.0;
  SensorMount mount{};

  static constexpr std::string_view name = "gaze", limit_unit = "rad";
  static constexpr auto parameters() {
    return std::tuple{parameter("alpha", &Gaze::alpha, "rad", acute_angle, "angle of view"),
                      parameter("kappa", &Gaze::kappa, "", above_zero, "cost")};
  }
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return kappa * (1.0 - dot(mount(a, b.p), mount(a, b.p)));
  }
  double violation(const Sight<double>& a, const Sight<double>& b) const {
    return view_angle(mount, a, b.p) - alpha;
  }
};

struct Named1 : Gaze {
  static constexpr std::string_view name = "Gaze";
};
struct Spaced : Gaze {
  static constexpr std::string_view name = "my gaze";
};
struct Taken : Gaze {
  static constexpr std::string_view name = "too_near";
};
struct OfText : Gaze {
  static constexpr std::string_view name = "region";
};
struct BadDefault {
  double d = -1;
  static constexpr std::string_view name = "bad_default";
  static constexpr auto parameters() {
    return std::tuple{parameter("d", &BadDefault::d, "m", above_zero, "never so")};
  }
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return d * dot(a.p, b.p);
  }
};
/// A robot that describes nothing.
struct Bare : Multirotor {
  static constexpr std::string_view name = "bare";
  static constexpr auto parameters() { return std::tuple{}; }
};

constexpr std::string_view one_bare = R"([agent.a]
robot = "multirotor"
start = { p = [0, 0, 1], heading = 0.0 }
sensor = { pitch = 0.3, offset = 0.2 }
[agent.b]
robot = "bare"
start = { p = [2, 0, 1], heading = 0.0 }
)";

Registry with_own() {
  Registry registry;
  registry.robots.add<Bare>();
  registry.potentials.add<Gaze>();
  return registry;
}

Scenario read(const std::string& more, const Registry& registry = with_own()) {
  return parse_scenario(std::string(one_bare) + more, "a", registry);
}

TEST(Parts, APartOfSomebodyElseIsAWordWhereverOursAre) {
  const Scenario scenario = read(R"([[couple]]
potential = { gaze = { alpha = 0.25 } }
between = ["a", "b"]
felt_by = ["a"]
[[shape]]
chain = ["b", "a"]
felt_by = "observer"
potentials = [{ gaze = { kappa = 2.0 }, weight = 0.5 }]
[[event]]
at = 1.0
add = { couple = { potential = { gaze = {} }, between = ["a", "b"], felt_by = ["a"], name = "later" } }
)");
  const auto& couplings = scenario.team.couplings();
  ASSERT_EQ(couplings.size(), 2U);
  const auto* gaze = couplings[0].term.potential.as<Gaze>();
  ASSERT_NE(gaze, nullptr);
  EXPECT_EQ(gaze->alpha, 0.25);
  EXPECT_EQ(gaze->mount.pitch, 0.3);  // of [agent.a.sensor]
  EXPECT_EQ(couplings[1].term.potential.as<Gaze>()->kappa, 2.0);
  EXPECT_EQ(scenario.team.agents()[1].model.name(), "bare");
}

TEST(Parts, WhatIsWrongWithItIsRefusedAsWithOurs) {
  const auto couple = [](const std::string& potential) {
    return refusal_of<std::exception>([&] {
      read("[[couple]]\npotential = " + potential + "\nbetween = [\"a\", \"b\"]\nfelt_by = [\"a\"]\n");
    });
  };
  EXPECT_EQ(couple("{ gaze = { alhpa = 0.3 } }"),
            "a:9: couple[0].potential.gaze.alhpa = 0.3, expected a known key, the nearest is \"alpha\"");
  EXPECT_EQ(couple("{ gaze = { alpha = 2.0 } }"),
            "a:9: couple[0].potential.gaze.alpha = 2, expected in (0, pi/2) rad");
  EXPECT_EQ(couple("{ gaze = { alpha = true } }"),
            "a:9: couple[0].potential.gaze.alpha = true, expected a number, in (0, pi/2) rad");
  EXPECT_EQ(couple("{ gaze = { kappa = 1e12 } }"),
            "a:9: couple[0].potential.gaze.kappa = 1000000000000, expected > 0, at most 1e9");
  EXPECT_EQ(couple("{ gazes = {} }"),
            "a:9: couple[0].potential.gazes = {}, expected a known key, the nearest is \"gaze\"");
  EXPECT_THAT(refusal_of<std::exception>([] { read("", Registry{}); }),
              testing::HasSubstr("a:6: agent.b.robot = \"bare\", expected one of \"multirotor\""));
}

TEST(Parts, OursKnowNothingOfWhatAnotherProgramAdds) {
  (void)with_own();
  EXPECT_EQ(Registry{}.potentials.find("gaze"), nullptr);
  EXPECT_EQ(built_in_registry().potentials.find("gaze"), nullptr);
  EXPECT_NE(with_own().potentials.find("gaze"), nullptr);
}

TEST(Parts, ANameIsAWordAndOfOnePartAlone) {
  Registry registry;
  registry.potentials.add<Gaze>();
  EXPECT_EQ(refusal_of<std::exception>([&] { registry.potentials.add<Gaze>(); }),
            "a potential is called \"gaze\", expected a name of its own, another has this one");
  EXPECT_EQ(refusal_of<std::exception>([&] { registry.potentials.add<Taken>(); }),
            "a potential is called \"too_near\", expected a name of its own, another has this one");
  EXPECT_EQ(refusal_of<std::exception>([&] { registry.potentials.add<OfText>(); }),
            "a potential is called \"region\", expected a name of its own, another has this one");
  constexpr std::string_view word = "expected a word: a lower-case letter, then these, digits and _";
  EXPECT_THAT(refusal_of<std::exception>([&] { registry.potentials.add<Spaced>(); }),
              testing::HasSubstr(word));
  EXPECT_THAT(refusal_of<std::exception>([&] { registry.potentials.add<Named1>(); }),
              testing::HasSubstr(word));
  EXPECT_EQ(refusal_of<std::exception>([&] { registry.potentials.add<BadDefault>(); }),
            "bad_default.d = -1, expected > 0 m");
}

/// Options of a solver of somebody else.
struct Patience {
  int steps = 3;
  static constexpr auto parameters() {
    return std::tuple{parameter("steps", &Patience::steps, "", {1, 9, "1 to 9"}, "of an update")};
  }
};

TEST(Parts, ASolverOfSomebodyElseIsMadeWithItsOptionsAndIsNoneOfOurs) {
  Registry registry = with_own();
  std::vector<int> steps;
  const auto make = [&](const Team& team, const Horizon& horizon, const Patience& options) {
    steps.push_back(options.steps);
    return std::make_unique<NewtonRiccati>(team, horizon);
  };
  registry.solvers.add<Patience>("patient", {.keep_apart = true}, make);
  const Scenario given = read("[solver]\nname = \"patient\"\nsteps = 7\n", registry);
  EXPECT_EQ(given.solver.name, "patient");
  EXPECT_EQ(make_solver(given.solver, given.team, given.horizon)->ocp().nx(), given.team.nx());
  const SolverChoice plain = solver_named("patient", registry);
  (void)make_solver(plain, given.team, given.horizon);
  EXPECT_EQ(steps, (std::vector{7, 3}));

  EXPECT_EQ(solver_names(registry).back(), "patient");
  EXPECT_EQ(solver_names().back(), "cgmres");
  EXPECT_EQ(registry.solvers.names_that(&SolverAbilities::keep_apart), "newton_riccati or patient");
  EXPECT_EQ(refusal_of<std::exception>([&] { read("[solver]\nname = \"patient\"\nsteps = 70\n", registry); }),
            "a:10: solver.steps = 70, expected an integer, 1 to 9");
  EXPECT_EQ(refusal_of<std::exception>([&] { registry.solvers.add<Patience>("cgmres", {}, make); }),
            "a solver is called \"cgmres\", expected a name of its own, another has this one");
  EXPECT_EQ(refusal_of<std::exception>([&] {
              registry.solvers.add({"empty", {}, {}});
            }),
            "the solver \"empty\" has no function, expected one that reads its options");
}

TEST(Parts, EveryOneOfOursDescribesItsParametersWithUnitRangeDefaultAndMeaning) {
  const Registry& registry = built_in_registry();
  const auto described = [](const auto& list) {
    for (const auto& part : list.all()) {
      EXPECT_FALSE(part->parameters.empty()) << part->name;
      for (const ParameterText& p : part->parameters) {
        EXPECT_FALSE(p.key.empty() || p.meaning.empty() || p.range.empty()) << part->name << '.' << p.key;
      }
    }
  };
  described(registry.robots), described(registry.potentials), described(registry.references),
      described(registry.limits);
  EXPECT_THAT(registry.robots.names(), ElementsAre("multirotor", "angle_multirotor", "omni_rover", "unicycle",
                                                   "point_mass", "velocity_multirotor", "hover_multirotor"));
  EXPECT_EQ(registry.potentials.names().size(), 10U);
}

/// The table of a part with its defaults, and with `bad` in place of the first number of `key`.
template <class Part>
std::string table_of(const Part& part, std::string_view key = "", std::string_view bad = "") {
  std::string text;
  for (const ParameterText& p : part.parameters) {
    std::string value = p.fallback;
    if (p.range.starts_with("one of")) value = fmt::format("\"{}\"", value);
    if (p.must_be_given) value = p.range == "finite" ? "[1, 2, 3]" : p.key == "p" ? "[[1, 2, 3]]" : "[1]";
    if (p.key == key) value = value.starts_with('[') ? fmt::format("[{}, 2, 3]", bad) : std::string(bad);
    if (!value.empty()) text += fmt::format("{} = {}\n", p.key, value);
  }
  return text + " ";
}

template <class Check>
void for_each_list(Check&& check) {
  const Registry& registry = built_in_registry();
  check(registry.robots), check(registry.potentials), check(registry.references), check(registry.limits);
}

TEST(Parts, EveryDefaultOfOursIsReadBackAsItIs) {
  for_each_list([](const auto& list) {
    for (const auto& part : list.all()) {
      const TomlDocument document = parse_toml(table_of(*part), "a");
      EXPECT_NO_THROW(read_named(list, part->name, TomlTable(document))) << part->name;
    }
  });
}

TEST(Parts, NoParameterOfOursTakesANumberOutOfItsRange) {
  int refused = 0;
  for_each_list([&](const auto& list) {
    for (const auto& part : list.all()) {
      for (const ParameterText& p : part->parameters) {
        if (p.range.starts_with("one of") || p.range.starts_with("a list")) continue;
        for (const std::string bad : {"nan", "inf", p.range.starts_with("> 0") ? "0.0" : "-2e9"}) {
          const TomlDocument document = parse_toml(table_of(*part, p.key, bad), "a");
          EXPECT_THAT(refusal_of<ScenarioError>([&] { read_named(list, part->name, TomlTable(document)); }),
                      testing::AllOf(testing::HasSubstr(p.key), testing::HasSubstr("expected")))
              << part->name << bad;
          ++refused;
        }
      }
    }
  });
  EXPECT_GT(refused, 150);
}

TEST(Parts, WhatAPotentialOfOursSaysOfKeepingApartIsWhatItsLimitDoes) {
  for (const auto& part : built_in_registry().potentials.all()) {
    const TomlDocument document = parse_toml(" \n", "a");
    const Potential potential = part->read(TableSource(TomlTable(document)), {});
    EXPECT_EQ(keeps_apart(potential), limits_distance_from_below(potential)) << part->name;
    EXPECT_EQ(observes(potential), potential.mount() != nullptr) << part->name;
    const bool limits = potential.violation({}, {}) != -std::numeric_limits<double>::infinity();
    EXPECT_EQ(potential.limit_unit() != "in its own unit", limits) << part->name;
  }
}

}  // namespace
}  // namespace sightline
