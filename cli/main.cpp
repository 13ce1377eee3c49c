#include "sightline/command_line.hpp"

#ifdef SIGHTLINE_DDS
#include "sightline/dds.hpp"
#endif
#ifdef SIGHTLINE_MUJOCO
#include "sightline/mujoco.hpp"
#endif

int main(int argc, char** argv) {
  sightline::Registry registry;
#ifdef SIGHTLINE_DDS
  sightline::add_dds(registry);
#endif
#ifdef SIGHTLINE_MUJOCO
  sightline::add_mujoco(registry);
#endif
  return sightline::command_line(argc, argv, registry);
}
