#include "sightline/solver/newton/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

using L = NativeLane;

double sum(L a) {
  double s = 0.0;
  for (int i = 0; i < L::width; ++i) s += a[i];
  return s;
}

/// f(position) for each pack of a group's rows.
template <class F>
void each_pack(const Layout::Span& rows, F&& f) {
  for (std::ptrdiff_t i = rows.first; i < rows.end(); i += L::width) f(i);
}

double dot_packs(const double* a, const double* b, int n) {
  L even = 0.0, odd = 0.0;
  int i = 0;
  for (; i + L::width < n; i += 2 * L::width) {
    even = fma(L::load(a + i), L::load(b + i), even);
    odd = fma(L::load(a + i + L::width), L::load(b + i + L::width), odd);
  }
  if (i < n) even = fma(L::load(a + i), L::load(b + i), even);
  return sum(even + odd);
}

double in_order(std::span<const double> summands) {
  return std::accumulate(summands.begin(), summands.end(), 0.0);
}

constexpr int iteration_budget_factor = 4;  // a non-mutual team receives more iterations
// The error of a substitution pass is as large as its next correction; conjugate gradients leave a
// far smaller one.
constexpr double refinement_tolerance = 0.005;
constexpr double guess_energy_ratio =
    10.0;  // energy per squared length of the deviation from a guess, relative to a correction

}  // namespace

Krylov::Krylov(const Layout& layout, const InfluenceGraph& graph, const Couplings& couplings, int threads,
               int max_iterations, double stop)
    : layout_(layout),
      kind_(graph.kind),
      schedule_(static_cast<int>(layout.groups.size()), couplings.coupled_groups(), threads),
      of_groups_(layout.groups.size()),
      curvature_(layout.groups.size()),
      changes_(layout.groups.size() * at(layout.width)),
      max_iterations_(max_iterations),
      stop_(stop),
      gmres_(graph.kind == Influence::cyclic ? layout.s_length : 1,
             iteration_budget_factor * std::max(max_iterations, 1)),
      s_vectors_(5, std::max(layout.s_length, gmres_.length())),
      u_vectors_(2, layout.u_length) {
  if (kind_ == Influence::none || kind_ == Influence::mutual || couplings.has_swarms()) return;
  for (std::size_t g = 0; g < layout.groups.size(); ++g) {
    const std::size_t turn = at(layout.groups[g].turn);
    if (turns_.size() <= turn) turns_.resize(turn + 1);
    turns_[turn].groups.push_back(static_cast<int>(g));
    turns_[turn].wakes.emplace_back(at(layout.width));
  }
  due_.resize(turns_.size());
  visited_.resize(turns_.size());
  added_ = Rows(1, layout.s_length);
  std::vector<char> feels(graph.feelers.size(), 0);
  for (const std::vector<int>& feelers : graph.feelers)
    for (const int feeler : feelers) feels[at(feeler)] = 1;
  for (std::size_t a = 0; a < graph.feelers.size(); ++a) {
    const Layout::Place& of = layout.place(static_cast<int>(a));
    Turn& turn = turns_[at(layout.groups[at(of.group)].turn)];
    const auto group = std::find(turn.groups.begin(), turn.groups.end(), of.group) - turn.groups.begin();
    std::vector<int>& wakes = turn.wakes[static_cast<std::size_t>(group)][at(of.lane)];
    for (const int feeler : graph.feelers[a]) {
      const int woken = layout.groups[at(layout.place(feeler).group)].turn;
      turns_[at(woken)].feels = true;
      if (feels[a] == 0) continue;  // its own step is final
      turn.is_felt = goes_on_ = true;
      if (std::find(wakes.begin(), wakes.end(), woken) == wakes.end()) wakes.push_back(woken);
    }
  }
}

Krylov::Completion Krylov::complete(Groups& groups, const Couplings& couplings, double* du, double* ds,
                                    ThreadPool& pool, WarmStart warm_start, const Deadline& deadline,
                                    bool begun) noexcept {
  if (deadline.passed()) return {};
  const Work work{groups, couplings, du, ds, pool, warm_start, deadline, begun};
  switch (kind_) {
    case Influence::none:
      return {};
    case Influence::mutual:
      return max_iterations_ > 0 ? conjugate_gradients(work) : Completion{};
    case Influence::cascade:
    case Influence::cyclic:
      return {.iterations = turns_.empty() ? general(work) : substitute(work)};
  }
  return {};
}

void Krylov::begin_direction(int g, Groups& groups, const Couplings& couplings, const double* ds) noexcept {
  couplings.product(g, ds, s_vectors_[0]);  // right side for the negative correction
  direct(g, groups, s_vectors_[0], u_vectors_[0], s_vectors_[2]);
}

void Krylov::begin_image(int g, const Couplings& couplings) noexcept {
  couplings.product(g, s_vectors_[2], s_vectors_[4]);
  bend(g, s_vectors_[0], s_vectors_[4], s_vectors_[2]);
}

/// z = P^-1 r, and the group's part of r'z.
void Krylov::direct(int g, Groups& groups, const double* r, double* z_u, double* z) noexcept {
  groups.precondition(g, r, z_u, z);
  const Layout::Span s = layout_.s_of(g);
  of_groups_[at(g)] = dot_packs(r + s.first, z + s.first, s.length);
}

/// The group's part of z'(P + C)z.
void Krylov::bend(int g, const double* w, const double* Cp, const double* z) noexcept {
  const Layout::Span s = layout_.s_of(g);
  const auto image = [&](std::ptrdiff_t i) { return L::load(w + i) + L::load(Cp + i); };
  L even = 0.0, odd = 0.0;
  for (int i = 0; i < s.length; i += 2 * L::width) {
    const std::ptrdiff_t at_i = s.first + i;
    even = fma(image(at_i), L::load(z + at_i), even);
    if (i + L::width < s.length) odd = fma(image(at_i + L::width), L::load(z + at_i + L::width), odd);
  }
  curvature_[at(g)] = sum(even + odd);
}

/// Each pass over the groups ends at a sum over all groups.
Krylov::Completion Krylov::conjugate_gradients(const Work& work) noexcept {
  Groups& groups = work.groups;
  const Couplings& couplings = work.couplings;
  double *r = s_vectors_[0], *w = s_vectors_[1], *z = s_vectors_[2], *p = s_vectors_[3];
  double* const Cp = s_vectors_[4];
  double *z_u = u_vectors_[0], *p_u = u_vectors_[1];
  const bool swarms = couplings.has_swarms();
  if (swarms) couplings.product(work.ds, r);  // right side for the negative correction
  if (!work.begun) {
    groups.each(work.pool, [&](int g, int) noexcept {
      if (!swarms) couplings.product(g, work.ds, r);
      direct(g, groups, r, z_u, z);
    });
  }
  double rho = 0.0;
  int k = 0;
  while (k < max_iterations_) {
    const double next_rho = in_order(of_groups_);
    if (!(next_rho > 1e-28)) break;  // already solved, or not a number
    const L beta = k > 0 ? next_rho / rho : 0.0;
    rho = next_rho;
    // The direction is z + beta p; w represents P times it, up to the range of the dynamics' rows:
    // P is never multiplied.
    const auto conjugate = [&](int g) {
      each_pack(layout_.s_of(g), [&](std::ptrdiff_t i) {
        fma(beta, L::load(p + i), L::load(z + i)).store(z + i);
        fma(beta, L::load(w + i), L::load(r + i)).store(w + i);
      });
      each_pack(layout_.u_of(g),
                [&](std::ptrdiff_t i) { fma(beta, L::load(p_u + i), L::load(z_u + i)).store(z_u + i); });
    };
    const auto image = [&](int g) {
      if (!swarms) couplings.product(g, z, Cp);
      bend(g, w, Cp, z);
    };
    if (k == 0) {
      w = r;
      if (swarms) couplings.product(z, Cp);
      if (!work.begun) groups.each(work.pool, [&](int g, int) noexcept { image(g); });
    } else if (swarms) {
      groups.each(work.pool, [&](int g, int) noexcept { conjugate(g); });
      couplings.product(z, Cp);
      groups.each(work.pool, [&](int g, int) noexcept { image(g); });
    } else {
      schedule_.run(
          work.pool, [&](int g, int) noexcept { conjugate(g); }, [&](int g, int) noexcept { image(g); });
    }
    const double curvature = in_order(curvature_);
    if (!(curvature > 1e-14 * rho)) break;  // the team's cost has no minimum along this direction
    const double step = -rho / curvature;
    ++k;
    if (k == max_iterations_ || std::sqrt(rho) < stop_ || work.deadline.passed()) return {k, z_u, step};
    const L alpha = step;
    double* const next_r = k == 1 ? s_vectors_[1] : r;  // the old r stays in use as w
    groups.each(work.pool, [&](int g, int) noexcept {
      each_pack(layout_.u_of(g), [&](std::ptrdiff_t i) {
        fma(alpha, L::load(z_u + i), L::load(work.du + i)).store(work.du + i);
      });
      each_pack(layout_.s_of(g), [&](std::ptrdiff_t i) {
        fma(alpha, L::load(w + i) + L::load(Cp + i), L::load(r + i)).store(next_r + i);
      });
      direct(g, groups, next_r, p_u, p);
    });
    r = next_r;
    std::swap(z, p);
    std::swap(z_u, p_u);
  }
  return {.iterations = k};
}

/// Stores the robots' own steps. Initial guess for pending neighbours: the block-diagonal step plus
/// a fraction of the last coupling correction.
void Krylov::guess(const Work& work) noexcept {
  if (work.warm_start == WarmStart::none) share_ = 0.0;
  if (work.warm_start == WarmStart::of_attempts) share_ = has_added_ ? 1.0 : 0.0;
  double *const ds_alone = s_vectors_[4], *const du_alone = u_vectors_[1];
  const bool guesses = share_ != 0.0;
  const L part = share_;
  work.groups.each(work.pool, [&](int g, int) noexcept {
    const Layout::Span s = layout_.s_of(g), u = layout_.u_of(g);
    std::copy_n(work.ds + s.first, s.length, ds_alone + s.first);
    if (kind_ == Influence::cyclic) std::copy_n(work.du + u.first, u.length, du_alone + u.first);
    if (!guesses) return;
    each_pack(s, [&](std::ptrdiff_t i) {
      fma(part, L::load(added_[0] + i), L::load(work.ds + i)).store(work.ds + i);
    });
  });
}

/// The fraction of the correction that recurred is the forecast for the next step: with noisy steps
/// it is zero.
void Krylov::remember(const Work& work) noexcept {
  const double* const ds_alone = s_vectors_[4];
  work.groups.each(work.pool, [&](int g, int) noexcept {
    L now_then = 0.0, then_then = 0.0;
    each_pack(layout_.s_of(g), [&](std::ptrdiff_t i) {
      const L now = L::load(work.ds + i) - L::load(ds_alone + i), then = L::load(added_[0] + i);
      now_then = fma(now, then, now_then);
      then_then = fma(then, then, then_then);
      now.store(added_[0] + i);
    });
    of_groups_[at(g)] = sum(now_then);
    changes_[at(g * layout_.width)] = sum(then_then);
  });
  double then_then = 0.0;
  for (std::size_t g = 0; g < of_groups_.size(); ++g) then_then += changes_[g * at(layout_.width)];
  const double share = in_order(of_groups_) / then_then;
  share_ = has_added_ && share > 0.0 ? std::min(share, 1.0) : 0.0;
  has_added_ = true;
}

/// Each turn uses the results of the previous turns. Blocks whose change is below the tolerance do
/// not re-queue their neighbours: a cascade is exact to it, and parts of a cyclic team iterate
/// separately.
int Krylov::substitute(const Work& work) noexcept {
  const int most = iteration_budget_factor * max_iterations_;
  const bool may_fail = kind_ == Influence::cyclic;
  double *const ds_alone = s_vectors_[4], *const du_alone = u_vectors_[1];
  std::fill(visited_.begin(), visited_.end(), 0);
  if (goes_on_) guess(work);
  for (std::size_t t = 0; t < turns_.size(); ++t) due_[t] = turns_[t].feels;
  double first = 0.0, last = 0.0;
  int pass = 0;
  const auto is_due = [&] {
    return std::any_of(due_.begin(), due_.end(), [](char due) { return due != 0; });
  };
  bool late = false;
  for (; pass < most && is_due() && !late; ++pass) {
    last = 0.0;
    for (std::size_t t = 0; t < turns_.size(); ++t) {
      if (due_[t] == 0) continue;
      due_[t] = 0;
      last = std::max(last, take_turn(static_cast<int>(t), work));
    }
    if (pass < 2) first = std::max(first, last);  // with a guess the first pass may change little
    late = work.deadline.passed();
  }
  if (!may_fail || ((!is_due() || last <= first) && first < 1e300)) {
    if (goes_on_) remember(work);
    return pass;
  }
  forget();
  std::copy_n(ds_alone, layout_.s_length, work.ds);
  std::copy_n(du_alone, layout_.u_length, work.du);
  return late ? pass : pass + general(work);
}

/// @return the largest change of a robot's own cost
double Krylov::take_turn(int turn, const Work& work) noexcept {
  const Turn& its = turns_[at(turn)];
  const double stop = square(refinement_tolerance * stop_);
  double *const r = s_vectors_[0], *const before = s_vectors_[1], *const z = s_vectors_[2];
  double* const z_u = u_vectors_[0];
  const int groups = static_cast<int>(its.groups.size());
  const bool first_visit = visited_[at(turn)] == 0, guessed = first_visit && share_ > 0.0;
  const double* const from = first_visit ? s_vectors_[4] : work.ds;
  visited_[at(turn)] = 1;
  // Groups of one turn use each other's state before the turn.
  work.pool.share(groups, [&](int i, int) noexcept {
    const int g = its.groups[at(i)];
    work.couplings.product(g, work.ds, r);
    each_pack(layout_.s_of(g), [&](std::ptrdiff_t k) {
      const L now = L::load(r + k);
      if (!first_visit) (now - L::load(before + k)).store(r + k);
      now.store(before + k);
    });
    work.groups.precondition(g, r, z_u, z);
    each_pack(layout_.u_of(g),
              [&](std::ptrdiff_t k) { (L::load(work.du + k) - L::load(z_u + k)).store(work.du + k); });
    if (!its.is_felt) return;
    L energy = 0.0, length = 0.0, moved = 0.0;
    each_pack(layout_.s_of(g),
              [&](std::ptrdiff_t k) { energy = fma(L::load(r + k), L::load(z + k), energy); });
    if (guessed) {
      // Other groups have used the guess: the relevant change is the deviation from it, with the
      // energy per length of the correction.
      each_pack(layout_.s_of(g), [&](std::ptrdiff_t k) {
        const L correction = L::load(z + k), off = L::load(from + k) - correction - L::load(work.ds + k);
        length = fma(correction, correction, length);
        moved = fma(off, off, moved);
      });
    }
    for (int lane = 0; lane < layout_.width; ++lane) {
      double of_robot = 0.0, long_2 = 0.0, moved_2 = 0.0;
      for (int k = lane; k < L::width; k += layout_.width)
        of_robot += energy[k], long_2 += length[k], moved_2 += moved[k];
      if (guessed) of_robot = long_2 > 0.0 ? guess_energy_ratio * of_robot * (moved_2 / long_2) : moved_2;
      changes_[at(g * layout_.width + lane)] = of_robot;
    }
  });
  double largest = 0.0;
  if (!its.is_felt) return largest;
  for (int i = 0; i < groups; ++i) {
    const int g = its.groups[at(i)];
    each_pack(layout_.s_of(g),
              [&](std::ptrdiff_t k) { (L::load(from + k) - L::load(z + k)).store(work.ds + k); });
    for (int lane = 0; lane < layout_.width; ++lane) {
      const double of_robot = changes_[at(g * layout_.width + lane)];
      largest = std::max(largest, of_robot);
      if (!(of_robot > stop)) continue;
      for (const int woken : its.wakes[at(i)][at(lane)]) due_[at(woken)] = 1;
    }
  }
  return largest;
}

int Krylov::general(const Work& work) noexcept {
  const int ns = layout_.s_length;
  double *const image = s_vectors_[0], *const b = s_vectors_[1], *const y = s_vectors_[2];
  const bool swarms = work.couplings.has_swarms();
  const auto coupled = [&](const double* v, auto&& use) {
    if (swarms) work.couplings.product(v, image);
    work.groups.each(work.pool, [&](int g, int) noexcept {
      if (!swarms) work.couplings.product(g, v, image);
      use(g);
    });
  };
  const auto product = [&](const double* v, double* out) {
    coupled(v, [&](int g) {
      work.groups.precondition(g, image, u_vectors_[0], out);
      each_pack(layout_.s_of(g),
                [&](std::ptrdiff_t i) { (L::load(out + i) + L::load(v + i)).store(out + i); });
    });
  };
  std::copy_n(work.ds, ns, b);
  std::copy_n(work.ds, ns, y);
  const Gmres::Outcome outcome =
      gmres_.solve(product, b, y, 0.1 * stop_, [&] { return work.deadline.passed(); });
  coupled(y, [&](int g) {
    each_pack(layout_.s_of(g), [&](std::ptrdiff_t i) { (-L::load(image + i)).store(image + i); });
    work.groups.precondition(g, image, u_vectors_[0], work.ds);
    each_pack(layout_.u_of(g), [&](std::ptrdiff_t i) {
      (L::load(work.du + i) + L::load(u_vectors_[0] + i)).store(work.du + i);
    });
  });
  return outcome.iterations;
}

}  // namespace sightline
