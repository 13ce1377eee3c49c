#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/config.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/renamed.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline::cli {
namespace {

/// Rewrites a file that contains renamed keys or words, and prints the new names.
void fix(const std::filesystem::path& file) {
  const std::string text = read_text(file);
  const RenamedText renamed = with_present_names(text, file.native());
  for (const std::string& change : renamed.changes) print_sentence(change);
  if (renamed.text != text) write_text(file, renamed.text);
}

}  // namespace

int check(const CheckCommand& command, const Registry& registry) {
  try {
    if (command.fix) fix(command.scenario.file);
    const Scenario read = command.scenario.read(registry);
    const Controls controls(read);
    const Preflight known = preflight(read);
    for (const std::string& refusal : known.refusals) print_message("{}\n", refusal);
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
    if (const std::string reported = controls.kernels().sentence(); !reported.empty())
      print_sentence(reported);
    return 0;
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
}

std::string version_text() { return fmt::format("sightline {}\n{}", sightline::version, compiler); }

int show_version() {
  print("{}\n", version_text());
  return 0;
}

}  // namespace sightline::cli
