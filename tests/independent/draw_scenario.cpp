// Draws scenarios into a folder:  draw_scenario DIR FIRST COUNT
// SEED.toml of each seed from FIRST on; a flight lasts 2 to 8 s. Every second one that may says
// that it begins outside of its limits.
#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "sightline/scenario.hpp"
#include "tests/independent/random_scenario.hpp"

/// With safety.start_outside, or as it is where that is refused.
static std::string begun_outside(const std::string& text) {
  const std::string section = "[safety]\n";
  const std::size_t at = text.find(section);
  if (at == std::string::npos) return text;
  std::string changed = text;
  changed.insert(at + section.size(), "start_outside = true\n");
  try {
    (void)sightline::parse_scenario(changed, "drawn.toml");
  } catch (const sightline::ScenarioError&) {
    return text;
  }
  return changed;
}

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "usage: draw_scenario DIR FIRST COUNT\n");
    return 2;
  }
  const std::string folder = argv[1];
  const std::uint64_t first = std::strtoull(argv[2], nullptr, 10),
                      count = std::strtoull(argv[3], nullptr, 10);
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const double duration = 2.0 + 0.5 * static_cast<double>(seed * 7 % 13);
    std::ofstream file(fmt::format("{}/{}.toml", folder, seed));
    const std::string text = sightline::test::RandomScenario(seed, duration).text();
    file << (seed % 2 == 0 ? begun_outside(text) : text);
    if (!file.flush()) {
      fmt::print(stderr, "{}/{}.toml cannot be written\n", folder, seed);
      return 1;
    }
  }
  return 0;
}
