#include "sightline/analysis/identification/motion_prediction.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

constexpr std::size_t periods = 300, late = 4;

/// A flight of that robot under random steps, each command `late` periods after it was given.
FlownMotion flight(const Model& model, double size) {
  Random random(3);
  FlownMotion motion;
  motion.commands = *commands_of(model);
  std::vector<double> x(static_cast<std::size_t>(model.nx()));
  model.at_rest({{0, 0, 2}, {0.6, 0.8}}, x.data());
  std::array<double, 4> u{};
  for (std::size_t k = 0; k < periods; ++k) {
    if (k % 37 == 0) u = uniform_array<4>(random, -size, size);
    motion.add(model, x.data(), 0.0, x.data(), u);
    const std::array<double, 4> in_force = k < late ? std::array<double, 4>{} : motion.u[k - late];
    for (int part = 0; part < 10; ++part) {
      model.step(x.data(), in_force.data(), 0.001);
      EXPECT_TRUE(model.normalise(x.data()));
    }
  }
  return motion;
}

void expect_prediction(const FlownMotion& motion, const ModelStructure& structure,
                       const ModelNumbers& numbers, double tolerance) {
  const MotionPrediction prediction(motion, structure, numbers);
  for (const std::size_t from : {std::size_t{0}, std::size_t{60}, std::size_t{171}}) {
    prediction.run(from, 100, motion.truth[from], [&](std::size_t j, const SeenMotion& m) {
      const SeenMotion& y = motion.truth[from + j];
      EXPECT_LE(norm(m.p - y.p), tolerance) << j;
      EXPECT_NEAR(m.psi, y.psi, tolerance) << j;
      EXPECT_NEAR(m.v_f, y.v_f, tolerance) << j;
      EXPECT_NEAR(m.v_s, y.v_s, tolerance) << j;
    });
  }
}

TEST(MotionPrediction, IsTheMotionOfTheRobotThatHasTheStructure) {
  const double delay = 0.01 * late;
  const auto numbers_of = [&](const auto& m) -> ModelNumbers {
    return {.b_z = m.b_z,
            .b_psi = m.b_psi,
            .a_f = m.a_f,
            .b_f = m.b_f,
            .a_s = m.a_s,
            .b_s = m.b_s,
            .delay = delay};
  };
  expect_prediction(flight(Multirotor{}, 1), {Commands::tilt, true, false, false}, numbers_of(Multirotor{}),
                    1e-4);
  expect_prediction(flight(HoverMultirotor{}, 1), {Commands::tilt, true, true, false},
                    numbers_of(HoverMultirotor{}), 1e-4);
  const LaggingHoverMultirotor lagging;
  ModelNumbers with_lags = numbers_of(lagging);
  with_lags.tau = lagging.tau, with_lags.tau_z = lagging.tau_z, with_lags.tau_psi = lagging.tau_psi;
  expect_prediction(flight(lagging, 1), {Commands::tilt, true, true, true}, with_lags, 1e-3);
  for (const VelocityFrame frame : {VelocityFrame::heading, VelocityFrame::level}) {
    const VelocityMultirotor v{.frame = frame};
    expect_prediction(
        flight(v, 0.7), {Commands::velocity, true, frame == VelocityFrame::level, true},
        {.tau_f = v.tau_f, .tau_s = v.tau_s, .delay = delay, .tau_z = v.tau_z, .tau_psi = v.tau_psi}, 1e-4);
  }
}

TEST(MotionPrediction, MovesSmoothlyWithTheDelay) {
  const FlownMotion motion = flight(HoverMultirotor{}, 1);
  const auto end = [&](double delay) {
    SeenMotion last;
    MotionPrediction(motion, {Commands::tilt, true, true, false}, {.delay = delay})
        .run(60, 100, motion.truth[60], [&](std::size_t, const SeenMotion& m) { last = m; });
    return last.p.x;
  };
  for (double delay = 0.02; delay < 0.2; delay += 0.0037) {
    const double slope = (end(delay + 1e-6) - end(delay)) / 1e-6,
                 wide = (end(delay + 1e-3) - end(delay)) / 1e-3;
    EXPECT_NEAR(slope, wide, 0.02) << delay;
  }
}

}  // namespace
}  // namespace sightline
