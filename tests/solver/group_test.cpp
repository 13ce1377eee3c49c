#include <gtest/gtest.h>

#include "sightline/kernels.hpp"
#include "sightline/model.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Group, EachLaneRollsOutItsOwnRobotByEuler) {
  constexpr int stages = 9;
  constexpr double h = 0.05;
  Random random(1);
  const auto programs =
      std::make_shared<const StagePrograms>(trace_stage(Multirotor{}, h, Seen::pose_and_motion));
  for (const int width : {2, narrow_width, native_width}) {
    const auto group = make_group(programs, stages, width, KernelChoice::compiled_if_there);
    Rows memory(1, static_cast<int>(group->room()));
    group->settle(memory[0]);
    Rows u(1, stages * 4 * width), s(1, stages * seen_size(Seen::pose_and_motion) * width);
    for (int i = 0; i < stages * 4 * width; ++i) u[0][i] = uniform(random, -1, 1);
    std::vector<std::array<double, 7>> x(static_cast<std::size_t>(width));
    for (int lane = 0; lane < width; ++lane) {
      auto& state = x[static_cast<std::size_t>(lane)];
      state = uniform_array<7>(random, -1, 1);
      for (int i = 0; i < 7; ++i) group->x(0, i, lane) = state[static_cast<std::size_t>(i)];
    }
    group->roll_out(u[0], s[0]);
    for (int lane = 0; lane < width; ++lane) {
      auto& state = x[static_cast<std::size_t>(lane)];
      for (int k = 0; k < stages; ++k) {
        std::array<double, 4> input{};
        for (int i = 0; i < 4; ++i) input[static_cast<std::size_t>(i)] = u[0][(k * 4 + i) * width + lane];
        const Sight<double> seen = sight(Multirotor{}, state, input);
        EXPECT_LE(relative_error(s[0][(k * seen_size(Seen::pose_and_motion) + 7) * width + lane], seen.v.z),
                  1e-14);
        EXPECT_LE(relative_error(s[0][(k * seen_size(Seen::pose_and_motion) + 5) * width + lane], seen.v.x),
                  1e-14);
        const auto rate = Multirotor{}.f(state, input);
        for (std::size_t i = 0; i < 7; ++i) {
          state[i] += h * rate[i];
          EXPECT_LE(relative_error(group->x(k + 1, static_cast<int>(i), lane), state[i]), 1e-13);
        }
      }
    }
  }
}

}  // namespace
}  // namespace sightline
