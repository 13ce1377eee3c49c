#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/advise/potential_page.hpp"
#include "sightline/io/closed_loop.hpp"
#include "sightline/io/scenario.hpp"
#include "sightline/io/version.hpp"
#include "sightline/potential/finite.hpp"
#include "sightline/potential/region.hpp"

namespace sightline::cli {
namespace {

/// What is to be known of the regions that were written as text.
/// @return a sentence for each that is no finite number somewhere
std::vector<std::string> look_at_regions(const Scenario& scenario, std::string& remarks) {
  std::vector<std::string> faults;
  const auto& couplings = scenario.team.couplings();
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const auto* region = couplings[i].term.potential.as<Region>();
    if (region == nullptr) continue;
    const std::string who = fmt::format("couple[{}] {}", i, region->name());
    if (const auto smoothed = region->smoothed(); !smoothed.empty()) {
      remarks += fmt::format("smooth      {}: corners of {} are rounded off over {} (m, rad)\n", who,
                             fmt::join(smoothed, ", "), region->width());
    }
    if (const auto spot = not_finite_at(couplings[i].term.potential)) {
      faults.push_back(fmt::format("{}:{}: {} is no finite number with {}, expected one everywhere",
                                   scenario.file.native(), scenario.coupling_lines[i], who,
                                   to_string(*spot)));
    }
  }
  return faults;
}

/// What the verdicts warn of, a line each.
std::string warnings_of(const Team& team) {
  std::string lines;
  for (const JudgedCoupling& one : judge_couplings(team)) {
    const std::string_view name = team.couplings()[one.coupling].term.potential.name();
    for (const std::string& sentence : one.verdict.warnings) {
      lines += fmt::format("warning     couple[{}] {}: {}\n", one.coupling, name, sentence);
    }
  }
  return lines;
}

/// Where the barrier reckons with less than what it will meet, a line each.
std::string warnings_of_speeds(const Scenario& scenario) {
  std::string lines;
  if (!scenario.safety || scenario.safety->barrier == BarrierMode::off) return lines;
  for (const Stranger& stranger : scenario.strangers) {
    const double speed = stranger.motion ? top_speed(*stranger.motion) : 0.0;
    if (speed <= stranger.speed_max) continue;
    lines +=
        fmt::format("warning     {} moves at up to {} m/s, the barrier reckons with speed_max = {} m/s\n",
                    scenario.team.name(stranger.body), speed, stranger.speed_max);
  }
  return lines;
}

}  // namespace

int check(const std::filesystem::path& scenario) {
  try {
    const Scenario read = read_scenario(scenario);
    (void)Controls(read);
    std::string remarks;
    const std::vector<std::string> faults = look_at_regions(read, remarks);
    for (const std::string& fault : faults) tell("{}\n", fault);
    if (!faults.empty()) return 2;
    print("ok\n{}{}{}{}", summary(read), remarks, warnings_of(read.team), warnings_of_speeds(read));
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
