#include "sightline/solver/newton/krylov.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

InfluenceGraph influence_graph(std::span<const BodyPotential> potentials, int agents,
                               std::span<const SwarmPotential> swarms) {
  std::vector<std::pair<int, int>> arrows;  // from the seen to the one that feels
  bool all_mutual = true, any = false;
  for (const BodyPotential& p : potentials) {
    if (p.a < 0 || p.b < 0) continue;
    any = true;
    all_mutual &= p.ends.a_feels && p.ends.b_feels;
    if (p.ends.a_feels) arrows.emplace_back(p.b, p.a);
    if (p.ends.b_feels) arrows.emplace_back(p.a, p.b);
  }
  for (const SwarmPotential& swarm : swarms) {
    any = true;
    for (std::size_t i = 1; i < swarm.agents.size(); ++i) {
      arrows.emplace_back(swarm.agents[i - 1], swarm.agents[i]);
      arrows.emplace_back(swarm.agents[i], swarm.agents[i - 1]);
    }
  }
  if (!any) return {Influence::none, 0, std::vector<int>(static_cast<std::size_t>(agents), 0)};
  if (all_mutual) return {Influence::mutual, 0, {}};
  std::vector<int> depth(static_cast<std::size_t>(agents), 0);
  for (int round = 0; round <= agents; ++round) {
    bool changed = false;
    for (const auto& [from, to] : arrows) {
      const int through = depth[static_cast<std::size_t>(from)] + 1;
      int& known = depth[static_cast<std::size_t>(to)];
      if (through > known) known = through, changed = true;
    }
    if (!changed) return {Influence::cascade, *std::max_element(depth.begin(), depth.end()), depth};
  }
  return {Influence::cyclic, 0, {}};
}

Krylov::Krylov(const Layout& layout, const InfluenceGraph& graph, int max_iterations, double stop)
    : layout_(layout),
      graph_(graph),
      max_iterations_(max_iterations),
      stop_(stop),
      gmres_(graph.kind == Influence::cyclic ? layout.s_length : 1, generous * std::max(max_iterations, 1)),
      s_vectors_(6, std::max(layout.s_length, gmres_.length())),
      u_vectors_(2, layout.u_length) {}

int Krylov::complete(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept {
  switch (graph_.kind) {
    case Influence::none:
      return 0;
    case Influence::mutual:
      return conjugate_gradients(groups, couplings, du, ds);
    case Influence::cascade:
      return sweeps(groups, couplings, du, ds);
    case Influence::cyclic:
      return general(groups, couplings, du, ds);
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

int Krylov::sweeps(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept {
  const int ns = layout_.s_length, nu = layout_.u_length;
  double* const r = s_vectors_[0];
  double* const z = s_vectors_[1];
  const double* from = ds;
  const int sweeps = std::min(graph_.depth, generous * max_iterations_);
  const double stop = sharper * stop_;
  double sign = -1.0;  // z is +- the correction
  for (int k = 0; k < sweeps; ++k, sign = -sign) {
    couplings.product(from, r);
    groups.precondition(r, u_vectors_[0], z);
    add(du, sign, u_vectors_[0], nu);
    from = z;
    if (k + 1 < sweeps && dot_packs(r, z, ns) < stop * stop) return k + 1;
  }
  return sweeps;
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
