// A multirotor keeps a boat in view, a robot that the library does not know, while the boat rounds its buoys.
#include "own_robot.hpp"

#include <cstdio>
#include <sightline/sightline.hpp>
using namespace sightline;

int main() {
  Team team;
  const Circle buoys = {.centre = {0, 0, 0}, .radius = 4, .rate = 0.2};
  const auto boat = team.add(Boat{}, {.Q = {1, 1}, .R = {0.1, 0.1}, .x_ref = buoys, .name = "boat"});
  const auto uav = team.add(Multirotor{}, {.R = {0.2, 0.2, 0.2, 0.2}, .name = "uav"});
  const Between view{uav, boat};
  team.couple(4.0 * Bearing{}, view, felt_by(uav));
  team.couple(4.0 * TooNear{.d_min = 1}, view, felt_by(uav));
  team.couple(8.0 * TooFar{.d_max = 2}, view, felt_by(uav));

  NewtonRiccati mpc(team, {.T = 1.0, .N = 20, .dt = 0.01});
  Plant plant(team, {4, 0, 0, 0, 1, 0, 0, 0, /**/ 3, -2, 1, 1, 0, 0, 0});
  double least = 1e9, most = 0, angle = 0;
  for (int k = 0; k < 4000; ++k) {
    plant.step(mpc.step(0.01 * k, plant.x()), 0.01);
    const double* const x = plant.x().data();
    const Vec3<double> p = {x[0], x[1], x[2]}, q = {x[8], x[9], x[10]};
    if (k < 600) continue;  // on its way
    least = std::min(least, norm(p - q)), most = std::max(most, norm(p - q));
    angle = std::max(angle, view_angle(SensorMount{}, {q, {x[11], x[12]}}, p));
  }
  std::printf("distance %.2f to %.2f m, at most %.2f rad from the axis\n", least, most, angle);
}
