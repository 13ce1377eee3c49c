#include "sightline/scenario/templates.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "sightline/scenario.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

TomlDocument expanded(const std::string& text) {
  TomlDocument document = parse_toml(text, "team.toml");
  expand(document);
  return document;
}

std::vector<std::string> names(const TomlDocument& document, std::string_view section = "agent") {
  return TomlTable(document).table(section).keys();
}

std::string template_refusal(const std::string& text) {
  return refusal_of<ScenarioError>([&] { expanded(text); });
}

/// A robot's places, by its number.
std::vector<std::vector<double>> places(const std::string& p, int count) {
  const TomlDocument document =
      expanded(fmt::format("[agent.\"r{{0..{}}}\"]\nstart = {{ p = {} }}\n", count - 1, p));
  std::vector<std::vector<double>> found;
  for (const auto& [name, at] : TomlTable(document).named_tables("agent"))
    found.push_back(at.table("start").numbers("p", 3));
  return found;
}

TEST(Templates, ATableFillsWhatARobotDoesNotSay) {
  const TomlDocument document = expanded(R"(
[template.base]
R = [1.0, 1.0]
start = { heading = 0.5, p = [1.0, 1.0, 1.0] }
reference = { constant = { p = [0.0, 0.0, 1.0] } }
[template.fast]
inherits = "base"
u_max = [2.0, 2.0]
[agent]
a = { inherits = "fast", start = { p = [3.0, 0.0, 1.0] } }
b = { inherits = "base", R = [5.0, 5.0], reference = { circle = { radius = 1.0 } } }
)");
  const TomlTable agents = TomlTable(document).table("agent"), a = agents.table("a"), b = agents.table("b");
  EXPECT_FALSE(TomlTable(document).has("template"));
  EXPECT_THAT(a.numbers("R", 2), ElementsAre(1.0, 1.0));
  EXPECT_THAT(a.numbers("u_max", 2), ElementsAre(2.0, 2.0));
  EXPECT_THAT(a.table("start").numbers("p", 3), ElementsAre(3.0, 0.0, 1.0));
  EXPECT_EQ(a.table("start").number("heading"), 0.5) << "start is filled key by key";
  EXPECT_THAT(b.numbers("R", 2), ElementsAre(5.0, 5.0));
  EXPECT_FALSE(b.has("u_max"));
  EXPECT_THAT(b.table("reference").keys(), ElementsAre("circle"))
      << "what chooses one of several is taken whole";
  EXPECT_FALSE(a.has("inherits"));
}

TEST(Templates, ARangeStandsForNumberedRobotsInTheOrderOfTheFile) {
  const TomlDocument document = expanded(R"(
[agent.zeta]
[agent."uav{08..11}"]
[agent."n{2..3}x"]
[agent.alpha]
[target."t{0..0}"]
[[keep_apart]]
agents = ["zeta", "uav{08..10}", "alpha"]
[[shape]]
star = { centre = "t0", observers = ["n{2..3}x"] }
)");
  EXPECT_THAT(names(document),
              ElementsAre("zeta", "uav08", "uav09", "uav10", "uav11", "n2x", "n3x", "alpha"));
  EXPECT_THAT(names(document, "target"), ElementsAre("t0"));
  const TomlTable root(document);
  EXPECT_THAT(root.tables("keep_apart")[0].texts("agents", TomlTable::any_length, "names"),
              ElementsAre("zeta", "uav08", "uav09", "uav10", "alpha"));
  EXPECT_THAT(root.tables("shape")[0].table("star").texts("observers", TomlTable::any_length, "names"),
              ElementsAre("n2x", "n3x"));
}

TEST(Templates, PlacesAreOnALineACircleOrAGrid) {
  EXPECT_THAT(places("{ place = \"line\", from = [0.0, 0.0, 1.0], to = [3.0, 0.0, 2.5] }", 4),
              ElementsAre(ElementsAre(0, 0, 1), ElementsAre(1, 0, 1.5), ElementsAre(2, 0, 2),
                          ElementsAre(3, 0, 2.5)));
  EXPECT_THAT(places("{ place = \"line\", from = [2.0, 0.0, 1.0], to = [3.0, 0.0, 2.5] }", 1),
              ElementsAre(ElementsAre(2, 0, 1)));
  EXPECT_THAT(places("{ place = \"circle\", centre = [1.0, 0.0, 1.5], radius = 2.0 }", 4),
              ElementsAre(ElementsAre(3, 0, 1.5), ElementsAre(1, 2, 1.5), ElementsAre(-1, 0, 1.5),
                          ElementsAre(1, -2, 1.5)));
  EXPECT_THAT(places("{ place = \"circle\", centre = [0.0, 0.0, 1.0], radius = 8.0, from = 0.19634954 }", 1),
              ElementsAre(ElementsAre(7.846, 1.561, 1.0)))
      << "to the millimetre";
  EXPECT_THAT(
      places("{ place = \"grid\", corner = [0.0, 0.0, 1.0], step = [1.0, 2.0, 0.1], columns = 2 }", 5),
      ElementsAre(ElementsAre(0, 0, 1), ElementsAre(1, 0, 1.1), ElementsAre(0, 2, 1.2),
                  ElementsAre(1, 2, 1.3), ElementsAre(0, 4, 1.4)));
}

TEST(Templates, ARobotFacesAPointAndTakesItsOwnOfAList) {
  const TomlDocument document = expanded(R"(
[agent."r{0..1}"]
start = { p = { each = [[1.0, 0.0, 1.0], [0.0, 2.0, 1.0]] }, heading = { face = [0.0, 0.0] } }
R = { each = [[1.0], [2.0]] }
reference = { waypoints = { times = [0.0, 9.0], p = [[0.0, 0.0, 1.0], { place = "line", from = [5.0, 0.0, 1.0], to = [6.0, 0.0, 1.0] }] } }
)");
  const TomlTable agents = TomlTable(document).table("agent"), first = agents.table("r0"),
                  second = agents.table("r1");
  EXPECT_EQ(first.table("start").number("heading"), 3.141593);
  EXPECT_THAT(second.table("start").numbers("p", 3), ElementsAre(0.0, 2.0, 1.0));
  EXPECT_THAT(second.numbers("R", 1), ElementsAre(2.0));
  EXPECT_THAT(second.table("reference").table("waypoints").rows("p", 2, 3)[1], ElementsAre(6.0, 0.0, 1.0));
}

TEST(Templates, WhatIsWrongIsNamedAtItsLine) {
  EXPECT_EQ(template_refusal("[template.base]\nR = [1.0]\n[agent.a]\ninherits = \"bas\"\n"),
            "team.toml:4: agent.a.inherits = \"bas\", expected a template, the nearest is \"base\"");
  EXPECT_EQ(template_refusal("[agent.a]\ninherits = \"b\"\n"),
            "team.toml:2: agent.a.inherits = \"b\", expected a template, there is none");
  EXPECT_EQ(
      template_refusal(
          "[template.a]\ninherits = \"b\"\n[template.b]\ninherits = \"a\"\n[agent.r]\ninherits = \"a\"\n"),
      "team.toml:4: template.b.inherits = \"a\", expected a template that does not inherit itself, a "
      "inherits b does");
  EXPECT_EQ(
      template_refusal("[agent.r]\n[template.a]\nR = [1.0]\n"),
      "team.toml:2: template.a = {...}, expected a robot, target, obstacle or template that inherits it");
  EXPECT_EQ(
      template_refusal("[agent.\"r{3..1}\"]\n"),
      "team.toml:1: agent.\"r{3..1}\" = {}, expected a name, or a range of at most 1024 as in \"uav{0..7}\"");
  EXPECT_EQ(template_refusal("[agent.\"r{0..2}\"]\n[agent.r1]\n"),
            "team.toml:1: agent.\"r{0..2}\" = {}, expected names of their own, r1 is there already");
  EXPECT_EQ(template_refusal("[agent.\"r{0..2}\"]\nR = { each = [1.0, 2.0] }\n"),
            "team.toml:2: agent.r0.R.each = [1, 2], expected a list of 3, one for each robot");
  EXPECT_EQ(template_refusal("[agent.r]\nstart = { p = { place = \"cirle\" } }\n"),
            "team.toml:2: agent.r.start.p.place = \"cirle\", expected one of \"line\", \"circle\", \"grid\", "
            "the nearest is "
            "\"circle\"");
  EXPECT_EQ(template_refusal("[agent.r]\nstart = { heading = { face = [0.0, 0.0] } }\n"),
            "team.toml:2: agent.r.start.heading.face = [0, 0], expected a start.p of three numbers or a "
            "place, from which "
            "it is faced");
}

TEST(Templates, AWrongValueOfATemplateIsNamedAtTheLineOfTheTemplate) {
  const std::string text =
      "[template.t]\nrobot = \"multirotor\"\nR = [1.0]\n[agent.\"r{0..1}\"]\ninherits = \"t\"\n"
      "start = { p = { place = \"line\", from = [0.0, 0.0, 1.0], to = [3.0, 0.0, 1.0] } }\n";
  try {
    parse_scenario(text, "team.toml");
    FAIL();
  } catch (const ScenarioError& error) {
    EXPECT_STREQ(error.what(), "team.toml:3: agent.r0.R = [1], expected an array of 4 numbers");
  }
}

TEST(Templates, PrintedItReadsAsTheSameScenario) {
  int read = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    const Scenario scenario = read_scenario(entry.path());
    TomlDocument document = parse_toml(scenario.text, entry.path().native());
    expand(document);
    const std::string text = printed(document);
    EXPECT_EQ(text.find("template"), text.npos);
    const Scenario again = parse_scenario(text, entry.path());
    EXPECT_EQ(summary(again), summary(scenario)) << entry.path();
    EXPECT_EQ(again.x0, scenario.x0) << entry.path();
    TomlDocument twice = parse_toml(text, entry.path().native());
    expand(twice);
    EXPECT_EQ(printed(twice), text) << entry.path();
    ++read;
  }
  EXPECT_GE(read, 10);
}

}  // namespace
}  // namespace sightline
