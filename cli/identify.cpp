#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/identification/identification_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;

ExcitationKind kind_of(const std::string& name) {
  const auto found = std::find(excitation_names.begin(), excitation_names.end(), name);
  if (found == excitation_names.end()) {
    throw std::invalid_argument(
        fmt::format("--excitation = {}, expected one of {}", name, fmt::join(excitation_names, ", ")));
  }
  return static_cast<ExcitationKind>(found - excitation_names.begin());
}

/// Returns the result of `make`; errors receive the place as a prefix.
template <class Make>
auto in(const fs::path& place, Make&& make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", place.native(), error.what()));
  }
}

/// The flown motion of the robot from the log of a run.
FlownMotion flown(const IdentifyCommand& command, const Registry& registry) {
  const fs::path log = log_of(command.of.file);
  const FlownAs flight = flown_as(log);
  const Scenario scenario =
      parse_scenario(flight.text, log, registry, {.files = flight.files, .set = command.of.set});
  const RecordedFlight recorded(log, scenario.team, scenario.x0, scenario.horizon.dt);
  return in(command.of.file, [&] { return motion_of(recorded, scenario.horizon.dt, command.agent); });
}

}  // namespace

int identify(const IdentifyCommand& command, const Registry& registry) {
  std::error_code ignored;  // the reading reports the error of an inaccessible file
  const bool of_log = fs::is_directory(command.of.file, ignored);
  std::optional<FolderLock> lock;
  FlownMotion motion;
  std::optional<Identification> found;
  const auto lock_in = [&](const fs::path& otherwise) {
    lock.emplace(command.output.empty() ? otherwise : command.output,
                 std::initializer_list<std::string_view>{"identify.json", "identify.html"});
  };
  try {
    if (of_log) {
      motion = flown(command, registry);
      lock_in(command.of.file);
      found = in(command.of.file, [&] { return sightline::identify(motion); });
    } else {
      const Scenario scenario = command.of.read(registry);
      const AgentId robot =
          in(command.of.file, [&] { return identified_robot(scenario.team, command.agent); });
      const ExcitationOptions options{.kind = kind_of(command.excitation),
                                      .seconds = command.seconds,
                                      .seed = command.seed.value_or(scenario.simulation.seed),
                                      .height = command.height,
                                      .radius = command.radius};
      options.check();
      lock_in(fs::path("out") / scenario.name / "identify");
      motion = scenario.links ? excite_over_link(scenario, robot, options, registry)
                              : fly_excitation(scenario, robot, options);
      found = in(command.of.file, [&] { return sightline::identify(motion, options.kind); });
    }
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }

  const std::string json = to_json(*found);
  if (command.json) {
    print("{}", json);
  } else {
    print("{}\n", to_string(*found));
  }
  const fs::path& folder = lock->folder();
  write_text(folder / "identify.json", json);
  if (!command.json) print("{}\n", (folder / "identify.json").native());
  try {
    write_text(folder / "identify.html", identification_html(*found, motion));
    if (!command.json) print("{}\n", (folder / "identify.html").native());
  } catch (const std::runtime_error& error) {
    print_sentence(fmt::format("no identify.html: {}", sentence_of(error)));
  }
  return 0;
}

}  // namespace sightline::cli
