#include "sightline/scenario/read_part.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/potential/bearing.hpp"
#include "sightline/potential/bounds.hpp"
#include "sightline/potential/distance.hpp"
#include "sightline/potential/pass_right.hpp"
#include "sightline/potential/sensor_cone.hpp"
#include "sightline/potential/slope.hpp"
#include "sightline/scenario/read_robot.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::robot_of;
using Numbers = std::vector<double>;

const Observer camera = {"uav0", SensorMount{.pitch = 0.25, .offset = 0.125}};

Weighted potential(const std::string& text) {
  const TomlDocument document = parse_toml(text, "a");
  return read_potential(TomlTable(document), camera);
}

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

TEST(ReadPart, each_parameter_of_a_robot_reaches_its_rates) {
  const std::string parameters =
      "parameters = { b_z = 2.0, b_psi = 3.0, a_f = -4.0, b_f = 5.0, a_s = -6.0, b_s = 7.0 }\n";
  const Numbers u = {0.5, -0.5, 0.25, 1.0};
  EXPECT_EQ(rates("robot = \"multirotor\"\n" + parameters, {0, 0, 0, 1, 0, 1, 1}, u),
            (Numbers{1, 1, 0.5, 0, 3, -1.5, -2.5}));
  EXPECT_EQ(rates("robot = \"angle_multirotor\"\n" + parameters, {0, 0, 0, 0, 1, 1}, u),
            (Numbers{1, 1, 0.5, 3, -1.5, -2.5}));
}

TEST(ReadPart, each_parameter_of_a_robot_on_the_ground_reaches_its_rates) {
  EXPECT_EQ(rates("robot = \"omni_rover\"\nparameters = { b_psi = 3.0, a_f = -4.0, b_f = 5.0, a_s = -6.0, "
                  "b_s = 7.0 }\n",
                  {0, 0, 2, 1, 0, 1, 1}, {0.5, -0.5, 1.0}),
            (Numbers{1, 1, 0, 0, 3, -1.5, -2.5}));
  EXPECT_EQ(rates("robot = \"unicycle\"\nparameters = { b_psi = 3.0, a_f = -4.0, b_f = 5.0 }\n",
                  {0, 0, 2, 1, 0, 1}, {0.5, 1.0}),
            (Numbers{1, 0, 0, 0, 3, -1.5}));
}

TEST(ReadPart, each_parameter_of_a_point_mass_and_of_lags_reaches_the_rates) {
  const Numbers u = {0.5, -0.5, 0.25, 1.0};
  EXPECT_EQ(rates("robot = \"point_mass\"\nparameters = { drag = 0.5 }\n", {0, 0, 2, 1, 2, 4}, u),
            (Numbers{1, 2, 4, 0, -1.5, -1.75}));
  EXPECT_EQ(rates("robot = \"velocity_multirotor\"\n"
                  "parameters = { tau_f = 0.5, tau_s = 0.25, tau_z = 2.0, tau_psi = 0.125 }\n",
                  {0, 0, 2, 1, 0, 1, 1, 1, 2}, u),
            (Numbers{1, 1, 1, 0, 2, -1, -6, -0.375, -8}));
}

TEST(ReadPart, parameters_left_out_are_those_of_the_struct) {
  const Model read = robot_of("robot = \"multirotor\"\n"), built = Multirotor{};
  const std::array<double, 4> u = {0.5, -0.5, 0.25, 1.0};
  const std::array<double, 7> x = {0, 0, 0, 1, 0, 1, 1};
  std::array<double, 7> a{}, b{};
  read.f(x.data(), u.data(), a.data());
  built.f(x.data(), u.data(), b.data());
  EXPECT_EQ(a, b);
}

TEST(ReadPart, each_parameter_of_a_potential_sets_its_field) {
  const Weighted cone = potential(
      "potential = { sensor_cone = { alpha = 0.25, kappa_G = 0.5, kappa_A = 3, form = \"tangent\" } "
      "}\nweight = 0.4\n");
  EXPECT_EQ(cone.weight, 0.4);
  const auto* c = cone.potential.as<SensorCone>();
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(std::tie(c->alpha, c->kappa_G, c->kappa_A, c->form),
            std::make_tuple(0.25, 0.5, 3.0, ConeForm::tangent));
  EXPECT_EQ(std::tie(c->mount.pitch, c->mount.offset), std::make_tuple(0.25, 0.125));

  const Weighted near =
      potential("potential = { keep_out = { d_min = 2, kappa_H = 3, kappa_G = 4, kappa_A = 5 } }\n");
  EXPECT_EQ(near.weight, 1.0);
  const auto* k = near.potential.as<KeepOut>();
  ASSERT_NE(k, nullptr);
  EXPECT_EQ(std::tie(k->d_min, k->kappa_H, k->kappa_G, k->kappa_A), std::make_tuple(2.0, 3.0, 4.0, 5.0));

  const Weighted far =
      potential("potential = { cohesion = { d_max = 2, kappa_H = 3, kappa_G = 4, kappa_A = 5 } }\n");
  const auto* d = far.potential.as<Cohesion>();
  ASSERT_NE(d, nullptr);
  EXPECT_EQ(std::tie(d->d_max, d->kappa_H, d->kappa_G, d->kappa_A), std::make_tuple(2.0, 3.0, 4.0, 5.0));

  const Weighted band =
      potential("potential = { altitude_band = { z_min = 1, z_max = 2, kappa_G = 4, kappa_A = 5 } }\n");
  const auto* b = band.potential.as<AltitudeBand>();
  ASSERT_NE(b, nullptr);
  EXPECT_EQ(std::tie(b->z_min, b->z_max, b->kappa_G, b->kappa_A), std::make_tuple(1.0, 2.0, 4.0, 5.0));

  const Weighted fence = potential(
      "potential = { geofence = { low = [1, 2, 3], high = [4, 5, 6], kappa_G = 7, kappa_A = 8 } }\n");
  const auto* g = fence.potential.as<Geofence>();
  ASSERT_NE(g, nullptr);
  EXPECT_EQ(std::tie(g->kappa_G, g->kappa_A), std::make_tuple(7.0, 8.0));
  EXPECT_EQ(g->low, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(g->high, (std::array<double, 3>{4, 5, 6}));
}

TEST(ReadPart, each_parameter_of_a_slope_sets_its_field) {
  const Weighted bearing =
      potential("potential = { bearing = { alpha = 0.25, width = 0.5, tilt = 0.125 } }\n");
  const auto* b = bearing.potential.as<Bearing>();
  ASSERT_NE(b, nullptr);
  EXPECT_EQ(std::tie(b->alpha, b->width, b->tilt), std::make_tuple(0.25, 0.5, 0.125));
  EXPECT_EQ(std::tie(b->mount.pitch, b->mount.offset), std::make_tuple(0.25, 0.125));

  const Weighted near = potential("potential = { too_near = { d_min = 2, kappa = 5 } }\n");
  const auto* n = near.potential.as<TooNear>();
  ASSERT_NE(n, nullptr);
  EXPECT_EQ(std::tie(n->d_min, n->kappa), std::make_tuple(2.0, 5.0));

  const Weighted pass = potential("potential = { pass_right = { d_min = 2, delta = 0.5, kappa = 5 } }\n");
  const auto* right = pass.potential.as<PassRight>();
  ASSERT_NE(right, nullptr);
  EXPECT_EQ(std::tie(right->d_min, right->delta, right->kappa), std::make_tuple(2.0, 0.5, 5.0));

  const Weighted far = potential("potential = { too_far = { d_max = 3, kappa = 6 } }\n");
  const auto* f = far.potential.as<TooFar>();
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(std::tie(f->d_max, f->kappa), std::make_tuple(3.0, 6.0));

  const Weighted relative = potential("potential = { relative_velocity = { v_0 = 0.5 } }\n");
  const auto* r = relative.potential.as<RelativeVelocity>();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(r->v_0, 0.5);
}

TEST(ReadPart, each_reference_is_the_one_of_its_struct) {
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

TEST(ReadPart, each_option_of_a_solver_sets_its_field) {
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

TEST(ReadPart, a_solver_by_its_name_has_the_options_of_its_struct) {
  for (const char* name : {"cmscgmres", "cgmres"}) {
    const SolverChoice choice = solver_named(name);
    EXPECT_EQ(choice.name, name);
    const auto o = std::get<ContinuationOptions>(choice.options), built = ContinuationOptions{};
    EXPECT_EQ(std::tie(o.zeta, o.k_max, o.alpha, o.jacobian),
              std::tie(built.zeta, built.k_max, built.alpha, built.jacobian));
  }
}

TEST(ReadPart, each_name_makes_the_solver_of_that_name) {
  Team team;
  team.add(Multirotor{}, {});
  for (const char* name : {"cmscgmres", "cgmres", "newton_riccati"}) {
    EXPECT_EQ(make_solver(solver_named(name), team, Horizon{})->name(), name);
  }
}

TEST(ReadPart, a_solver_that_is_none_is_refused_with_those_there_are) {
  try {
    solver_named("simplex\n");
    FAIL() << "expected a refusal";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "solver = simplex\\n, expected one of newton_riccati, cmscgmres, cgmres");
  }
}

}  // namespace
}  // namespace sightline
