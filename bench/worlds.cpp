// Cost of a vehicle's step of 1 ms in each vehicle world:  build/release/bin/bench_worlds
#include "sightline/worlds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
#include <vector>

#include "sightline/mujoco.hpp"

namespace {

using namespace sightline;

/// Hovering vehicles on a grid with this spacing [m], each with its own oscillating command. Every
/// second vehicle is 1 m higher.
struct Grid {
  Team team;
  std::vector<double> x0;
  std::vector<RobotVehicle> vehicles;

  Grid(int n, double distance, const std::optional<Imu>& imu = {}) {
    const int side = static_cast<int>(std::ceil(std::sqrt(n)));
    for (int i = 0; i < n; ++i) {
      const AgentId robot = team.add(Multirotor{}, {.name = fmt::format("uav{}", i)});
      x0.insert(x0.end(), {distance * (i % side), distance * (i / side), 5.0 + i % 2, 1, 0, 0, 0});
      vehicles.push_back({robot, Vehicle::x500()});
      vehicles.back().vehicle.imu = imu;
    }
  }
};

/// Processor time of a step of the world, the best of five runs of 3 s [us]; negative if the world
/// ended.
double microseconds(World& world, int n) {
  constexpr int periods = 300, steps_per_period = 10;
  std::vector<double> u(4 * static_cast<std::size_t>(n));
  CommandGate gate(world.team(), 0.01);
  double best = 1e300;
  for (int run = 0, k = 0; run < 5; ++run) {
    const std::clock_t begin = std::clock();
    for (int i = 0; i < periods; ++i, ++k) {
      // All vehicles swing alike, so that none meets another.
      for (std::size_t j = 0; j < u.size(); j += 4)
        u[j] = 0.3 * std::sin(0.05 * k), u[j + 1] = 0.3 * std::cos(0.05 * k);
      if (!world.apply(0.01 * k, {}, gate.pass(u, {}), 0.01, 1)) return -1.0;
    }
    const double passed = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    best = std::min(best, passed / (periods * steps_per_period));
  }
  return best;
}

/// An IMU model with its full computing cost but negligible drift.
constexpr Imu steady_imu = {
    .gyro_bias = 0, .gyro_walk = 1e-9, .accelerometer_bias = 0, .accelerometer_walk = 1e-9};

}  // namespace

int main() {
  fmt::print(
      "| vehicles | apart | rotors [us a step] | with downwash | with IMU | mujoco [us a step] |\n"
      "|---|---|---|---|---|---|\n");
  for (const auto& [n, distance] :
       {std::pair{1, 3.0}, {2, 3.0}, {8, 3.0}, {8, 1.0}, {32, 3.0}, {32, 1.0}, {64, 3.0}}) {
    const Grid grid(n, distance), measured(n, distance, steady_imu);
    RotorWorld rotors(grid.team, grid.x0, grid.vehicles),
        blowing(grid.team, grid.x0, grid.vehicles, {.downwash = {1.0}}),
        measuring(measured.team, measured.x0, measured.vehicles);
    MujocoWorld mujoco(grid.team, grid.x0, grid.vehicles);
    fmt::print("| {} | {} m | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", n, distance, microseconds(rotors, n),
               microseconds(blowing, n), microseconds(measuring, n), microseconds(mujoco, n));
  }
}
