#include <fmt/format.h>

#include "cli/commands.hpp"
#include "sightline/io/scenario.hpp"
#include "sightline/io/version.hpp"

namespace sightline::cli {

int check(const std::filesystem::path& scenario) {
  try {
    const Scenario read = read_scenario(scenario);
    make_solver(read.solver, read.team, read.horizon);
    fmt::print("ok\n{}", summary(read));
    return 0;
  } catch (const ScenarioError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}

int version() {
  fmt::print("sightline {}\n{}\n", sightline::version, compiler);
  return 0;
}

}  // namespace sightline::cli
