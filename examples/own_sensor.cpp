// A sensor of one's own as text, in the words of scenarios/sensors: uav0 keeps uav1 before its sonar.
#include <cmath>
#include <cstdio>
#include <sightline/sightline.hpp>
using namespace sightline;

std::array<double, 7> circle(double t) {
  return {0.5 * std::cos(0.3 * t), 0.5 * std::sin(0.3 * t), 1, 0, 0, 0, 0};
}

int main() {
  const Region sonar =
      Region(all_of({"bearing < half_angle", "0.3 m < range < 4 m"}), {{"half_angle", "25 deg"}})
          .slope(Softplus{.kappa_G = 1, .kappa_H = 0})
          .sigmoid(8)
          .seen_from({.pitch = 0.5, .offset = 0.17});

  Team team;
  const auto uav0 = team.add(Multirotor{}, {.Q = {0, 0, 0, 0, 0, 0.7, 0.7}, .R = {1, 1, 1, 1}});
  const auto uav1 = team.add(Multirotor{}, {.Q = {1.5, 1.5, 1.6, 1, 1}, .R = {1, 1, 1, 1}, .x_ref = circle});
  team.couple(0.4 * sonar, {uav0, uav1}, felt_by(uav0));
  team.couple(0.4 * KeepOut{.d_min = 1}, {uav0, uav1}, felt_by(uav0));

  NewtonRiccati mpc(team, {.T = 1.0, .N = 20, .dt = 0.01});
  Plant plant(team, {-0.6, -0.3, 0.6, 1, 0, 0, 0, /**/ 0, 0, 0.5, 1, 0, 0, 0});

  std::span<const double> u;
  for (int k = 0; k < 3000; ++k) plant.step(u = mpc.step(0.01 * k, plant.x()), 0.01);
  const auto sight = [&](AgentId uav) {
    return team.model(uav).sight(plant.x().data() + team.state_offset(uav),
                                 u.data() + team.input_offset(uav));
  };
  std::printf("after 30 s: %s\n", sonar.violation(sight(uav0), sight(uav1), 30) <= 0 ? "in view" : "lost");
}
