// The figures of section 7.1 in closed loop: docs/equations.md, 9, and saturation by 7.4.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/ipopt.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {
namespace {

using paper::Variant;

struct Figures {
  double cost = 0.0;
  double distance_min = 1e9, distance_max = 0.0, angle_max = 0.0;  // from 6 s on
  double in_view_from = 0.0;                                       // the angle stays <= 0.5 rad
  double rms = 0.0;                                                // of uav1, from 10 s on
  double raw_u_max = 0.0, u_max = 0.0;
  double residual_max = 0.0, kkt_max = 0.0;  // from 6 s on
  int converged = 0, stepped = 0, shortened = 0, other = 0;
};

template <class S = Cmscgmres>
Figures fly_paper(const Team& team, std::vector<double> start, int updates,
                  const ContinuationOptions& options = {}) {
  S mpc(team, {}, options);
  Figures f;
  int settled = 0;
  fly(mpc, std::move(start), updates, [&](double t, const std::vector<double>& x, const Solution& s) {
    f.cost += 0.01 * stage_cost(team, t, x, s.u);
    const Sight<double> observer = team.model(paper::uav0).sight(&x[0], &s.u[0]);
    const Sight<double> target = team.model(paper::uav1).sight(&x[7], &s.u[4]);
    const double distance = norm(observer.p - target.p), angle = view_angle({}, observer, target.p);
    if (!(angle <= 0.5)) f.in_view_from = t + 0.01;
    for (const double u : s.raw_u) f.raw_u_max = std::max(f.raw_u_max, std::fabs(u));
    for (const double u : s.u) f.u_max = std::isfinite(u) ? std::max(f.u_max, std::fabs(u)) : 1e9;
    (s.status == Status::converged         ? f.converged
     : s.status == Status::stepped         ? f.stepped
     : s.status == Status::iteration_limit ? f.shortened
                                           : f.other) += 1;
    if (t >= 6.0) {
      f.distance_min = std::min(f.distance_min, distance);
      f.distance_max = std::max(f.distance_max, distance);
      f.angle_max = std::max(f.angle_max, angle);
      f.residual_max = std::max(f.residual_max, s.residual);
      f.kkt_max = std::max(f.kkt_max, mpc.kkt(t, x));
    }
    if (t >= 10.0) {
      const Vec3<double> e = target.p - paper::target_path()(t).p;
      f.rms += dot(e, e);
      ++settled;
    }
  });
  f.rms = std::sqrt(f.rms / std::max(settled, 1));
  return f;
}

TEST(PaperCampaign, MaskedAndJointItLandsOnThePapersFigures) {
  struct Row {
    Variant variant;
    double cost, within, distance_min, distance_max, in_view_from, rms;
  };
  for (const Row& row : {Row{Variant::masked, 79.8, 0.5, 1.43, 1.82, 21.0, 0.070},
                         Row{Variant::joint, 76.8, 0.3, 1.47, 1.81, 7.0, 0.139}}) {
    SCOPED_TRACE(row.variant == Variant::masked ? "masked" : "joint");
    const Figures f = fly_paper(paper::team(row.variant), paper::start(), 6000);
    EXPECT_NEAR(f.cost, row.cost, row.within);
    EXPECT_GE(f.distance_min, row.distance_min);
    EXPECT_LE(f.distance_max, row.distance_max);
    EXPECT_LE(f.in_view_from, row.in_view_from);
    EXPECT_NEAR(f.rms, row.rms, 0.005);
    EXPECT_LE(f.u_max, 1.0);
    EXPECT_EQ(f.raw_u_max, f.u_max) << "no limit is active";
    EXPECT_EQ(f.shortened + f.other, 0);
  }
}

TEST(PaperCampaign, SingleShootingLandsOnTheSameFigures) {
  const Figures joint = fly_paper<Cgmres>(paper::team(Variant::joint), paper::start(), 6000);
  const Figures masked = fly_paper<Cgmres>(paper::team(Variant::masked), paper::start(), 6000);
  EXPECT_NEAR(joint.cost, 76.8, 0.3);
  EXPECT_NEAR(masked.cost, 79.8, 0.5);
  for (const Figures& f : {joint, masked}) {
    EXPECT_LE(f.residual_max, 1e-4);
    EXPECT_EQ(f.raw_u_max, f.u_max) << "no limit is active";
    EXPECT_EQ(f.shortened + f.other, 0);
  }
}

TEST(PaperCampaign, InTheSteadyStateTheOptimalityConditionsHold) {
  for (const Variant variant : {Variant::joint, Variant::masked}) {
    const Figures f = fly_paper(paper::team(variant), paper::start(), 3000);
    EXPECT_LE(f.residual_max, 1e-4);
    EXPECT_LE(f.kkt_max, 5e-3);
    EXPECT_GE(f.converged, 2900);
  }
}

TEST(PaperCampaign, SaturatedItFliesOnWithinItsLimits) {
  const Figures joint = fly_paper(paper::team(Variant::joint), paper::saturating_start(), 1500);
  const Figures masked = fly_paper(paper::team(Variant::masked), paper::saturating_start(), 1500);
  EXPECT_NEAR(joint.cost, 64.7, 0.3);
  EXPECT_NEAR(masked.cost, 64.6, 0.3);
  for (const Figures& f : {joint, masked}) {
    EXPECT_GT(f.u_max, 0.99) << "the limits are active";
    EXPECT_LE(f.u_max, 1.0);
    EXPECT_LE(f.raw_u_max, 1.02);
    EXPECT_EQ(f.shortened + f.other, 0);
  }
}

TEST(PaperCampaign, LimitsNeedNotBeSymmetric) {
  const Figures joint = fly_paper(paper::team(Variant::joint, {-0.4, 0.8}), paper::saturating_start(), 1500);
  const Figures masked =
      fly_paper(paper::team(Variant::masked, {-0.4, 0.8}), paper::saturating_start(), 1500);
  EXPECT_NEAR(joint.cost, 67.89, 0.3);
  EXPECT_NEAR(masked.cost, 67.77, 0.3);
}

TEST(PaperCampaign, AMaskedTargetFliesAsIfAlone) {
  Cmscgmres together(paper::team(Variant::masked), {}), alone(paper::target_alone(), {});
  std::vector<std::vector<double>> path;
  const auto start = paper::start();
  fly(alone, {start.begin() + 7, start.end()}, 6000,
      [&](double, const std::vector<double>& x, const Solution&) { path.push_back(x); });
  double worst = 0.0;
  std::size_t k = 0;
  fly(together, start, 6000, [&](double, const std::vector<double>& x, const Solution&) {
    for (std::size_t i = 0; i < 7; ++i) worst = std::max(worst, std::fabs(x[7 + i] - path[k][i]));
    ++k;
  });
  EXPECT_LE(worst, 1e-8);
}

TEST(PaperCampaign, AnyReasonableZetaFliesTheSame) {
  for (const double zeta : {1.0, 50.0, 100.0, 150.0}) {
    const Figures f = fly_paper(paper::team(Variant::joint), paper::start(), 6000, {.zeta = zeta});
    EXPECT_NEAR(f.cost, 76.8, 0.3) << zeta;
    EXPECT_EQ(f.other, 0) << zeta;
    EXPECT_TRUE(f.shortened == 0 || 0.01 * zeta > 1) << zeta;
  }
}

TEST(PaperCampaign, FewIterationsAreEnough) {
  for (const int k_max : {3, 5, 10}) {
    const Figures f = fly_paper(paper::team(Variant::masked), paper::start(), 6000, {.k_max = k_max});
    EXPECT_NEAR(f.cost, 79.8, 0.5) << k_max;
    EXPECT_EQ(f.shortened + f.other, 0) << k_max;
  }
}

TEST(PaperCampaign, OnceSettledTheInputIsThatOfTheConvergedProblem) {
  const struct {
    Team team;
    std::vector<double> start;
  } cases[] = {{paper::team(Variant::joint), paper::start()},
               {paper::target_alone(), {0, 0, 0.5, 1, 0, 0, 0}}};
  for (const auto& [team, start] : cases) {
    const Ocp ocp(team, {});
    Cmscgmres mpc(ocp);
    IpoptReference reference(ocp);
    std::vector<double> guess(static_cast<std::size_t>(20 * team.nu()));
    int k = 0;
    fly(mpc, start, 2001, [&](double t, const std::vector<double>& x, const Solution& s) {
      if (k++ < 600 || k % 100 != 1) return;
      const Optimum optimum = reference.solve(t, x, guess);
      guess = optimum.u;
      EXPECT_LE(optimum.residual, 1e-7);
      for (std::size_t j = 0; j < s.u.size(); ++j)
        EXPECT_NEAR(s.u[j], optimum.u[j], 2e-3) << t << " s, u" << j;
    });
  }
}

}  // namespace
}  // namespace sightline
