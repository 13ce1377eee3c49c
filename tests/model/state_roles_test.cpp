#include "sightline/model/state_roles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <random>
#include <vector>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/robots.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// What the names of the library's robots say their states are.
StateRoles by_name(const Model& model) {
  StateRoles roles;
  const auto names = model.states();
  for (int k = 0; k < static_cast<int>(names.size()); ++k) {
    const std::string_view name = names[static_cast<std::size_t>(k)];
    if (name == "p_x") roles.position[0] = k;
    if (name == "p_y") roles.position[1] = k;
    if (name == "p_z") roles.position[2] = k;
    if (name == "d_x") roles.direction = {k, k + 1};
    if (name == "psi") roles.angle = k;
    if (name.starts_with("v_")) roles.velocities.push_back(k);
    if (name == "v_f") roles.velocity_V[0] = k;
    if (name == "v_s") roles.velocity_V[1] = k;
    if (name == "v_x") roles.velocity_G[0] = k;
    if (name == "v_y") roles.velocity_G[1] = k;
    if (name == "v_z") roles.velocity_G[2] = k;
    if (name == "r") roles.rate = k;
    if (name == "a_f") roles.tilt[0] = k;
    if (name == "a_s") roles.tilt[1] = k;
  }
  return roles;
}

std::vector<Model> all_robots() {
  return {Model(Multirotor{}),
          Model(AngleMultirotor{}),
          Model(OmniRover{}),
          Model(Unicycle{}),
          Model(PointMass{}),
          Model(VelocityMultirotor::px4()),
          Model(HoverMultirotor{}),
          Model(LaggingHoverMultirotor{}),
          Model(VelocityMultirotor::ar_drone())};
}

TEST(StateRoles, OfTheLibrarySRobotsAreWhatTheirNamesSay) {
  for (const Model& model : all_robots()) {
    const StateRoles found = roles_of(model), named = by_name(model);
    EXPECT_EQ(found.position, named.position) << model.name();
    EXPECT_EQ(found.direction, named.direction) << model.name();
    EXPECT_EQ(found.angle, named.angle) << model.name();
    EXPECT_EQ(found.velocities, named.velocities) << model.name();
    EXPECT_EQ(found.velocity_V, named.velocity_V) << model.name();
    EXPECT_EQ(found.velocity_G, named.velocity_G) << model.name();
    EXPECT_EQ(found.rate, named.rate) << model.name();
    EXPECT_EQ(found.tilt, named.tilt) << model.name();
    EXPECT_THAT(found.others, IsEmpty()) << model.name();
  }
}

TEST(StateRoles, OfARobotWithoutNamesAreThoseOfItsPoseAndVelocity) {
  const StateRoles unicycle = roles_of(Model(test::Unicycle{}));
  EXPECT_THAT(unicycle.position, ElementsAre(0, 1, -1));
  EXPECT_EQ(unicycle.angle, 2);
  EXPECT_THAT(unicycle.velocities, ElementsAre(3));
  const StateRoles quadrotor = roles_of(Model(test::Quadrotor{}));
  EXPECT_THAT(quadrotor.position, ElementsAre(0, 1, 2));
  EXPECT_THAT(quadrotor.velocities, ElementsAre(3, 4, 5));
  EXPECT_THAT(quadrotor.direction, ElementsAre(6, 7));
}

TEST(StateRoles, OfATextRobotDoNotDependOnWhatItsStatesAreCalled) {
  const TextRobot car = {.states = {"speed", "yaw", "up", "east", "north", "omega", "aside"},
                         .inputs = {"a", "w", "b"},
                         .f = {"a - 0.5 * speed", "omega", "0", "speed * cos(yaw) - aside * sin(yaw)",
                               "speed * sin(yaw) + aside * cos(yaw)", "w - omega", "b - aside"},
                         .position = {"east", "north", "up"},
                         .heading = {"yaw"}};
  const StateRoles roles = roles_of(car.model());
  EXPECT_THAT(roles.position, ElementsAre(3, 4, 2));
  EXPECT_EQ(roles.angle, 1);
  EXPECT_THAT(roles.velocities, ElementsAre(0, 6));
  EXPECT_THAT(roles.velocity_V, ElementsAre(0, 6));
  EXPECT_EQ(roles.rate, 5);
}

TEST(StateRoles, AStateIsNoVelocityForItsNameAlone) {
  const TextRobot boat = {.states = {"p_x", "p_y", "p_z", "v_battery", "speed"},
                          .inputs = {"a"},
                          .f = {"speed", "0", "0", "-a", "a"},
                          .position = {"p_x", "p_y", "p_z"}};
  EXPECT_THAT(roles_of(boat.model()).velocities, ElementsAre(4));
}

/// Its pose is that of a point ahead of the axle, and its states are polar.
struct Polar {
  static constexpr int nx = 2, nu = 2;
  static constexpr std::string_view name = "polar";
  template <class S>
  std::array<S, nx> f(const std::array<S, nx>&, const std::array<S, nu>& u) const {
    return {u[0], u[1]};
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0] * cos(x[1]), x[0] * sin(x[1]), S(0.0)}, {S(1.0), S(0.0)}};
  }
  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {std::hypot(pose.p.x, pose.p.y), std::atan2(pose.p.y, pose.p.x)};
  }
};

TEST(StateRoles, OfAPoseThatIsNoStateThereAreNone) {
  const StateRoles roles = roles_of(Model(Polar{}));
  EXPECT_FALSE(roles.has_position());
  EXPECT_FALSE(roles.has_heading());
  EXPECT_THAT(roles.velocities, IsEmpty());
}

/// A robot of the plane that also climbs by `climb`, with the rate of its heading `turn`.
TextRobot flyer(const std::string& climb, const std::string& turn) {
  return {.states = {"p_x", "p_y", "p_z", "psi", "v", "theta", "w"},
          .inputs = {"thrust", "turn", "pitch"},
          .f = {"v * cos(psi) * cos(theta)", "v * sin(psi) * cos(theta)", climb, turn, "2 * thrust - 0.5 * v",
                "pitch - theta", "turn - w"},
          .position = {"p_x", "p_y", "p_z"},
          .heading = {"psi"}};
}

TEST(InputRoles, OfTheLibrarySRobotsTheYawInputIsTheOneThatItsNameSays) {
  for (const Model& model : all_robots()) {
    const auto names = model.inputs();
    const auto named = std::find(names.begin(), names.end(), "u_psi");
    EXPECT_EQ(yaw_input(model), named == names.end() ? -1 : static_cast<int>(named - names.begin()))
        << model.name();
  }
}

TEST(InputRoles, OfTheLibrarySRobotsThoseThatRollHaveNoHeight) {
  for (const Model& model : all_robots()) EXPECT_EQ(has_height(model), !model.rolls()) << model.name();
}

TEST(InputRoles, AHeightThatTakesSpeedAndPitchIsOne) {
  EXPECT_TRUE(has_height(flyer("v * sin(theta)", "turn").model()));
  EXPECT_TRUE(has_height(flyer("v * theta * w * p_x", "turn").model()));
  EXPECT_TRUE(has_height(flyer("0.1", "turn").model())) << "it sinks or rises by itself";
}

TEST(InputRoles, AHeightThatNothingChangesIsNone) {
  for (const char* level : {"0", "0 * v", "v - v", "thrust * pitch - pitch * thrust"})
    EXPECT_FALSE(has_height(flyer(level, "turn").model())) << level;
}

TEST(InputRoles, TheYawInputIsFoundThroughStatesAndOnlyWhereItIsOne) {
  EXPECT_EQ(yaw_input(flyer("0", "turn").model()), 1);
  EXPECT_EQ(yaw_input(flyer("0", "9.81 * tan(pitch) / (12 + v)").model()), 2);
  EXPECT_EQ(yaw_input(flyer("0", "w").model()), 1) << "through a lag";
  EXPECT_EQ(yaw_input(flyer("0", "turn + thrust - thrust").model()), 1);
  EXPECT_EQ(yaw_input(flyer("0", "turn - thrust").model()), -1) << "two wheels";
  EXPECT_EQ(yaw_input(flyer("0", "0.2").model()), -1);
}

TEST(InputRoles, NamesAndOrdersOfATextRobotPlayNoPart) {
  std::mt19937 random(43);
  const TextRobot plain = flyer("v * sin(theta)", "w + 0.5 * turn");
  const Model known = plain.model();
  const StateRoles roles = roles_of(known);
  for (int n = 0; n < 50; ++n) {
    // Other names, which come from what robots of the library call something else.
    std::vector<std::string> names = {"v_x", "u_psi", "d_x", "p_n", "omega", "v_z", "psi_2", "a", "b", "c_1"};
    std::shuffle(names.begin(), names.end(), random);
    TextRobot renamed = plain;
    const auto rename = [&](const std::string& from) {
      const std::vector<std::string>& states = plain.states;
      const auto state = std::find(states.begin(), states.end(), from);
      if (state != states.end()) return names[static_cast<std::size_t>(state - states.begin())];
      const auto input = std::find(plain.inputs.begin(), plain.inputs.end(), from);
      return input == plain.inputs.end() ? from
                                         : names[7 + static_cast<std::size_t>(input - plain.inputs.begin())];
    };
    const auto rename_words = [&](const std::string& text) {
      std::string all, word;
      for (const char c : text + " ") {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
          word += c;
          continue;
        }
        all += rename(word) + c;
        word.clear();
      }
      return all;
    };
    for (std::string& one : renamed.states) one = rename(one);
    for (std::string& one : renamed.inputs) one = rename(one);
    for (std::string& one : renamed.position) one = rename(one);
    for (std::string& one : renamed.heading) one = rename(one);
    for (std::string& one : renamed.f) one = rename_words(one);
    const Model model = renamed.model();
    EXPECT_EQ(yaw_input(model), yaw_input(known));
    EXPECT_EQ(has_height(model), has_height(known));
    const StateRoles found = roles_of(model);
    EXPECT_EQ(found.position, roles.position);
    EXPECT_EQ(found.angle, roles.angle);
    EXPECT_EQ(found.velocities, roles.velocities);
    std::vector<double> x = {0.1, 0.2, 1.0, 0.4, 0.5, 0.2, -0.3}, y = x;
    const std::vector<double> u = {0.3, -0.7, 0.2};
    known.step(x.data(), u.data(), 0.02);
    model.step(y.data(), u.data(), 0.02);
    EXPECT_EQ(x, y);
  }
}

TEST(InputRoles, APushIsTakenByRobotsWithVelocitiesThatAirMoves) {
  EXPECT_TRUE(takes_push(Model(Multirotor{})));
  EXPECT_TRUE(takes_push(Model(PointMass{})));
  EXPECT_FALSE(takes_push(flyer("0", "turn").model()));
}

}  // namespace
}  // namespace sightline
