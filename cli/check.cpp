#include <fmt/format.h>

#include "cli/arguments.hpp"
#include "cli/components.hpp"
#include "cli/output.hpp"
#include "sightline/analysis.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/config.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/guarantee.hpp"
#include "sightline/scenario/renamed.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline::cli {
namespace {

struct CheckCommand {
  NamedScenario scenario;
  bool expanded = false, fix = false;
};

/// Rewrites a file that contains renamed keys or words, and prints the new names.
void fix(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  const RenamedText renamed = with_present_names(text, file.native());
  for (const std::string& change : renamed.changes) print_sentence(change);
  if (renamed.text != text) write_text(file, renamed.text);
}

Preflight preflight_of(const Scenario& scenario) {
  if constexpr (has("analysis")) return preflight(scenario);
  print_sentence(left_out("the check of potentials, observation cycles and observability", "analysis"));
  return check_scenario(scenario);
}

int check(const CheckCommand& command, const Registry& registry) {
  if (command.fix) fix(command.scenario.file);
  const Scenario read = command.scenario.read(registry);
  const Controls controls(read);
  const Preflight known = preflight_of(read);
  for (const std::string& refusal : known.refusals) print_message("{}\n", refusal);
  if (!known.refusals.empty()) return 2;
  if (command.expanded) {
    TomlDocument document = parse_toml(read.text, command.scenario.file.native());
    expand(document);
    print("{}", printed(document));
    return 0;
  }
  constexpr std::size_t pairs_of_a_line = 8;
  print("ok\n{}{}", summary(read), describe(distance_guarantees(read), read.team, pairs_of_a_line));
  for (const std::string& remark : known.remarks) print("smooth      {}\n", remark);
  for (const std::string& warning : known.warnings) print("warning     {}\n", warning);
  if (const std::string reported = controls.kernels().sentence(); !reported.empty()) print_sentence(reported);
  return 0;
}

}  // namespace

Execute describe_check(CLI::App& app) {
  const auto command = std::make_shared<CheckCommand>();
  app.description("Check a scenario and print what it describes");
  add_scenario(app, command->scenario);
  app.add_flag("--print", command->expanded, "Print the scenario with its templates and ranges expanded");
  app.add_flag("--fix", command->fix, "First rewrite the file: keys and words that have another name now")
      ->excludes("--print", "--set");
  return [command](const Registry& registry, char**) {
    return refusing([&] { return check(*command, registry); });
  };
}

std::string version_text() { return fmt::format("sightline {}\n{}", sightline::version, compiler); }

Execute describe_version(CLI::App& app) {
  app.description("Version and compiler");
  return [](const Registry&, char**) {
    print("{}\n", version_text());
    return 0;
  };
}

}  // namespace sightline::cli
