// Sensor tracking with two quadrotors, [Dentler 2018], (60)-(70), in the words of scenarios/paper_7_1.toml.
#include <cmath>
#include <cstdio>
#include <sightline/sightline.hpp>
using namespace sightline;

std::array<double, 7> circle(double t) {
  return {0.5 * std::cos(0.3 * t), 0.5 * std::sin(0.3 * t), 1, 0, 0, 0, 0};
}

int main() {
  Team team;
  const auto uav0 = team.add(Multirotor{}, {.Q = {0, 0, 0, 0, 0, 0.7, 0.7}, .R = {1, 1, 1, 1}});
  const auto uav1 = team.add(Multirotor{}, {.Q = {1.5, 1.5, 1.6, 1, 1}, .R = {1, 1, 1, 1}, .x_ref = circle});

  const Between pair{uav0, uav1};
  const auto feels = felt_by(uav0);
  team.couple(0.4 * SensorCone{.alpha = 0.5, .kappa_G = 0.01, .kappa_A = 2}, pair, feels);
  team.couple(0.4 * KeepOut{.d_min = 1, .kappa_H = 4.5, .kappa_G = 0.001, .kappa_A = 3}, pair, feels);
  team.couple(0.4 * Cohesion{.d_max = 2, .kappa_H = 1.5, .kappa_G = 0.001, .kappa_A = 3}, pair, feels);

  NewtonRiccati mpc(team, {.T = 1.0, .N = 20, .dt = 0.01});
  Plant plant(team, {-0.6, -0.3, 0.6, 1, 0, 0, 0, /**/ 0, 0, 0.5, 1, 0, 0, 0});

  for (int k = 0; k < 6000; ++k) plant.step(mpc.step(0.01 * k, plant.x()), 0.01);
  for (const double x : plant.x()) std::printf("%.12g\n", x);  // both robots' states after 60 s
}
