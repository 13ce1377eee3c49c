#include "sightline/safety/threat_selection.hpp"

#include <cassert>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline {

ThreatSelection::Requester::Requester(int bodies)
    : cooperative(at(bodies)), chosen_(at(bodies)), key_(at(bodies)), chosen_key_(at(bodies)) {}

ThreatSelection::ThreatSelection(int bodies) : ids_(at(bodies)) {
  for (std::vector<double> *const column : {&p_x_, &p_y_, &p_z_, &v_x_, &v_y_, &v_z_, &hard_, &speed_})
    column->resize(at(bodies));
}

void ThreatSelection::add(const Body &body) noexcept {
  assert(count_ < ids_.size() && "there is room for each body");
  const std::size_t i = count_++;
  ids_[i] = body.id;
  p_x_[i] = body.p.x, p_y_[i] = body.p.y, p_z_[i] = body.p.z;
  v_x_[i] = body.v.x, v_y_[i] = body.v.y, v_z_[i] = body.v.z;
  hard_[i] = body.d_hard, speed_[i] = body.speed_max;
}

std::span<const int> ThreatSelection::nearest_threats(int self, const Vec3<double> &p, const Vec3<double> &v,
                                                      std::size_t most, Requester &requester) const noexcept {
  const std::size_t n = count_;
  const double *const p_x = p_x_.data(), *const p_y = p_y_.data(), *const p_z = p_z_.data();
  const double *const v_x = v_x_.data(), *const v_y = v_y_.data(), *const v_z = v_z_.data();
  const double *const hard = hard_.data(), *const speed = speed_.data(),
                      *const c = requester.cooperative.data();
  double *const key = requester.key_.data();
  std::vector<int> &chosen = requester.chosen_;
  std::vector<double> &chosen_key = requester.chosen_key_;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3<double> r = {p.x - p_x[i], p.y - p_y[i], p.z - p_z[i]};
    const Vec3<double> w = {v.x - c[i] * v_x[i], v.y - c[i] * v_y[i], v.z - c[i] * v_z[i]};
    key[i] = nearest_threats_key(r, w, hard[i], (1.0 - c[i]) * speed[i]);
  }
  std::size_t count = 0;
  double last = infinity;  // a key must be less than this to be selected
  for (std::size_t i = 0; i < n; ++i) {
    if (!(key[i] < last) || ids_[i] == self) continue;
    if (count < most) ++count;
    std::size_t to = count - 1;
    for (; to > 0 && chosen_key[to - 1] > key[i]; --to)
      chosen_key[to] = chosen_key[to - 1], chosen[to] = chosen[to - 1];
    chosen_key[to] = key[i], chosen[to] = ids_[i];
    if (count == most) last = chosen_key[most - 1];
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(key[i]) && ids_[i] != self) chosen[count++] = ids_[i];
  }
  return std::span(chosen).first(count);
}

}  // namespace sightline
