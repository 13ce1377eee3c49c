/// Teams that change in flight, under a supervisor and a barrier: who comes flies, who is held is
/// kept off, protection goes on. The summary says from when to when.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sightline/judge/event_description.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

/// A robot of the scenario that holds its place.
std::string robot(std::string_view name, std::string_view p, std::string_view more = {},
                  double heading = 0.0) {
  return fmt::format(
      "[agent.{}]\nrobot = \"multirotor\"\nstart = {{ p = {}, heading = {:.4f} }}\nQ = [1.5, 1.5, 1.6, 1.0, "
      "1.0, 0.0, 0.0]\n"
      "reference = {{ constant = {{ p = {}, heading = {:.4f} }} }}\n{}\n",
      name, p, heading, p, heading, more);
}
/// One that flies from one place to another.
std::string traveller(std::string_view name, std::string_view from, std::string_view to, double begin,
                      double end, double heading = 0.0) {
  return fmt::format(
      "[agent.{}]\nrobot = \"multirotor\"\nstart = {{ p = {}, heading = {:.4f} }}\nQ = [1.5, 1.5, 1.6, 1, 1, "
      "0, 0]\n"
      "reference = {{ waypoints = {{ times = [{:.1f}, {:.1f}], p = [{}, {}], heading = [{:.4f}, {:.4f}] }} "
      "}}\n",
      name, from, heading, begin, end, from, to, heading, heading);
}
std::string lasts(double seconds) { return fmt::format("[simulation]\nduration = {:.1f}\n", seconds); }

class ChangingFlight final : public Sink<Sample> {
 public:
  explicit ChangingFlight(const std::string& text)
      : scenario(parse_scenario(text, "changing.toml")),
        controls_(scenario),
        sample_(sized_sample(scenario.team, controls_.controllers(), controls_.team_switcher())),
        summary(scenario, 1) {
    SimulatedClock clock;
    const auto world = make_world(scenario);
    ClosedLoop loop(scenario, *world, controls_.controllers(), clock, *this, nullptr,
                    controls_.team_switcher());
    const LoopOutcome outcome = loop.fly();
    EXPECT_TRUE(outcome.finite);
    EXPECT_EQ(outcome.refused, 0);
  }
  Sample* claim() noexcept override { return &sample_; }
  void close() noexcept override {}
  void publish() noexcept override {
    summary.add(sample_);
    samples.push_back(sample_);
  }

  Vec3<double> place(const Sample& sample, std::string_view body) const {
    const double* const x =
        &sample.x[static_cast<std::size_t>(scenario.team.state_offset(scenario.team.find(body)))];
    return {x[0], x[1], x[2]};
  }
  double nearest(std::string_view a, std::string_view b, double from = 0.0) const {
    double least = 1e9;
    for (const Sample& s : samples) {
      if (s.time >= from) least = std::min(least, norm(place(s, a) - place(s, b)));
    }
    return least;
  }
  double lowest(std::string_view a) const {
    double z = 1e9;
    for (const Sample& s : samples) z = std::min(z, place(s, a).z);
    return z;
  }
  /// "2.01 uav1: hold", but for what the script does.
  std::vector<std::string> reported() const {
    std::vector<std::string> words;
    for (const auto& event : summary.values().events) {
      if (!event.name.starts_with("event \"")) words.push_back(event.name);
    }
    return words;
  }
  std::string line(std::string_view what) const {
    for (const SummaryLine& line : summary_lines(summary.json())) {
      if (line.what.starts_with(what)) return line.value;
    }
    return "no such line";
  }

  Scenario scenario;

 private:
  Controls controls_;
  Sample sample_;

 public:
  Summary summary;
  std::vector<Sample> samples;
};

const std::string supervised = "[safety]\nfloor = 0.3\n[safety.supervisor]\n";
const std::string guarded = "[safety]\nd_hard = 0.6\nfloor = 0.3\nbarrier = \"on\"\n[safety.supervisor]\n";

TEST(ChangingTeams, WhoJoinsOrReturnsUnderASupervisorFlies) {
  const std::string team = lasts(6.0) + supervised + robot("a", "[0.0, 0.0, 1.0]");
  const std::string lost = "[[simulation.fault]]\nkind = \"dropout\"\nbody = \"b\"\nuntil = 3.4\n";  // silent
  for (const std::string& fault : {std::string(), lost}) {
    const ChangingFlight joins(team + robot("b", "[2.0, 0.0, 1.0]", "present = false") + fault +
                               "[[event]]\nat = 3.5\nadd = \"b\"\n");
    EXPECT_THAT(joins.reported(), testing::IsEmpty());
    EXPECT_GT(joins.lowest("b"), 0.95);
  }
  const ChangingFlight returns(
      team + robot("b", "[2.0, 0.0, 1.0]") + traveller("c", "[4, 0, 1]", "[4, 2, 1]", 0.0, 2.0) +
      "[[event]]\nat = 1.5\nremove = [\"b\", \"c\"]\n[[event]]\nat = 4.0\nadd = [\"b\", \"c\"]\n");
  EXPECT_THAT(returns.reported(), testing::IsEmpty());
  EXPECT_GT(returns.lowest("b"), 0.95);
  for (const Sample& s : returns.samples) {
    if (std::abs(s.time - 4.01) < 1e-6) {
      EXPECT_EQ(returns.place(s, "c").y, 0.0) << "where its start says";
    }
  }
}

TEST(ChangingTeams, AnObstacleThatComesWithoutBeingSeenMakesPartnersHoldAndNobodyLand) {
  const ChangingFlight flight(
      lasts(6.0) + supervised + robot("a", "[0.0, 0.0, 1.0]") + robot("b", "[0.0, 3.0, 1.0]") +
      "[obstacle.box]\np = [1.5, 0.0, 1.0]\npresent = false\n[[couple]]\npotential = { too_near = {} }\n"
      "between = [\"a\", \"box\"]\n[[simulation.fault]]\nkind = \"dropout\"\nbody = \"box\"\n"
      "[[event]]\nat = 2.0\nadd = \"box\"\n");
  EXPECT_THAT(flight.reported(), testing::ElementsAre("a: predicted", "a: slowed", "a: hold"));
  EXPECT_GT(flight.lowest("a"), 0.9);
}

TEST(ChangingTeams, WhoIsHeldOrLandsIsKeptOffByAllThatKeepApart) {
  for (const char* then : {"hold", "land"}) {
    for (const char* potential : {"too_near = { d_min = 1.0 }", "pass_right = { d_min = 1.0 }"}) {
      const ChangingFlight flight(
          lasts(7.0) + robot("a", "[0.0, 0.05, 1.0]") +
          traveller("b", "[-2.5, 0.0, 1.0]", "[2.5, 0.0, 1.0]", 0.5, 5.5) +
          fmt::format("[[keep_apart]]\nagents = \"all\"\nweight = 8.0\npotential = {{ {} }}\n"
                      "[[event]]\nat = 0.3\nremove = {{ agent = \"a\", then = \"{}\" }}\n",
                      potential, then));
      EXPECT_GT(flight.nearest("a", "b"), 0.6) << then << " " << potential;
    }
  }
}

TEST(ChangingTeams, TheMateOfAnObserverThatIsHeldStaysInItsView) {
  // The target alone feels the view, which looks along y.
  const ChangingFlight flight(
      lasts(6.0) + "settle = 0.0\n" +
      robot("eye", "[0.0, 0.0, 1.0]", "sensor = { pitch = 0.0, offset = 0.17 }", 1.5708) +
      "[agent.mate]\nrobot = \"multirotor\"\nstart = { p = [0.0, 1.5, 1.0] }\n"
      "[[couple]]\npotential = { bearing = { alpha = 0.4 } }\nweight = 4.0\nbetween = [\"eye\", "
      "\"mate\"]\nfelt_by = "
      "[\"mate\"]\n[[couple]]\npotential = { too_near = { d_min = 1.2 } }\nweight = 4.0\nbetween = [\"eye\", "
      "\"mate\"]\n"
      "felt_by = [\"mate\"]\n[[event]]\nat = 0.5\nremove = { agent = \"eye\", then = \"hold\" }\n");
  EXPECT_EQ(flight.summary.values().pairs.at(0).in_view_fraction, 1.0);
  EXPECT_LT(norm(flight.place(flight.samples.back(), "mate") - Vec3<double>{0.0, 1.5, 1.0}), 0.5);
}

TEST(ChangingTeams, WhoIsToldToLandReachesTheGroundUnderABarrierWithAFloor) {
  const ChangingFlight flight(lasts(7.0) + guarded + robot("a", "[0.0, 0.0, 1.0]") +
                              robot("b", "[2.0, 0.0, 1.0]") +
                              "[[event]]\nat = 0.5\nremove = { agent = \"b\", then = \"land\" }\n");
  EXPECT_LT(flight.place(flight.samples.back(), "b").z, 0.05);
  EXPECT_GT(flight.lowest("a"), 0.9);
}

TEST(ChangingTeams, WhoIsAddedOnTopOfAnotherIsTold) {
  const std::string team = lasts(1.0) + robot("a", "[0.0, 0.0, 1.0]");
  const std::string add = "[[event]]\nat = 0.5\nadd = \"b\"\n",
                    reported = "b: added nearer to another body than it may be";
  EXPECT_THAT(
      ChangingFlight(team + supervised + robot("b", "[0.3, 0.0, 1.0]", "present = false") + add).reported(),
      testing::Contains(reported));
  EXPECT_THAT(ChangingFlight(team + robot("b", "[0.0, 0.0, 1.0]", "present = false") + add).reported(),
              testing::Contains(reported));
  EXPECT_THAT(ChangingFlight(team + robot("b", "[0.3, 0.0, 1.0]", "present = false") + add).reported(),
              testing::IsEmpty())
      << "nobody asks for a distance";
  EXPECT_THAT(ChangingFlight(team + guarded + "[obstacle.b]\np = [0.4, 0.0, 1.0]\npresent = false\n" + add)
                  .reported(),
              testing::Contains(reported));
}

TEST(ChangingTeams, ViewsAndDistancesAreJudgedWhileTheyAreInForceAndAnIdleObserverIsTold) {
  const std::string team = lasts(4.0) + "settle = 0.0\n" + supervised + robot("seen", "[0.0, 0.0, 1.0]") +
                           robot("eye", "[-1.6, 0.0, 1.0]", "sensor = { pitch = 0.0, offset = 0.17 }") +
                           "[[couple]]\npotential = { bearing = { alpha = 0.5 } }\nbetween = [\"eye\", "
                           "\"seen\"]\nfelt_by = [\"eye\"]\n";
  const ChangingFlight whole(team);
  EXPECT_THAT(whole.line("eye sees seen"), HasSubstr("100.0 % of the time; in view for good from 0.000 s"));
  EXPECT_EQ(Json::parse(whole.summary.json()).contains("idle_observers"), false);

  const ChangingFlight leaves(team + "[[event]]\nat = 1.0\nremove = \"seen\"\n");
  EXPECT_THAT(leaves.line("eye sees seen"),
              HasSubstr("100.0 % of 1.0 s, 0.0 to 1.0 s; in view to its end from 0.000 s"));
  EXPECT_THAT(leaves.line("eye observes no body"), HasSubstr("3.0 s, 1.0 to 4.0 s"));
  EXPECT_THAT(leaves.line("hard distance"), HasSubstr("in 1.0 s, 0.0 to 1.0 s"));
  EXPECT_THAT(leaves.line("limit bearing"), HasSubstr("kept for 1.0 s, 0.0 to 1.0 s"));
  EXPECT_FALSE(leaves.summary.target_lost_at_end());
  const Json judged = Json::parse(leaves.summary.json());
  EXPECT_NEAR(judged.at("pairs").at(0).at("in_force").at("to").get<double>(), 1.01, 1e-9);
  EXPECT_EQ(judged.at("idle_observers").at(0).at("observer"), "eye");

  // Who is asked to observe what comes later is idle until then.
  const ChangingFlight comes(
      lasts(2.0) + robot("eye", "[-1.6, 0.0, 1.0]", "sensor = { pitch = 0.0, offset = 0.17 }") +
      robot("seen", "[0.0, 0.0, 1.0]", "present = false") +
      "[[couple]]\npotential = { bearing = { alpha = 0.5 } }\nbetween = [\"eye\", \"seen\"]\nfelt_by = "
      "[\"eye\"]\n[[event]]\nat = 0.5\nadd = \"seen\"\n");
  EXPECT_THAT(comes.line("eye observes no body"), HasSubstr("0.5 s, 0.0 to 0.5 s"));
}

TEST(ChangingTeams, AKeepOutWhoseCouplingEndsIsJudgedToTheEndOfTheContact) {
  const ChangingFlight flight(
      lasts(3.0) + robot("a", "[0.0, 0.0, 1.0]") +
      traveller("b", "[0.8, 0.0, 1.0]", "[3.0, 0.0, 1.0]", 1.0, 2.0) +
      "[[couple]]\nname = \"off\"\npotential = { too_near = { d_min = 1.0 } }\nweight = 0.001\n"
      "between = [\"a\", \"b\"]\n[[event]]\nat = 0.3\nremove = { couple = \"off\" }\n");
  const SummaryValues v = flight.summary.values();
  ASSERT_EQ(v.limits.size(), 1U);
  EXPECT_GT(v.limits[0].longest, 0.9) << "the contact ended after 1 s";
  EXPECT_LT(v.limits[0].longest, 2.5);
  EXPECT_EQ(v.limits[0].fraction, 1.0);
}

}  // namespace
}  // namespace sightline
