#include "sightline/command_line.hpp"
#include "sightline/registry.hpp"

#ifdef SIGHTLINE_COMPONENT_LIBRARIES
#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdio>
#include <string>
#elif defined(SIGHTLINE_MUJOCO)
#include "sightline/mujoco.hpp"
#endif

namespace {

#ifdef SIGHTLINE_COMPONENT_LIBRARIES
/// With shared libraries, DDS and MuJoCo are packages of their own: a system without them has the rest.
void add_component(sightline::Registry& registry, const char* name) {
  const std::string library = fmt::format("libsightline_{}.so." SIGHTLINE_COMPONENT_LIBRARIES, name);
  void* const opened = dlopen(library.c_str(), RTLD_NOW);
  if (opened == nullptr) {
    const std::string why = dlerror();
    // The library itself is not there: the package is not installed. One that lacks another library is broken.
    if (!why.starts_with(library + ":")) fmt::print(stderr, "sightline: without {}: {}\n", name, why);
    return;
  }
  using Add = void(sightline::Registry&);
  const auto add = reinterpret_cast<Add*>(dlsym(opened, fmt::format("sightline_add_{}", name).c_str()));
  if (add == nullptr) {
    fmt::print(stderr, "sightline: without {}: {} has no sightline_add_{}\n", name, library, name);
    return;
  }
  add(registry);
}

void add_components(sightline::Registry& registry) {
  add_component(registry, "dds");
  add_component(registry, "mujoco");
}
#else
void add_components([[maybe_unused]] sightline::Registry& registry) {
#ifdef SIGHTLINE_DDS
  sightline::add_dds(registry);
#endif
#ifdef SIGHTLINE_MUJOCO
  sightline::add_mujoco(registry);
#endif
}
#endif

}  // namespace

int main(int argc, char** argv) {
  sightline::Registry registry;
  add_components(registry);
  return sightline::command_line(argc, argv, registry);
}
