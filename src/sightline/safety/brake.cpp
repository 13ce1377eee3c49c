#include <algorithm>
#include <cassert>
#include <cmath>

#include "sightline/supervisor.hpp"

namespace sightline {

Brake::Brake(const Model& model, std::span<const double> u_ref, double tau)
    : model_(model),
      u_ref_(u_ref.begin(), u_ref.end()),
      trial_(u_ref_),
      rate_(static_cast<std::size_t>(model.nx())),
      soon_(rate_),
      tau_(tau) {
  assert(u_ref_.size() <= inputs_max && "a robot has at most 16 inputs");
}

std::array<double, Brake::rows> Brake::outcome(std::span<const double> x,
                                               std::span<const double> u) noexcept {
  model_.f(x.data(), u.data(), rate_.data());
  for (std::size_t i = 0; i < x.size(); ++i) soon_[i] = x[i] + tau_ * rate_[i];
  const Sight<double> now = model_.sight(x.data(), u.data()), then = model_.sight(soon_.data(), u.data());
  return {then.v.x, then.v.y, then.v.z, (now.d.x * then.d.y - now.d.y * then.d.x) / tau_};
}

void Brake::operator()(std::span<const double> x, const Vec3<double>& velocity, std::span<const double> u_min,
                       std::span<const double> u_max, std::span<double> u, double turn_rate) noexcept {
  const std::size_t nu = u_ref_.size();
  const std::array<double, rows> wanted = {velocity.x, velocity.y, velocity.z, turn_rate},
                                 at_rest = outcome(x, u_ref_);
  std::array<std::array<double, rows>, inputs_max> J;  // columns
  for (std::size_t j = 0; j < nu; ++j) {
    constexpr double step = 1e-3;
    trial_[j] = u_ref_[j] + step;
    J[j] = outcome(x, trial_);
    trial_[j] = u_ref_[j];
    for (std::size_t r = 0; r < rows; ++r) J[j][r] = (J[j][r] - at_rest[r]) / step;
  }
  // (J'J + 1e-9) du = J'(wanted - at_rest), by Cholesky.
  std::array<std::array<double, inputs_max>, inputs_max> A;
  std::array<double, inputs_max> du;
  const auto product = [](const auto& a, const auto& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  };
  std::array<double, rows> missing;
  for (std::size_t r = 0; r < rows; ++r) missing[r] = wanted[r] - at_rest[r];
  for (std::size_t i = 0; i < nu; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double a = product(J[i], J[j]) + (i == j ? 1e-9 : 0.0);
      for (std::size_t k = 0; k < j; ++k) a -= A[i][k] * A[j][k];
      A[i][j] = i == j ? std::sqrt(std::max(a, 1e-12)) : a / A[j][j];
    }
    du[i] = product(J[i], missing);
    for (std::size_t k = 0; k < i; ++k) du[i] -= A[i][k] * du[k];
    du[i] /= A[i][i];
  }
  for (std::size_t i = nu; i-- > 0;) {
    for (std::size_t k = i + 1; k < nu; ++k) du[i] -= A[k][i] * du[k];
    du[i] /= A[i][i];
    const double next = u_ref_[i] + du[i];
    u[i] = std::isfinite(next) ? std::clamp(next, u_min[i], u_max[i])
                               : std::clamp(u_ref_[i], u_min[i], u_max[i]);
  }
}

}  // namespace sightline
