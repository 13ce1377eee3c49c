#include <gtest/gtest.h>

#include "sightline/base.hpp"
#include "sightline/kernels.hpp"

// GCC 12 mistakes the masks of its own intrinsics for a fault.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <Eigen/Dense>

#include "sightline/formula.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/difference.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

int size_of(const std::vector<Block>& blocks) {
  int n = 0;
  for (const Block& b : blocks) n += b.size;
  return n;
}

/// Where a block begins.
int place(const std::vector<Block>& blocks, std::string_view name) {
  int n = 0;
  for (const Block& b : blocks) {
    if (b.name == name) return n;
    n += b.size;
  }
  ADD_FAILURE() << "no block " << name;
  return 0;
}

/// Phi of a stage in extended precision, by the model's struct itself.
template <RobotModel M>
struct Phi {
  M model;
  Seen seen;
  std::vector<double> x_ref, weights, lambda, gradient, Hessian;
  std::vector<double> s_0;  // potentials are quadratic in s around here

  Wide operator()(const std::vector<Wide>& z) const {
    std::array<Wide, M::nx> x;
    std::array<Wide, M::nu> u;
    for (int i = 0; i < M::nx; ++i) x[at(i)] = z[at(i)];
    for (int i = 0; i < M::nu; ++i) u[at(i)] = z[at(M::nx + i)];
    const auto f = model.f(x, u);
    std::array<Wide, sight_size> s;
    write_sight(sight(model, x, u), s);
    Wide phi = 0.0;
    for (int i = 0; i < M::nx; ++i) {
      const Wide e = x[at(i)] - x_ref[at(i)];
      phi =
          phi + 0.5 * weights[at(i)] * (e * e) + lambda[at(i)] * (x[at(i)] + default_horizon.h() * f[at(i)]);
    }
    for (int i = 0; i < M::nu; ++i) {
      const Wide e = u[at(i)] - weights[at(M::nx + M::nu + i)];
      phi = phi + 0.5 * weights[at(M::nx + i)] * (e * e);
    }
    const int ns = seen_size(seen);
    for (int i = 0; i < ns; ++i) {
      phi = phi + gradient[at(i)] * s[at(i)];
      for (int j = 0; j < ns; ++j) {
        const double entry = Hessian[at(upper_index(std::min(i, j), std::max(i, j), ns))];
        phi = phi + 0.5 * entry * ((s[at(i)] - s_0[at(i)]) * (s[at(j)] - s_0[at(j)]));
      }
    }
    return phi;
  }
};

/// One stage by dense linear algebra from differences of Phi, against the traced program.
template <RobotModel M>
void expect_stage_is_the_dense_one(const M& model, Seen seen, Random& random) {
  constexpr int nx = M::nx, nu = M::nu;
  std::vector<double> scales(at(nu));
  for (double& s : scales) s = uniform(random, 0.4, 2);
  const StagePrograms programs = trace_stage(model, default_horizon.h(), seen, {}, scales);
  const BlockProgram& back = programs.back;
  std::vector<double> in(at(size_of(back.inputs)));
  for (double& v : in) v = uniform(random, -1, 1);
  const int P_at = place(back.inputs, "carry") + 1 + 2 * nx;
  for (int i = 0; i < nx; ++i) in[at(P_at + upper_index(i, i, nx))] += 4.0;
  for (int a = 0; a < nu; ++a) in[at(place(back.inputs, "held") + a)] = a == 1 ? infinity : 0.0;
  const int weights_at = place(back.inputs, "weights");
  for (int i = 0; i < nu; ++i) in[at(weights_at + nx + i)] = 5.0;
  in[at(weights_at + nx + 2 * nu)] = 0.1;
  in[at(place(back.inputs, "carry"))] = 0.0;
  const int ns = programs.sizes.ns, c_at = place(back.inputs, "coupling");
  for (int i = 0; i < ns * (ns + 1) / 2; ++i) in[at(c_at + ns + i)] *= 0.02;
  for (int i = 5; seen == Seen::leaning && i < 8; ++i)
    for (int j = 8; j < ns; ++j) in[at(c_at + ns + upper_index(i, j, ns))] = 0.0;
  const auto part = [&](int from, int n) {
    return std::vector<double>(in.begin() + from, in.begin() + from + n);
  };
  const int carry_at = place(back.inputs, "carry");
  std::array<double, M::nx> x_here;
  std::array<double, M::nu> u_here;
  std::copy_n(in.begin(), nx, x_here.begin());
  std::copy_n(in.begin() + nx, nu, u_here.begin());
  std::vector<double> s_0(at(sight_size));
  write_sight(sight(model, x_here, u_here), s_0);
  const Phi<M> phi{model,
                   seen,
                   part(place(back.inputs, "x_ref"), nx),
                   part(weights_at, programs.sizes.weights()),
                   part(carry_at + 1, nx),
                   part(c_at, ns),
                   part(c_at + ns, ns * (ns + 1) / 2),
                   s_0};

  Eigen::MatrixXd W(nx + nu, nx + nu), F(nx, nx + nu), P(nx, nx);
  Eigen::VectorXd g(nx + nu), e(nx);
  CentralDifference d(phi, std::span<const double>(in).first(at(nx + nu)));
  for (int i = 0; i < nx + nu; ++i) {
    g(i) = d.first(at(i));
    for (int j = 0; j <= i; ++j) W(i, j) = W(j, i) = d.second(at(i), at(j));
  }
  for (int row = 0; row < nx; ++row) {
    const auto flow = [&](const std::vector<Wide>& z) {
      std::array<Wide, M::nx> x;
      std::array<Wide, M::nu> u;
      std::copy_n(z.begin(), nx, x.begin());
      std::copy_n(z.begin() + nx, nu, u.begin());
      return x[at(row)] + default_horizon.h() * model.f(x, u)[at(row)];
    };
    CentralDifference slope(flow, std::span<const double>(in).first(at(nx + nu)));
    for (int j = 0; j < nx + nu; ++j) F(row, j) = slope.first(at(j));
  }
  for (int i = 0; i < nx; ++i) {
    e(i) = in[at(carry_at + 1 + nx + i)];
    for (int j = i; j < nx; ++j) P(i, j) = P(j, i) = in[at(P_at + upper_index(i, j, nx))];
  }
  // Input 1 is held: no row, no column.
  const double rho = in[at(weights_at + nx + 2 * nu)];
  Eigen::MatrixXd A = F.leftCols(nx), B = F.rightCols(nu), G = W.bottomLeftCorner(nu, nx);
  Eigen::MatrixXd R = W.bottomRightCorner(nu, nu);
  for (int i = 0; i < nu; ++i) R(i, i) += rho / (scales[at(i)] * scales[at(i)]);
  Eigen::VectorXd r = g.tail(nu);
  const Eigen::MatrixXd B_free = B;
  B.col(1).setZero();
  G.row(1).setZero();
  R.row(1).setZero();
  R.col(1).setZero();
  R(1, 1) = 1.0;
  r(1) = 0.0;
  const Eigen::MatrixXd M_uu = R + B.transpose() * P * B, M_ux = G + B.transpose() * P * A;
  const Eigen::VectorXd M_u = r + B.transpose() * e;
  const Eigen::MatrixXd K = M_uu.ldlt().solve(M_ux);
  const Eigen::VectorXd k = M_uu.ldlt().solve(M_u);
  const Eigen::MatrixXd P_0 = W.topLeftCorner(nx, nx) + A.transpose() * P * A - M_ux.transpose() * K;
  const Eigen::VectorXd e_0 = A.transpose() * e - M_ux.transpose() * k;

  const std::vector<double> out = evaluate(back.program, in);
  const auto expect = [&](double got, double wanted, const char* what, int i, int j) {
    EXPECT_LE(relative_error(got, wanted), 2e-9) << what << " " << i << " " << j;
  };
  const int H_at = place(back.outputs, "H_u"), gain_at = place(back.outputs, "gain");
  const int k_at = place(back.outputs, "k"), out_at = place(back.outputs, "carry_out");
  EXPECT_LE(out[at(out_at)], 0.0);
  for (int a = 0; a < nu; ++a) {
    expect(out[at(H_at + a)], g(nx + a), "H_u", a, 0);
    // An input that moves one state alone is measured in what it moves.
    const double unit = (B_free.col(a).array().abs() > 1e-9).count() == 1 ? B_free.col(a).sum() : 1.0;
    expect(out[at(k_at + a)], unit * k(a), "k", a, 0);
    for (int j = 0; j < nx; ++j)
      expect(out[at(gain_at + nu + nu * (nu - 1) / 2 + j * nu + a)], unit * K(a, j), "K", a, j);
  }
  for (int i = 0; i < nx; ++i) {
    expect(out[at(out_at + 1 + i)], g(i), "lambda", i, 0);
    expect(out[at(out_at + 1 + nx + i)], e_0(i), "e", i, 0);
    for (int j = i; j < nx; ++j)
      expect(out[at(out_at + 1 + 2 * nx + upper_index(i, j, nx))], P_0(i, j), "P", i, j);
  }
}

TEST(Stage, TheTracedRecursionIsTheDenseOne) {
  Random random(1);
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion, Seen::leaning, Seen::all}) {
    for (int trial = 0; trial < 5; ++trial) {
      expect_stage_is_the_dense_one(Multirotor{}, seen, random);
      expect_stage_is_the_dense_one(AngleMultirotor{}, seen, random);
      expect_stage_is_the_dense_one(OmniRover{}, seen, random);
      expect_stage_is_the_dense_one(Unicycle{}, seen, random);
      expect_stage_is_the_dense_one(PointMass{.drag = 0.31}, seen, random);
      expect_stage_is_the_dense_one(VelocityMultirotor{}, seen, random);
      expect_stage_is_the_dense_one(VelocityMultirotor{.frame = VelocityFrame::level}, seen, random);
      expect_stage_is_the_dense_one(HoverMultirotor{}, seen, random);
      expect_stage_is_the_dense_one(LaggingHoverMultirotor{}, seen, random);
    }
  }
}

/// Numbers that often meet each other, h, 1 and their reciprocals, with either sign; never zero.
double any_number(Random& random) {
  const std::array few = {1.0, 2.0, 0.5, 0.05, 20.0, 0.1};
  const double number = random() % 2 == 0 ? few[random() % few.size()] : uniform(random, 0.001, 30);
  return random() % 4 == 0 ? -number : number;
}

double a_positive(Random& random) { return std::abs(any_number(random)); }

/// The programs of a model at random parameters and stage lengths are one, but for their constants.
template <class Draw>
void expect_one_structure(Draw&& draw) {
  Random random(7);
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion, Seen::leaning, Seen::all}) {
    const StagePrograms first = trace_stage(draw(random), default_horizon.h(), seen);
    for (int trial = 0; trial < 200; ++trial) {
      const StagePrograms other = trace_stage(draw(random), std::abs(any_number(random)), seen);
      ASSERT_EQ(structure(other), structure(first)) << trial;
      ASSERT_EQ(other.sizes, first.sizes);
    }
  }
}

TEST(Stage, NoParameterAndNoStageLengthChangesTheStructureOfAModel) {
  expect_one_structure([](Random& r) {
    return Multirotor{any_number(r), any_number(r), any_number(r),
                      any_number(r), any_number(r), any_number(r)};
  });
  expect_one_structure([](Random& r) {
    return AngleMultirotor{any_number(r), any_number(r), any_number(r),
                           any_number(r), any_number(r), any_number(r)};
  });
  expect_one_structure([](Random& r) {
    return OmniRover{any_number(r), any_number(r), any_number(r), any_number(r), any_number(r)};
  });
  expect_one_structure([](Random& r) { return Unicycle{any_number(r), any_number(r), any_number(r)}; });
  expect_one_structure([](Random& r) { return PointMass{a_positive(r)}; });
  expect_one_structure([](Random& r) {
    return VelocityMultirotor{a_positive(r), a_positive(r), a_positive(r), a_positive(r)};
  });
  expect_one_structure([](Random& r) {
    return VelocityMultirotor{a_positive(r),       a_positive(r), a_positive(r), a_positive(r), 1, 1, 1,
                              VelocityFrame::level};
  });
  expect_one_structure([](Random& r) {
    return HoverMultirotor{any_number(r), any_number(r), any_number(r),
                           any_number(r), any_number(r), any_number(r)};
  });
  expect_one_structure([](Random& r) {
    return LaggingHoverMultirotor{any_number(r), any_number(r), any_number(r), any_number(r), any_number(r),
                                  any_number(r), a_positive(r), a_positive(r), a_positive(r)};
  });
  expect_one_structure([](Random& r) {
    return LaggedMultirotor<Lags::climb>{a_positive(r), a_positive(r), a_positive(r)};
  });
}

TEST(Stage, AMultirotorUnderVelocityCommandsWithoutFurtherLagsIsOneOfEquation24) {
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion}) {
    EXPECT_EQ(structure(trace_stage(LaggedMultirotor<Lags::plane>{}, default_horizon.h(), seen)),
              structure(trace_stage(Multirotor{}, default_horizon.h(), seen)));
  }
}

TEST(Stage, NoParameterOfABarrierChangesTheStructure) {
  Random random(8);
  const auto positive = [&] { return std::abs(any_number(random)); };
  const auto of = [&](const Limit& limit) {
    return structure(trace_stage(Multirotor{}, positive(), Seen::pose,
                                 std::array{RelaxedBarrier{limit, positive(), positive()}}));
  };
  const auto speed = of(SpeedLimit{}), disc = of(InputDisc{});
  EXPECT_NE(speed, disc);
  for (int trial = 0; trial < 200; ++trial) {
    ASSERT_EQ(of(SpeedLimit{positive()}), speed);
    ASSERT_EQ(of(InputDisc{positive()}), disc);
  }
}

TEST(Stage, AParameterOfZeroIsOfAnotherShape) {
  const auto of = [](const Model& model) {
    return structure(trace_stage(model, default_horizon.h(), Seen::pose));
  };
  EXPECT_NE(of(PointMass{}), of(PointMass{.drag = 0.1}));
  EXPECT_NE(of(Multirotor{}), of(Multirotor{.a_f = 0.0}));
  EXPECT_NE(of(Multirotor{}), of(AngleMultirotor{}));
}

/// A unit is c (1/c), which is 1 for some c alone; as a number it made the structure one of its
/// value.
TEST(Stage, AnInputThatMovesOneStateIsAColumnOfTheIdentityAtEveryStageLength) {
  Random random(9);
  for (int trial = 0; trial < 200; ++trial) {
    const double length = uniform(random, 0.001, 0.2), tau = uniform(random, 0.05, 3);
    const StagePrograms p = trace_stage(VelocityMultirotor{tau, tau, tau, tau}, length, Seen::pose);
    std::vector<double> in(at(size_of(p.precondition_forward.inputs)), 0.0);
    const int k_at = place(p.precondition_forward.inputs, "k");
    for (int a = 0; a < 4; ++a) in[at(k_at + a)] = -1.0;
    const std::vector<double> out = evaluate(p.precondition_forward.program, in);
    const int du_at = place(p.precondition_forward.outputs, "du"),
              y_at = place(p.precondition_forward.outputs, "y_out");
    for (int a = 0; a < 4; ++a) {
      EXPECT_LE(relative_error(out[at(du_at + a)], tau / length), 1e-15);
      EXPECT_EQ(out[at(y_at + 5 + a)], 1.0);
    }
  }
}

}  // namespace
}  // namespace sightline
