/// `sightline localize`, for the command line and for Python.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/analysis/localization/localize_team.hpp"
#include "sightline/readers/rig_recording.hpp"

namespace sightline {

struct LocalizeOptions {
  std::string landmarks = "all", robots = "all";  ///< robots that see them: all, none or names
  std::string anchor{};                           ///< empty: none
  std::string start = "known";                    ///< or unknown
  bool identities = true;
  std::filesystem::path noise{};   ///< TOML with [localize]; empty: the noise of the kind
  std::vector<std::string> set{};  ///< KEY=VALUE of [localize], over the file
  std::uint64_t seed = 1;
  bool identify_noise = false;  ///< first fit the noise to the recording of a team
  std::string pixels{};         ///< of the cameras of a bag, as in read_rig_recording()
};

/// @throws std::invalid_argument naming option, value and what was expected; ScenarioError for keys
///   of [localize]
TeamRun team_run(const TeamRecording& recording, const LocalizeOptions& options);

/// The results as text, as JSON, and the files that hold them.
struct LocalizedFiles {
  std::string text, json;
  std::vector<std::filesystem::path> files{};
};

/// Localizes a recording and writes summary.json, report.html, localize.mcap and, where the noise is
/// identified, noise.toml.
/// @param folder   empty: out/RECORDING/localize
/// @param command  for the summary
/// @throws std::invalid_argument and ScenarioError for bad input, before anything is written; another
///   std::runtime_error for lost output
LocalizedFiles localize_recording(const std::filesystem::path& recording, const LocalizeOptions& options,
                                  const std::filesystem::path& folder, const std::string& command);

/// The same for a camera rig: options of teams, `seed` and `identify_noise` are refused. The random
/// walks of the motion are identified first, unless `noise` is given or `set` has one of them.
/// @param place  of the recording, for messages and the name of the folder
LocalizedFiles localize_recording(const RigRecording& recording, const std::filesystem::path& place,
                                  const LocalizeOptions& options, const std::filesystem::path& folder,
                                  const std::string& command);

}  // namespace sightline
