#include "sightline/safety/row_projection.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/safety/barrier_rows.hpp"

namespace sightline {
namespace {

/// Linearisation of the rows in the commands, at the nominal command.
struct LinearRows {
  std::span<const double> u_min, u_max;
  double bent;                                    // [m] bound on the nonlinearity within the limits
  std::array<double, most_inputs> u{};            // the nominal command
  std::array<double, most_inputs> low{}, high{};  // the limits, narrowed by floor and ceiling
  double lost = 0.0;                              // violation of floor and ceiling due to the limits [m]
  NextState nominal{};
  std::array<NextState, most_inputs> slope{};
  Bounded<HalfSpace, most_half_spaces> half;
  Bounded<std::size_t, most_half_spaces> of;  // index of each half-space's row

  LinearRows(std::span<const double> least, std::span<const double> most, double curved,
             const NextState& there)
      : u_min(least), u_max(most), bent(curved), nominal(there) {
    std::copy(least.begin(), least.end(), low.begin());
    std::copy(most.begin(), most.end(), high.begin());
  }

  /// Adds a row, unless no command within the limits can violate it.
  void add(const BarrierRow& row, std::size_t index) {
    HalfSpace h;
    double lowest = 0.0, centre = 0.0;
    for (std::size_t k = 0; k < u_min.size(); ++k) {
      h.a[k] = row.value(slope[k]);
      lowest += std::min(h.a[k] * (u_min[k] - u[k]), h.a[k] * (u_max[k] - u[k]));
      centre += h.a[k] * u[k];
    }
    const double missing = std::clamp(row.missed(nominal), -far_away, far_away);
    if (lowest - missing > bent) return;
    h.b = centre + missing;
    if (row.wall == Wall::floor || row.wall == Wall::ceiling) {
      // If one input alone climbs, floor and ceiling become limits of that input, which have
      // priority.
      const auto moves = [](double a) { return a != 0; };
      const auto k = static_cast<std::size_t>(std::find_if(h.a.begin(), h.a.end(), moves) - h.a.begin());
      if (std::count_if(h.a.begin(), h.a.end(), moves) == 1) {
        double& limit = h.a[k] > 0 ? low[k] : high[k];
        const double wanted = h.b / h.a[k];
        limit = h.a[k] > 0 ? std::clamp(wanted, limit, high[k]) : std::clamp(wanted, low[k], limit);
        lost = std::max(lost, h.b - h.a[k] * limit);
        return;
      }
    }
    h.hard = row.wall != Wall::none;
    of.push_back(index);
    half.push_back(h);
  }

  /// Adds the error of the linearised step to the rows. @return the largest error [m]
  double correct(const BarrierPeriod& now, const NextState& there,
                 const std::array<double, most_inputs>& at) {
    double most = 0.0;
    for (std::size_t i = 0; i < half.size(); ++i) {
      double linear = half[i].b;
      for (std::size_t k = 0; k < most_inputs; ++k) linear -= half[i].a[k] * at[k];
      const double more = now.rows[of[i]].missed(there) - linear;
      half[i].b += more;
      most = std::max(most, std::abs(more));
    }
    return most;
  }
};

}  // namespace

double project_on_rows(const BarrierLaw& law, const NextState& nominal, BarrierPeriod& now,
                       std::span<double> u) noexcept {
  LinearRows linear(now.u_min, now.u_max, 1e-3 * square(law.parts), nominal);
  std::copy(u.begin(), u.end(), linear.u.begin());
  for (std::size_t k = 0; k < u.size(); ++k) {
    constexpr double difference = 1e-3;
    std::array<double, most_inputs> moved = linear.u;
    moved[k] += difference;
    const NextState there = law.next(now.x, std::span(moved).first(u.size()));
    linear.slope[k].p = (1.0 / difference) * (there.p - nominal.p);
    linear.slope[k].d = {(there.d.x - nominal.d.x) / difference, (there.d.y - nominal.d.y) / difference};
    linear.slope[k].v = {(there.v.x - nominal.v.x) / difference, (there.v.y - nominal.v.y) / difference};
    linear.slope[k].beside = (there.beside - nominal.beside) / difference;
    const Lagging &late = there.lagging, &of = nominal.lagging;
    linear.slope[k].lagging = {{(late.a.x - of.a.x) / difference, (late.a.y - of.a.y) / difference},
                               (late.rate - of.rate) / difference};
  }
  std::size_t taken = 0;
  std::array<double, most_inputs> at = linear.u;
  const auto nearest = std::span(at).first(u.size());
  double violation = 0.0;
  constexpr int rounds = 5;
  for (int round = 0; round < rounds; ++round) {
    for (; taken < now.rows.size(); ++taken) linear.add(now.rows[taken], taken);
    at = linear.u;
    const ProjectionResult result = project(linear.half, std::span(linear.low).first(u.size()),
                                            std::span(linear.high).first(u.size()), nearest);
    violation = std::max(result.violation, linear.lost);
    const NextState there = law.next(now.x, nearest);
    const double most = linear.correct(now, there, at);
    if (!result.feasible) break;
    add_cuts(law, there, now);
    if (most < corrected && taken == now.rows.size()) break;
  }
  if (all_finite(nearest)) std::copy(nearest.begin(), nearest.end(), u.begin());
  return violation;
}

}  // namespace sightline
