#include "sightline/solver/newton/neighbourhood.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {
namespace {

using L = NativeLane;

constexpr int entries_of(int n) { return n * (n + 1) / 2; }

/// Symmetric n x n matrix times vector, in packs.
template <int n>
std::array<L, n> multiplied(const std::array<L, entries_of(n)>& H, const std::array<L, n>& v) {
  std::array<L, n> out;
  for (int i = 0; i < n; ++i) {
    L sum = 0.0;
    for (int j = 0; j < n; ++j)
      sum = fma(H[at(upper_index(std::min(i, j), std::max(i, j), n))], v[at(j)], sum);
    out[at(i)] = sum;
  }
  return out;
}

/// y_a -= H z_b, y_b -= H z_a over a stretch of two agents' rows.
template <int n>
void subtract_products(const double* H, const double* z_a, const double* z_b, double* y_a, double* y_b,
                       std::ptrdiff_t row, int length) {
  for (int k = 0; k < length; k += L::width) {
    std::array<L, entries_of(n)> block;
    for (int e = 0; e < entries_of(n); ++e) block[at(e)] = L::load(H + e * length + k);
    const auto pass = [&](const double* from, double* to) {
      std::array<L, n> v;
      for (int i = 0; i < n; ++i) v[at(i)] = L::load(from + i * row + k);
      const std::array<L, n> image = multiplied<n>(block, v);
      for (int i = 0; i < n; ++i) (L::load(to + i * row + k) - image[at(i)]).store(to + i * row + k);
    };
    pass(z_b, y_a);
    pass(z_a, y_b);
  }
}

double least(L a) {
  double m = a[0];
  for (int i = 1; i < L::width; ++i) m = std::min(m, a[i]);
  return m;
}
double greatest(L a) { return -least(-a); }

}  // namespace

Neighbourhood::Neighbourhood(const SwarmPotential& swarm, const Layout& layout, KernelChoice choice)
    : swarm_(swarm),
      layout_(layout),
      value_(swarm.value, choice),
      derivatives_(swarm.derivatives, choice),
      n_(swarm.sees_headings ? inputs : 3),
      rows_(padded(layout.stages)),
      grid_(agents()),
      centres_(swarm.agents.size()),
      extents_(swarm.agents.size()),
      poses_(n_ * agents(), rows_),
      z_(n_ * agents(), rows_),
      y_(n_ * agents(), rows_),
      sums_((n_ + entries_of(n_)) * agents(), rows_),
      in_(1, inputs * rows_),
      out_(1, outputs * rows_),
      cost_(1, rows_) {
  const int all = agents() * (agents() - 1) / 2;
  pairs_.reserve(at(std::min(swarm.capacity, all)));
  stretches_.reserve(pairs_.capacity() * at(rows_ / stretch));
  H_ = Rows(entries_of(n_) * static_cast<int>(stretches_.capacity()), stretch);
}

/// Copies each agent's numbers of s to rows along the horizon; the last value pads the row.
void Neighbourhood::collect(const double* s, Rows& rows) const noexcept {
  const int N = layout_.stages;
  for (int i = 0; i < agents(); ++i) {
    const Layout::View from = layout_.s(swarm_.agents[at(i)]);
    for (int q = 0; q < n_; ++q) {
      double* const to = rows[i * n_ + q];
      for (int k = 0; k < N; ++k) to[k] = s[from(k, q)];
      std::fill(to + N, to + rows_, to[N - 1]);
    }
  }
}

double Neighbourhood::least_distance_2(int a, int b, int begin, int end) const noexcept {
  L nearest = std::numeric_limits<double>::max();
  for (int k = begin; k < end; k += W) {
    L sum = 0.0;
    for (int q = 0; q < 3; ++q) {
      const L r = L::load(poses_[a * n_ + q] + k) - L::load(poses_[b * n_ + q] + k);
      sum = fma(r, r, sum);
    }
    nearest = -maximum(-nearest, -sum);
  }
  return least(nearest);
}

/// Adds a pair; without free capacity it replaces the farthest pair, if that is farther.
void Neighbourhood::offer(const Pair& pair) noexcept {
  const auto nearer = [](const Pair& p, const Pair& q) {
    return std::tie(p.distance_2, p.a, p.b) < std::tie(q.distance_2, q.a, q.b);
  };
  if (pairs_.size() < pairs_.capacity()) {
    pairs_.push_back(pair);
    return;
  }
  if (left_out_++ == 0) std::make_heap(pairs_.begin(), pairs_.end(), nearer);
  if (!nearer(pair, pairs_.front())) return;
  std::pop_heap(pairs_.begin(), pairs_.end(), nearer);
  pairs_.back() = pair;
  std::push_heap(pairs_.begin(), pairs_.end(), nearer);
}

void Neighbourhood::find(const double* s) noexcept {
  collect(s, poses_);
  // The ball around the centre of a plan's bounding box contains the plan.
  double widest = 0.0;
  for (int i = 0; i < agents(); ++i) {
    std::array<double, 3> middle, half;
    for (int q = 0; q < 3; ++q) {
      const double* const x = poses_[i * n_ + q];
      L low = L::load(x), high = low;
      for (int k = W; k < rows_; k += W) {
        low = -maximum(-low, -L::load(x + k));
        high = maximum(high, L::load(x + k));
      }
      middle[at(q)] = 0.5 * least(low) + 0.5 * greatest(high);
      half[at(q)] = greatest(high) - middle[at(q)];
    }
    centres_[at(i)] = {middle[0], middle[1], middle[2]};
    extents_[at(i)] = norm(Vec3<double>{half[0], half[1], half[2]});
    if (extents_[at(i)] > widest) widest = extents_[at(i)];
  }
  pairs_.clear();
  left_out_ = 0;
  const double radius_2 = square(swarm_.radius);
  grid_.each_pair(centres_, swarm_.radius + 2 * widest, [&](int a, int b) {
    const double apart = norm(centres_[at(a)] - centres_[at(b)]) - extents_[at(a)] - extents_[at(b)];
    if (apart >= swarm_.radius) return;
    const double distance_2 = least_distance_2(a, b, 0, rows_);
    if (distance_2 < radius_2) offer({a, b, distance_2});
  });
  if (left_out_ > 0) {
    std::sort(pairs_.begin(), pairs_.end(),
              [](const Pair& p, const Pair& q) { return std::tie(p.a, p.b) < std::tie(q.a, q.b); });
  }
  find_stretches();
}

void Neighbourhood::find_stretches() noexcept {
  stretches_.clear();
  const double radius_2 = square(swarm_.radius);
  for (const Pair& pair : pairs_) {
    for (int k = 0; k < rows_; k += stretch) {
      if (least_distance_2(pair.a, pair.b, k, k + stretch) < radius_2)
        stretches_.push_back({pair.a, pair.b, k});
    }
  }
}

/// f(first, count) for the stretches of each pair, with the pair's pose differences in in_.
template <class F>
void Neighbourhood::each_pair_of_stretches(F&& f) noexcept {
  for (std::size_t first = 0, next = 0; first < stretches_.size(); first = next) {
    const Stretch& pair = stretches_[first];
    double* pack = in_[0];
    for (; next < stretches_.size() && stretches_[next].a == pair.a && stretches_[next].b == pair.b; ++next) {
      const int stage = stretches_[next].stage;
      for (int k = stage; k < stage + stretch; k += W, pack += W * inputs) {
        for (int q = 0; q < n_; ++q)
          (L::load(poses_[pair.a * n_ + q] + k) - L::load(poses_[pair.b * n_ + q] + k)).store(pack + q * W);
      }
    }
    f(first, next - first);
  }
}

void Neighbourhood::evaluate(const double* s, double* c) noexcept {
  collect(s, poses_);
  const int entries = n_ + entries_of(n_);
  std::fill(sums_.all().begin(), sums_.all().end(), 0.0);
  each_pair_of_stretches([&](std::size_t first, std::size_t count) {
    derivatives_.run(in_[0], out_[0], static_cast<int>(count) * stretch / W);
    const double* out = out_[0];
    for (std::size_t i = first; i < first + count; ++i) {
      const Stretch& its = stretches_[i];
      double* const of_a = sums_[its.a * entries] + its.stage;
      double* const of_b = sums_[its.b * entries] + its.stage;
      double* const H = H_[static_cast<int>(i) * entries_of(n_)];
      for (int k = 0; k < stretch; k += W, out += W * outputs) {
        const auto add = [&](double* to, L value) { (L::load(to) + value).store(to); };
        int entry = 0;
        for (int q = 0; q < n_; ++q, ++entry) {
          const L g = L::load(out + q * W);
          add(of_a + entry * sums_.stride() + k, g);
          add(of_b + entry * sums_.stride() + k, -g);
        }
        for (int q = 0; q < n_; ++q) {
          for (int r = q; r < n_; ++r, ++entry) {
            const L h = L::load(out + (inputs + upper_index(q, r, inputs)) * W);
            add(of_a + entry * sums_.stride() + k, h);
            add(of_b + entry * sums_.stride() + k, h);
            h.store(H + (entry - n_) * stretch + k);
          }
        }
      }
    }
  });
  for (int i = 0; i < agents(); ++i) {
    const int agent = swarm_.agents[at(i)], ns = layout_.part(agent).ns;
    const Layout::View to = layout_.c(agent);
    int entry = i * entries;
    const auto scatter = [&](int place) {
      const double* const sum = sums_[entry++];
      for (int k = 1; k < layout_.stages; ++k) c[to(k, place)] += sum[k];
    };
    for (int q = 0; q < n_; ++q) scatter(q);
    for (int q = 0; q < n_; ++q) {
      for (int r = q; r < n_; ++r) scatter(ns + upper_index(q, r, ns));
    }
  }
}

void Neighbourhood::product(const double* z, double* y) const noexcept {
  if (pairs_.empty()) return;
  collect(z, z_);
  std::fill(y_.all().begin(), y_.all().end(), 0.0);
  const auto subtract = n_ == 3 ? subtract_products<3> : subtract_products<inputs>;
  for (std::size_t i = 0; i < stretches_.size(); ++i) {
    const Stretch& its = stretches_[i];
    const double* const H = H_[static_cast<int>(i) * entries_of(n_)];
    const auto of = [&](Rows& rows, int agent) { return rows[agent * n_] + its.stage; };
    subtract(H, of(z_, its.a), of(z_, its.b), of(y_, its.a), of(y_, its.b), z_.stride(), stretch);
  }
  for (int i = 0; i < agents(); ++i) {
    const Layout::View to = layout_.s(swarm_.agents[at(i)]);
    for (int q = 0; q < n_; ++q) {
      const double* const sum = y_[i * n_ + q];
      for (int k = 1; k < layout_.stages; ++k) y[to(k, q)] += sum[k];
    }
  }
}

void Neighbourhood::values(const double* s, std::span<double> of_agents) noexcept {
  collect(s, poses_);
  each_pair_of_stretches([&](std::size_t first, std::size_t count) {
    value_.run(in_[0], cost_[0], static_cast<int>(count) * stretch / W);
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const int begin = stretches_[first + i].stage, length = std::min(stretch, layout_.stages - begin);
      for (int k = 0; k < length; ++k) sum += cost_[0][static_cast<int>(i) * stretch + k];
    }
    const Stretch& pair = stretches_[first];
    for (const int i : {pair.a, pair.b}) of_agents[at(swarm_.agents[at(i)])] += sum;
  });
}

}  // namespace sightline
