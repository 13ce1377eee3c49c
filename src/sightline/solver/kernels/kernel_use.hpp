/// Report of which formulas of a solver are compiled, for messages. Formulas without a compiled
/// function are interpreted: same bits, several times slower, with no other indication.
#pragma once

#include <string>
#include <vector>

namespace sightline {

struct KernelUse {
  struct Formula {
    std::string name;  ///< "robot multirotor", "sensor_cone + keep_out"
    bool compiled;
  };
  std::vector<Formula> formulas{};  ///< unique names, in order of first use

  /// Adds a formula. A name counts as compiled only if all its formulas are.
  void add(const std::string& name, bool compiled);
  /// "2 of 5 formulas are interpreted, ...: robot rover, region"; empty if all are compiled.
  std::string sentence() const;
};

}  // namespace sightline
