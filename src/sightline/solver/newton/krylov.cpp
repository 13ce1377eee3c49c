#include "sightline/solver/newton/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base/index.hpp"

namespace sightline {
namespace {

using L = NativeLane;

double sum(L a) {
  double s = 0.0;
  for (int i = 0; i < L::width; ++i) s += a[i];
  return s;
}

template <class F>
void each_pack(int n, F&& f) {
  for (int i = 0; i < n; i += L::width) f(i);
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

void negate(double* a, int n) {
  each_pack(n, [&](int i) { (-L::load(a + i)).store(a + i); });
}

/// a += f b
void add(double* a, double f, const double* b, int n) {
  const L factor = f;
  each_pack(n, [&](int i) { fma(factor, L::load(b + i), L::load(a + i)).store(a + i); });
}

constexpr int generous = 4;  // a team that is not mutual is worth more iterations
// A sweep leaves an error of the size of the next; an iteration of conjugate gradients leaves a far smaller one.
constexpr double sharper = 0.01;

}  // namespace

Krylov::Krylov(const Layout& layout, const InfluenceGraph& graph, int max_iterations, double stop,
               bool has_swarms)
    : layout_(layout),
      kind_(graph.kind),
      max_iterations_(max_iterations),
      stop_(stop),
      gmres_(graph.kind == Influence::cyclic ? layout.s_length : 1, generous * std::max(max_iterations, 1)),
      s_vectors_(6, std::max(layout.s_length, gmres_.length())),
      u_vectors_(2, layout.u_length) {
  if (kind_ == Influence::none || kind_ == Influence::mutual || has_swarms) return;
  for (std::size_t g = 0; g < layout.groups.size(); ++g) {
    const std::size_t turn = at(layout.groups[g].turn);
    if (turns_.size() <= turn) turns_.resize(turn + 1);
    turns_[turn].groups.push_back(static_cast<int>(g));
    turns_[turn].wakes.emplace_back(at(layout.width));
  }
  due_.resize(turns_.size());
  for (std::size_t a = 0; a < graph.feelers.size(); ++a) {
    const Layout::Place& of = layout.place(static_cast<int>(a));
    Turn& turn = turns_[at(layout.groups[at(of.group)].turn)];
    const auto group = std::find(turn.groups.begin(), turn.groups.end(), of.group) - turn.groups.begin();
    std::vector<int>& wakes = turn.wakes[static_cast<std::size_t>(group)][at(of.lane)];
    for (const int feeler : graph.feelers[a]) {
      const int woken = layout.groups[at(layout.place(feeler).group)].turn;
      turns_[at(woken)].feels = turn.is_felt = true;
      if (std::find(wakes.begin(), wakes.end(), woken) == wakes.end()) wakes.push_back(woken);
    }
  }
}

int Krylov::complete(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept {
  switch (kind_) {
    case Influence::none:
      return 0;
    case Influence::mutual:
      return conjugate_gradients(groups, couplings, du, ds);
    case Influence::cascade:
    case Influence::cyclic:
      return turns_.empty() ? general(groups, couplings, du, ds) : substitute(groups, couplings, du, ds);
  }
  return 0;
}

int Krylov::conjugate_gradients(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept {
  const int ns = layout_.s_length, nu = layout_.u_length;
  double *r = s_vectors_[0], *w = s_vectors_[1], *z = s_vectors_[2], *p = s_vectors_[3];
  double* const Cp = s_vectors_[4];
  double *z_u = u_vectors_[0], *p_u = u_vectors_[1];
  couplings.product(ds, r);  // for the negative of the correction
  double rho = 0.0;
  int k = 0;
  while (k < max_iterations_) {
    groups.precondition(r, z_u, z);
    const double next_rho = dot_packs(r, z, ns);
    if (!(next_rho > 1e-28)) break;  // solved already, or not a number
    const L beta = k > 0 ? next_rho / rho : 0.0;
    rho = next_rho;
    // The direction is z + beta p; w stands for P times it, up to what the dynamics' rows take: P is never
    // multiplied.
    if (k == 0) {
      w = r;
    } else {
      each_pack(ns, [&](int i) {
        fma(beta, L::load(p + i), L::load(z + i)).store(z + i);
        fma(beta, L::load(w + i), L::load(r + i)).store(w + i);
      });
    }
    couplings.product(z, Cp);
    L even = 0.0, odd = 0.0;
    const auto image = [&](int i) { return L::load(w + i) + L::load(Cp + i); };
    for (int i = 0; i < ns; i += 2 * L::width) {
      even = fma(image(i), L::load(z + i), even);
      if (i + L::width < ns) odd = fma(image(i + L::width), L::load(z + i + L::width), odd);
    }
    const double curvature = sum(even + odd);
    if (!(curvature > 1e-14 * rho)) break;  // along this direction the team's cost has no minimum
    const L alpha = rho / curvature;
    each_pack(nu, [&](int i) {
      L direction = L::load(z_u + i);
      if (k > 0) {
        direction = fma(beta, L::load(p_u + i), direction);
        direction.store(z_u + i);
      }
      subtract_product(alpha, direction, L::load(du + i)).store(du + i);
    });
    ++k;
    if (k == max_iterations_ || std::sqrt(rho) < stop_) break;
    double* const next_r = k == 1 ? s_vectors_[1] : r;  // r lives on as w
    each_pack(ns, [&](int i) { subtract_product(alpha, image(i), L::load(r + i)).store(next_r + i); });
    r = next_r;
    std::swap(z, p);
    std::swap(z_u, p_u);
  }
  return k;
}

/// Each turn sees what those before it came to. Who changed by little wakes nobody, so a cascade is exact to that, and the
/// parts of a team with cycles go on alone.
int Krylov::substitute(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept {
  const int most = generous * max_iterations_;
  const bool may_fail = kind_ == Influence::cyclic;
  double *const ds_alone = s_vectors_[4], *const du_alone = u_vectors_[1];
  if (may_fail) {
    std::copy_n(ds, layout_.s_length, ds_alone);
    std::copy_n(du, layout_.u_length, du_alone);
  }
  std::fill_n(s_vectors_[1], layout_.s_length, 0.0);
  for (std::size_t t = 0; t < turns_.size(); ++t) due_[t] = turns_[t].feels;
  double first = 0.0, last = 0.0;
  int pass = 0;
  const auto is_due = [&] {
    return std::any_of(due_.begin(), due_.end(), [](char due) { return due != 0; });
  };
  for (; pass < most && is_due(); ++pass) {
    last = 0.0;
    for (std::size_t t = 0; t < turns_.size(); ++t) {
      if (due_[t] == 0) continue;
      due_[t] = 0;
      last = std::max(last, take_turn(static_cast<int>(t), groups, couplings, du, ds));
    }
    if (pass == 0) first = last;
  }
  if (!may_fail || (last <= first && first < 1e300)) return pass;
  std::copy_n(ds_alone, layout_.s_length, ds);
  std::copy_n(du_alone, layout_.u_length, du);
  return pass + general(groups, couplings, du, ds);
}

/// @return the greatest change of a robot's own cost
double Krylov::take_turn(int turn, Groups& groups, const Couplings& couplings, double* du,
                         double* ds) noexcept {
  const Turn& its = turns_[at(turn)];
  const double stop = square(sharper * stop_);
  double *const r = s_vectors_[0], *const before = s_vectors_[1], *const z = s_vectors_[2];
  double* const z_u = u_vectors_[0];
  for (const int g : its.groups) couplings.product(g, ds, r);
  double largest = 0.0;
  for (std::size_t i = 0; i < its.groups.size(); ++i) {
    const int g = its.groups[i];
    const Layout::Part& part = layout_.groups[at(g)];
    const int ns = padded(layout_.stages * part.ns * layout_.width);
    const int nu = padded(layout_.stages * part.nu * layout_.width);
    each_pack(ns, [&](int k) {
      const L now = L::load(r + part.s + k);
      (now - L::load(before + part.s + k)).store(r + part.s + k);
      now.store(before + part.s + k);
    });
    groups.precondition(g, r, z_u, z);
    add(du + part.u, -1.0, z_u + part.u, nu);
    if (!its.is_felt) continue;
    add(ds + part.s, -1.0, z + part.s, ns);
    L change = 0.0;
    each_pack(ns, [&](int k) { change = fma(L::load(r + part.s + k), L::load(z + part.s + k), change); });
    for (int lane = 0; lane < layout_.width; ++lane) {
      double of_robot = 0.0;
      for (int k = lane; k < L::width; k += layout_.width) of_robot += change[k];
      largest = std::max(largest, of_robot);
      if (!(of_robot > stop)) continue;
      for (const int woken : its.wakes[i][at(lane)]) due_[at(woken)] = 1;
    }
  }
  return largest;
}

int Krylov::general(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept {
  const int ns = layout_.s_length, nu = layout_.u_length;
  double *const image = s_vectors_[0], *const b = s_vectors_[1], *const y = s_vectors_[2];
  const auto product = [&](const double* v, double* out) {
    couplings.product(v, image);
    groups.precondition(image, u_vectors_[0], out);
    add(out, 1.0, v, ns);
  };
  std::copy_n(ds, ns, b);
  std::copy_n(ds, ns, y);
  const Gmres::Outcome outcome = gmres_.solve(product, b, y, 0.1 * stop_);
  couplings.product(y, image);
  negate(image, ns);
  groups.precondition(image, u_vectors_[0], ds);
  add(du, 1.0, u_vectors_[0], nu);
  return outcome.iterations;
}

}  // namespace sightline
