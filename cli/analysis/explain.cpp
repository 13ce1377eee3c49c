#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "sightline/analysis.hpp"
#include "sightline/scenario.hpp"

namespace sightline::cli {

Execute describe_explain(CLI::App& app) {
  const auto scenario = std::make_shared<NamedScenario>();
  app.description("Analyse which limits can hold together and what they cost");
  add_scenario(app, *scenario);
  return [scenario](const Registry& registry, char**) {
    try {
      print("{}", explain_text(scenario->read(registry)));
      return 0;
    } catch (const ScenarioError& error) {
      print_message("{}\n", error.what());
      return 2;
    }
  };
}

}  // namespace sightline::cli
