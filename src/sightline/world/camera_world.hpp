/// Adds cameras to a world: detections of tagged bodies, next to the measured states.
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

/// Decorator that adds cameras to any world that provides the true states. A picture is taken at
/// the first measure() at which it is due, so its stamp is a whole number of periods. Its
/// detections arrive at the first measure() after the latency. A picture shows the true states.
/// Attitudes are those that the world reports. For other robots they follow from the model, and are
/// upright if the model has no tilt.
///
/// An absent body neither detects nor is detected. Its pending detections are dropped when it
/// leaves.
class CameraWorld final : public SensingWorld {
 public:
  /// @param source  built for the same options and team
  /// @throws std::invalid_argument for a camera or tags out of range, and for a world that already
  /// provides detections
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
  std::optional<double> last_{};  // time of the last measure() [s]
  std::vector<Detection> found_;  // in one picture
  UnderWay<Detection> detections_;
};

}  // namespace sightline
