/// What a robot does not know of what it looks at shrinks its views in the plan.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/default_horizon.hpp"

namespace sightline {
namespace {

constexpr ViewUncertainty uncertainty{.sigma = 0.08, .growth = 0.1};

SensorCone cone_of(double sigmas) {
  return {.alpha = 0.4, .kappa_G = 0.05, .kappa_A = 20, .mount = {.sigmas = sigmas}};
}

/// The cone of a robot whose uncertainty at t = 0 is written into the formula.
struct WrittenUncertainty {
  double sigmas;

  static constexpr std::string_view name = "written_doubt";
  template <class S>
  S operator()(const Sight<S>& observer, const Sight<S>& target, const S& t) const {
    Sight<S> uncertain = observer;
    uncertain.uncertainty = uncertainty.sigma + uncertainty.growth * t;
    return cone_of(sigmas)(uncertain, target);
  }
};

/// uav0 looks at uav1, which passes 1.5 m ahead of it.
template <class View>
Team looking(const View& view) {
  Team team;
  const auto uav0 = team.add(Multirotor{}, {.R = {.1, .1, .1, .1}, .name = "uav0"});
  const auto uav1 = team.add(Multirotor{}, {.Q = {1, 1, 1, 1, 1}, .R = {1, 1, 1, 1}, .name = "uav1"});
  team.couple(4.0 * view, {uav0, uav1}, felt_by(uav0));
  return team;
}
constexpr std::array<double, 14> aside = {0, 0, 1.5, 1, 0, 0, 0, /**/ 1.5, 0.5, 0.9, 1, 0, 0, 0};

/// States of all stages.
template <class View>
std::vector<double> planned(const View& view, std::span<const ViewUncertainty> reported) {
  NewtonRiccati solver(Ocp(looking(view), default_horizon));
  if (!reported.empty()) solver.set_view_uncertainty(reported);
  for (int update = 0; update < 19; ++update) (void)solver.solve(0.0, aside);
  const Solution solution = solver.solve(0.0, aside);
  return {solution.x.begin(), solution.x.end()};
}

/// Off the axis after half a horizon [rad].
double angle_in(const std::vector<double>& plan) {
  const Team team = looking(cone_of(0.0));
  const double* x = &plan[10 * 14];
  const std::array<double, 8> u{};
  const Sight<double> a = team.model(BodyId{0}).sight(x, u.data()),
                      b = team.model(BodyId{1}).sight(x + 7, u.data());
  return view_angle(SensorMount{}, a, b.p);
}

TEST(ViewUncertainty, ThatIsToldIsPlannedWithAsOneThatIsWrittenIn) {
  for (const double sigmas : {0.5, 1.0, 3.0}) {
    const std::vector<double> reported = planned(cone_of(sigmas), std::array{uncertainty, ViewUncertainty{}}),
                              written = planned(WrittenUncertainty{sigmas}, {});
    for (std::size_t i = 0; i < reported.size(); ++i) EXPECT_NEAR(reported[i], written[i], 1e-9) << sigmas;
  }
}

TEST(ViewUncertainty, OfNobodyOrOfAnotherNumberOfBodiesChangesNothing) {
  const std::vector<double> sure = planned(cone_of(0.0), {});
  for (const std::vector<double>& other :
       {planned(cone_of(2.0), {}), planned(cone_of(2.0), std::array{uncertainty}),
        planned(cone_of(0.0), std::array{uncertainty, uncertainty}),
        planned(cone_of(2.0), std::array{ViewUncertainty{}, uncertainty})})
    for (std::size_t i = 0; i < sure.size(); ++i) EXPECT_NEAR(other[i], sure[i], 1e-9);
}

TEST(ViewUncertainty, TheMoreOfItTheNearerTheTargetIsPlannedToTheAxis) {
  const double sure = angle_in(planned(cone_of(0.0), {}));
  double before = sure;
  for (const double sigmas : {1.0, 2.0, 3.0}) {
    const double angle = angle_in(planned(cone_of(sigmas), std::array{uncertainty, ViewUncertainty{}}));
    EXPECT_LT(angle, before) << sigmas;
    before = angle;
  }
  EXPECT_LT(before, 0.9 * sure);
}

}  // namespace
}  // namespace sightline
