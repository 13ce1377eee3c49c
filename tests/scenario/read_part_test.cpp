#include "sightline/scenario/read_part.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/scenario/read_robot.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::robot_of;
using Numbers = std::vector<double>;

std::vector<double> reference(const std::string& text, double t, const Model& model = Multirotor{}) {
  const TomlDocument document = parse_toml(text, "a");
  std::vector<double> x(static_cast<std::size_t>(model.nx()));
  read_reference(TomlTable(document), model)(t, model, x);
  return x;
}

CmscgmresOptions options(const std::string& text) {
  const TomlDocument document = parse_toml(text, "a");
  return std::get<CmscgmresOptions>(read_solver(TomlTable(document), Horizon{}).options);
}

/// f of a robot as text has it. Inlined, GCC 12 takes the lists for those of another model.
[[gnu::noinline]] Numbers rates(const std::string& text, const Numbers& x, const Numbers& u) {
  Numbers rate(x.size());
  robot_of(text).f(x.data(), u.data(), rate.data());
  return rate;
}

TEST(ReadPart, EachParameterOfARobotReachesItsRates) {
  const std::string parameters =
      "parameters = { b_z = 2.0, b_psi = 3.0, a_f = -4.0, b_f = 5.0, a_s = -6.0, b_s = 7.0 }\n";
  const Numbers u = {0.5, -0.5, 0.25, 1.0};
  EXPECT_EQ(rates("robot = \"multirotor\"\n" + parameters, {0, 0, 0, 1, 0, 1, 1}, u),
            (Numbers{1, 1, 0.5, 0, 3, -1.5, -2.5}));
  EXPECT_EQ(rates("robot = \"angle_multirotor\"\n" + parameters, {0, 0, 0, 0, 1, 1}, u),
            (Numbers{1, 1, 0.5, 3, -1.5, -2.5}));
}

TEST(ReadPart, EachParameterOfARobotOnTheGroundReachesItsRates) {
  EXPECT_EQ(rates("robot = \"omni_rover\"\nparameters = { b_psi = 3.0, a_f = -4.0, b_f = 5.0, a_s = -6.0, "
                  "b_s = 7.0 }\n",
                  {0, 0, 2, 1, 0, 1, 1}, {0.5, -0.5, 1.0}),
            (Numbers{1, 1, 0, 0, 3, -1.5, -2.5}));
  EXPECT_EQ(rates("robot = \"unicycle\"\nparameters = { b_psi = 3.0, a_f = -4.0, b_f = 5.0 }\n",
                  {0, 0, 2, 1, 0, 1}, {0.5, 1.0}),
            (Numbers{1, 0, 0, 0, 3, -1.5}));
}

TEST(ReadPart, EachParameterOfAPointMassAndOfLagsReachesTheRates) {
  const Numbers u = {0.5, -0.5, 0.25, 1.0};
  EXPECT_EQ(rates("robot = \"point_mass\"\nparameters = { drag = 0.5 }\n", {0, 0, 2, 1, 2, 4}, u),
            (Numbers{1, 2, 4, 0, -1.5, -1.75}));
  EXPECT_EQ(rates("robot = \"velocity_multirotor\"\n"
                  "parameters = { tau_f = 0.5, tau_s = 0.25, tau_z = 2.0, tau_psi = 0.125 }\n",
                  {0, 0, 2, 1, 0, 1, 1, 1, 2}, u),
            (Numbers{1, 1, 1, 0, 2, -1, -6, -0.375, -8}));
}

TEST(ReadPart, EachReferenceIsTheOneOfItsStruct) {
  const std::string timed = " = { times = [0, 2], p = [[1, 2, 3], [3, 2, 1]], heading = [0.5, 1.5] } }\n";
  const Waypoints waypoints{.times = {0, 2}, .p = {{1, 2, 3}, {3, 2, 1}}, .heading = {0.5, 1.5}};
  const Steps steps{.times = {0, 2}, .p = {{1, 2, 3}, {3, 2, 1}}, .heading = {0.5, 1.5}};
  const Circle circle{.centre = {1, 2, 3}, .radius = 0.75, .rate = 0.25};
  const Model model = Multirotor{};
  const auto at_rest = [&](const Pose<double>& pose) {
    std::vector<double> x(7);
    model.at_rest(pose, x.data());
    return x;
  };
  for (double t = -1; t < 4; t += 0.25) {
    EXPECT_EQ(reference("reference = { waypoints" + timed, t), at_rest(waypoints(t)));
    EXPECT_EQ(reference("reference = { steps" + timed, t), at_rest(steps(t)));
    EXPECT_EQ(reference("reference = { circle = { centre = [1, 2, 3], radius = 0.75, rate = 0.25 } }\n", t),
              at_rest(circle(t)));
    EXPECT_EQ(reference("reference = { constant = { p = [1, 2, 3] } }\n", t), at_rest({{1, 2, 3}, {0, 0}}));
    EXPECT_EQ(reference("reference = { constant = { p = [1, 2, 3], heading = 0.0 } }\n", t),
              at_rest({{1, 2, 3}, {1, 0}}));
    EXPECT_EQ(reference("reference = { state = [1, 2, 3, 4, 5, 6, 7] }\n", t),
              (std::vector<double>{1, 2, 3, 4, 5, 6, 7}));
    EXPECT_EQ(reference("\n", t), std::vector<double>(7));
  }
}

TEST(ReadPart, EachOptionOfASolverSetsItsField) {
  for (const char* name : {"cmscgmres", "cgmres"}) {
    const CmscgmresOptions o =
        options(fmt::format("name = \"{}\"\n", name) +
                "zeta = 5\nk_max = 7\nalpha = 3\ndifference_step = 1e-3\nslack_weight = 0.5\n"
                "jacobian = \"forward_difference\"\ngmres_tolerance = 1e-5\ntolerance = 1e-2\n");
    EXPECT_EQ(std::tie(o.zeta, o.k_max, o.alpha, o.difference_step, o.slack_weight, o.jacobian,
                       o.gmres_tolerance, o.tolerance),
              std::make_tuple(5.0, 7, 3.0, 1e-3, 0.5, JacobianProduct::forward_difference, 1e-5, 1e-2));
  }
}

TEST(ReadPart, EachNameMakesTheSolverOfThatName) {
  Team team;
  team.add(Multirotor{}, {});
  for (const char* name : {"cmscgmres", "cgmres", "newton_riccati"}) {
    EXPECT_EQ(make_solver(solver_named(name), team, Horizon{})->name(), name);
  }
}

TEST(ReadPart, ASolverThatIsNoneIsRefusedWithThoseThereAre) {
  try {
    solver_named("simplex\n");
    FAIL() << "expected a refusal";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "solver = simplex\\n, expected one of newton_riccati, cmscgmres, cgmres");
  }
}

}  // namespace
}  // namespace sightline
