// The benchmark "keep in view": the command line with the controllers of docs/benchmark.md.
//
//   sightline_keep_in_view [--process COMMAND] ARGUMENTS OF sightline
#include <string_view>

#include "benchmark/controllers/controllers.hpp"
#include "sightline/command_line.hpp"

int main(int argc, char** argv) {
  std::string command;
  if (argc >= 3 && std::string_view(argv[1]) == "--process") {
    command = argv[2];
    argv[2] = argv[0];
    argv += 2, argc -= 2;
  }
  sightline::Registry registry;
  sightline::benchmark::add_controllers(registry, command);
  return sightline::command_line(argc, argv, registry);
}
