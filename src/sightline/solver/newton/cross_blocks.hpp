/// The blocks of the Hessian that couple two agents by potentials that are not relative, over lanes.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "sightline/base/index.hpp"
#include "sightline/solver/newton/pair_batch.hpp"

namespace sightline {

/// Of pairs whose agents stand in two groups, each lane used once, the blocks are side by side: one product for all of them. Arrays
/// z, y are those of the layout.
template <int W>
class CrossBlocks {
 public:
  /// @param batches, layout  outlive it; their pairs do not change
  CrossBlocks(const std::vector<PairBatch>& batches, const Layout& layout)
      : batches_(batches), layout_(layout), slots_of_(batches.size()), into_(layout.groups.size()) {
    for (std::size_t b = 0; b < batches.size(); ++b) {
      if (cross(b).empty()) continue;
      for (const BodyPotential* pair : batches[b].pairs) slots_of_[b].push_back(add(*pair, b));
    }
  }

  /// Those of the batch's last `derive`.
  void take(std::size_t batch) noexcept {
    const std::vector<int>& slots = slots_of_[batch];
    const int N = layout_.stages, stage = static_cast<int>(cross(batch).size()) * W;
    for (std::size_t p = 0; p < slots.size(); ++p) {
      double* H = slots_[at(slots[p])].H[0] + layout_.place(batches_[batch].pairs[p]->a).lane;
      for (const PosePotential::Second& entry : cross(batch)) {
        const double sign = entry.negative ? -1.0 : 1.0;
        batches_[batch].points.each_out(static_cast<int>(p) * N, N, entry.output,
                                        [&](int k, double value) { H[k * stage] = sign * value; });
        H += W;
      }
    }
  }

  /// y += C z, all rows.
  void product(const double* z, double* y) const noexcept {
    for (const Slot& slot : slots_) product(slot, feels(slot).a_feels, feels(slot).b_feels, z, y);
  }
  /// The rows of one group.
  void product(int group, const double* z, double* y) const noexcept {
    for (const auto& [slot, of_b] : into_[at(group)]) product(slots_[at(slot)], !of_b, of_b, z, y);
  }

 private:
  using L = Lane<W>;

  struct Slot {
    typename L::Bits b_of_a{}, a_of_b{};  // lane of the partner
    L a_mask = 0.0, b_mask = 0.0;         // lanes in use
    int group_a = 0, group_b = 0;
    std::size_t batch = 0;
    Rows H{};  // [stage][entry][lane], zero in lanes not in use
  };

  const std::vector<PosePotential::Second>& cross(std::size_t batch) const {
    return batches_[batch].pairs[0]->potential.cross;
  }
  const Ends& feels(const Slot& slot) const { return batches_[slot.batch].pairs[0]->ends; }

  /// @return its slot
  int add(const BodyPotential& pair, std::size_t batch) {
    const Layout::Place a = layout_.place(pair.a), b = layout_.place(pair.b);
    auto slot = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) {
      return s.batch == batch && s.group_a == a.group && s.group_b == b.group && s.a_mask[a.lane] == 0 &&
             s.b_mask[b.lane] == 0;
    });
    if (slot == slots_.end()) {
      const int numbers = layout_.stages * static_cast<int>(cross(batch).size()) * W;
      slot = slots_.insert(slot,
                           {.group_a = a.group, .group_b = b.group, .batch = batch, .H = Rows(1, numbers)});
      const int made = static_cast<int>(slot - slots_.begin());
      if (pair.ends.a_feels) into_[at(a.group)].emplace_back(made, false);
      if (pair.ends.b_feels) into_[at(b.group)].emplace_back(made, true);
    }
    slot->b_of_a[a.lane] = b.lane;
    slot->a_of_b[b.lane] = a.lane;
    slot->a_mask.v[a.lane] = 1.0;
    slot->b_mask.v[b.lane] = 1.0;
    return static_cast<int>(slot - slots_.begin());
  }

  void product(const Slot& slot, bool of_a, bool of_b, const double* z, double* y) const noexcept {
    const Layout::Part &part_a = layout_.groups[at(slot.group_a)], &part_b = layout_.groups[at(slot.group_b)];
    const double* H = slot.H[0];
    for (int k = 0; k < layout_.stages; ++k) {
      const std::ptrdiff_t a = part_a.s + k * part_a.ns * W, b = part_b.s + k * part_b.ns * W;
      for (const PosePotential::Second& entry : cross(slot.batch)) {
        double *const of_i = y + a + entry.row * W, *const of_j = y + b + (entry.column - sight_size) * W;
        const L block = L::load(H), z_a = L::load(z + (of_i - y)), z_b = L::load(z + (of_j - y));
        H += W;
        if (of_a) (L::load(of_i) + block * permuted(z_b, slot.b_of_a)).store(of_i);
        if (of_b) (L::load(of_j) + permuted(block * z_a, slot.a_of_b) * slot.b_mask).store(of_j);
      }
    }
  }

  const std::vector<PairBatch>& batches_;
  const Layout& layout_;
  std::vector<Slot> slots_;
  std::vector<std::vector<int>> slots_of_;               // [batch][pair]
  std::vector<std::vector<std::pair<int, bool>>> into_;  // [group]: slots, and whether it is by their b
};

}  // namespace sightline
