#include "sightline/analysis/identification/identification_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/identified.hpp"

namespace sightline {
namespace {

using test::alone;
using test::identified;
using test::number;
using testing::HasSubstr;
using testing::Not;

/// A scenario of a robot like this template, without the key that nobody reads yet.
Scenario like(const std::string& text, int nx) {
  const std::string known = std::regex_replace(text, std::regex("command_delay[^\n]*\n"), "");
  return alone("inherits = \"uav\"", nx, "", known);
}

TEST(IdentificationText, TheTemplateIsTheRobotThatWasFound) {
  const Identification found = identified(test::vehicle("x500"));
  const std::string text = template_text(found, found.best, "uav");
  EXPECT_THAT(text, HasSubstr("\ncommand_delay = 0.0"));
  const Scenario lagging = like(text, 11);
  EXPECT_EQ(lagging.team.model(BodyId{0}).name(), "hover_multirotor");
  for (const ParameterText& p : lagging.team.model(BodyId{0}).parameters())
    EXPECT_NEAR(std::stod(p.value) / number(found.best, p.key), 1.0, 1e-3) << p.key;
  const std::string lumped = template_text(found, *found.lumped, "uav");
  EXPECT_THAT(lumped, HasSubstr("\ncommand_delay = 0.1"));
  EXPECT_THAT(lumped, Not(HasSubstr("tau")));
  EXPECT_EQ(like(lumped, 7).team.model(BodyId{0}).nx(), 7);
}

TEST(IdentificationText, OfEachKindOfRobotTheTemplateIsReadBack) {
  const std::string noise(test::usual_noise);
  const Identification paper = identified(alone("robot = \"multirotor\"", 7, noise));
  const std::string text = template_text(paper, paper.best, "uav");
  EXPECT_THAT(text, HasSubstr("robot = \"multirotor\"\n"));
  EXPECT_THAT(text, Not(HasSubstr("command_delay")));
  EXPECT_EQ(like(text, 7).team.model(BodyId{0}).name(), "multirotor");
  const Identification velocity =
      identified(alone("robot = \"velocity_multirotor\"", 9, noise, "[world]\nkind = \"rotors\"\n"));
  const std::string of_velocity = template_text(velocity, velocity.best, "uav");
  EXPECT_THAT(of_velocity, HasSubstr("v_max = 3.0, climb_max = 1.0, yaw_max = 0.78, frame = \"level\" }"));
  EXPECT_EQ(like(of_velocity, 9).team.model(BodyId{0}).name(), "velocity_multirotor");
  const Identification along = identified(alone("robot = \"velocity_multirotor\"", 9, noise));
  EXPECT_THAT(template_text(along, along.best, "uav"), HasSubstr("frame = \"heading\" }"));
}

TEST(IdentificationText, TableJsonAndPageSayTheSame) {
  const Scenario scenario = test::vehicle("crazyflie");
  const FlownMotion motion = fly_excitation(scenario, test::uav(scenario));
  const Identification found = identify(motion);
  const std::string table = to_string(found);
  EXPECT_THAT(table, HasSubstr("(24) + delay + Coriolis + lags"));
  EXPECT_THAT(table, HasSubstr("  chosen\n"));
  EXPECT_THAT(table, HasSubstr("delay of a model without lags"));
  EXPECT_THAT(table, HasSubstr("against the true motion: R^2 0.99"));
  const auto json = nlohmann::json::parse(to_json(found));
  EXPECT_EQ(json.at("robot"), "uav");
  EXPECT_EQ(json.at("candidates").size(), 8U);
  EXPECT_EQ(json.at("best").at("numbers").size(), 12U);
  EXPECT_NEAR(json.at("error").at("r2").get<double>(), found.error().r2, 1e-12);
  EXPECT_THAT(table, HasSubstr(json.at("template").get<std::string>()));
  const std::string page = identification_html(found, motion);
  EXPECT_THAT(page, HasSubstr("application/json"));
  EXPECT_THAT(page, HasSubstr("Identification of uav"));
}

}  // namespace
}  // namespace sightline
