#include <gtest/gtest.h>

#include <array>
#include <string>

#include "sightline/loop.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {
namespace {

TEST(Sample, KindsOfEventsFollowTheLevelsAndTheFaultsInTheirOrder) {
  for (int i = 0; i < fallback_level_count; ++i) {
    EXPECT_EQ(to_string(static_cast<EventKind>(static_cast<int>(EventKind::valid) + i)),
              to_string(static_cast<FallbackLevel>(i)));
  }
  for (int i = 1; i < measurement_fault_count; ++i) {
    EXPECT_EQ(to_string(static_cast<EventKind>(static_cast<int>(EventKind::measurement_not_finite) + i - 1)),
              "measurement_" + std::string(to_string(static_cast<MeasurementFault>(i))));
  }
}

TEST(Sample, ABodyShowsTheLeanOfItsTrueAttitudeElseThatOfItsModel) {
  Team team;
  team.add(Multirotor{}, {.name = "uav"});
  Sample sample;
  sample.x = {1, 2, 3, 0.6, 0.8, 0.1, 0.2};
  sample.u = {0.5, -0.25, 0, 0};
  const auto shown = [&] { return true_sight(team, BodyId{0}, sample); };
  const Vec2<double> of_model = Multirotor{}.lean(std::array<double, 7>{}, std::array{0.5, -0.25, 0.0, 0.0});
  EXPECT_EQ(shown().lean.x, of_model.x);
  sample.attitudes = {no_attitude};
  EXPECT_EQ(shown().lean.y, of_model.y);
  sample.attitudes = {leaning({0.6, 0.8}, {-0.3, 0.2})};
  EXPECT_NEAR(shown().lean.x, -0.3, 1e-15);
  EXPECT_NEAR(shown().lean.y, 0.2, 1e-15);
  EXPECT_EQ(shown().p.z, 3.0);
}

}  // namespace
}  // namespace sightline
