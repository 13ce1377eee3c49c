#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "sightline/events.hpp"
#include "sightline/potentials.hpp"
#include "sightline/scenario/read_event.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// The first `n` bodies of a team.
std::vector<BodyId> first(int n) {
  std::vector<BodyId> bodies;
  for (int i = 0; i < n; ++i) bodies.push_back(BodyId{i});
  return bodies;
}

/// The pairs as numbers, ordered and each once.
std::set<std::pair<int, int>> numbers(const std::vector<Between>& pairs) {
  std::set<std::pair<int, int>> set;
  for (const Between& pair : pairs) set.emplace(pair.first.index, pair.second.index);
  return set;
}

Team robots(int n) {
  Team team;
  for (int i = 0; i < n; ++i) team.add(Multirotor{});
  return team;
}

TEST(Shape, AChainOfNHasNMinus1PairsEachBodyObservesTheOneBefore) {
  for (int n = 1; n < 40; ++n) {
    const auto pairs = chain(first(n));
    ASSERT_EQ(static_cast<int>(pairs.size()), n - 1);
    for (int i = 1; i < n; ++i) {
      EXPECT_EQ(pairs[static_cast<std::size_t>(i) - 1].first, BodyId{i});
      EXPECT_EQ(pairs[static_cast<std::size_t>(i) - 1].second, BodyId{i - 1});
    }
  }
}

TEST(Shape, InARingEachBodyObservesOnceAndIsObservedOnce) {
  for (int n = 2; n < 40; ++n) {
    const auto pairs = ring(first(n));
    std::set<int> observers, targets;
    for (const Between& pair : pairs) {
      EXPECT_NE(pair.first, pair.second);
      observers.insert(pair.first.index);
      targets.insert(pair.second.index);
    }
    EXPECT_EQ(static_cast<int>(pairs.size()), n);
    EXPECT_EQ(static_cast<int>(observers.size()), n);
    EXPECT_EQ(static_cast<int>(targets.size()), n);
  }
  EXPECT_TRUE(ring(first(1)).empty());
}

TEST(Shape, InAStarAllObserveTheCentre) {
  for (int n = 1; n < 40; ++n) {
    const auto pairs = star(BodyId{n}, first(n));
    ASSERT_EQ(static_cast<int>(pairs.size()), n);
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(pairs[static_cast<std::size_t>(i)].first, BodyId{i});
      EXPECT_EQ(pairs[static_cast<std::size_t>(i)].second, BodyId{n});
    }
  }
}

TEST(Shape, AllPairsAreEveryTwoBodiesOnce) {
  for (int n = 1; n < 40; ++n) {
    const auto pairs = all_pairs(first(n));
    EXPECT_EQ(static_cast<int>(pairs.size()), n * (n - 1) / 2);
    EXPECT_EQ(numbers(pairs).size(), pairs.size());
    for (const Between& pair : pairs) EXPECT_LT(pair.first.index, pair.second.index);
  }
}

TEST(Shape, ABodyThatStandsTwiceIsRefused) {
  const std::vector<BodyId> twice = {BodyId{0}, BodyId{1}, BodyId{0}};
  EXPECT_EQ(refusal_of([&] { chain(twice); }), "body 0 stands twice in the chain, expected each body once");
  EXPECT_EQ(refusal_of([&] { ring(twice); }), "body 0 stands twice in the ring, expected each body once");
  EXPECT_EQ(refusal_of([&] { star(BodyId{1}, first(2)); }),
            "body 1 stands twice in the star, expected each body once");
  EXPECT_EQ(refusal_of([&] { all_pairs(twice); }),
            "body 0 stands twice in the pairs, expected each body once");
}

TEST(Shape, AnExpandedChainIsTheChainCoupledByHand) {
  for (const bool joint : {false, true}) {
    const Team by_hand = chain(6, joint ? paper::Variant::joint : paper::Variant::masked);
    Team team = robots(6);
    couple(team, {0.4 * SensorCone{}, 0.4 * KeepOut{}, 0.4 * Cohesion{}}, chain(first(6)),
           joint ? FeltBy::both : FeltBy::observer);
    ASSERT_EQ(team.couplings().size(), by_hand.couplings().size());
    for (std::size_t i = 0; i < team.couplings().size(); ++i) {
      const Coupling &a = team.couplings()[i], &b = by_hand.couplings()[i];
      EXPECT_EQ(a.term.weight, b.term.weight);
      EXPECT_EQ(a.term.potential.name(), b.term.potential.name());
      EXPECT_EQ(a.between.first, b.between.first);
      EXPECT_EQ(a.between.second, b.between.second);
      EXPECT_EQ(a.felt_by, b.felt_by);
    }
  }
}

TEST(Shape, ACouplingFeltByBothIsFeltByTheRobotsAlone) {
  Team team = robots(2);
  const BodyId rock = team.add(Obstacle{"rock"});
  couple(team, {1.0 * KeepOut{}}, all_pairs(first(3)), FeltBy::both);
  ASSERT_EQ(team.couplings().size(), 3U);
  for (const Coupling& coupling : team.couplings()) {
    EXPECT_EQ(coupling.felt_by.size(), coupling.between.second == rock ? 1U : 2U);
  }
}

TEST(Shape, EachPairHasTheTermsOfItsOwnObserver) {
  Team team = robots(5);
  const TermsOf terms_of = [](Between pair) {
    SensorCone cone;
    cone.mount.pitch = 0.1 * pair.first.index;
    return std::vector<Weighted>{1.0 * cone};
  };
  couple(team, terms_of, ring(first(5)), FeltBy::observer);
  for (const Coupling& coupling : team.couplings()) {
    EXPECT_EQ(coupling.term.potential.mount()->pitch, 0.1 * coupling.between.first.index);
  }
}

/// Two that may look, and one to be looked at.
struct Pursuit {
  Team team;
  Script script;
  AgentId a = team.add(Multirotor{}, {.name = "a"}), b = team.add(Multirotor{}, {.name = "b"});
  BodyId ball = team.add(Obstacle{"ball"});

  void pursue(const RelayOptions& options) {
    const TermsOf terms = [](Between) { return std::vector<Weighted>{0.4 * SensorCone{}, 0.4 * Cohesion{}}; };
    relay(team, script, terms, {a, b}, ball, options);
  }
};

TEST(Relay, OneObservesAtATimeAndEachMayTakeOverFromEach) {
  Pursuit p;
  p.pursue({.name = "on duty"});
  EXPECT_EQ(p.team.couplings().size(), 2U);
  for (const Coupling& c : p.team.couplings()) EXPECT_EQ(c.between.first, p.a);
  ASSERT_EQ(p.script.events.size(), 2U);
  EXPECT_TRUE(faults_of(p.script, ActiveTeam(p.team)).empty());
  ActiveTeam active_team(p.team);
  for (const std::size_t event : {0U, 1U, 0U, 1U, 0U}) {
    const TeamEvent& change = p.script.events[event];
    for (const Action& action : change.actions) ASSERT_EQ(active_team.apply(action, 1.0, 0.0), "");
    const Team team = active_team.team(1.0);
    EXPECT_EQ(team.couplings().size(), 2U);
    for (const Coupling& c : team.couplings()) EXPECT_EQ(team.name(c.between.first), event == 0 ? "b" : "a");
  }
}

TEST(Relay, IsRefusedWithoutANameOrWithARobotTwice) {
  Pursuit p;
  EXPECT_THAT(refusal_of([&] { p.pursue({}); }), testing::HasSubstr("no name"));
  EXPECT_THAT(refusal_of([&] {
                const TermsOf none = [](Between) { return std::vector<Weighted>{}; };
                relay(p.team, p.script, none, {p.a, p.a}, p.ball, {.name = "r"});
              }),
              testing::HasSubstr("stands twice in the relay"));
}

/// Robots a and b that look at the ball or at each other.
struct Choosing : Pursuit {
  ViewChoice choice{.name = "who",
                    .observers = {a, b},
                    .targets = {ball, a, b},
                    .variances = std::vector<ViewVariance>(6, {.step = 10.0, .values = {1e-4, 1e-2}}),
                    .first = {0, 1}};
  const TermsOf terms = [](Between) { return std::vector<Weighted>{0.4 * SensorCone{}, 0.4 * Cohesion{}}; };
};

TEST(Best, EachObserverHasTheTermsOfItsTargetAlone) {
  Choosing p;
  best(p.team, p.script, p.terms, p.choice, 1.0);
  ASSERT_EQ(p.team.couplings().size(), 4U);
  EXPECT_EQ(p.team.couplings()[0].between.second, p.ball);
  EXPECT_EQ(p.team.couplings()[2].between.second, p.a);
  // Of each observer: to two others and to nobody.
  ASSERT_EQ(p.script.events.size(), 6U);
  EXPECT_EQ(describe(p.script.events[0], p.team),
            "who: a turns to ball, when the choice for a falls on this, as often as that comes about: a "
            "observes ball, "
            "over 1 s");
  EXPECT_TRUE(faults_of(p.script, ActiveTeam(p.team)).empty());
  ActiveTeam active_team(p.team);
  for (const std::size_t event : {1U, 2U, 0U, 3U}) {
    for (const Action& action : p.script.events[event].actions)
      ASSERT_EQ(active_team.apply(action, 1.0, 0.0), "");
    const std::size_t of_a = event == 2 ? 0 : 2;
    const Team team = active_team.team(1.0);
    EXPECT_EQ(std::count_if(team.couplings().begin(), team.couplings().end(),
                            [&](const Coupling& c) { return team.name(c.between.first) == "a"; }),
              static_cast<std::ptrdiff_t>(of_a));
  }
}

TEST(Best, AnObserverOfTwoChoicesAndAnEventThatTurnsItAreRefused) {
  Choosing p;
  best(p.team, p.script, p.terms, p.choice, 1.0);
  ViewChoice other = p.choice;
  EXPECT_EQ(refusal_of([&] { best(p.team, p.script, p.terms, other, 1.0); }),
            "two choices of observers are called who, expected two names");
  other.name = "whom";
  EXPECT_EQ(refusal_of([&] { best(p.team, p.script, p.terms, other, 1.0); }),
            "\"a\" observes in who already, expected a robot that turns by one choice alone");
  other.name.clear();
  EXPECT_THAT(refusal_of([&] { best(p.team, p.script, p.terms, other, 1.0); }),
              testing::HasSubstr("no name"));
  p.script.events.push_back({.name = "turn", .trigger = AtTime{1.0}, .actions = {Observe{p.a, p.b}}});
  const auto faults = faults_of(p.script, ActiveTeam(p.team));
  ASSERT_FALSE(faults.empty());
  EXPECT_EQ(
      faults[0].sentence,
      "observe.observer = \"a\", which turns by the shape \"who\", expected a robot that no shape turns");
}

}  // namespace
}  // namespace sightline
