#include <gtest/gtest.h>

#include "sightline/kernels.hpp"
#include "sightline/model.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

template <int W>
void expect_lanes_are_points() {
  Random random(1);
  const StagePrograms programs = trace_stage(AngleMultirotor{}, 0.05, Seen::pose);
  InterpretedStage<W> stage(programs);
  const StageSizes n = stage.sizes();
  Rows x(1, n.nx * W), u(1, n.nu * W), F(1, n.nx * W), s(1, n.ns * W);
  for (double& v : x.all()) v = uniform(random, -1, 1);
  for (double& v : u.all()) v = uniform(random, -1, 1);
  stage.step(x[0], u[0], F[0], s[0]);
  for (int lane = 0; lane < W; ++lane) {
    std::vector<double> point;
    for (int i = 0; i < n.nx; ++i) point.push_back(x[0][i * W + lane]);
    for (int i = 0; i < n.nu; ++i) point.push_back(u[0][i * W + lane]);
    const std::vector<double> out = evaluate(programs.step.program, point);
    for (int i = 0; i < n.nx; ++i) EXPECT_EQ(F[0][i * W + lane], out[static_cast<std::size_t>(i)]);
    for (int i = 0; i < n.ns; ++i) EXPECT_EQ(s[0][i * W + lane], out[static_cast<std::size_t>(n.nx + i)]);
  }
}

TEST(Kernel, EachLaneIsAPointOfItsOwnAtEveryWidth) {
  expect_lanes_are_points<1>();
  expect_lanes_are_points<2>();
  expect_lanes_are_points<4>();
  expect_lanes_are_points<8>();
}

}  // namespace
}  // namespace sightline
