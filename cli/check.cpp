#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/preflight.hpp"
#include "sightline/base/version.hpp"
#include "sightline/scenario/closed_loop.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline::cli {

int check(const std::filesystem::path& scenario, bool expanded, const Parts& parts) {
  try {
    const Scenario read = read_scenario(scenario, parts);
    (void)Controls(read);
    const Preflight known = preflight(read);
    for (const std::string& refusal : known.refusals) tell("{}\n", refusal);
    if (!known.refusals.empty()) return 2;
    if (expanded) {
      TomlDocument document = parse_toml(read.text, scenario.native());
      expand(document);
      print("{}", printed(document));
      return 0;
    }
    print("ok\n{}", summary(read));
    for (const std::string& remark : known.remarks) print("smooth      {}\n", remark);
    for (const std::string& warning : known.warnings) print("warning     {}\n", warning);
    return 0;
  } catch (const std::exception& error) {
    tell("{}\n", error.what());
    return 2;
  }
}

int version() {
  print("sightline {}\n{}\n", sightline::version, compiler);
  return 0;
}

}  // namespace sightline::cli
