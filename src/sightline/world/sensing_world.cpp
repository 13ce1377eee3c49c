#include "sightline/base.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

SensingWorld::SensingWorld(std::unique_ptr<World> world)
    : world_(std::move(world)), applied_(size(world_->team().nu())) {}

bool SensingWorld::apply(double t, std::span<const double> estimated, const Command& u, double period,
                         std::int64_t periods) noexcept {
  std::copy(u.begin(), u.end(), applied_.begin());
  return world_->apply(t, estimated, u, period, periods);
}

Sight<double> SensingWorld::sight_of(BodyId body, std::span<const double> x) const noexcept {
  const Team& all = team();
  return all.model(body).sight(&x[size(all.state_offset(body))], applied_.data() + all.input_offset(body));
}

Quaternion SensingWorld::attitude_of(BodyId body, const Sight<double>& sight,
                                     const Measured& now) const noexcept {
  const bool received = at(body) < now.attitudes.size() && now.attitudes[at(body)] != no_attitude;
  return received ? now.attitudes[at(body)] : leaning(sight.d, sight.lean);
}

}  // namespace sightline
