/// Results of a localized recording as text, JSON, TOML and HTML.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/localization/identify_noise.hpp"
#include "sightline/analysis/localization/localize_team.hpp"

namespace sightline {

/// What was localized, and how.
struct LocalizedRecording {
  std::string place, command;  ///< path of the recording; command line
  const TeamRecording& recording;
  const TeamRun& run;
  const TeamLocalization& result;
  std::optional<IdentifiedNoise> identified{};
  double wall_seconds = 0.0;  ///< that the filter took
};

std::string to_string(const LocalizedRecording& localized);
/// docs/real_data.md lists the keys.
std::string to_json(const LocalizedRecording& localized);

/// Estimated and true paths, errors and reported deviations, for the report.
class LocalizationCurves final : public TeamEstimates {
 public:
  explicit LocalizationCurves(const TeamRecording& recording, TeamEstimates* next = nullptr);
  void estimate(double t, int robot, const PoseGuess& pose, const std::optional<PlanarPose>& truth) override;
  void fit(const TeamSighting& z, const TeamFit& fit) override;
  std::string html(const LocalizedRecording& localized) const;

 private:
  struct Curves {
    std::vector<double> t, x, y, true_x, true_y, error, sigma;
  };
  const TeamRecording& recording_;
  TeamEstimates* const next_;
  std::vector<Curves> robots_;
};

}  // namespace sightline
