#include "sightline/model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/formula.hpp"
#include "sightline/robots.hpp"
#include "tests/support/difference.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The laws of every robot; a new one is added to the list and obeys them all.
template <class M>
class RobotLaws : public testing::Test {
 protected:
  static constexpr std::size_t nx = M::nx, nu = M::nu;
  using X = std::array<double, nx>;
  using U = std::array<double, nu>;
  static_assert(RobotModel<M>);

  /// A state on its manifold.
  X state() {
    X x = robot_.at_rest(random_pose(random_, 3));
    for (double& v : x) v += uniform(random_, -1, 1);
    EXPECT_TRUE(Model(robot_).normalise(x.data()));
    return x;
  }
  U input() { return uniform_array<nu>(random_, -1, 1); }

  template <class S, std::size_t n>
  static std::array<S, n> as(const std::array<double, n>& a) {
    std::array<S, n> s;
    for (std::size_t i = 0; i < n; ++i) s[i] = S(a[i]);
    return s;
  }

  static std::array<double, sight_size> numbers(const Sight<double>& s) {
    std::array<double, sight_size> row;
    write_sight(s, row);
    return row;
  }

  M robot_;
  Random random_{1};
};

using Robots =
    testing::Types<Multirotor, AngleMultirotor, OmniRover, Unicycle, PointMass, VelocityMultirotor,
                   LaggedMultirotor<Lags::plane>, LaggedMultirotor<Lags::climb>, LaggedMultirotor<Lags::yaw>,
                   HoverMultirotor, LaggingHoverMultirotor, Body, PosedBody>;
TYPED_TEST_SUITE(RobotLaws, Robots);

/// Whether the state says where a robot heads; the others head along x of G.
template <class M>
constexpr bool has_heading = requires {
  M::heading_at;
}
|| requires { M::angle_at; };

TYPED_TEST(RobotLaws, AStepIsTheRungeKuttaStepOfTheRateBitForBit) {
  const Model model = this->robot_;
  for (int k = 0; k < 1000; ++k) {
    const auto x = this->state();
    const auto u = this->input();
    auto stepped = x, integrated = x;
    model.step(stepped.data(), u.data(), 0.01);
    std::array<double, RungeKuttaScratch::rows_needed * TypeParam::nx> rows;
    rk4_step(
        [&](std::span<const double> z, std::span<double> rate) { model.f(z.data(), u.data(), rate.data()); },
        integrated, 0.01, {rows});
    EXPECT_EQ(stepped, integrated);
  }
}

TYPED_TEST(RobotLaws, TheRateIsTheSameOnEveryScalar) {
  for (int k = 0; k < 1000; ++k) {
    const auto x = this->state();
    const auto u = this->input();
    const auto expected = this->robot_.f(x, u);
    const auto strict = this->robot_.f(this->template as<Strict>(x), this->template as<Strict>(u));
    const auto lanes = this->robot_.f(this->template as<NativeLane>(x), this->template as<NativeLane>(u));
    const auto still =
        this->robot_.f(this->template as<Tangent<double>>(x), this->template as<Tangent<double>>(u));
    std::array<double, TestFixture::nx> erased;
    Model(this->robot_).f(x.data(), u.data(), erased.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      EXPECT_TRUE(same_bits(strict[i].value(), expected[i]));
      EXPECT_TRUE(same_bits(lanes[i][native_width - 1], expected[i]));
      EXPECT_TRUE(same_bits(still[i].value, expected[i]));
      EXPECT_EQ(still[i].rate, 0.0);
      EXPECT_TRUE(same_bits(erased[i], expected[i]));
    }
  }
}

/// f and sight of a model, recorded over (x, u).
struct Recorded {
  explicit Recorded(const Model& model) : nx(static_cast<std::size_t>(model.nx())) {
    const int n = model.nx() + model.nu();
    const auto z = variables(graph, 0, n);
    for (const Symbol& s : z) inputs.push_back(s.in(graph));
    std::vector<Symbol> rate(nx);
    model.f(std::span(z).first(nx), std::span(z).subspan(nx), rate);
    for (const Symbol& r : rate) f.push_back(r.in(graph));
    std::array<Symbol, sight_size> row;
    write_sight(model.sight(std::span(z).first(nx), std::span(z).subspan(nx)), row);
    for (const Symbol& s : row) sight.push_back(s.in(graph));
  }

  std::vector<double> at(const std::vector<Term>& outputs, std::span<const double> z) const {
    return evaluate({graph, outputs, static_cast<int>(inputs.size())}, z);
  }

  std::size_t nx;
  Graph graph;
  std::vector<Term> inputs, f, sight;
};

template <class X, class U>
std::vector<double> stacked(const X& x, const U& u) {
  std::vector<double> z(x.begin(), x.end());
  z.insert(z.end(), u.begin(), u.end());
  return z;
}

TYPED_TEST(RobotLaws, WhatIsRecordedGivesTheRateAndTheSight) {
  const Recorded recorded{Model(this->robot_)};
  for (int k = 0; k < 1000; ++k) {
    const auto x = this->state();
    const auto u = this->input();
    const auto z = stacked(x, u);
    const auto f = this->robot_.f(x, u);
    const auto f_recorded = recorded.at(recorded.f, z);
    for (std::size_t i = 0; i < f.size(); ++i) EXPECT_LE(relative_error(f_recorded[i], f[i]), 1e-15);
    const auto seen = this->numbers(Model(this->robot_).sight(x.data(), u.data()));
    const auto seen_recorded = recorded.at(recorded.sight, z);
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_LE(relative_error(seen_recorded[i], seen[i]), 1e-15);
  }
}

TYPED_TEST(RobotLaws, TheJacobianIsTheCentralDifference) {
  Recorded recorded{Model(this->robot_)};
  std::vector<std::vector<Term>> rows;
  for (const Term f : recorded.f) rows.push_back(gradient(recorded.graph, f, recorded.inputs));
  for (int k = 0; k < 100; ++k) {
    const auto z = stacked(this->state(), this->input());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto f_i = [&](const std::vector<Wide>& at) {
        std::array<Wide, TestFixture::nx> x;
        std::array<Wide, TestFixture::nu> u;
        std::copy_n(at.begin(), x.size(), x.begin());
        std::copy_n(at.begin() + TestFixture::nx, u.size(), u.begin());
        return this->robot_.f(x, u)[i];
      };
      CentralDifference difference(f_i, z);
      const auto row = recorded.at(rows[i], z);
      for (std::size_t j = 0; j < z.size(); ++j)
        EXPECT_LE(relative_error(row[j], difference.first(j)), 1e-11);
    }
  }
}

TYPED_TEST(RobotLaws, TheVelocityIsTheRateOfThePositionAlongTheMotion) {
  for (int k = 0; k < 1000; ++k) {
    const auto x = this->state();
    const auto u = this->input();
    const auto f = this->robot_.f(x, u);
    const auto position = [&](double time) {
      auto moved = x;
      for (std::size_t i = 0; i < x.size(); ++i) moved[i] += time * f[i];
      return this->robot_.pose(moved).p;
    };
    const double h = 1e-4;
    const Vec3<double> rate = (0.5 / h) * (position(h) - position(-h));
    EXPECT_LE(norm(Model(this->robot_).sight(x.data(), u.data()).v - rate), 1e-10);
  }
}

TYPED_TEST(RobotLaws, ARobotAtRestStandsInItsPose) {
  const Model model(this->robot_);
  for (int k = 0; k < 1000; ++k) {
    const Pose<double> pose = random_pose(this->random_, 3);
    std::array<double, TestFixture::nx> x, rate;
    const std::array<double, TestFixture::nu> no_input{};
    model.at_rest(pose, x.data());
    model.f(x.data(), no_input.data(), rate.data());
    for (const double r : rate) EXPECT_EQ(r, 0.0);
    const Sight<double> seen = model.sight(x.data(), no_input.data());
    EXPECT_EQ(norm(seen.v), 0.0);
    EXPECT_EQ(norm(seen.p - pose.p), 0.0);
    if constexpr (has_heading<TypeParam>) {
      EXPECT_NEAR(seen.d.x, pose.d.x, 3e-16);
      EXPECT_NEAR(seen.d.y, pose.d.y, 3e-16);
    }
  }
}

TYPED_TEST(RobotLaws, ANormalisedStateShowsAHeadingOfLengthOne) {
  const Model model(this->robot_);
  for (int k = 0; k < 1000; ++k) {
    auto x = uniform_array<TestFixture::nx>(this->random_, -20, 20);
    ASSERT_TRUE(model.normalise(x.data()));
    const Vec2<double> d = this->robot_.pose(x).d;
    EXPECT_NEAR(dot(d, d), 1.0, 5e-16);
    const auto once = x;
    ASSERT_TRUE(model.normalise(x.data()));
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], once[i], 3e-16);
  }
}

TYPED_TEST(RobotLaws, NormalisingTurnsNoRobot) {
  const Model model(this->robot_);
  for (int k = 0; k < 1000; ++k) {
    auto x = uniform_array<TestFixture::nx>(this->random_, -20, 20);
    const Pose<double> before = this->robot_.pose(x);
    ASSERT_TRUE(model.normalise(x.data()));
    const Pose<double> after = this->robot_.pose(x);
    EXPECT_EQ(norm(after.p - before.p), 0.0);
    EXPECT_NEAR(after.d.x * before.d.y, after.d.y * before.d.x, 1e-14 * std::hypot(before.d.x, before.d.y));
    EXPECT_GT(dot(after.d, before.d), 0.0);
  }
}

TYPED_TEST(RobotLaws, AStateThatIsNotFiniteIsRefused) {
  const Model model(this->robot_);
  for (std::size_t i = 0; i < TestFixture::nx; ++i) {
    for (const double bad : {nan, infinity, -infinity}) {
      auto x = this->state();
      x[i] = bad;
      EXPECT_FALSE(model.normalise(x.data())) << i << ' ' << bad;
    }
  }
}

/// What a push of this acceleration gives a robot that heads to d.
template <class M>
Vec3<double> taken(const Vec2<double>& d, const Vec3<double>& a) {
  if constexpr (std::same_as<M, Body> || std::same_as<M, PosedBody>) return {};
  if constexpr (std::same_as<M, PointMass>) return a;
  if constexpr (requires { M::climb_lags; }) return {a.x, a.y, M::climb_lags ? a.z : 0.0};
  if constexpr (requires { M::lagging; }) return {a.x, a.y, M::lagging ? a.z : 0.0};
  if constexpr (std::same_as<M, Unicycle>) {
    const double along = d.x * a.x + d.y * a.y;
    return {along * d.x, along * d.y, 0.0};
  }
  return {a.x, a.y, 0.0};
}

TYPED_TEST(RobotLaws, APushAcceleratesTheRobotWhereItGivesWay) {
  const Model model(this->robot_);
  for (int k = 0; k < 1000; ++k) {
    const auto x = this->state();
    const std::array<double, TestFixture::nu> no_input{};
    const Vec3<double> a = random_point(this->random_, 2);
    std::array<double, TestFixture::nx> rate{};
    model.push(x.data(), a, rate.data());
    const auto velocity = [&](double time) {
      auto moved = x;
      for (std::size_t i = 0; i < x.size(); ++i) moved[i] += time * rate[i];
      return model.sight(moved.data(), no_input.data()).v;
    };
    const Vec3<double> gained = velocity(1) - velocity(0);
    EXPECT_LE(norm(gained - taken<TypeParam>(this->robot_.pose(x).d, a)), 1e-14);
  }
}

TYPED_TEST(RobotLaws, EveryStateAndInputHasItsName) {
  const Model model(this->robot_);
  EXPECT_EQ(model.nx(), TypeParam::nx);
  EXPECT_EQ(model.nu(), TypeParam::nu);
  EXPECT_EQ(model.name(), TypeParam::name);
  ASSERT_EQ(model.states().size(), TestFixture::nx);
  ASSERT_EQ(model.inputs().size(), TestFixture::nu);
  for (const auto names : {model.states(), model.inputs()}) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      EXPECT_FALSE(names[i].empty());
      for (std::size_t j = 0; j < i; ++j) EXPECT_NE(names[i], names[j]);
    }
  }
}

TYPED_TEST(RobotLaws, ItsLimitsLeaveRoomForEveryInput) {
  const Model model(this->robot_);
  ASSERT_EQ(model.u_min().size(), TestFixture::nu);
  ASSERT_EQ(model.u_max().size(), TestFixture::nu);
  for (std::size_t i = 0; i < TestFixture::nu; ++i) {
    EXPECT_LT(model.u_min()[i], 0.0);
    EXPECT_GT(model.u_max()[i], 0.0);
  }
}

TYPED_TEST(RobotLaws, ItTurnsWhereItsStateSaysWhereItHeads) {
  EXPECT_EQ(Model(this->robot_).turns(), has_heading<TypeParam>);
}

TEST(Model, AHeadingOfNoDirectionIsRefused) {
  std::array<double, 7> x = {1, 2, 3, 0, 0, 0, 0};
  EXPECT_FALSE(Model(Multirotor{}).normalise(x.data()));
  std::array<double, 2> d = {0, 0};
  EXPECT_FALSE(normalise_heading(d.data()));
  d = {nan, 1};
  EXPECT_FALSE(normalise_heading(d.data()));
  d = {infinity, 1};
  EXPECT_FALSE(normalise_heading(d.data()));
}

TEST(Model, AnAngleIsWrappedByWholeTurnsIntoMinusPiToPi) {
  using std::numbers::pi;
  Random random(2);
  for (int k = 0; k < 20'000; ++k) {
    const double psi = uniform(random, -100, 100), wrapped = wrap_angle(psi);
    EXPECT_GT(wrapped, -pi);
    EXPECT_LE(wrapped, pi);
    EXPECT_NEAR(std::remainder((psi - wrapped) / (2 * pi), 1.0), 0.0, 1e-14);
    EXPECT_EQ(wrap_angle(wrapped), wrapped);
  }
  for (const double half_turn : {pi, -pi, 3 * pi, -3 * pi}) EXPECT_NEAR(wrap_angle(half_turn), pi, 1e-15);
  EXPECT_EQ(wrap_angle(0.0), 0.0);
  EXPECT_GT(wrap_angle(std::nextafter(-pi, -4.0)), 0.0);
}

TEST(Model, AllFiniteMeansEveryOne) {
  std::vector<double> values(20, 1.0);
  EXPECT_TRUE(all_finite(values));
  EXPECT_TRUE(all_finite({}));
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (const double bad : {nan, infinity, -infinity}) {
      values[i] = bad;
      EXPECT_FALSE(all_finite(values));
    }
    values[i] = 1.0;
  }
}

/// Throws once it is asked for numbers, not while it is recorded.
struct Moody {
  static constexpr std::size_t nx = 2, nu = 1;
  static constexpr std::string_view name = "moody";
  template <class S>
  static void throw_invalid() {
    if constexpr (std::is_same_v<S, double>) throw std::runtime_error("not today");
  }
  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    throw_invalid<S>();
    return {x[1], u[0]};
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], S(0.0), S(0.0)}, {S(1.0), S(0.0)}};
  }
  template <class S>
  std::array<S, nx> at_rest(const Pose<S>& pose) const {
    throw_invalid<S>();
    return {pose.p.x, S(0.0)};
  }
};

TEST(Model, WhatThrowsLeavesNumbersThatAreNone) {
  const Model model{Moody{}};
  double x[3] = {1, 2, 9}, u[1] = {0.5}, rate[3] = {1, 1, 9};
  model.f(x, u, rate);
  EXPECT_TRUE(std::isnan(rate[0]) && std::isnan(rate[1]));
  EXPECT_EQ(rate[2], 9);
  const Sight<double> sight = model.sight(x, u);
  EXPECT_TRUE(std::isnan(sight.p.x) && std::isnan(sight.v.z) && std::isnan(sight.d.y));
  model.step(x, u, 0.01);
  EXPECT_TRUE(std::isnan(x[0]) && std::isnan(x[1]));
  EXPECT_EQ(x[2], 9);
  model.at_rest({}, x);
  EXPECT_TRUE(std::isnan(x[0]));
}

TEST(Model, StatesAndInputsWithoutNamesAreNumbered) {
  const Model model{Moody{}};
  EXPECT_TRUE(std::ranges::equal(model.states(), std::array{"x_0", "x_1"}));
  EXPECT_TRUE(std::ranges::equal(model.inputs(), std::array{"u_0"}));
  EXPECT_EQ((numbered_names<'u', 100>[9]), "u_9");
  EXPECT_EQ((numbered_names<'u', 100>[10]), "u_10");
  EXPECT_EQ((numbered_names<'u', 100>[99]), "u_99");
}

}  // namespace
}  // namespace sightline
