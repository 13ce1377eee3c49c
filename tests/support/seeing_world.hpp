/// The model's world, in which the first body says where it sees the second.
#pragma once

#include <array>

#include "sightline/worlds.hpp"

namespace sightline::test {

class SeeingWorld : public World {
 public:
  explicit SeeingWorld(Team team, std::vector<double> x0, const PlantOptions& plant = {},
                       const SensorOptions& sensor = {})
      : model_(std::move(team), std::move(x0), plant, sensor) {}

  const Team& team() const noexcept override { return model_.team(); }
  std::span<const double> start() const noexcept override { return model_.start(); }
  MeasuredMost measured_max() const noexcept override { return {.detections = seen_.size()}; }
  void set_presence(std::span<const Presence> presence) noexcept override { model_.set_presence(presence); }
  Measured measure(double t) noexcept override {
    Measured measured = model_.measure(t);
    seen_[0].stamp = t;
    seen_[0].p = {measured.measured[7] - measured.measured[0], t, 0};
    measured.detections = seen_;
    return measured;
  }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override {
    return model_.apply(t, estimated, u, period, periods);
  }

 private:
  ModelWorld model_;
  std::array<Detection, 1> seen_{Detection{.observer = BodyId{0}, .target = BodyId{1}}};
};

}  // namespace sightline::test
