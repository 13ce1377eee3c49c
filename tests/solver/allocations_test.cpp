// An update takes nothing from the heap: counted, not believed.
#include "cli/allocations.hpp"

#include <gtest/gtest.h>

#include <array>

#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using paper::Variant;

/// Calls of the heap by f; zero where the build does not count.
template <class F>
std::int64_t counted(F&& f) {
  const std::int64_t before = cli::allocations();
  f();
  return cli::allocations() - before;
}

TEST(Allocations, TheCounterSeesWhatASolverIsMadeOf) {
  const std::int64_t one = cli::counts_allocations() ? 1 : 0;
  EXPECT_EQ(counted([] {}), 0);
  EXPECT_EQ(counted([] { Rows(3, 3); }), one);
  EXPECT_GE(counted([] { Cmscgmres(paper::target_alone(), {}); }), 10 * one);
}

template <class S>
class AllocationsOf : public testing::Test {};

using Continuations = testing::Types<Cmscgmres, Cgmres>;
TYPED_TEST_SUITE(AllocationsOf, Continuations);

TYPED_TEST(AllocationsOf, NoUpdateTakesMemoryFromTheFirstOnHoweverItEnds) {
  for (const JacobianProduct product : {JacobianProduct::exact, JacobianProduct::forward_difference}) {
    for (const Variant variant : {Variant::joint, Variant::masked}) {
      TypeParam mpc(paper::team(variant), {}, {.jacobian = product});
      std::vector<double> x = paper::saturating_start(), bad(14, not_a_number), huge = x;
      huge[0] = 1e200;
      std::array<bool, status_count> seen{};
      double t = 0.0;
      const auto update = [&](std::span<const double> states) {
        Status status{};
        EXPECT_EQ(counted([&] { status = mpc.solve(t, states).status; }), 0);
        seen[static_cast<std::size_t>(status)] = true;
      };
      for (int k = 0; k < 300; ++k, t += 0.01) {
        update(x);
        if (k % 100 == 50) update(bad);
        if (k % 100 == 60) update(huge);
        if (k % 100 == 70) update({});
        if (k == 150) mpc.restart();
        if (k == 200) t = 0.0;
        const auto u = mpc.step(t, x);
        advance(mpc.ocp().team(), x, u, 0.01);
      }
      EXPECT_EQ(counted([&] { (void)mpc.kkt(t, x); }), 0);
      for (const Status status :
           {Status::converged, Status::stepped, Status::not_finite, Status::invalid_state})
        EXPECT_TRUE(seen[static_cast<std::size_t>(status)]) << to_string(status) << " was not met";
    }
  }
}

TEST(Allocations, NoNewtonUpdateTakesMemoryHoweverItEnds) {
  for (const Variant variant : {Variant::joint, Variant::masked}) {
    NewtonRiccati mpc(paper::team(variant), {}), hurried(paper::team(variant), {}, {.deadline = 1e-9});
    std::vector<double> x = paper::saturating_start(), bad(14, not_a_number), huge = x, far = x;
    huge[0] = 1e200;
    far[0] = 40.0, far[7] = -40.0;
    std::array<bool, status_count> seen{};
    const auto update = [&](NewtonRiccati& solver, double t, std::span<const double> states) {
      Status status{};
      EXPECT_EQ(counted([&] { status = solver.solve(t, states).status; }), 0);
      seen[static_cast<std::size_t>(status)] = true;
    };
    for (int k = 0; k < 100; ++k) {
      const double t = 0.01 * k;
      update(mpc, t, x);
      advance(mpc.ocp().team(), x, mpc.step(t, x), 0.01);
      if (k % 20 == 5) update(mpc, t, bad);
      if (k % 20 == 10) update(mpc, t, huge);
      if (k % 20 == 15) update(mpc, t, far);
      if (k % 20 == 18) update(hurried, t, x);
    }
    std::vector<double> u(8);
    const auto take_stage = [&](int k) { mpc.plan(k, u), hurried.set_plan(k, u); };
    EXPECT_EQ(counted([&] { take_stage(3); }), 0);
    EXPECT_EQ(counted([&] { (void)mpc.kkt(1.0, x); }), 0);
    for (int k = 0; k < status_count; ++k)
      EXPECT_TRUE(seen[static_cast<std::size_t>(k)]) << to_string(Status(k));
  }
}

TEST(Allocations, GmresTakesNoneAfterItWasMade) {
  const int n = 100;
  Gmres gmres(n, 30);
  Rows rows(2, gmres.length());
  for (const double scale : {1.0, 0.0, not_a_number}) {
    for (int i = 0; i < n; ++i) rows[0][i] = scale * i;
    const auto product = [&](const double* v, double* out) {
      for (int i = 0; i < n; ++i) out[i] = (1.0 + 0.1 * i) * v[i];
    };
    EXPECT_EQ(counted([&] { gmres.solve(product, rows[0], rows[1], 1e-8); }), 0);
  }
}

}  // namespace
}  // namespace sightline
