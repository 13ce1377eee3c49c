// What is its own; the laws it shares with single shooting are in continuation_test.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {
namespace {

using paper::Variant;

/// The largest defect |x_1 - x_0 - h f(x_0, u_0)| of the first stage, u_0 being that of the
/// prediction.
double first_defect(const Ocp& ocp, const Solution& s) {
  std::vector<double> rate(static_cast<std::size_t>(ocp.nx()));
  Hamiltonian(ocp).flow(s.x.data(), s.raw_u.data(), rate.data());
  double worst = 0.0;
  for (std::size_t i = 0; i < rate.size(); ++i)
    worst = std::max(worst, std::fabs(s.x[rate.size() + i] - s.x[i] - ocp.horizon().h() * rate[i]));
  return worst;
}

TEST(Cmscgmres, AJumpOfTheStateBecomesADefectThatDecaysByOneMinusZetaDtAnUpdate) {
  for (const double zeta : {10.0, 30.0}) {
    Cmscgmres mpc(paper::team(Variant::joint), {}, {.zeta = zeta});
    std::vector<double> x = fly(mpc, paper::start(), 1500);
    x[0] += 0.1;
    std::vector<double> defects;
    fly(
        mpc, x, 6,
        [&](double, const std::vector<double>&, const Solution& s) {
          defects.push_back(first_defect(mpc.ocp(), s));
        },
        15.0);
    EXPECT_NEAR(defects[0], 0.1, 1e-4);  // the prediction is the one before the step
    for (std::size_t k = 0; k + 1 < defects.size(); ++k)
      EXPECT_NEAR(defects[k + 1] / defects[k], 1 - 0.01 * zeta, 0.05) << zeta << ", update " << k;
  }
}

}  // namespace
}  // namespace sightline
