// The command line with a robot, a potential, a reference and a solver of one's own: `own_command_line run own_parts.toml`.
#include <cstdio>
#include <sightline/command_line.hpp>
#include <stdexcept>

#include "own_parts.hpp"
#include "own_solver.hpp"

int main(int argc, char** argv) {
  sightline::Registry registry;
  try {
    registry.robots.add<Blimp>();
    registry.potentials.add<Halo>();
    registry.references.add<FigureEight>();
    registry.solvers.add<OneMoveOptions>(
        "one_move", {},
        [](const sightline::Team& team, const sightline::Horizon& horizon, const OneMoveOptions& options) {
          return std::make_unique<OneMove>(team, horizon, options);
        });
  } catch (const std::invalid_argument& error) {  // a name that is taken, a default that is out of range
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return sightline::command_line(argc, argv, registry);
}
