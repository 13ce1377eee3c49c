#include "benchmark/controllers/gauss_newton.hpp"

#include <algorithm>
#include <cmath>

namespace sightline::benchmark {
namespace {

/// H with the rows and columns of fixed inputs replaced by those of the identity.
Mat<nu, nu> of_free(const Mat<nu, nu>& H, const std::array<bool, nu>& free) {
  Mat<nu, nu> reduced = identity<nu>();
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nu; ++j)
      if (free[at(i)] && free[at(j)]) reduced(i, j) = H(i, j);
  return reduced;
}

}  // namespace

bool minimise_within(const Mat<nu, nu>& H, const Mat<nu, 1>& g, const Input& low, const Input& high,
                     Mat<nu, 1>& d, std::array<bool, nu>& free) noexcept {
  constexpr int passes = 12;
  d = {};
  for (std::size_t i = 0; i < nu; ++i) d(static_cast<int>(i), 0) = std::clamp(0.0, low[i], high[i]);
  for (int pass = 0; pass < passes; ++pass) {
    const Mat<nu, 1> slope = H * d + g;
    for (int i = 0; i < nu; ++i)
      free[at(i)] =
          !((d(i, 0) <= low[at(i)] && slope(i, 0) > 0) || (d(i, 0) >= high[at(i)] && slope(i, 0) < 0));
    const Cholesky<nu> factor(of_free(H, free));
    if (!factor.positive) return false;
    Mat<nu, 1> right;
    for (int i = 0; i < nu; ++i) right(i, 0) = free[at(i)] ? -slope(i, 0) : 0.0;
    const Mat<nu, 1> way = factor.solve(right);
    // The longest step along the projected way that lowers the value; 1 if no limit is met.
    const auto value = [&](const Mat<nu, 1>& v) {
      double sum = 0.0;
      const Mat<nu, 1> Hv = H * v;
      for (int i = 0; i < nu; ++i) sum += v(i, 0) * (0.5 * Hv(i, 0) + g(i, 0));
      return sum;
    };
    const double before = value(d);
    Mat<nu, 1> best = d;
    for (double step = 1.0; step > 1e-3; step *= 0.5) {
      Mat<nu, 1> tried = d + step * way;
      for (int i = 0; i < nu; ++i) tried(i, 0) = std::clamp(tried(i, 0), low[at(i)], high[at(i)]);
      if (!(value(tried) < before)) continue;
      best = tried;
      break;
    }
    if (best == d) return true;
    d = best;
  }
  return true;
}

GaussNewton::GaussNewton(const VelocityLoop& robot, const Horizon& horizon)
    : robot_(&robot),
      h_(horizon.h()),
      x_(at(horizon.N + 1)),
      x_tried_(x_),
      u_(at(horizon.N)),
      u_tried_(u_),
      stages_(at(horizon.N)) {}

void GaussNewton::restart() noexcept { std::fill(u_.begin(), u_.end(), Input{}); }

State GaussNewton::next(const State& x, const Input& u) const noexcept {
  State y = robot_->rate(x.data(), u);
  for (std::size_t i = 0; i < nx; ++i) y[i] = x[i] + h_ * y[i];
  return y;
}

double GaussNewton::roll(const StageCost& cost, std::vector<State>& x,
                         const std::vector<Input>& u) const noexcept {
  double sum = 0.0;
  for (std::size_t k = 0; k < u.size(); ++k) {
    x[k + 1] = next(x[k], u[k]);
    for (const double r : cost(static_cast<int>(k), x[k], u[k], x[k + 1])) sum += r * r;
  }
  return sum;
}

void GaussNewton::linearise(int k, const StageCost& cost, Stage& stage) const noexcept {
  constexpr double step = 1e-6;
  const State& x = x_[at(k)];
  const Input& u = u_[at(k)];
  const State& y = x_[at(k + 1)];
  const Residuals r = cost(k, x, u, y);
  for (int i = 0; i < residuals_max; ++i) stage.r(i, 0) = r[at(i)];
  for (int j = 0; j < nz; ++j) {
    State x_j = x;
    Input u_j = u;
    (j < nx ? x_j[at(j)] : u_j[at(j - nx)]) += step;
    const State y_j = next(x_j, u_j);
    const Residuals r_j = cost(k, x_j, u_j, y_j);
    for (int i = 0; i < residuals_max; ++i) stage.J(i, j) = (r_j[at(i)] - r[at(i)]) / step;
    for (int i = 0; i < nx; ++i)
      (j < nx ? stage.A(i, j) : stage.B(i, j - nx)) = (y_j[at(i)] - y[at(i)]) / step;
  }
}

bool GaussNewton::sweep(const Input& u_min, const Input& u_max) noexcept {
  Mat<nx, nx> P;
  Mat<nx, 1> p;
  for (std::size_t k = stages_.size(); k-- > 0;) {
    Stage& s = stages_[k];
    const Mat<nz, nz> H = transposed(s.J) * s.J;
    const Mat<nz, 1> g = transposed(s.J) * s.r;
    const Mat<nx, nx> AP = transposed(s.A) * P;
    const Mat<nu, nx> BP = transposed(s.B) * P;
    const Mat<nx, nx> xx = block<nx, nx>(H, 0, 0) + AP * s.A;
    const Mat<nu, nx> ux = block<nu, nx>(H, nx, 0) + BP * s.A;
    const Mat<nu, nu> uu = block<nu, nu>(H, nx, nx) + BP * s.B;
    const Mat<nx, 1> x = block<nx, 1>(g, 0, 0) + transposed(s.A) * p;
    const Mat<nu, 1> u = block<nu, 1>(g, nx, 0) + transposed(s.B) * p;

    Input low, high;
    for (std::size_t i = 0; i < nu; ++i) low[i] = u_min[i] - u_[k][i], high[i] = u_max[i] - u_[k][i];
    std::array<bool, nu> free{};
    if (!minimise_within(uu, u, low, high, s.change, free)) return false;
    const Cholesky<nu> factor(of_free(uu, free));
    if (!factor.positive) return false;
    Mat<nu, nx> right;
    for (int i = 0; i < nu; ++i)
      for (int j = 0; j < nx; ++j) right(i, j) = free[at(i)] ? -ux(i, j) : 0.0;
    s.gain = factor.solve(right);

    P = xx + transposed(s.gain) * (uu * s.gain) + transposed(s.gain) * ux + transposed(ux) * s.gain;
    p = x + transposed(s.gain) * (uu * s.change) + transposed(s.gain) * u + transposed(ux) * s.change;
    make_symmetric(P);
  }
  return true;
}

Status GaussNewton::update(const double* x, const StageCost& cost, const Input& u_min, const Input& u_max,
                           int steps) noexcept {
  std::copy_n(x, nx, x_.front().begin());
  for (Input& u : u_)
    for (std::size_t i = 0; i < nu; ++i) u[i] = std::clamp(u[i], u_min[i], u_max[i]);
  value_ = roll(cost, x_, u_);
  bool fell = true;
  for (int step = 0; step < steps; ++step) {
    for (std::size_t k = 0; k < u_.size(); ++k) linearise(static_cast<int>(k), cost, stages_[k]);
    if (!std::isfinite(value_) || !sweep(u_min, u_max)) {
      restart();
      return Status::not_finite;
    }
    fell = false;
    for (double share = 1.0; share > 1e-2 && !fell; share *= 0.5) {
      x_tried_.front() = x_.front();
      double sum = 0.0;
      for (std::size_t k = 0; k < u_.size(); ++k) {
        const Stage& s = stages_[k];
        Mat<nx, 1> off;
        for (int i = 0; i < nx; ++i) off(i, 0) = x_tried_[k][at(i)] - x_[k][at(i)];
        const Mat<nu, 1> change = share * s.change + s.gain * off;
        for (std::size_t i = 0; i < nu; ++i)
          u_tried_[k][i] = std::clamp(u_[k][i] + change(static_cast<int>(i), 0), u_min[i], u_max[i]);
        x_tried_[k + 1] = next(x_tried_[k], u_tried_[k]);
        for (const double r : cost(static_cast<int>(k), x_tried_[k], u_tried_[k], x_tried_[k + 1]))
          sum += r * r;
      }
      if (!(sum < value_)) continue;
      fell = true, value_ = sum;
      std::swap(x_, x_tried_), std::swap(u_, u_tried_);
    }
    if (!fell) break;
  }
  return fell ? Status::stepped : Status::iteration_limit;
}

}  // namespace sightline::benchmark
