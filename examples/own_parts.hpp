// A robot, a potential and a reference of one's own that scenarios call by name; each says its parameters itself.
#pragma once

#include <sightline/kernels.hpp>
#include <sightline/potential.hpp>

/// A blimp that its propellers push forward and up, and turn; x = [p, d, v_f, v_z], u = [u_f, u_z, u_psi].
struct Blimp {
  static constexpr int nx = 7, nu = 3;
  static constexpr std::string_view name = "blimp";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "d_x",
                                                              "d_y", "v_f", "v_z"};
  static constexpr int heading_at = 3;  // (d_x, d_y) is a direction, and stays of length 1

  double thrust = 0.8, drag = 0.5, turn = 0.7;

  static constexpr auto parameters() {
    using sightline::parameter, sightline::Parameters, sightline::above_zero, sightline::from_zero;
    return Parameters{parameter("thrust", &Blimp::thrust, "m/s^2", above_zero, "acceleration per command"),
                      parameter("drag", &Blimp::drag, "1/s", from_zero, "how fast it slows down by itself"),
                      parameter("turn", &Blimp::turn, "rad/s", above_zero, "yaw rate per command")};
  }
  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const S rate = turn * u[2];
    return {x[5] * x[3],
            x[5] * x[4],
            x[6],
            -(x[4] * rate),
            x[3] * rate,
            thrust * u[0] - drag * x[5],
            thrust * u[1] - drag * x[6]};
  }
  template <class S>
  sightline::Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }
  std::array<double, nx> at_rest(const sightline::Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y};
  }
};

/// Draws two robots to a distance of each other: l = kappa (D^2 / d^2 - 1)^2.
struct Halo {
  double d = 2.0, kappa = 1.0;

  static constexpr std::string_view name = "halo", limit_unit = "m";
  static constexpr auto parameters() {
    using sightline::parameter, sightline::Parameters, sightline::above_zero;
    return Parameters{parameter("d", &Halo::d, "m", above_zero, "distance to keep"),
                      parameter("kappa", &Halo::kappa, "", above_zero, "cost at no distance")};
  }
  template <class S>
  S operator()(const sightline::Sight<S>& a, const sightline::Sight<S>& b) const {
    const sightline::Vec3<S> r = a.p - b.p;
    const S off = (1.0 / (d * d)) * (r.x * r.x + r.y * r.y + r.z * r.z) - 1.0;
    return kappa * off * off;
  }
  /// Further off than half of d [m].
  double violation(const sightline::Sight<double>& a, const sightline::Sight<double>& b) const {
    return std::fabs(norm(a.p - b.p) - d) - 0.5 * d;
  }
};

/// A figure eight at constant height; the heading is free.
struct FigureEight {
  static constexpr std::string_view name = "figure_eight";
  sightline::Vec3<double> centre{};
  double size = 2.0, rate = 0.3;

  static constexpr auto parameters() {
    using namespace sightline;
    return Parameters{needed(parameter("centre", &FigureEight::centre, "m", any_finite, "where it crosses")),
                      parameter("size", &FigureEight::size, "m", above_zero, "from the middle to an end"),
                      parameter("rate", &FigureEight::rate, "rad/s", any_finite, "how fast it goes round")};
  }
  sightline::Pose<double> operator()(double t) const {
    const double s = std::sin(rate * t), c = std::cos(rate * t);
    return {{centre.x + size * s, centre.y + size * s * c, centre.z}, {0.0, 0.0}};
  }
};

/// What `sightline_add_formulas(TARGET own_parts.hpp)` compiles; without that line it is interpreted.
inline void sightline_formulas(sightline::Generator& generator) {
  using namespace sightline;
  generator.add(Blimp{}, Seen::pose);
  generator.add({1.0 * Halo{}});
}
