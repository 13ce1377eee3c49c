#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "examples/own_potential.hpp"
#include "sightline/kernels.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

constexpr int stages = 12;

/// All that a group computes from random data, in one list.
std::vector<double> all_results(Group& group, int width, std::uint64_t seed) {
  Rows memory(1, static_cast<int>(group.room()));
  group.settle(memory[0]);
  Random random(seed);
  const StageSizes& n = group.sizes();
  Rows u(4, stages * n.nu * width), s(3, stages * n.ns * width), c(1, stages * n.coupling() * width);
  for (int lane = 0; lane < width; ++lane) {
    for (int i = 0; i < n.nx; ++i) group.x(0, i, lane) = uniform(random, -1, 1);
    for (int i = 0; i < n.weights() - 1; ++i) group.weight(i, lane) = uniform(random, 0.5, 2);
  }
  for (double& v : c.all()) v = uniform(random, -0.01, 0.01);
  for (int i = 0; i < stages * n.nu * width; ++i) {
    u[0][i] = uniform(random, -1, 1);
    u[1][i] = random() % 5 == 0 ? std::numeric_limits<double>::infinity() : 0.0;  // held, or free
  }
  std::vector<double> results;
  const auto keep = [&](const Rows& rows) {
    results.insert(results.end(), rows.all().begin(), rows.all().end());
  };
  group.roll_out(u[0], s[0]);
  group.backward(u[0], u[1], c[0], u[2], u[3]);
  group.forward(u[3], s[1]);
  keep(u);
  for (int i = 0; i < stages * n.ns * width; ++i) s[2][i] = 0.01 * s[1][i];
  group.precondition(s[2], u[3], s[1]);
  keep(u);
  keep(s);
  return results;
}

template <RobotModel M>
void expect_same_bits(const M& model, Seen seen, const std::vector<RelaxedBarrier>& barriers = {},
                      const RateCost& rates = {}) {
  const auto programs =
      std::make_shared<const StagePrograms>(trace_stage(model, 0.04, seen, barriers, {}, rates));
  for (const int width : {2, narrow_width, native_width}) {
    const auto compiled = make_group(programs, stages, width, KernelChoice::compiled_if_there);
    const auto interpreted = make_group(programs, stages, width, KernelChoice::interpreted);
    EXPECT_EQ(all_results(*compiled, width, 1), all_results(*interpreted, width, 1));
    EXPECT_NE(typeid(*compiled), typeid(*interpreted)) << model.name;
  }
}

TEST(KernelTable, CompiledAndInterpretedGroupsGiveTheSameBits) {
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion}) {
    expect_same_bits(Multirotor{}, seen);
    expect_same_bits(Multirotor{.b_z = 1.3, .b_psi = 1.21, .a_f = -0.3, .b_f = 1.1, .a_s = -0.35, .b_s = 1.2},
                     seen);
    expect_same_bits(AngleMultirotor{}, seen);
    expect_same_bits(OmniRover{}, seen);
    expect_same_bits(OmniRover{.b_psi = 1.21, .a_f = -2.0, .b_f = 1.3, .a_s = -2.0, .b_s = 1.4}, seen);
    expect_same_bits(Unicycle{}, seen);
    expect_same_bits(Unicycle{.b_psi = 1.21, .a_f = -0.3, .b_f = 1.1}, seen);
    expect_same_bits(PointMass{}, seen);
    expect_same_bits(PointMass{.drag = 0.7}, seen);
    expect_same_bits(VelocityMultirotor{}, seen);
    expect_same_bits(VelocityMultirotor{.frame = VelocityFrame::level}, seen);
    expect_same_bits(LaggedMultirotor<Lags::plane>{}, seen);
    expect_same_bits(HoverMultirotor{}, seen);
    expect_same_bits(LaggingHoverMultirotor{}, seen);
    expect_same_bits(LaggingHoverMultirotor::crazyflie(), seen);
    expect_same_bits(VelocityMultirotor{.tau_f = 0.4, .tau_s = 0.45, .tau_z = 0.6, .tau_psi = 0.15}, seen);
  }
}

TEST(KernelTable, AMultirotorWhoseInputRatesCostIsCompiledWhateverTheCost) {
  const std::vector<double> some = {0.1, 0.0, 0.3, 2.0};
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion})
    expect_same_bits(Multirotor{.a_f = -0.4}, seen, {}, {some, 0.02});
}

TEST(KernelTable, RobotsThatAreSeenToLeanAreCompiledToo) {
  expect_same_bits(Multirotor{}, Seen::leaning);
  expect_same_bits(VelocityMultirotor{}, Seen::leaning);
  expect_same_bits(VelocityMultirotor{.frame = VelocityFrame::level}, Seen::leaning);
  expect_same_bits(VelocityMultirotor{.tau_f = 0.4, .tau_s = 0.45, .tau_z = 0.6, .tau_psi = 0.15},
                   Seen::leaning);
  expect_same_bits(HoverMultirotor{}, Seen::leaning);
  expect_same_bits(LaggingHoverMultirotor{}, Seen::leaning);
  expect_same_bits(LaggingHoverMultirotor::crazyflie(), Seen::leaning);
}

TEST(KernelTable, ABarrierOfTheLibraryIsCompiledWhateverItsParameters) {
  for (const double scale : {0.57, 1.0, 1.9}) {
    const RelaxedBarrier speed{SpeedLimit{0.77 * scale}, 0.013 * scale, 0.11 * scale};
    const RelaxedBarrier disc{InputDisc{0.77 * scale}, 0.013 * scale, 0.11 * scale};
    expect_same_bits(Multirotor{}, Seen::pose, {speed});
    expect_same_bits(Multirotor{}, Seen::pose, {disc});
  }
  expect_same_bits(Multirotor{}, Seen::pose, {RelaxedBarrier{SpeedLimit{}}});
  expect_same_bits(Multirotor{}, Seen::pose, {RelaxedBarrier{InputDisc{}}});
}

TEST(KernelTable, ModelsThatWereNotPrintedAreInterpreted) {
  const auto programs =
      std::make_shared<const StagePrograms>(trace_stage(Multirotor{.a_f = 0.0}, 0.05, Seen::pose));
  const auto group = make_group(programs, stages, 2, KernelChoice::compiled_if_there);
  const auto interpreted = make_group(programs, stages, 2, KernelChoice::interpreted);
  const Group& chosen = *group;
  const Group& expected = *interpreted;
  EXPECT_EQ(typeid(chosen), typeid(expected));
}

TEST(KernelTable, AProgramOfTheSameHashAndAnotherSizeIsNotTakenForIt) {
  Graph graph;
  const Symbol a(graph, graph.input(0)), b(graph, graph.input(1));
  const std::array<Term, 1> out = {(exp(a) * 0.731 + sqrt(b) * b * 0.219).in(graph)};
  const Program program(graph, out, 2);
  ASSERT_EQ(find_formula(program, native_width), nullptr);
  ProgramSize other = size_of(program);
  other.inputs += 3;
  static const std::array<FormulaKernel, 1> wrong = {{{structure(program), native_width, other, nullptr}}};
  static KernelTable table{{}, wrong};
  register_kernels(table);
  EXPECT_EQ(find_formula(program, native_width), nullptr);
  static const std::array<FormulaKernel, 1> right = {
      {{structure(program), native_width, size_of(program), nullptr}}};
  static KernelTable second{{}, right};
  register_kernels(second);
  EXPECT_EQ(find_formula(program, native_width), right.data());

  const auto programs = std::make_shared<const StagePrograms>(trace_stage(PointMass{}, 0.04, Seen::pose));
  ProgramSize smaller = size_of(*programs);
  --smaller.instructions;
  const auto must_not_be_made = +[](std::shared_ptr<const StagePrograms> given, int n) {
    ADD_FAILURE() << "a kernel of another size";
    return make_group(std::move(given), n, 2, KernelChoice::interpreted);
  };
  static const std::array<StageKernel, 1> stage = {{{structure(*programs), 2, smaller, must_not_be_made}}};
  static KernelTable third{stage, {}};
  register_kernels(third);
  EXPECT_NE(make_group(programs, stages, 2, KernelChoice::compiled_if_there), nullptr);
}

/// Numbers of few values, so that they meet each other, 0 and 1 and the formulas' own.
double any_of(Random& random, std::initializer_list<double> values) {
  return values.begin()[random() % values.size()];
}

Weighted random_term(Random& random, int which) {
  const double weight = any_of(random, {0.4, 1.0, 2.0, 20.0}),
               kappa_G = any_of(random, {0.0, 0.001, 1.0, 2.0}),
               kappa_A = any_of(random, {0.001, 1.0, 2.0, 3.0}),
               height = any_of(random, {0.5, 1.0, 2.0, 4.0}), distance = any_of(random, {1.0, 2.0, 3.0});
  switch (which) {
    case 0:
      return weight *
             SensorCone{.alpha = 0.5,
                        .kappa_G = kappa_G,
                        .kappa_A = kappa_A,
                        .form = random() % 2 == 0 ? ConeForm::sine : ConeForm::tangent,
                        .mount = {any_of(random, {0.0, 0.5, -0.5}), any_of(random, {0.0, 1.0, -0.2})}};
    case 1:
      return weight * KeepOut{.d_min = distance, .kappa_H = height, .kappa_G = kappa_G, .kappa_A = kappa_A};
    case 2:
      return weight * Cohesion{.d_max = distance, .kappa_H = height, .kappa_G = kappa_G, .kappa_A = kappa_A};
    case 3:
      return weight * AltitudeBand{.z_min = any_of(random, {-1.0, 0.0, 0.5}),
                                   .z_max = distance,
                                   .kappa_G = kappa_G,
                                   .kappa_A = kappa_A};
    case 5:
      return weight * Bearing{.width = distance,
                              .tilt = any_of(random, {0.0, 0.1, 0.2}),
                              .mount = {any_of(random, {0.0, 0.5, -0.5}), any_of(random, {0.0, 1.0, -0.2})}};
    case 6:
      return weight * TooNear{distance, height};
    case 7:
      return weight * TooFar{distance, height};
    case 8:
      return weight * RelativeVelocity{height};
    default:
      return weight * Geofence{{-distance, -1, 0}, {1, distance, 1}, kappa_G, kappa_A};
  }
}

TEST(KernelTable, ThePotentialsWithSlopesAreFoundWhateverTheirParameters) {
  Random random(2);
  const std::vector<std::vector<int>> together = {{5, 6, 7, 8}, {5, 6, 7}, {5}, {6}, {7}, {8}};
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Weighted> terms;
    for (const int w : together[static_cast<std::size_t>(trial) % together.size()])
      terms.push_back(random_term(random, w));
    std::vector<const Weighted*> pointers;
    for (const Weighted& t : terms) pointers.push_back(&t);
    const Ends ends{true, random() % 3 != 0, true, random() % 2 == 0};
    const PosePotential p = trace_potential(pointers, 0.05, ends, Numbers::parameters);
    EXPECT_NE(find_formula(p.derivatives, native_width), nullptr) << trial;
  }
}

TEST(KernelTable, TheBuiltInPotentialsAreFoundWhateverTheirParametersAndOrder) {
  Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const bool pair = trial % 4 != 0;
    std::vector<int> which = pair ? std::vector{0, 1, 2} : std::vector{3, 4};
    std::shuffle(which.begin(), which.end(), random);
    which.resize(1 + random() % which.size());
    std::vector<Weighted> terms;
    for (const int w : which) terms.push_back(random_term(random, w));
    std::vector<const Weighted*> pointers;
    for (const Weighted& t : terms) pointers.push_back(&t);
    const Ends ends{true, pair && random() % 3 != 0, true, random() % 2 == 0};
    const PosePotential p = trace_potential(pointers, 0.05, ends, Numbers::parameters);
    EXPECT_NE(find_formula(p.derivatives, native_width), nullptr) << trial;
  }
}

TEST(KernelTable, AUsersPotentialIsFoundOnceItsFormulasWereAdded) {
  const Weighted term = 1.7 * Downwash{.kappa_H = 1.0, .s_r = 0.5, .s_z = 0.5};
  const std::array terms = {&term};
  for (const Ends& ends : {Ends{}, {.b_feels = false}, {.b_is_agent = false}}) {
    const PosePotential p = trace_potential(terms, 0.02, ends, Numbers::parameters);
    EXPECT_NE(find_formula(p.derivatives, native_width), nullptr);
  }
}

}  // namespace
}  // namespace sightline
