/// Which formulas of a solver are compiled, for messages: one that is not found among the compiled functions is
/// interpreted, several times slower, to the same bits, and nothing else would tell.
#pragma once

#include <string>
#include <vector>

namespace sightline {

struct KernelUse {
  struct Formula {
    std::string name;  ///< "robot multirotor", "sensor_cone + keep_out"
    bool compiled;
  };
  std::vector<Formula> formulas{};  ///< each name once, in the order they were met

  /// Of one name it is compiled if all are.
  void add(const std::string& name, bool compiled);
  /// "2 of 5 formulas are interpreted, ...: robot rover, region", empty where all are compiled.
  std::string sentence() const;
};

}  // namespace sightline
