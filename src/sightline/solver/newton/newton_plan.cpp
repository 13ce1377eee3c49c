// The plan of a NewtonUpdate as others read and set it, and what others predict of themselves.
#include <algorithm>
#include <cmath>

#include "sightline/base/index.hpp"
#include "sightline/solver/newton/newton_update.hpp"

namespace sightline {

void NewtonUpdate::planned(double time, std::span<double> u) const noexcept {
  if (u.size() != u_out_.size()) return;
  const double stages = (time - plan_time_) / ocp_.horizon().h();
  const int k = static_cast<int>(clamp(std::isfinite(stages) ? stages : 0.0, 0.0, ocp_.horizon().N - 1.0));
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    const Layout::View from = groups_.layout().u(a);
    const std::size_t to = at(ocp_.team().input_offset(ocp_.agent_bodies()[at(a)]));
    for (int i = 0; i < groups_.layout().part(a).nu; ++i) u[to + at(i)] = plan_[from(k, i)];
  }
}

bool NewtonUpdate::is_stage(int k, std::span<const double> u) const noexcept {
  return k >= 0 && k < ocp_.horizon().N && u.size() == u_out_.size();
}

void NewtonUpdate::plan(int k, std::span<double> u) const noexcept {
  if (!is_stage(k, u)) return;
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    const Layout::View from = groups_.layout().u(a);
    const std::size_t to = at(ocp_.team().input_offset(ocp_.agent_bodies()[at(a)]));
    for (int i = 0; i < groups_.layout().part(a).nu; ++i) u[to + at(i)] = u_[from(k, i)];
  }
}

void NewtonUpdate::set_plan(int k, std::span<const double> u) noexcept {
  if (!is_stage(k, u)) return;
  detach_plan();
  has_plan_ = true;
  started_ = false;
  for (int a = 0; a < static_cast<int>(ocp_.agent_bodies().size()); ++a) {
    const Layout::View to = groups_.layout().u(a);
    const std::size_t from = at(ocp_.team().input_offset(ocp_.agent_bodies()[at(a)]));
    for (int i = 0; i < groups_.layout().part(a).nu; ++i) u_[to(k, i)] = u[from + at(i)];
  }
}

void NewtonUpdate::set_prediction(const Prediction& prediction) noexcept {
  if (prediction.who.index < 0 || prediction.who.index >= ocp_.team().bodies() ||
      ocp_.team().is_agent(prediction.who))
    return;
  Prediction& to = predictions_[at(prediction.who.index)];
  if (prediction.sights.size() > to.sights.capacity()) return;
  to.time = prediction.time;
  to.h = prediction.h;
  to.sights.assign(prediction.sights.begin(), prediction.sights.end());
}

void NewtonUpdate::set_view_uncertainty(std::span<const ViewUncertainty> of_bodies) noexcept {
  if (of_bodies.size() != predictions_.size()) return;
  const Horizon& horizon = ocp_.horizon();
  for (std::size_t b = 0; b < of_bodies.size(); ++b) {
    for (int k = 0; k < horizon.N; ++k)
      couplings_->set_uncertainty(static_cast<int>(b), k, of_bodies[b].after(k * horizon.h()));
  }
}

void NewtonUpdate::set_applied(const AppliedInputs& applied) noexcept {
  if (applied.previous.size() != u_out_.size() || applied.offset.size() != u_out_.size()) return;
  limits_move_ = true;
  before_.assign(applied.previous.begin(), applied.previous.end());
  added_.assign(applied.offset.begin(), applied.offset.end());
  for (int a = 0; a < static_cast<int>(x_at_.size()); ++a) {
    const BodyId robot = ocp_.agent_bodies()[at(a)];
    if (applied.lean.size() == predictions_.size()) groups_.set_lean(a, applied.lean[at(robot)]);
    if (applied.u_ref.size() == u_out_.size())
      groups_.set_u_ref(a, applied.u_ref.data() + ocp_.team().input_offset(robot));
  }
}

}  // namespace sightline
