#include "sightline/analysis/localization/localize_recording.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "sightline/analysis/localization/estimate_log.hpp"
#include "sightline/analysis/localization/localization_text.hpp"
#include "sightline/analysis/localization/noise_text.hpp"
#include "sightline/analysis/localization/rig_text.hpp"
#include "sightline/base/character.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

std::string names_of(const TeamRecording& recording) {
  std::vector<std::string> names;
  for (const TeamRecording::Robot& robot : recording.robots) names.push_back(robot.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

int robot_named(const TeamRecording& recording, std::string_view option, std::string_view name,
                std::string_view or_else) {
  const auto found = std::find_if(recording.robots.begin(), recording.robots.end(),
                                  [&](const TeamRecording::Robot& one) { return one.name == name; });
  if (found == recording.robots.end())
    throw std::invalid_argument(
        fmt::format("{} = {}, expected {}{}", option, name, or_else, names_of(recording)));
  return static_cast<int>(found - recording.robots.begin());
}

/// "all", "none", or names with commas between them.
std::vector<bool> robots_named(const TeamRecording& recording, std::string_view option,
                               std::string_view list) {
  std::vector<bool> chosen(recording.robots.size(), list == "all");
  if (list == "all" || list == "none") return chosen;
  for (const std::string_view name : split(list, ','))
    chosen[static_cast<std::size_t>(robot_named(recording, option, name, "all, none or some of "))] = true;
  return chosen;
}

/// Reads --noise and --set.
template <class Noise>
void read_noise(const LocalizeOptions& options, Noise& noise) {
  const auto read = [&](const std::string& text, const std::string& name, bool is_table) {
    const TomlDocument document = parse_toml(text, name);
    const TomlTable root(document);
    if (!is_table) {
      read_keys(root, {}, noise);
      return;
    }
    root.expect_only({"localize"});
    read_keys(root.table("localize"), {}, noise);
  };
  if (!options.noise.empty()) read(read_text(options.noise), options.noise.native(), true);
  for (const std::string& one : options.set) read(one, "--set " + one, false);
  noise.check();
}

/// Whether the options give a random walk of a rig's motion; a file of --noise does.
bool give_walk(const LocalizeOptions& options) {
  return !options.noise.empty() ||
         std::any_of(options.set.begin(), options.set.end(), [](const std::string& one) {
           const TomlDocument document = parse_toml(one, "--set " + one);
           const TomlTable numbers(document);
           return numbers.size() > (numbers.has("corner_noise") ? 1U : 0U);
         });
}

/// The result of a run, whose refusals name the recording. Done before a folder is made: a recording that
/// cannot be localized leaves none.
template <class Run>
auto result_of(const std::filesystem::path& place, const Run& run) {
  try {
    return run();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", place.native(), error.what()));
  }
}

/// The folder of the results, locked.
FolderLock folder_for(const std::filesystem::path& place, const std::filesystem::path& chosen) {
  const auto named = place.filename().empty() ? place.parent_path().filename() : place.filename();
  return {chosen.empty() ? std::filesystem::path("out") / named / "localize" : chosen,
          {"summary.json", "report.html", "localize.mcap", "noise.toml"}};
}

/// Writes one of the files.
void add(LocalizedFiles& written, const FolderLock& lock, const char* name, const std::string& text) {
  write_text(lock.folder() / name, text);
  written.files.push_back(lock.folder() / name);
}

}  // namespace

TeamRun team_run(const TeamRecording& recording, const LocalizeOptions& options) {
  if (!options.pixels.empty())
    throw std::invalid_argument(fmt::format(
        "--pixels = {}, expected none: {} is no recording of a camera rig", options.pixels, recording.kind));
  TeamRun run{.noise = recording.noise, .seed = options.seed};
  run.sees_landmarks = robots_named(recording, "--landmarks", options.landmarks);
  run.sees_robots = robots_named(recording, "--robots", options.robots);
  if (!options.anchor.empty()) {
    if (recording.relative)
      throw std::invalid_argument(fmt::format("--anchor = {}, expected none: poses of {} are relative to {}",
                                              options.anchor, recording.kind, recording.robots[0].name));
    run.anchor = robot_named(recording, "--anchor", options.anchor, "one of ");
    if (recording.robots[static_cast<std::size_t>(run.anchor)].truth.empty())
      throw std::invalid_argument(
          fmt::format("--anchor = {}, expected a robot with Groundtruth.dat", options.anchor));
  }
  if (options.start != "known" && options.start != "unknown")
    throw std::invalid_argument(fmt::format("--start = {}, expected known or unknown", options.start));
  run.start_known = options.start == "known";
  run.identities = options.identities;
  if (!run.identities && !run.start_known)
    throw std::invalid_argument(
        "--no-identities, expected known poses at the start: sightings without identity find none");
  read_noise(options, run.noise);
  return run;
}

LocalizedFiles localize_recording(const std::filesystem::path& place, const LocalizeOptions& options,
                                  const std::filesystem::path& folder, const std::string& command) {
  namespace fs = std::filesystem;
  const TeamRecording recording = read_team_recording(place);
  TeamRun run = team_run(recording, options);
  const double wall = result_of(place, [&] {
    using Steady = std::chrono::steady_clock;
    const auto begun = Steady::now();
    (void)localize_team(recording, run);
    return std::chrono::duration<double>(Steady::now() - begun).count();
  });
  const FolderLock lock = folder_for(place, folder);
  std::optional<IdentifiedNoise> identified;
  if (options.identify_noise) {
    identified = identify_noise(recording, run);
    run.noise = identified->noise;
  }
  const fs::path log_file = lock.folder() / "localize.mcap";
  EstimateLog log(beside(log_file), recording,
                  {{"version", std::string(version)},
                   {"recording", recording.kind},
                   {"seed", fmt::format("{}", run.seed)},
                   {"noise", noise_text(run.noise)}});
  LocalizationCurves curves(recording, &log);
  const TeamLocalization result = localize_team(recording, run, &curves);
  log.close();
  fs::rename(beside(log_file), log_file);
  const LocalizedRecording localized{.place = place.native(),
                                     .command = command,
                                     .recording = recording,
                                     .run = run,
                                     .result = result,
                                     .identified = identified,
                                     .wall_seconds = wall};
  LocalizedFiles written{to_string(localized), to_json(localized)};
  written.files.push_back(log_file);
  add(written, lock, "summary.json", written.json);
  add(written, lock, "report.html", curves.html(localized));
  if (identified) add(written, lock, "noise.toml", noise_text(identified->noise));
  return written;
}

LocalizedFiles localize_recording(const RigRecording& recording, const std::filesystem::path& place,
                                  const LocalizeOptions& options, const std::filesystem::path& folder,
                                  const std::string& command) {
  namespace fs = std::filesystem;
  const LocalizeOptions none;
  const auto refuse = [&](std::string_view option, std::string_view value) {
    throw std::invalid_argument(
        fmt::format("{} = {}, expected none: {} is of a camera rig", option, value, place.native()));
  };
  if (options.landmarks != none.landmarks) refuse("--landmarks", options.landmarks);
  if (options.robots != none.robots) refuse("--robots", options.robots);
  if (!options.anchor.empty()) refuse("--anchor", options.anchor);
  if (options.start != none.start) refuse("--start", options.start);
  if (!options.identities) refuse("--no-identities", "given");
  if (options.identify_noise) refuse("--identify-noise", "given");
  if (options.seed != none.seed) refuse("--seed", fmt::format("{}", options.seed));
  RigNoise noise{.corner_noise = recording.corner_noise};
  read_noise(options, noise);
  const bool identified = !give_walk(options);
  const RigLocalization result = result_of(place, [&] {
    if (identified) noise = identify_motion(recording, noise).noise;
    return localize_rig(recording, noise);
  });
  const FolderLock lock = folder_for(place, folder);
  const LocalizedRig localized{.place = place.native(),
                               .command = command,
                               .recording = recording,
                               .noise = noise,
                               .result = result,
                               .identified = identified};
  LocalizedFiles written{to_string(localized), to_json(localized)};
  const fs::path log_file = lock.folder() / "localize.mcap";
  write_rig_log(beside(log_file), localized);
  fs::rename(beside(log_file), log_file);
  written.files.push_back(log_file);
  add(written, lock, "summary.json", written.json);
  add(written, lock, "report.html", to_html(localized));
  if (identified) add(written, lock, "noise.toml", noise_text(noise));
  return written;
}

}  // namespace sightline
