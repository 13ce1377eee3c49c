// A robot that hovers steps aside from the downwash of another that circles through the place above it.
#include "own_potential.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <sightline/sightline.hpp>
using namespace sightline;

/// Flies 20 s, two rounds. @return the least distance of the two from above, while one is over the other [m]
double least_distance(double weight) {
  Team team;
  const std::array<double, 7> Q = {1, 1, 1, 0, 0, 0, 0};
  const auto low = team.add(Multirotor{}, {.Q = Q, .x_ref = std::array<double, 7>{0, 0, 1}});
  const auto high =
      team.add(Multirotor{},
               {.Q = Q, .x_ref = Circle{.centre = {1, 0, 2}, .radius = 1, .rate = 0.2 * std::numbers::pi}});
  team.couple(weight * Downwash{}, Between{low, high}, felt_by(low));

  NewtonRiccati mpc(team, {.T = 1.0, .N = 20, .dt = 0.01});
  Plant plant(team, {0, 0, 1, 1, 0, 0, 0, /**/ 2, 0, 2, 1, 0, 0, 0});
  double least = INFINITY;
  for (int k = 0; k < 2000; ++k) {
    plant.step(mpc.step(0.01 * k, plant.x()), 0.01);
    least = std::min(least, std::hypot(plant.x()[0] - plant.x()[7], plant.x()[1] - plant.x()[8]));
  }
  return least;
}

int main() {
  std::printf("least distance from above: %.2f m with the potential, %.2f m without\n", least_distance(1.0),
              least_distance(0.0));
}
