#include "sightline/solver/newton/coupling.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/solver/newton/cross_blocks.hpp"
#include "sightline/solver/newton/neighbourhood.hpp"
#include "sightline/solver/newton/pair_batch.hpp"

namespace sightline {
namespace {

constexpr int relative = PosePotential::relative_size;
constexpr int relative_outputs = relative + relative * (relative + 1) / 2;
constexpr int upper(int i, int j) {
  return i < j ? upper_index(i, j, relative) : upper_index(j, i, relative);
}

/// Row i of the potentials' Hessian in (r, d) times (v_0, v_1, v_2).
template <class L>
[[gnu::always_inline]] inline L row_of_three(const L* H, int i, const L* v) {
  return fma(H[upper(i, 2)], v[2], fma(H[upper(i, 1)], v[1], H[upper(i, 0)] * v[0]));
}
template <class L>
[[gnu::always_inline]] inline L row_of_five(const L* H, int i, const L* v) {
  return fma(H[upper(i, 4)], v[4], fma(H[upper(i, 3)], v[3], row_of_three(H, i, v)));
}

/// Pairs of relative potentials between two groups, each lane used once; numbers are stored in the
/// lanes of a.
template <int W>
struct Slot {
  typename Lane<W>::Bits b_of_a{}, a_of_b{};  // lane of the partner
  Lane<W> a_mask = 0.0, b_mask = 0.0;         // lanes in use
  int group_a = 0, group_b = 0;
  bool a_feels = true, b_feels = true;
  const PosePotential* potential = nullptr;                  // of all pairs, if equal
  Ramp ramp{};                                               // of all pairs
  double part = 1.0;                                         // active fraction of the weights
  bool in_place = false;                                     // evaluated over the lanes of agents
  std::vector<PackFormula<W>> formulas;                      // derivatives of the potential, to be summed
  std::vector<std::pair<std::size_t, std::size_t>> pairs{};  // relative batch, index in it
  double* out = nullptr;  // [stage][gradient and Hessian][lane], zero in lanes not in use
};

/// Each potential is evaluated by the first applicable method:
///
///   lone pair   the only potential, relative, one group of two lanes  lanes are stages, no sums
///   in place    half of its slots' lanes in use, agents only          lanes are agents
///   gathered    otherwise                                             lanes are points of a batch
///
/// and pairs of a swarm by Neighbourhood. Gathered batches, then the slots of each group, are
/// evaluated independently; then each group takes the derivatives that act on it.
template <int W>
class LaneCouplings final : public Couplings {
  using L = Lane<W>;

 public:
  using Couplings::derive;
  using Couplings::product;

  LaneCouplings(std::span<const BodyPotential> pairs, const Layout& layout, int bodies, KernelChoice choice,
                std::span<const SwarmPotential> swarms)
      : Couplings(layout),
        first_(pairs.data()),
        parameters_{Rows(sight_size * bodies, layout.stages), Rows(1, layout.stages),
                    Rows(bodies, layout.stages)} {
    for (const BodyPotential& pair : pairs) add(pair, choice);
    // Reverse chain order: each slot but one finds its second group already written.
    std::sort(slots_.begin(), slots_.end(),
              [](const Slot<W>& a, const Slot<W>& b) { return a.group_a > b.group_a; });
    outputs_ = Rows(static_cast<int>(slots_.size()), layout.stages * relative_outputs * W);
    for (Slot<W>& slot : slots_) settle(slot, choice);
    for (const SwarmPotential& swarm : swarms) swarms_.emplace_back(swarm, layout_, choice);
    find_slots();
    crosses_.emplace(general_, layout_, choice);
    rows_into_ = find_rows(false);
    rows_from_ = find_rows(true);
    for (PairBatch& b : general_) b.points.resize(static_cast<int>(b.pairs.size()) * layout.stages);
    for (PairBatch& b : relative_) b.points.resize(static_cast<int>(b.pairs.size()) * layout.stages);
    lone_pair_ = W == 2 && swarms.empty() && pairs.size() == 1 && slots_.size() == 1 &&
                 layout.groups.size() == 1 && layout.groups[0].ns == relative;
  }

  void set_time(int k, double t) noexcept override { parameters_.time[0][k] = t; }
  void set_uncertainty(int body, int k, double sigma) noexcept override {
    parameters_.uncertainty[body][k] = sigma;
  }
  void set_weights(double t) noexcept override {
    for (std::vector<PairBatch>* batches : {&relative_, &general_}) {
      for (PairBatch& batch : *batches) batch.points.set_part(batch.pairs[0]->ramp.at(t));
    }
    for (Slot<W>& slot : slots_) slot.part = slot.ramp.at(t);
  }
  void set_body(int body, int k, const Sight<double>& sight) noexcept override {
    std::array<double, sight_size> s;
    write_sight(sight, s);
    for (int i = 0; i < sight_size; ++i) parameters_.bodies[body * sight_size + i][k] = s[at(i)];
  }

  bool gathers() const noexcept override {
    return lone_pair_ || has_swarms() || !std::all_of(in_place_.begin(), in_place_.end(), std::identity()) ||
           !crosses_->all_in_place();
  }
  void gather(const double* s, double* c, ThreadPool& pool) noexcept override {
    if (lone_pair_) return derive_lone_pair(s);
    const int batches = static_cast<int>(relative_.size()), general = static_cast<int>(general_.size());
    pool.share(batches + general, [&](int b, int) noexcept {
      b < batches ? gather_relative(at(b), s) : gather_general(at(b - batches), s);
    });
    if (swarms_.empty()) return;
    std::fill_n(c, layout_.c_length, 0.0);
    for (Neighbourhood& swarm : swarms_) swarm.evaluate(s, c);
  }
  void derive(int group, const double* s) noexcept override {
    if (lone_pair_) return;
    for (const int i : slots_of_group_[at(group)]) {
      if (Slot<W>& slot = slots_[at(i)]; slot.in_place) derive_in_place(slot, s);
    }
    crosses_->derive(group, parameters_, s);
  }
  std::vector<std::pair<int, int>> coupled_groups() const override {
    std::vector<std::pair<int, int>> list = crosses_->coupled_groups();
    for (const Slot<W>& slot : slots_) list.emplace_back(slot.group_a, slot.group_b);
    return list;
  }

  void take(int group, double* c) const noexcept override {
    if (lone_pair_) return take_lone_pair(c);
    const Layout::Part& part = layout_.groups[at(group)];
    const FeltRows& rows = rows_into_[at(group)];
    const bool assigns = rows.assigns && swarms_.empty();
    if (swarms_.empty()) std::fill_n(c, (assigns ? 1 : layout_.stages) * part.nc() * W, 0.0);
    for (std::size_t i = 0; i < rows.felt.size(); ++i) {
      const auto& [slot, of_b] = rows.felt[i];
      if (of_b) {
        add_to_b(slots_[at(slot)], part, c);
      } else if (i == 0 && assigns) {
        write_to_a<true>(slots_[at(slot)], part, c);
      } else {
        write_to_a<false>(slots_[at(slot)], part, c);
      }
    }
    crosses_->add(group, c);
  }

  void values(const double* s, std::span<double> sums, std::span<const char> wanted) noexcept override {
    for (std::vector<PairBatch>* batches : {&relative_, &general_}) {
      for (PairBatch& batch : *batches) batch.sum_values(layout_, parameters_, s, first_, sums, wanted);
    }
  }

  void product(int group, const double* z, double* y) const noexcept override {
    if (lone_pair_) return product_of_lone_pair(false, z, y);
    product(group, rows_into_[at(group)], z, y);
    crosses_->product(group, z, y);
  }
  void transposed_product(int group, const double* z, double* y) const noexcept override {
    if (lone_pair_) return product_of_lone_pair(true, z, y);
    product(group, rows_from_[at(group)], z, y);
    crosses_->transposed_product(group, z, y);
  }
  void add_swarms(const double* z, double* y) const noexcept override {
    for (const Neighbourhood& swarm : swarms_) swarm.product(z, y);
  }
  bool has_swarms() const noexcept override { return !swarms_.empty(); }
  const StageParameters& parameters() const noexcept override { return parameters_; }

  void find_neighbours(const double* s) noexcept override {
    for (Neighbourhood& swarm : swarms_) swarm.find(s);
  }
  Neighbours neighbours() const noexcept override {
    Neighbours all;
    for (const Neighbourhood& swarm : swarms_) {
      all.pairs += static_cast<int>(swarm.pairs().size());
      all.left_out += swarm.left_out();
    }
    return all;
  }
  void swarm_values(const double* s, std::span<double> of_agents) noexcept override {
    for (Neighbourhood& swarm : swarms_) swarm.values(s, of_agents);
  }

 private:
  /// Batch with the pair's formula; relative pairs also differ by their slots.
  PairBatch& batch_of(std::vector<PairBatch>& batches, const BodyPotential& pair, KernelChoice choice) {
    for (PairBatch& b : batches) {
      if (b.suits(pair)) return b;
    }
    batches.push_back({{}, Points(pair.potential, choice)});
    return batches.back();
  }

  void add(const BodyPotential& pair, KernelChoice choice) {
    if (!pair.potential.relative) {
      batch_of(general_, pair, choice).pairs.push_back(&pair);
      return;
    }
    PairBatch& batch = batch_of(relative_, pair, choice);
    const PosePotential* const potential = batch.pairs.empty() ? &pair.potential : &batch.pairs[0]->potential;
    batch.pairs.push_back(&pair);
    const Layout::Place a = layout_.place(pair.a), b = layout_.place(pair.b);
    const auto fits = [&](const Slot<W>& s) {
      return s.group_a == a.group && s.group_b == b.group && s.potential == potential &&
             s.a_mask[a.lane] == 0 && s.b_mask[b.lane] == 0;
    };
    auto slot = std::find_if(slots_.begin(), slots_.end(), fits);
    if (slot == slots_.end()) {
      Slot<W> s;
      s.group_a = a.group;
      s.group_b = b.group;
      s.a_feels = pair.ends.a_feels;
      s.b_feels = pair.ends.b_feels;
      s.potential = potential;
      s.ramp = pair.ramp;
      slots_.push_back(std::move(s));
      slot = slots_.end() - 1;
    }
    slot->pairs.emplace_back(&batch - relative_.data(), batch.pairs.size() - 1);
    slot->b_of_a[a.lane] = b.lane;
    slot->a_of_b[b.lane] = a.lane;
    slot->a_mask.v[a.lane] = 1.0;
    slot->b_mask.v[b.lane] = 1.0;
    in_place_.resize(relative_.size());
  }

  void find_slots() {
    slots_of_group_.resize(layout_.groups.size());
    for (const PairBatch& batch : relative_) slots_of_.emplace_back(batch.pairs.size());
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      slots_of_group_[at(slots_[i].group_a)].push_back(static_cast<int>(i));
      for (const auto& [batch, p] : slots_[i].pairs) slots_of_[batch][p] = static_cast<int>(i);
    }
  }

  /// Lanes of agents pay if half of them are in use; all pairs of one formula use the same method.
  void settle(Slot<W>& slot, KernelChoice choice) {
    slot.out = outputs_[static_cast<int>(&slot - slots_.data())];
    const Program& derivatives = slot.potential->derivatives;
    slot.formulas.emplace_back(derivatives, choice);
    for (const Program& p : slot.potential->others) slot.formulas.emplace_back(p, choice);
    for (std::size_t b = 0; b < relative_.size(); ++b) {
      if (&relative_[b].pairs[0]->potential != slot.potential) continue;
      int slots = 0;
      for (const Slot<W>& s : slots_) slots += s.potential == slot.potential;
      const int pairs = static_cast<int>(relative_[b].pairs.size());
      slot.in_place = W >= 4 && 2 * pairs >= W * slots;
      in_place_[b] = slot.in_place;
    }
  }

  void gather_relative(std::size_t b, const double* s) noexcept {
    if (in_place_[b]) return;
    PairBatch& batch = relative_[b];
    batch.gather(layout_, parameters_, s);
    batch.points.derive();
    for (std::size_t p = 0; p < batch.pairs.size(); ++p) {
      double* const to = slots_[at(slots_of_[b][p])].out + layout_.place(batch.pairs[p]->a).lane;
      for (int o = 0; o < relative_outputs; ++o) {
        batch.points.each_out(static_cast<int>(p) * layout_.stages, layout_.stages, o,
                              [&](int k, double value) { to[(k * relative_outputs + o) * W] = value; });
      }
    }
  }
  void gather_general(std::size_t b, const double* s) noexcept {
    if (crosses_->in_place(b)) return;
    general_[b].gather(layout_, parameters_, s);
    general_[b].points.derive();
    crosses_->take(b);
  }

  void derive_in_place(Slot<W>& slot, const double* s) noexcept {
    const Layout::Part &part_a = layout_.groups[at(slot.group_a)], &part_b = layout_.groups[at(slot.group_b)];
    alignas(row_alignment) std::array<double, relative * W> in;
    alignas(row_alignment) std::array<double, relative_outputs * W> sum, more;
    for (int k = 1; k < layout_.stages; ++k) {
      const double* const a = s + part_a.s + k * part_a.ns * W;
      const double* const b = s + part_b.s + k * part_b.ns * W;
      for (int i = 0; i < 3; ++i) {
        (L::load(a + i * W) - permuted(L::load(b + i * W), slot.b_of_a)).store(&in[at(i * W)]);
      }
      for (int i = 3; i < relative; ++i) L::load(a + i * W).store(&in[at(i * W)]);
      slot.formulas[0].run(in.data(), sum.data());
      for (std::size_t o = 1; o < slot.formulas.size(); ++o) {
        slot.formulas[o].run(in.data(), more.data());
        for (int i = 0; i < relative_outputs; ++i)
          (L::load(&sum[at(i * W)]) + L::load(&more[at(i * W)])).store(&sum[at(i * W)]);
      }
      if (slot.part != 1.0) {
        for (int i = 0; i < relative_outputs; ++i)
          (L(slot.part) * L::load(&sum[at(i * W)])).store(&sum[at(i * W)]);
      }
      double* const out = slot.out + k * relative_outputs * W;
      for (int i = 0; i < relative_outputs; ++i)
        masked(slot.a_mask, L::load(&sum[at(i * W)])).store(out + i * W);
    }
  }

  template <bool assigns>
  void write_to_a(const Slot<W>& slot, const Layout::Part& part, double* c) const noexcept {
    const auto write = [](double* to, L value) { (assigns ? value : L::load(to) + value).store(to); };
    for (int k = 1; k < layout_.stages; ++k) {
      const double* const out = slot.out + k * relative_outputs * W;
      double* const c_k = c + k * part.nc() * W;
      for (int i = 0; i < relative; ++i) {
        write(c_k + i * W, L::load(out + i * W));
        for (int j = i; j < relative; ++j)
          write(c_k + (part.ns + upper_index(i, j, part.ns)) * W,
                L::load(out + (relative + upper(i, j)) * W));
      }
    }
  }
  void add_to_b(const Slot<W>& slot, const Layout::Part& part, double* c) const noexcept {
    const auto of_b = [&](const double* from) {
      return masked(slot.b_mask, permuted(L::load(from), slot.a_of_b));
    };
    for (int k = 1; k < layout_.stages; ++k) {
      const double* const out = slot.out + k * relative_outputs * W;
      double* const c_k = c + k * part.nc() * W;
      for (int i = 0; i < 3; ++i) {
        (L::load(c_k + i * W) - of_b(out + i * W)).store(c_k + i * W);
        for (int j = i; j < 3; ++j) {
          double* const to = c_k + (part.ns + upper_index(i, j, part.ns)) * W;
          (L::load(to) + of_b(out + (relative + upper(i, j)) * W)).store(to);
        }
      }
    }
  }

  template <bool assigns>
  void product_of_a(const Slot<W>& slot, const double* z, double* y) const noexcept {
    const Layout::Part &part_a = layout_.groups[at(slot.group_a)], &part_b = layout_.groups[at(slot.group_b)];
    for (int k = 1; k < layout_.stages; ++k) {
      const std::ptrdiff_t at_a = part_a.s + k * part_a.ns * W, at_b = part_b.s + k * part_b.ns * W;
      std::array<L, 15> H;
      for (int i = 0; i < 15; ++i) H[at(i)] = L::load(slot.out + (k * relative_outputs + relative + i) * W);
      std::array<L, 3> b;
      for (int i = 0; i < 3; ++i) b[at(i)] = permuted(L::load(z + at_b + i * W), slot.b_of_a);
      for (int i = 0; i < relative; ++i) {
        double* const to = y + at_a + i * W;
        const L row = row_of_three(H.data(), i, b.data());
        (assigns ? -row : L::load(to) - row).store(to);
      }
    }
  }
  void add_product_of_b(const Slot<W>& slot, const double* z, double* y) const noexcept {
    const Layout::Part &part_a = layout_.groups[at(slot.group_a)], &part_b = layout_.groups[at(slot.group_b)];
    for (int k = 1; k < layout_.stages; ++k) {
      const std::ptrdiff_t at_a = part_a.s + k * part_a.ns * W, at_b = part_b.s + k * part_b.ns * W;
      std::array<L, 15> H;
      for (int i = 0; i < 15; ++i) H[at(i)] = L::load(slot.out + (k * relative_outputs + relative + i) * W);
      std::array<L, relative> a;
      for (int i = 0; i < relative; ++i) a[at(i)] = L::load(z + at_a + i * W);
      for (int i = 0; i < 3; ++i) {
        double* const to = y + at_b + i * W;
        (L::load(to) - masked(slot.b_mask, permuted(row_of_five(H.data(), i, a.data()), slot.a_of_b)))
            .store(to);
      }
    }
  }

  // One pair in one group of two lanes: no sums, and one product covers both directions.
  void derive_lone_pair(const double* s) noexcept {
    constexpr int M = native_width;
    const BodyPotential& pair = *relative_[0].pairs[0];
    Points& points = relative_[0].points;
    const Layout::View a = layout_.s(pair.a), b = layout_.s(pair.b);
    for (int k = 0; k < layout_.stages; k += M) {
      std::array<std::ptrdiff_t, M> stage;  // the last pack repeats the last stage
      for (int i = 0; i < M; ++i) stage[at(i)] = a.stage * std::min(k + i, layout_.stages - 1);
      double* const in = &points.in(k, 0);
      for (int i = 0; i < relative; ++i) {
        const Lane<M> of_a = Lane<M>::gather(s + a(0, i), stage);
        (i < 3 ? of_a - Lane<M>::gather(s + b(0, i), stage) : of_a).store(in + i * M);
      }
    }
    points.derive();
  }
  void take_lone_pair(double* c) const noexcept {
    constexpr int M = native_width;
    const BodyPotential& pair = *relative_[0].pairs[0];
    const Points& points = relative_[0].points;
    const Slot<W>& slot = slots_[0];
    const L none = 0.0;
    const L a_row = pair.ends.a_feels ? slot.a_mask : none, b_row = pair.ends.b_feels ? slot.b_mask : none;
    const L both = a_row + b_row, difference = a_row - b_row;
    const double* const out = points.out(0, 0);
    for (int k = 1; k < layout_.stages; ++k) {
      double* const c_k = c + k * relative_outputs * W;
      const double* const of_k = out + k / M * relative_outputs * M + k % M;
      for (int i = 0; i < relative; ++i) (L(of_k[i * M]) * (i < 3 ? difference : a_row)).store(c_k + i * W);
      for (int i = 0; i < relative; ++i) {
        for (int j = i; j < relative; ++j) {
          const int at_ij = relative + upper(i, j);
          (L(of_k[at_ij * M]) * (j < 3 ? both : a_row)).store(c_k + at_ij * W);
        }
      }
    }
  }

  void product_of_lone_pair(bool transposed, const double* z, double* y) const noexcept {
    constexpr int M = native_width;
    const Slot<W>& slot = slots_[0];
    const BodyPotential& pair = *relative_[0].pairs[0];
    const Layout::Part& part = layout_.groups[0];
    const L none = 0.0;
    const auto [a_feels, b_feels] = rows_of(pair.ends.a_feels, pair.ends.b_feels, transposed);
    const L a_row = -(a_feels ? slot.a_mask : none), b_row = -(b_feels ? slot.b_mask : none);
    const L both = a_row + b_row;
    typename L::Bits other{};
    for (int i = 0; i < W; ++i) other[i] = (i + 1) % W;
    const double* const out = relative_[0].points.out(0, relative);
    for (int k = 1; k < layout_.stages; ++k) {
      const double* const z_k = z + k * part.ns * W;
      double* const y_k = y + k * part.ns * W;
      const double* const of_k = out + k / M * relative_outputs * M + k % M;
      std::array<L, 15> H;
      for (int i = 0; i < 15; ++i) H[at(i)] = L(of_k[i * M]);
      std::array<L, relative> v;  // of the partner; the heading of b does not occur
      for (int i = 0; i < relative; ++i) v[at(i)] = permuted(L::load(z_k + i * W), other);
      for (int i = 3; i < relative; ++i) v[at(i)] *= slot.b_mask;
      for (int i = 0; i < 3; ++i) (both * row_of_five(H.data(), i, v.data())).store(y_k + i * W);
      for (int i = 3; i < relative; ++i) (a_row * row_of_three(H.data(), i, v.data())).store(y_k + i * W);
    }
  }

  /// Slots that act on one group, by their a or b. The first one assigns instead of adding if it
  /// covers all rows.
  struct FeltRows {
    std::vector<std::pair<int, bool>> felt{};
    bool assigns = false;
  };
  /// Rows of C that a potential has, for a and for b; those of C' are of the other.
  static std::pair<bool, bool> rows_of(bool a_feels, bool b_feels, bool transposed) {
    return transposed ? std::pair(b_feels, a_feels) : std::pair(a_feels, b_feels);
  }
  std::vector<FeltRows> find_rows(bool transposed) const {
    std::vector<FeltRows> of_groups(layout_.groups.size());
    for (std::size_t i = 0; i < slots_.size(); ++i) {
      const int slot = static_cast<int>(i);
      const auto [a_feels, b_feels] = rows_of(slots_[i].a_feels, slots_[i].b_feels, transposed);
      if (a_feels) of_groups[at(slots_[i].group_a)].felt.emplace_back(slot, false);
      if (b_feels) of_groups[at(slots_[i].group_b)].felt.emplace_back(slot, true);
    }
    for (std::size_t g = 0; g < of_groups.size(); ++g) {
      FeltRows& rows = of_groups[g];
      std::stable_partition(rows.felt.begin(), rows.felt.end(),
                            [](const auto& felt) { return !felt.second; });
      rows.assigns = !rows.felt.empty() && !rows.felt[0].second && layout_.groups[g].ns == relative;
    }
    return of_groups;
  }
  void product(int group, const FeltRows& rows, const double* z, double* y) const noexcept {
    const Layout::Part& part = layout_.groups[at(group)];
    std::fill_n(y + part.s, (rows.assigns ? 1 : layout_.stages) * part.ns * W, 0.0);
    for (std::size_t i = 0; i < rows.felt.size(); ++i) {
      const auto& [slot, of_b] = rows.felt[i];
      if (of_b) {
        add_product_of_b(slots_[at(slot)], z, y);
      } else if (i == 0 && rows.assigns) {
        product_of_a<true>(slots_[at(slot)], z, y);
      } else {
        product_of_a<false>(slots_[at(slot)], z, y);
      }
    }
  }

  const BodyPotential* first_;
  StageParameters parameters_;
  std::vector<PairBatch> general_, relative_;
  std::vector<std::vector<int>> slots_of_;        // [relative batch][pair]
  std::vector<std::vector<int>> slots_of_group_;  // slots with their a in the group
  std::vector<char> in_place_;                    // [relative batch]
  std::vector<Slot<W>> slots_;
  Rows outputs_;  // of slots
  std::optional<CrossBlocks<W>> crosses_;
  std::vector<FeltRows> rows_into_, rows_from_;  // [group], of C and of C'
  std::vector<Neighbourhood> swarms_;
  bool lone_pair_ = false;
};

}  // namespace

void Couplings::derive(const double* s, double* c, ThreadPool& pool) noexcept {
  if (gathers()) gather(s, c, pool);
  pool.share(static_cast<int>(layout_.groups.size()), [&](int g, int) noexcept { derive(g, s); });
}

void Couplings::evaluate(const double* s, double* c, ThreadPool& pool) noexcept {
  derive(s, c, pool);
  pool.share(static_cast<int>(layout_.groups.size()),
             [&](int g, int) noexcept { take(g, c + layout_.groups[at(g)].c); });
}

void Couplings::evaluate(const double* s, double* c) noexcept {
  ThreadPool alone(1);
  evaluate(s, c, alone);
}

void Couplings::product(const double* z, double* y) const noexcept {
  for (int g = 0; g < static_cast<int>(layout_.groups.size()); ++g) product(g, z, y);
  add_swarms(z, y);
}

std::unique_ptr<Couplings> make_couplings(std::span<const BodyPotential> pairs, const Layout& layout,
                                          int bodies, KernelChoice choice,
                                          std::span<const SwarmPotential> swarms) {
  if (layout.width == native_width)
    return std::make_unique<LaneCouplings<native_width>>(pairs, layout, bodies, choice, swarms);
  if (layout.width == narrow_width)
    return std::make_unique<LaneCouplings<narrow_width>>(pairs, layout, bodies, choice, swarms);
  return std::make_unique<LaneCouplings<2>>(pairs, layout, bodies, choice, swarms);
}

}  // namespace sightline
