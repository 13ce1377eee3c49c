/// Localizes a recorded camera rig by RigFilter and evaluates the estimates.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sightline/analysis/localization/rig_filter.hpp"

namespace sightline {

/// Errors of estimates against the reference.
struct RigAccuracy {
  std::size_t samples = 0;
  double rmse = no_value, max_error = no_value;  ///< of the position [m]
  double attitude_rmse = no_value;               ///< of the angle of rotation [rad]
  double sigma = no_value;   ///< root mean square of the reported standard deviation of the position [m]
  double anees = no_value;   ///< of position and attitude; 6 is consistent
  double independent = 0.0;  ///< samples without their correlation in time
  std::array<double, 2> bounds{no_value, no_value};  ///< of a consistent estimate's ANEES, 95 %
};

struct RigLocalization {
  /// An estimate of the pose of B in G, with the covariance of its error, a twist in G.
  struct Estimate {
    double t = 0.0;  ///< [s]
    RigidPose pose{};
    Mat<6, 6> P{};
    double unseen = 0.0;  ///< since the last accepted sighting [s]
  };
  std::vector<Estimate> filter{};      ///< each uses nothing after its time but one sample of odometry
  std::vector<Estimate> smoothed{};    ///< each uses the whole recording
  std::vector<TagFit> fits{};          ///< one for each sighting
  std::vector<RigidPose> reference{};  ///< aligned with `filter`, one for each estimate; empty: unknown

  RigAccuracy of_filter{}, in_view{}, of_smoother{};  ///< in_view: of the filter, a tag seen within 1 s
  RigidPose alignment{};                              ///< applied to the reference
  std::size_t accepted = 0, rejected = 0, waiting = 0, restarts = 0;
  std::size_t places = 0;  ///< tags with an accepted sighting
  double innovation =
      no_value;  ///< mean of the squared normalised innovations of a coordinate; 1 is consistent
  double longest_unseen = 0.0;  ///< [s]
  double seconds = 0.0;         ///< of the recording
  double wall_seconds = 0.0;    ///< that the filter took
  /// Twice the negative logarithm of the likelihood of all sightings; those beyond the gate count as
  /// outliers.
  double cost = 0.0;
};

/// Covariance of the position and of the rotation about the axes of G [m], [rad].
Mat<6, 6> pose_covariance(const RigLocalization::Estimate& of);
/// Covariance of the position of an estimate [m^2].
Mat<3, 3> position_covariance(const RigLocalization::Estimate& of);

/// Runs the filter, and with `smooth` a smoother backwards over its steps. Estimates are at the times
/// of the reference, else at those of the sightings and, 100 a second, of the odometry. The reference is aligned with
/// the filter's estimates first: by the rigid motion that fits positions and, at arms of 1 m, axes
/// best. Deterministic.
/// @throws std::invalid_argument if no view of a known tag gives a first pose
RigLocalization localize_rig(const RigRecording& recording, const RigNoise& noise, bool smooth = true);

/// The noise with the random walks of the motion that maximise the likelihood of the sightings, by
/// factors from 2 to 1.2 one after the other. Uses no reference. The noise of the corners stays: their
/// errors last, so their innovations alone would make it too small.
struct IdentifiedMotion {
  RigNoise noise{};
  int runs = 0;  ///< of the filter
};
IdentifiedMotion identify_motion(const RigRecording& recording, RigNoise noise);

}  // namespace sightline
