#include <fmt/format.h>

#include <stdexcept>

#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/potential_page.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"

namespace sightline::cli {
namespace {

struct PotentialOptions {
  NamedScenario scenario;
  std::filesystem::path output;
  std::optional<long long> couple;
};

/// The requested coupling, or all.
std::optional<std::size_t> chosen(const PotentialOptions& options, const Scenario& scenario) {
  const std::size_t couplings = scenario.team.couplings().size();
  if (couplings == 0) {
    throw std::invalid_argument(
        fmt::format("{}: couple is missing, expected a coupling to look at", scenario.file.native()));
  }
  if (!options.couple) return {};
  if (*options.couple < 0 || static_cast<std::size_t>(*options.couple) >= couplings) {
    throw std::invalid_argument(fmt::format("--couple {}: {} has {} coupling{}, expected 0 to {}",
                                            *options.couple, scenario.file.native(), couplings,
                                            couplings == 1 ? "" : "s", couplings - 1));
  }
  return static_cast<std::size_t>(*options.couple);
}

int potential(const PotentialOptions& options, const Registry& registry) {
  Scenario scenario;
  std::optional<FolderLock> lock;
  std::optional<std::size_t> only;
  try {
    scenario = options.scenario.read(registry);
    only = chosen(options, scenario);
    lock.emplace(
        options.output.empty() ? std::filesystem::path("out") / scenario.name / "potential" : options.output,
        std::initializer_list<std::string_view>{"verdict.json", "index.html"});
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }

  const auto judged = judge_couplings(scenario.team, only, {}, scenario.x0);
  for (const JudgedCoupling& one : judged) {
    print("{}\n", title_of(scenario.team, one.coupling));
    if (one.same_as) print("  the same potential as couple[{}]\n", *one.same_as);
    for (const std::string& sentence : one.verdict.words) print("  {}\n", sentence);
  }
  const std::filesystem::path& folder = lock->folder();
  write_text(folder / "verdict.json", verdict_json(scenario, judged));
  write_text(folder / "index.html", potential_html(scenario, judged));
  for (const char* file : {"index.html", "verdict.json"}) print("{}\n", (folder / file).native());
  return 0;
}

}  // namespace

Execute describe_potential(CLI::App& app) {
  const auto command = std::make_shared<PotentialOptions>();
  app.description("Draw and judge the potentials of a scenario's couplings");
  add_scenario(app, command->scenario);
  app.add_option("--couple", command->couple, "One coupling, from 0 in the file's order");
  app.add_option("-o,--output", command->output, "Folder for the results [out/NAME/potential]");
  return [command](const Registry& registry, char**) { return potential(*command, registry); };
}

}  // namespace sightline::cli
