#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/preflight.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/version.hpp"
#include "sightline/scenario/closed_loop.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline::cli {

int check(const CheckCommand& command, const Parts& parts) {
  try {
    const Scenario read = command.scenario.read(parts);
    const Controls controls(read);
    const Preflight known = preflight(read);
    for (const std::string& refusal : known.refusals) tell("{}\n", refusal);
    if (!known.refusals.empty()) return 2;
    if (command.expanded) {
      TomlDocument document = parse_toml(read.text, command.scenario.file.native());
      expand(document);
      print("{}", printed(document));
      return 0;
    }
    print("ok\n{}", summary(read));
    for (const std::string& remark : known.remarks) print("smooth      {}\n", remark);
    for (const std::string& warning : known.warnings) print("warning     {}\n", warning);
    if (const std::string told = controls.kernels().sentence(); !told.empty()) say(told);
    return 0;
  } catch (const std::exception& error) {
    tell("{}\n", sentence_of(error));
    return 2;
  }
}

std::string version_text() { return fmt::format("sightline {}\n{}", sightline::version, compiler); }

int show_version() {
  print("{}\n", version_text());
  return 0;
}

}  // namespace sightline::cli
