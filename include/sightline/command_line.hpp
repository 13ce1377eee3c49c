/// The command line `sightline`, for a program with parts of its own.
///
///   int main(int argc, char** argv) {
///     sightline::Registry registry;
///     registry.robots.add<Boat>();
///     return sightline::command_line(argc, argv, registry);
///   }
///
/// is `sightline` with all its commands, and `robot = "boat"` a word of its scenarios. Link `sightline::command_line`.
#pragma once

#include "sightline/registry.hpp"

namespace sightline {

/// Reads the arguments of a program, does what they say, and gives the exit code: 0 done, 1 the flight failed or output
/// was lost, 2 bad input. Prints results on stdout and messages on stderr. Throws nothing.
int command_line(int argc, char** argv, const Registry& registry = built_in_registry());

/// Registers DDS as the bridge for fleets, for the commands fly, vehicles and doctor. Link `sightline::dds`.
/// @throws std::invalid_argument if a bridge is registered already
void add_dds(Registry& registry);

}  // namespace sightline
