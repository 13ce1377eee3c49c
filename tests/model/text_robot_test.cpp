#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sightline/formula.hpp"
#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

const TextRobot unicycle = {
    .states = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f"},
    .inputs = {"u_f", "u_psi"},
    .f = {"v_f * d_x", "v_f * d_y", "0", "-(d_y * rate)", "d_x * rate", "a_f * v_f + b_f * u_f"},
    .position = {"p_x", "p_y", "p_z"},
    .heading = {"d_x", "d_y"},
    .parameters = {{"rate", "b_psi * u_psi"}, {"b_psi", "1.5"}, {"a_f", "-b_f"}, {"b_f", "2.5"}}};
const TextRobot angle = {.states = {"v", "z", "psi", "y", "x"},
                         .inputs = {"a", "w"},
                         .f = {"a - 0.5 * v", "0", "w", "v * sin(psi)", "v * cos(psi)"},
                         .position = {"x", "y", "z"},
                         .heading = {"psi"}};

template <class Change>
TextRobot changed(TextRobot robot, Change&& change) {
  change(robot);
  return robot;
}

TEST(TextRobot, IsTheStructOfItsFormulasBitForBit) {
  const Model text = unicycle.model(), model = Unicycle{};
  EXPECT_EQ(text.nx(), 6);
  EXPECT_EQ(text.nu(), 2);
  EXPECT_TRUE(text.turns());
  Random random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    auto x = uniform_array<6>(random, -2, 2);
    const auto u = uniform_array<2>(random, -1, 1);
    auto y = x;
    std::array<double, 6> rate, expected;
    text.f(x.data(), u.data(), rate.data());
    model.f(x.data(), u.data(), expected.data());
    EXPECT_EQ(rate, expected);
    std::array<double, sight_size> seen, seen_expected;
    write_sight(text.sight(x.data(), u.data()), seen);
    write_sight(model.sight(x.data(), u.data()), seen_expected);
    EXPECT_EQ(seen, seen_expected);
    text.step(x.data(), u.data(), 0.01);
    model.step(y.data(), u.data(), 0.01);
    EXPECT_EQ(x, y);
    EXPECT_EQ(text.normalise(x.data()), model.normalise(y.data()));
    EXPECT_EQ(x, y);
  }
}

TEST(TextRobot, WhatIsRecordedGivesTheRateAndTheSight) {
  Random random(2);
  for (const TextRobot& robot : {unicycle, angle}) {
    const Model model = robot.model();
    const auto nx = static_cast<std::size_t>(model.nx()), nu = static_cast<std::size_t>(model.nu());
    Graph graph;
    const auto x = variables(graph, 0, model.nx()), u = variables(graph, model.nx(), model.nu());
    std::vector<Symbol> recorded(nx);
    model.f(x, u, recorded);
    recorded.resize(nx + sight_size);
    write_sight(model.sight(x, u), recorded.data() + nx);
    std::vector<Term> outputs;
    for (const Symbol& s : recorded) outputs.push_back(s.in(graph));
    const Program program(graph, outputs, model.nx() + model.nu());
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<double> z(nx + nu), expected(nx + sight_size);
      for (double& v : z) v = uniform(random, -2, 2);
      model.f(z.data(), z.data() + nx, expected.data());
      write_sight(model.sight(z.data(), z.data() + nx), expected.data() + nx);
      const std::vector<double> got = evaluate(program, z);
      for (std::size_t i = 0; i < got.size(); ++i) EXPECT_LE(relative_error(got[i], expected[i]), 1e-14);
    }
  }
}

TEST(TextRobot, AtRestItStandsInItsPose) {
  Random random(3);
  for (const TextRobot& robot : {unicycle, angle}) {
    const Model model = robot.model();
    for (int trial = 0; trial < 200; ++trial) {
      const Pose<double> pose = random_pose(random, 3);
      std::array<double, text_states_max> x{}, rate{};
      const std::array<double, text_inputs_max> none{};
      model.at_rest(pose, x.data());
      model.f(x.data(), none.data(), rate.data());
      for (const double r : rate) EXPECT_EQ(r, 0.0);
      const Sight<double> seen = model.sight(x.data(), none.data());
      EXPECT_EQ(norm(seen.p - pose.p), 0.0);
      EXPECT_NEAR(seen.d.x, pose.d.x, 3e-16);
      EXPECT_NEAR(seen.d.y, pose.d.y, 3e-16);
    }
  }
}

TEST(TextRobot, AtRestInManyPosesItIsAsInEachAsOneOfOurOwn) {
  Random random(4);
  for (const Model& model : {unicycle.model(), angle.model(), Model(Multirotor{}), Model(Unicycle{})}) {
    constexpr int n = 5, entry = 3;
    const int stage = entry * model.nx() + 1;
    std::vector<Pose<double>> poses;
    for (int k = 0; k < n; ++k) poses.push_back(random_pose(random, 3));
    std::vector<double> x(static_cast<std::size_t>(n * stage), 7.0), expected = x;
    std::vector<double> one(static_cast<std::size_t>(model.nx()));
    model.at_rest(poses, x.data(), stage, entry);
    double* r = expected.data();
    for (const Pose<double>& pose : poses) {
      model.at_rest(pose, one.data());
      for (std::size_t i = 0; i < one.size(); ++i) r[i * entry] = one[i];
      r += stage;
    }
    EXPECT_EQ(x, expected);
  }
}

TEST(TextRobot, AnAngleIsWrappedAndAStateThatIsNotFiniteRefused) {
  const Model model = angle.model();
  std::array<double, 5> x = {0, 0, 7.0, 0, 0};
  ASSERT_TRUE(model.normalise(x.data()));
  EXPECT_EQ(x[2], wrap_angle(7.0));
  x[0] = not_a_number;
  EXPECT_FALSE(model.normalise(x.data()));
  std::array<double, 6> no_direction{};
  EXPECT_FALSE(unicycle.model().normalise(no_direction.data()));
}

TEST(TextRobot, WithoutAHeadingItHeadsAlongX) {
  const Model model = changed(angle, [](TextRobot& r) { r.heading = {}; }).model();
  const std::array<double, 5> x = {0, 0, 1.0, 0, 0};
  const std::array<double, 2> u{};
  EXPECT_EQ(model.sight(x.data(), u.data()).d.x, 1.0);
  EXPECT_FALSE(model.turns());
}

TEST(TextRobot, ItsLimitsAreTheModels) {
  const Model model = changed(angle, [](TextRobot& r) { r.u_min = {-2, -3}, r.u_max = {4, 5}; }).model();
  EXPECT_EQ(model.u_min()[1], -3);
  EXPECT_EQ(model.u_max()[0], 4);
  EXPECT_EQ(angle.model().u_max()[1], 1);
}

TEST(TextRobot, WhatDoesNotFitTogetherIsRefusedWithASentence) {
  const auto refused = [](auto&& change) {
    return refusal_of([&] { changed(angle, change).model(); }).find("expected") != std::string::npos;
  };
  EXPECT_FALSE(refused([](TextRobot&) {}));
  EXPECT_TRUE(refused([](TextRobot& r) { r.f.pop_back(); }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.states.clear(), r.f.clear(); }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.inputs = std::vector<std::string>(9, "u"); }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.inputs[0] = "psi"; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.states[0] = "sin"; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.position[1] = "q"; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.position[1] = "x"; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.heading = {"w"}; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.heading = {"psi", "v", "z"}; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.f[0] = "a +"; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.parameters = {{"v", "1"}}; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.parameters = {{"k", "k"}}; }));
  EXPECT_TRUE(refused([](TextRobot& r) { r.u_max = {1.0}; }));
}

TEST(TextRobot, OfRecordedRatesIsTheSameRobot) {
  const TextRobot& text = unicycle;
  const Vocabulary names = text.vocabulary();
  std::vector<Expression> rates;
  for (const std::string& rate : text.f) rates.push_back(parse_formula(rate, names));
  const Model read = text.model(), recorded = text.model(rates);
  const std::vector<double> u(text.inputs.size(), 0.3);
  std::vector<double> x(text.states.size(), 0.7), y = x;
  read.step(x.data(), u.data(), 0.1);
  recorded.step(y.data(), u.data(), 0.1);
  EXPECT_EQ(x, y);
  rates.pop_back();
  EXPECT_THROW((void)text.model(rates), std::invalid_argument);
}

/// Rates drawn from pieces of the language: what is read flies or is refused, and never harms.
TEST(TextRobot, AnyTextIsARobotOrIsRefused) {
  Random random(4);
  const std::array<std::string, 26> pieces = {
      "v",     "psi",  "a",  "w", "k",   "+", "-", "*",    "/",    "(", ")",   "sin(", "cos(",
      "sqrt(", "exp(", "^2", "1", "0.5", " ", "x", "log(", "max(", ",", "1e9", "2 m",  "abs("};
  int read = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    TextRobot robot = angle;
    robot.parameters = {{"k", "0.3"}};
    std::string& rate = robot.f[random() % robot.f.size()];
    rate.clear();
    for (std::size_t n = 1 + random() % 6; n > 0; --n) rate += pieces[random() % pieces.size()];
    try {
      const Model model = robot.model();
      ++read;
      Graph graph;
      const auto nx = static_cast<std::size_t>(model.nx());
      const auto x = variables(graph, 0, 5), u = variables(graph, 5, 2);
      std::vector<Symbol> f(nx);
      model.f(x, u, f);
      std::vector<Term> outputs;
      for (const Symbol& s : f) outputs.push_back(s.in(graph));
      std::vector<double> z(7);
      for (double& v : z) v = uniform(random, 0.1, 1);
      std::vector<double> expected(nx);
      model.f(z.data(), z.data() + 5, expected.data());
      const std::vector<double> got = evaluate(Program(graph, outputs, 7), z);
      for (std::size_t i = 0; i < 5; ++i) {
        if (std::isfinite(expected[i])) {
          EXPECT_LE(relative_error(got[i], expected[i]), 1e-9) << rate;
        }
      }
    } catch (const FormulaError& error) {
      EXPECT_LE(error.offset(), rate.size());
    }
  }
  EXPECT_GE(read, 100);
}

}  // namespace
}  // namespace sightline
