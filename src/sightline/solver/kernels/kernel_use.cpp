#include <fmt/format.h>

#include <algorithm>

#include "sightline/solver.hpp"

namespace sightline {

void KernelUse::add(const std::string& name, bool compiled) {
  const auto known =
      std::find_if(formulas.begin(), formulas.end(), [&](const Formula& f) { return f.name == name; });
  if (known == formulas.end()) {
    formulas.push_back({name, compiled});
  } else {
    known->compiled = known->compiled && compiled;
  }
}

std::string KernelUse::sentence() const {
  std::string names;
  int interpreted = 0;
  for (const Formula& f : formulas) {
    if (f.compiled) continue;
    names += (interpreted++ > 0 ? ", " : "") + f.name;
  }
  if (interpreted == 0) return {};
  return fmt::format("{} of {} formulas {} interpreted, several times slower than compiled: {}", interpreted,
                     formulas.size(), interpreted == 1 ? "is" : "are", names);
}

}  // namespace sightline
