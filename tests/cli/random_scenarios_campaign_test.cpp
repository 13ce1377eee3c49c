// Scenarios of every kind, drawn, flown by the command line and judged from their logs' poses.
// SIGHTLINE_RANDOM="200 50" flies seeds 200 to 249 alone; what breaks a promise stays in out/random/.
#include <gtest/gtest.h>

#include <regex>
#include <sstream>

#include "tests/support/campaign.hpp"
#include "tests/support/command.hpp"
#include "tests/support/flight_judge.hpp"
#include "tests/support/random_scenario.hpp"

namespace sightline {
namespace {

struct Seeds {
  std::uint64_t first, count;
};

Seeds seeds() {
  Seeds seeds = {0, whole_campaign() ? 2000U : 20U};
  if (const char* const chosen = std::getenv("SIGHTLINE_RANDOM"))
    std::istringstream(chosen) >> seeds.first >> seeds.count;
  return seeds;
}

/// What is wrong with a flight of the scenario, whatever its exit code.
std::vector<std::string> wrong(const std::filesystem::path& scenario, const std::filesystem::path& folder,
                               const test::CommandResult& run) {
  static const std::regex refusal("^[^\n]*\\.toml:[0-9]+(:[0-9]+)?: [^\n]+\n");
  if (run.code == 2 && std::regex_search(run.err, refusal) && !std::filesystem::exists(folder / "run.mcap"))
    return {};
  if (run.code != 0 && run.code != 1) return {fmt::format("exit {}: {}", run.code, run.err)};
  std::vector<std::string> found;
  try {
    found = test::FlightJudge(scenario, folder, run.code).broken();
  } catch (const std::exception& error) {
    found.emplace_back(error.what());
  }
  if (run.code == 1 && run.err.empty()) found.emplace_back("exit 1, and no sentence says why");
  return found;
}

TEST(RandomScenarios, KeepWhatIsPromised) {
  const double duration = whole_campaign() ? 20.0 : 5.0;
  const auto [first, count] = seeds();
  const std::filesystem::path kept = SIGHTLINE_SOURCE_DIR "/out/random", folder = test::fresh_folder();
  std::map<int, int> codes;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const std::filesystem::path scenario = folder / fmt::format("{}.toml", seed), out = folder / "run";
    std::filesystem::remove_all(out);
    std::ofstream(scenario) << test::RandomScenario(seed, duration).text();
    const test::CommandResult run =
        test::sightline(fmt::format("run '{}' -o '{}'", scenario.string(), out.string()), folder);
    ++codes[run.code];
    const std::vector<std::string> found = wrong(scenario, out, run);
    if (!found.empty()) {
      std::filesystem::create_directories(kept);
      std::filesystem::copy_file(scenario, kept / scenario.filename(),
                                 std::filesystem::copy_options::overwrite_existing);
    }
    for (const std::string& sentence : found) {
      ADD_FAILURE() << "sightline run out/random/" << seed << ".toml: " << sentence;
    }
    std::filesystem::remove(scenario);
  }
  EXPECT_LE(codes[2], 1 + static_cast<int>(count) / 10) << "refused: few may be";
  for (const auto& [code, runs] : codes) RecordProperty(fmt::format("exit_{}", code), runs);
  fmt::print("exit 0: {}, exit 1: {}, refused: {}\n", codes[0], codes[1], codes[2]);
}

}  // namespace
}  // namespace sightline
