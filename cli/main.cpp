#include "sightline/command_line.hpp"

#ifdef SIGHTLINE_DDS
#include "sightline/dds.hpp"
#endif
#ifdef SIGHTLINE_MUJOCO
#include "sightline/mujoco.hpp"
#endif

int main(int argc, char** argv) {
  sightline::Parts parts;
#ifdef SIGHTLINE_DDS
  sightline::add_dds(parts);
#endif
#ifdef SIGHTLINE_MUJOCO
  sightline::add_mujoco(parts);
#endif
  return sightline::command_line(argc, argv, parts);
}
