#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis.hpp"
#include "sightline/scenario.hpp"

namespace sightline::cli {

int explain(const ExplainCommand& command, const Registry& registry) {
  try {
    const Scenario read = command.scenario.read(registry);
    print("{}", explain_text(read));
    return 0;
  } catch (const ScenarioError& error) {
    print_message("{}\n", error.what());
    return 2;
  }
}

}  // namespace sightline::cli
