/// Log of a localized recording: estimates, true poses and fits of sightings.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/analysis/localization/localize_team.hpp"
#include "sightline/log.hpp"

namespace sightline {

/// Writes /ROBOT/estimate, /ROBOT/pose (the true one) and /ROBOT/innovation as the log of a run has
/// them. Log time is the time since the start of the recording. Equal runs give equal bytes.
class EstimateLog final : public TeamEstimates {
 public:
  /// @param words  metadata "sightline" of the log
  EstimateLog(const std::filesystem::path& file, const TeamRecording& recording, const McapWords& words);

  void estimate(double t, int robot, const PoseGuess& pose, const std::optional<PlanarPose>& truth) override;
  void fit(const TeamSighting& z, const TeamFit& fit) override;
  /// Completes the file. @throws std::runtime_error naming the file, if a part of it is lost
  void close();

 private:
  struct Robot {
    McapChannel estimate, pose, innovation;
  };
  void flush_after(double time);
  const std::string& name_of(int body) const;

  const TeamRecording& recording_;
  std::filesystem::path file_;
  McapWriter log_;
  LogMessage message_{log_};
  std::vector<Robot> robots_;
  std::vector<std::byte> bytes_;
  double flushed_ = 0.0;  // [s]
};

}  // namespace sightline
