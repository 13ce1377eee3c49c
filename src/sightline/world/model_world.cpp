#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

ModelWorld::ModelWorld(Team team, std::vector<double> x0, const PlantOptions& plant,
                       const SensorOptions& sensor)
    : plant_(std::move(team), x0, plant),
      sensor_(plant_.team(), sensor),
      start_(std::move(x0)),
      presence_(size(plant_.team().bodies()), Presence::steered) {}

void ModelWorld::set_presence(std::span<const Presence> presence) noexcept {
  plant_.set_presence(presence);
  for (std::size_t i = 0; i < std::min(presence.size(), presence_.size()); ++i) {
    const Presence was = std::exchange(presence_[i], presence[i]);
    // Measurements from before the body left must not reach the body that starts again.
    if (was == Presence::absent && presence_[i] != Presence::absent)
      sensor_.begin(BodyId{static_cast<int>(i)}, plant_.x());
  }
}

void ModelWorld::surround(const Surroundings& around) noexcept {
  plant_.surround(around);
  sensor_.surround(around);
}

Measured ModelWorld::measure(double t) noexcept {
  const std::span<const double> measured = sensor_.measure(t, plant_.sensed());
  return {measured, sensor_.stamps(), plant_.x()};
}

/// Returns false if a state is no longer finite.
bool ModelWorld::apply(double, std::span<const double>, const Command& u, double period,
                       std::int64_t periods) noexcept {
  bool finite = true;
  for (; periods > 0; --periods) finite = plant_.step(u, period) && finite;
  return finite;
}

}  // namespace sightline
