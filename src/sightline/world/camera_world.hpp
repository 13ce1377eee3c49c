/// A world with cameras: what the robots' cameras see of the bodies with tags comes as detections beside the states.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/world/detection_source.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/sensing_world.hpp"

namespace sightline {

/// Any world that knows the truth, seen by cameras. A picture is taken at the first measure() at which it is due, so its stamp is a
/// whole number of periods; it arrives at the first one after its latency. What it shows is the truth then: the attitudes that the
/// world tells, of other robots those that their models say, upright where they say none.
///
/// A body that is absent neither sees nor is seen, and what it saw before it went does not arrive any more.
class CameraWorld final : public SensingWorld {
 public:
  /// @param source  of the same options and team
  /// @throws std::invalid_argument for a camera or tags out of range, and for a world that gives detections of its own
  CameraWorld(std::unique_ptr<World> world, CameraOptions options, std::unique_ptr<DetectionSource> source);

  MeasuredMost measured_max() const noexcept override {
    MeasuredMost most = SensingWorld::measured_max();
    most.detections = detections_.capacity();
    return most;
  }
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override;

 private:
  struct Shutter {
    std::int64_t next = 0;  // number of the next picture, due at next / rate
    RandomStream chance;
  };

  void place_bodies(const Measured& now) noexcept;
  void take_picture(std::size_t camera, double t) noexcept;

  CameraOptions options_;
  std::unique_ptr<DetectionSource> source_;
  std::vector<Shutter> shutters_;
  std::vector<ExposedBody> bodies_;
  std::optional<double> last_{};  // measure() [s]
  std::vector<Detection> found_;  // in one picture
  UnderWay<Detection> detections_;
};

}  // namespace sightline
