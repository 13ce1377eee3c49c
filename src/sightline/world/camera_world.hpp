/// A world with cameras: what the robots' cameras see of the bodies with tags comes as detections beside the states.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/world/detection_source.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// Any world that knows the truth, seen by cameras. A picture is taken at the first measure() at which it is due, so its stamp is a
/// whole number of periods; it arrives at the first one after its latency. What it shows is the truth then: the attitudes that the
/// world tells, of other robots those that their models say, upright where they say none.
///
/// A body that is absent neither sees nor is seen, and what it saw before it went does not arrive any more.
class CameraWorld final : public World {
 public:
  /// @param source  of the same options and team
  /// @throws std::invalid_argument for a camera or tags out of range, and for a world that gives detections of its own
  CameraWorld(std::unique_ptr<World> world, CameraOptions options, std::unique_ptr<DetectionSource> source);

  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  MeasuredMost measured_max() const noexcept override {
    MeasuredMost most = world_->measured_max();
    most.detections = waiting_.size();
    return most;
  }
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> believed, std::span<const double> u, double period,
             std::int64_t periods) noexcept override;
  std::string ended() const override { return world_->ended(); }

  /// The world that is seen.
  World& seen() noexcept { return *world_; }

 private:
  struct Shutter {
    std::int64_t next = 0;  // number of the next picture, due at next / rate
    RandomStream chance;
  };

  void place_bodies(const Measured& now) noexcept;
  void take_picture(std::size_t camera, double t) noexcept;
  std::span<const Detection> arrived(double t) noexcept;

  std::unique_ptr<World> world_;
  CameraOptions options_;
  std::unique_ptr<DetectionSource> source_;
  std::vector<Shutter> shutters_;
  std::vector<ExposedBody> bodies_;
  std::vector<double> applied_;               // inputs, by which robots lean
  std::optional<double> last_{};              // measure() [s]
  std::vector<Detection> found_;              // in one picture
  std::vector<Detection> waiting_, arrived_;  // the first waiting_count_ wait
  std::size_t waiting_count_ = 0;
};

}  // namespace sightline
