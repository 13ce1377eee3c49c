/// Contributions of non-relative potentials, over lanes: gradients and Hessians per agent, and the
/// blocks that couple two agents.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/solver/newton/pair_batch.hpp"

namespace sightline {

/// x where the mask is 1, else 0, even if x is not finite.
template <int W>
Lane<W> masked(Lane<W> mask, Lane<W> x) {
  return Lane<W>(mask.v > 0.5 ? x.v : typename Lane<W>::Vector{});
}

/// A slot collects pairs between the same two groups, each lane used once. Its numbers are stored
/// in the lanes of a, or of b if a is not controlled. A slot with one gathered pair reads its
/// numbers directly from the points. Arrays s, c, z, y follow the layout.
template <int W>
class CrossBlocks {
 public:
  /// @param batches, layout  must outlive the object; their pairs do not change
  CrossBlocks(const std::vector<PairBatch>& batches, const Layout& layout, KernelChoice choice)
      : batches_(batches),
        layout_(layout),
        slots_of_(batches.size()),
        in_place_of_(layout.groups.size()),
        into_(layout.groups.size()),
        from_(layout.groups.size()) {
    for (std::size_t b = 0; b < batches.size(); ++b) {
      const std::size_t before = slots_.size();
      for (const BodyPotential* pair : batches[b].pairs) slots_of_[b].push_back(add(*pair, b, choice));
      in_place_.push_back(fills_lanes(batches[b], slots_.size() - before));
      lines_.push_back(
          {lines(batches[b].pairs[0]->potential, false), lines(batches[b].pairs[0]->potential, true)});
      if (!in_place(b)) find_lone(b);
    }
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const Slot& slot = slots_[i];
      if (!in_place(slot.batch)) continue;
      in_place_of_[at(slot.group_a >= 0 ? slot.group_a : slot.group_b)].push_back(static_cast<int>(i));
    }
  }

  /// Whether the pairs of a batch are evaluated in the lanes of their agents; other batches are
  /// gathered.
  bool in_place(std::size_t batch) const { return in_place_[batch] != 0; }
  bool all_in_place() const { return std::all_of(in_place_.begin(), in_place_.end(), std::identity()); }
  std::vector<std::pair<int, int>> coupled_groups() const {
    std::vector<std::pair<int, int>> list;
    for (const Slot& slot : slots_) {
      if (slot.group_a >= 0 && slot.group_b >= 0) list.emplace_back(slot.group_a, slot.group_b);
    }
    return list;
  }

  /// Evaluates at s the in-place slots stored in the lanes of a group.
  void derive(int group, const StageParameters& parameters, const double* s) noexcept {
    for (const int slot : in_place_of_[at(group)]) derive(slots_[at(slot)], parameters, s);
  }
  /// Copies the results of the last `derive` of a gathered batch.
  void take(std::size_t batch) noexcept {
    const std::vector<int>& slots = slots_of_[batch];
    const int N = layout_.stages;
    for (std::size_t p = 0; p < slots.size(); ++p) {
      Slot& slot = slots_[at(slots[p])];
      if (slot.lone_at >= 0) continue;
      const BodyPotential& pair = *batches_[batch].pairs[p];
      double* const to = slot.out[0] + layout_.place(pair.a >= 0 ? pair.a : pair.b).lane;
      for (int o = 0; o < slot.outputs; ++o) {
        batches_[batch].points.each_out(static_cast<int>(p) * N, N, o,
                                        [&](int k, double value) { to[(k * slot.outputs + o) * W] = value; });
      }
    }
  }

  /// c += gradients and own Hessians of one group's agents; c points to the group's part.
  void add(int group, double* c) const noexcept {
    const int stage = layout_.groups[at(group)].nc() * W;
    for (const Felt& felt : into_[at(group)]) {
      const Slot& slot = slots_[at(felt.slot)];
      if (slot.lone_at >= 0) {
        add_lone(slot, felt, stage, c);
        continue;
      }
      const L b_mask = slot.b_mask;
      each_stage(slot, [&](int k, auto&& number) {
        double* const c_k = c + k * stage;
        for (const Own& own : felt.own) {
          const L of_a = number(own.output),
                  felt_number = felt.of_b ? masked(b_mask, permuted(of_a, slot.lead_of_b)) : of_a;
          fma(L(own.sign), felt_number, L::load(c_k + own.entry)).store(c_k + own.entry);
        }
      });
    }
  }

  /// y += C z, all rows.
  void product(const double* z, double* y) const noexcept {
    for (int g = 0; g < static_cast<int>(into_.size()); ++g) product(g, z, y);
  }
  /// The rows of one group.
  void product(int group, const double* z, double* y) const noexcept {
    for (const Felt& felt : into_[at(group)]) product(slots_[at(felt.slot)], felt.of_b, z, y);
  }
  /// The rows of one group of C'.
  void transposed_product(int group, const double* z, double* y) const noexcept {
    for (const auto& [slot, of_b] : from_[at(group)]) product(slots_[at(slot)], of_b, z, y);
  }

 private:
  using L = Lane<W>;

  struct Slot {
    typename L::Bits b_of_a{}, lead_of_b{};  // lane of the partner; lane of a for b
    L mask = 0.0, b_mask = 0.0;              // lanes in use
    int group_a = -1, group_b = -1;          // -1: not controlled
    std::size_t batch = 0;
    int outputs = 0;
    PackFormula<W> formula;
    int lone_at = -1;  // first point of its only pair; -1: numbers are in `out`
    Rows out{};        // [stage][output][lane], zero in lanes not in use
  };
  /// One number of c, at `entry` within its stage, from one output.
  struct Own {
    int entry, output;
    double sign;
  };
  /// Contribution of a slot to a group, through its a or its b.
  struct Felt {
    int slot;
    bool of_b;
    int lane;  // of its only pair
    std::vector<Own> own;
  };
  /// One row of C: `factor` indexes the partner's numbers, then the same negated.
  struct Line {
    struct Term {
      int output, factor;
    };
    int row;
    std::vector<Term> terms;
  };

  void derive(Slot& its, const StageParameters& parameters, const double* s) const noexcept {
    const PosePotential& potential = potential_of(its);
    const double part = batches_[its.batch].points.part();
    alignas(row_alignment) std::array<double, PosePotential::variable_count * W> in;
    for (int k = 0; k < layout_.stages; ++k) {
      double* to = in.data();
      for (const int v : potential.variables) {
        L number;
        if (v == PosePotential::time_variable) {
          number = parameters.time[0][k];
        } else if (v >= sight_size) {
          const Layout::Part& of = layout_.groups[at(its.group_b)];
          number = permuted(L::load(s + of.s + (k * of.ns + v - sight_size) * W), its.b_of_a);
        } else {
          const Layout::Part& of = layout_.groups[at(its.group_a)];
          number = L::load(s + of.s + (k * of.ns + v) * W);
        }
        number.store(to);
        to += W;
      }
      double* const out = its.out[0] + k * its.outputs * W;
      its.formula.run(in.data(), out);
      for (int o = 0; o < its.outputs; ++o)
        masked(its.mask, L(part) * L::load(out + o * W)).store(out + o * W);
    }
  }

  /// use(k, number) at each stage; number(o) is output o over the lanes of a; for a lone pair over
  /// all lanes.
  template <class Use>
  void each_stage(const Slot& slot, Use&& use) const noexcept {
    for (int k = 0; k < layout_.stages; ++k) {
      if (slot.lone_at >= 0) {
        const double* const out = batches_[slot.batch].points.out(slot.lone_at + k, 0);
        use(k, [&](int o) { return L(out[o * Points::W]); });
      } else {
        const double* const out = slot.out[0] + k * slot.outputs * W;
        use(k, [&](int o) { return L::load(out + o * W); });
      }
    }
  }

  const PosePotential& potential_of(const Slot& slot) const {
    return batches_[slot.batch].pairs[0]->potential;
  }

  /// In place pays if half of the lanes are in use; requires that no uncontrolled body occurs.
  static bool fills_lanes(const PairBatch& batch, std::size_t slots) {
    const BodyPotential& first = *batch.pairs[0];
    const bool agents_alone =
        std::all_of(first.potential.variables.begin(), first.potential.variables.end(), [&](int v) {
          return v == PosePotential::time_variable ||
                 (v < PosePotential::time_variable && (v >= sight_size ? first.b >= 0 : first.a >= 0));
        });
    return W >= 4 && agents_alone && 2 * batch.pairs.size() >= static_cast<std::size_t>(W) * slots;
  }

  /// @return index of the slot
  int add(const BodyPotential& pair, std::size_t batch, KernelChoice choice) {
    const Layout::Place none{-1, 0};
    const Layout::Place a = pair.a >= 0 ? layout_.place(pair.a) : none,
                        b = pair.b >= 0 ? layout_.place(pair.b) : none;
    const int lead = pair.a >= 0 ? a.lane : b.lane;
    auto slot = std::find_if(slots_.begin(), slots_.end(), [&](const Slot& s) {
      return s.batch == batch && s.group_a == a.group && s.group_b == b.group && s.mask[lead] == 0 &&
             (pair.b < 0 || s.b_mask[b.lane] == 0);
    });
    if (slot == slots_.end()) {
      const Program& derivatives = batches_[batch].pairs[0]->potential.derivatives;
      slot = slots_.insert(slot, {.group_a = a.group,
                                  .group_b = b.group,
                                  .batch = batch,
                                  .outputs = derivatives.outputs(),
                                  .formula = {derivatives, choice},
                                  .out = Rows(1, layout_.stages * derivatives.outputs() * W)});
      const int made = static_cast<int>(slot - slots_.begin());
      if (pair.a >= 0 && pair.ends.a_feels) feel(made, pair, false);
      if (pair.b >= 0 && pair.ends.b_feels) feel(made, pair, true);
      if (pair.a >= 0 && pair.b >= 0) {
        if (pair.ends.b_feels) from_[at(a.group)].emplace_back(made, false);
        if (pair.ends.a_feels) from_[at(b.group)].emplace_back(made, true);
      }
    }
    slot->mask.v[lead] = 1.0;
    if (pair.b >= 0) {
      slot->b_of_a[lead] = b.lane;
      slot->lead_of_b[b.lane] = lead;
      slot->b_mask.v[b.lane] = 1.0;
    }
    return static_cast<int>(slot - slots_.begin());
  }

  void feel(int slot, const BodyPotential& pair, bool of_b) {
    const int group = layout_.place(of_b ? pair.b : pair.a).group, ns = layout_.groups[at(group)].ns;
    const int from = of_b ? sight_size : 0;
    const PosePotential& potential = potential_of(slots_[at(slot)]);
    Felt felt{slot, of_b, layout_.place(of_b ? pair.b : pair.a).lane, {}};
    const auto own = [&](bool negative, int entry, int output) {
      felt.own.push_back({entry * W, output, negative ? -1.0 : 1.0});
    };
    for (const auto& g : potential.gradient)
      if ((g.variable >= sight_size) == of_b) own(g.negative, g.variable - from, g.output);
    for (const auto& h : potential.own)
      if ((h.row >= sight_size) == of_b)
        own(h.negative, ns + upper_index(h.row - from, h.column - from, ns), h.output);
    into_[at(group)].push_back(std::move(felt));
  }

  static std::vector<Line> lines(const PosePotential& potential, bool of_b) {
    std::vector<Line> all;
    for (const PosePotential::Second& entry : potential.cross) {
      const int of_a = entry.row, of_partner = entry.column - sight_size;
      const int row = of_b ? of_partner : of_a, factor = of_b ? of_a : of_partner;
      auto line = std::find_if(all.begin(), all.end(), [&](const Line& l) { return l.row == row; });
      if (line == all.end()) line = all.insert(line, {row, {}});
      line->terms.push_back({entry.output, entry.negative ? factor + sight_size : factor});
    }
    return all;
  }

  void find_lone(std::size_t batch) {
    const std::vector<int>& slots = slots_of_[batch];
    for (std::size_t p = 0; p < slots.size(); ++p) {
      if (std::count(slots.begin(), slots.end(), slots[p]) > 1) continue;
      slots_[at(slots[p])].lone_at = static_cast<int>(p) * layout_.stages;
      slots_[at(slots[p])].out = Rows();
    }
  }

  void add_lone(const Slot& slot, const Felt& felt, int stage, double* c) const noexcept {
    for (const Own& own : felt.own) {
      double* const to = c + own.entry + felt.lane;
      const double sign = own.sign;
      batches_[slot.batch].points.each_out(slot.lone_at, layout_.stages, own.output,
                                           [&](int k, double value) { to[k * stage] += sign * value; });
    }
  }

  void product(const Slot& slot, bool of_b, const double* z, double* y) const noexcept {
    const std::vector<Line>& lines = lines_[slot.batch][of_b];
    if (lines.empty()) return;
    const Layout::Part &part_a = layout_.groups[at(slot.group_a)], &part_b = layout_.groups[at(slot.group_b)];
    const Layout::Part &part = of_b ? part_b : part_a, &partner = of_b ? part_a : part_b;
    const L mask = of_b ? slot.b_mask : slot.mask;
    std::array<L, 2 * sight_size> factors;
    each_stage(slot, [&](int k, auto&& number) {
      const double* const z_k = z + partner.s + k * partner.ns * W;
      double* const y_k = y + part.s + k * part.ns * W;
      for (int i = 0; i < partner.ns; ++i) {
        const L of_partner = L::load(z_k + i * W),
                factor = of_b ? of_partner : permuted(of_partner, slot.b_of_a);
        factors[at(i)] = factor, factors[at(i + sight_size)] = -factor;
      }
      for (const Line& line : lines) {
        L row = 0.0;
        for (const auto& term : line.terms) row = fma(number(term.output), factors[at(term.factor)], row);
        if (of_b) row = permuted(row, slot.lead_of_b);
        (L::load(y_k + line.row * W) + masked(mask, row)).store(y_k + line.row * W);
      }
    });
  }

  const std::vector<PairBatch>& batches_;
  const Layout& layout_;
  std::vector<Slot> slots_;
  std::vector<std::vector<int>> slots_of_;               // [batch][pair]
  std::vector<char> in_place_;                           // [batch]
  std::vector<std::vector<int>> in_place_of_;            // [group]: slots
  std::vector<std::array<std::vector<Line>, 2>> lines_;  // [batch][of b]
  std::vector<std::vector<Felt>> into_;                  // [group]
  std::vector<std::vector<std::pair<int, bool>>> from_;  // [group]: slots whose other end feels, of b
};

}  // namespace sightline
