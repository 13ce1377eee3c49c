#include "sightline/model/state_roles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/model/ground_robots.hpp"
#include "sightline/model/hover_multirotor.hpp"
#include "sightline/model/model.hpp"
#include "sightline/model/point_mass.hpp"
#include "sightline/model/robots.hpp"
#include "sightline/model/text_robot.hpp"
#include "sightline/model/velocity_multirotor.hpp"
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
  }
  return roles;
}

TEST(StateRoles, OfTheLibrarySRobotsAreWhatTheirNamesSay) {
  for (const Model& model : {Model(Multirotor{}), Model(AngleMultirotor{}), Model(OmniRover{}),
                             Model(Unicycle{}), Model(PointMass{}), Model(VelocityMultirotor::px4()),
                             Model(HoverMultirotor{}), Model(LaggingHoverMultirotor{})}) {
    const StateRoles found = roles_of(model), named = by_name(model);
    EXPECT_EQ(found.position, named.position) << model.name();
    EXPECT_EQ(found.direction, named.direction) << model.name();
    EXPECT_EQ(found.angle, named.angle) << model.name();
    EXPECT_EQ(found.velocities, named.velocities) << model.name();
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
  const TextRobot car = {.states = {"speed", "yaw", "up", "east", "north"},
                         .inputs = {"a", "w"},
                         .f = {"a - 0.5 * speed", "w", "0", "speed * cos(yaw)", "speed * sin(yaw)"},
                         .position = {"east", "north", "up"},
                         .heading = {"yaw"}};
  const StateRoles roles = roles_of(car.model());
  EXPECT_THAT(roles.position, ElementsAre(3, 4, 2));
  EXPECT_EQ(roles.angle, 1);
  EXPECT_THAT(roles.velocities, ElementsAre(0));
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

}  // namespace
}  // namespace sightline
