// Two quadrotors: uav0 keeps uav1 in view, [Dentler 2018], (60)-(70); the problem of scenarios/paper_7_1.toml.
#include <cstdio>
#include <sightline/sightline.hpp>
using namespace sightline;

int main() {
  Team team;
  const Circle circle{.centre = {0, 0, 1}, .radius = 0.5, .rate = 0.3};
  const auto uav0 = team.add(Multirotor{}, {.Q = {0, 0, 0, 0, 0, 0.7, 0.7}, .R = {1, 1, 1, 1}});
  const auto uav1 = team.add(Multirotor{}, {.Q = {1.5, 1.5, 1.6, 1, 1}, .R = {1, 1, 1, 1}, .x_ref = circle});
  const Between pair{uav0, uav1};
  team.couple(0.4 * SensorCone{.alpha = 0.5, .kappa_G = 0.01, .kappa_A = 2}, pair, felt_by(uav0));
  team.couple(0.4 * KeepOut{.d_min = 1, .kappa_G = 0.001, .kappa_A = 3}, pair, felt_by(uav0));
  team.couple(0.4 * Cohesion{.d_max = 2, .kappa_G = 0.001, .kappa_A = 3}, pair, felt_by(uav0));
  NewtonRiccati mpc(team, {.T = 1.0, .N = 20, .dt = 0.01});
  Plant plant(team, {-0.6, -0.3, 0.6, 1, 0, 0, 0, /**/ 0, 0, 0.5, 1, 0, 0, 0});
  for (int k = 0; k < 6000; ++k) plant.step(mpc.step(0.01 * k, plant.x()), 0.01);
  for (const double x : plant.x()) std::printf("%.12g\n", x);  // both states after 60 s
}
