#include <memory>
#include <stdexcept>

#include "cli/arguments.hpp"
#include "cli/components.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/localization/localize_recording.hpp"
#include "sightline/import/read_rig.hpp"
#include "sightline/scenario.hpp"

namespace sightline::cli {
namespace {

struct LocalizeCommand {
  std::filesystem::path recording, output;
  LocalizeOptions options;
  bool json = false;
  std::string words;  ///< the command line
};

LocalizedFiles localized(const LocalizeCommand& of) {
  if constexpr (has("import")) {
    if (is_rig_recording(of.recording))
      return localize_recording(read_rig_recording(of.recording, of.options.pixels), of.recording, of.options,
                                of.output, of.words);
  }
  return localize_recording(of.recording, of.options, of.output, of.words);
}

int localize(const LocalizeCommand& command) {
  try {
    const LocalizedFiles done = localized(command);
    print("{}", command.json ? done.json : done.text);
    if (!command.json)
      for (const std::filesystem::path& file : done.files) print("{}\n", file.native());
    return 0;
  } catch (const std::invalid_argument& error) {
    print_message("{}\n", error.what());
  } catch (const ScenarioError& error) {
    print_message("{}\n", error.what());
  }
  return 2;
}

}  // namespace

Execute describe_localize(CLI::App& app) {
  const auto command = std::make_shared<LocalizeCommand>();
  LocalizeOptions& options = command->options;
  app.description("Localize a recorded team of planar robots or a camera rig among AprilTags");
  app.add_option("RECORDING", command->recording,
                 "Folder of MRCLAM, files of MURP, or a camera rig: folder with tagslam.yaml, PREFIX of "
                 "PREFIX_tagslam.yaml, or its bag PREFIX.mcap")
      ->required();
  app.add_option("-o,--output", command->output, "Folder for the results [out/RECORDING/localize]");
  app.add_option("--landmarks", options.landmarks,
                 "Robots that see landmarks: all, none or names, robot1,robot2")
      ->capture_default_str();
  app.add_option("--robots", options.robots, "Robots that see robots: all, none or names")
      ->capture_default_str();
  app.add_option("--anchor", options.anchor, "Robot whose pose is known once a second, to 1 cm and 0.01 rad");
  app.add_option("--start", options.start, "Poses at the start: known, to 1 cm and 0.01 rad, or unknown")
      ->capture_default_str();
  app.add_flag("!--no-identities", options.identities, "Ignore which body a sighting shows");
  app.add_option("--noise", options.noise,
                 "File with a table [localize] (TOML), as noise.toml of the results");
  app.add_option("--set", options.set, "KEY=VALUE of [localize], range_noise=0.1; may be repeated")
      ->allow_extra_args(false);
  app.add_flag(
      "--identify-noise", options.identify_noise,
      "First fit noise and correlation times to the recording of a team; the random walks of a rig are "
      "fitted unless --noise is given or --set has one");
  app.add_option("--pixels", options.pixels,
                 "Pictures of a bag without cameras.yaml in which the tags were found: raw or rectified");
  app.add_option("--seed", options.seed, "Seed of the noise of known poses of a team")
      ->check(CLI::Range(std::uint64_t{0}, seed_max))
      ->capture_default_str();
  app.add_flag("--json", command->json, "JSON instead of a table");
  return [command](const Registry&, char** argv) {
    for (char** word = argv + 1; *word != nullptr; ++word)
      command->words.append(command->words.empty() ? "" : " ").append(*word);
    return localize(*command);
  };
}

}  // namespace sightline::cli
