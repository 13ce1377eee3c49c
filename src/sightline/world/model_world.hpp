/// The simulated world of the models: a plant and a sensor.
#pragma once

#include <utility>
#include <vector>

#include "sightline/world/plant.hpp"
#include "sightline/world/sensor.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

class ModelWorld final : public World {
 public:
  /// @param x0  states of all bodies, in team order (nx)
  /// @throws std::invalid_argument as Plant and Sensor
  ModelWorld(Team team, std::vector<double> x0, const PlantOptions& plant = {},
             const SensorOptions& sensor = {});

  const Team& team() const noexcept override { return plant_.team(); }
  std::span<const double> start() const noexcept override { return start_; }
  void set_presence(std::span<const Presence> presence) noexcept override;
  void surround(const Surroundings& around) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  std::span<const double> truth() const noexcept override { return plant_.x(); }
  /// True states of all bodies (nx).
  std::span<const double> x() const noexcept { return plant_.x(); }

 private:
  Plant plant_;
  Sensor sensor_;
  std::vector<double> start_;  // x0 as given, before normalisation: a replay needs the same
  std::vector<Presence> presence_;
};

}  // namespace sightline
