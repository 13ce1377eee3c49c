#include "sightline/analysis/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "sightline/analysis/verdict_text.hpp"
#include "sightline/base.hpp"
#include "sightline/base/quantile.hpp"

namespace sightline {
namespace {

using std::numbers::pi;
constexpr double bin = 0.1;           // of distances [m]
constexpr double sector = pi / 36;    // of angles [rad]
constexpr double bias_reach = 1.0;    // greatest distance of the search for a bias [m]
constexpr double all_but_few = 0.95;  // fraction of a bin that counts as all of it
constexpr std::array<int, 3> position = {0, 1, 2};

/// Point n of an evenly spread (R3) sequence in the unit cube, by powers of the plastic number of
/// dimension 3.
std::array<double, 3> spread(int n) {
  constexpr std::array steps = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  std::array<double, 3> u{};
  for (std::size_t i = 0; i < 3; ++i) u[i] = std::fmod(0.5 + (n + 1) * steps[i], 1.0);
  return u;
}

Vec3<double> direction(double u, double v) {
  const double z = 2 * u - 1, r = std::sqrt(std::max(0.0, 1 - z * z)), phi = 2 * pi * v;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values.empty() ? 0.0 : quantile(std::move(values), 0.5);
}

/// Fraction of the counted samples that have a property.
struct Share {
  long of = 0, all = 0;

  void count(bool holds) { of += holds, ++all; }
  double value() const { return all > 0 ? static_cast<double>(of) / static_cast<double>(all) : 0.0; }
};

class TermJudge {
 public:
  TermJudge(const Potential& potential, const VerdictOptions& options)
      : potential_(potential), field_(potential), mount_(potential.mount()) {
    v_.name = potential.name();
    v_.options = options;
    v_.has_view = mount_ != nullptr;
    v_.sees_heading = field_.sees_heading();
  }

  Verdict verdict() {
    if (mount_ != nullptr) look_at_angles();
    look_at_volume();
    look_along_radii();
    look_at_limit();
    look_for_traps();
    if (v_.sees_heading) look_for_traps_in_yaw();
    return std::move(v_);
  }

 private:
  double violation(const Station& s) const { return potential_.violation(observer_of(s), target_of(s)); }
  double sloped(const Station& s) const { return potential_.sloped(observer_of(s), target_of(s)); }
  bool flat(double gradient) const { return !(std::fabs(gradient) >= v_.options.flat); }

  /// Whether the view is a cone around the axis, unlike the full circle of a lidar.
  bool looks_along_axis() const { return v_.of_limit && v_.of_limit->greatest < pi / 2; }

  void look_at_volume() {
    Share outside, step, flat_in_position, flat_in_yaw, both, behind, away;
    for (int n = 0; n < v_.options.samples; ++n) {
      const auto [u, v, w] = spread(n);
      volume_.push_back(seen_at(v_.options.reach * std::pow(w, 1.0 / 3) * direction(u, v), mount_));
    }
    values_ = field_(volume_);
    for (std::size_t k = 0; k < volume_.size(); ++k) {
      const FieldValue& f = values_[k];
      const bool breaks = violation(volume_[k]) > 0;
      outside_.push_back(breaks);
      outside.count(breaks);
      if (const double l = sloped(volume_[k]); std::isfinite(l)) step.count((l > 0) != breaks);
      const auto curvatures = f.curvatures();
      v_.curvature_worst =
          std::max({v_.curvature_worst, std::fabs(curvatures.front()), std::fabs(curvatures.back())});
      v_.curvature_in_yaw = std::max(v_.curvature_in_yaw, std::fabs(f.at(3, 3)));
      if (!breaks) continue;
      flat_in_position.count(flat(f.slope()));
      if (!v_.sees_heading) continue;
      const Vec3<double> p_S = in_sensor_frame(volume_[k], mount_);
      flat_in_yaw.count(flat(f.yaw()));
      both.count(flat(f.slope()) && flat(f.yaw()));
      if (p_S.x < 0) behind.count(flat(f.yaw()));
      // A turn to the left brings a target on the left (y_S > 0) nearer to the axis.
      if (looks_along_axis()) away.count(!flat(f.yaw()) && f.yaw() * p_S.y > 0);
    }
    v_.outside = outside.value();
    v_.step_disagrees = step.value();
    v_.flat_in_position = flat_in_position.value();
    v_.flat_in_yaw = flat_in_yaw.value();
    v_.flat_in_both = both.value();
    v_.flat_in_yaw_behind = behind.value();
    v_.turns_away = away.value();
  }

  /// Counts flat gradients by distance and by the angle off the axis, at equally many samples each.
  void look_along_radii() {
    const int bins = static_cast<int>(std::ceil(v_.options.reach / bin)),
              sectors = static_cast<int>(pi / sector);
    std::vector<Share> by_distance(at(bins)), by_angle(at(sectors));
    std::vector<Station> stations;
    for (int n = 0; n < v_.options.samples / 4; ++n) {
      const auto [u, v, w] = spread(n);
      stations.push_back(seen_at(v_.options.reach * w * direction(u, v), mount_));
    }
    const auto values = field_(stations);
    for (std::size_t k = 0; k < stations.size(); ++k) {
      if (!(violation(stations[k]) > 0)) continue;
      const Vec3<double> p_S = in_sensor_frame(stations[k], mount_);
      const double r = norm(p_S), angle = std::atan2(norm(p_S.y, p_S.z), p_S.x);
      by_distance[at(std::min(bins - 1, static_cast<int>(r / bin)))].count(flat(values[k].slope()));
      if (r > bin)
        by_angle[at(std::min(sectors - 1, static_cast<int>(angle / sector)))].count(flat(values[k].yaw()));
    }
    const auto none = [](const Share& s) { return s.all > 0 && s.value() > all_but_few; };
    int from = bins, sector_from = sectors, to = 0;
    while (from > 0 && none(by_distance[at(from - 1)])) --from;
    while (to < from && none(by_distance[at(to)])) ++to;
    while (sector_from > 0 && none(by_angle[at(sector_from - 1)])) --sector_from;
    if (from < bins) v_.flat_beyond = from * bin;
    if (to > 0) v_.flat_within = to * bin;
    if (v_.sees_heading && sector_from < sectors) v_.flat_in_yaw_from = sector_from * sector;
  }

  /// Point of the limit between a station inside and one outside, by bisection.
  Station crossing(Station in, Station out, const std::function<bool(const Station&)>& is_out) const {
    for (int n = 0; n < 40; ++n) {
      const Station middle = {.target = 0.5 * (in.target + out.target)};
      (is_out(middle) ? out : in) = middle;
    }
    return in;
  }

  void look_at_limit() {
    constexpr std::size_t most = 1000;
    std::vector<Station> limit;
    // Samples are evenly spread, and so are the lines between consecutive samples.
    for (std::size_t k = 1; k < volume_.size() && limit.size() < most; ++k) {
      if (outside_[k] == outside_[k - 1]) continue;
      limit.push_back(crossing(volume_[outside_[k] ? k - 1 : k], volume_[outside_[k] ? k : k - 1],
                               [this](const Station& s) { return violation(s) > 0; }));
    }
    if (limit.empty()) return;
    const auto values = field_(limit);
    std::vector<double> levels, conditions, biases, angles;
    for (const FieldValue& f : values) {
      levels.push_back(f.l);
      auto c = f.curvatures();
      for (double& x : c) x = std::fabs(x);
      std::sort(c.begin(), c.end());
      conditions.push_back(c[2] / std::max(c[0], 1e-300));
    }
    v_.level = median(levels);
    v_.condition = median(conditions);
    v_.condition_worst = *std::max_element(conditions.begin(), conditions.end());
    for (std::size_t k = 0; k < limit.size(); ++k) {
      const double away = bias_at(limit[k], values[k]);
      biases.push_back(away);
      angles.push_back(away / std::max(1e-3, norm(in_sensor_frame(limit[k], mount_))));
      if (std::fabs(away) > std::fabs(v_.bias_worst)) v_.bias_worst = away;
    }
    v_.bias = median(biases);
    v_.bias_angle = median(angles);
    Share disagrees;
    for (std::size_t k = 0; k < volume_.size(); ++k)
      disagrees.count((values_[k].l > v_.level) != outside_[k]);
    v_.sigmoid_disagrees = disagrees.value();
  }

  /// Half of the step of l at the limit; without a step, the median level.
  double half_step(const Station& s, const Vec3<double>& up) const {
    constexpr double beyond = 1e-3;  // [m]
    const auto at = [&](double distance) { return sloped({.target = s.target + distance * up}); };
    const double jump = 2 * at(beyond) - at(2 * beyond);  // at the limit itself, by extrapolation
                                                          // of the slope
    return jump > beyond ? 0.5 * jump : v_.level;
  }

  /// Distance along the gradient at which l has half of its step [m], at most bias_reach.
  double bias_at(const Station& s, const FieldValue& f) const {
    constexpr int steps = 50;
    constexpr double length = bias_reach / steps;
    const double slope = f.slope();
    if (!(slope > 0)) return 0.0;
    const Vec3<double> up = {f.first[0] / slope, f.first[1] / slope, f.first[2] / slope};
    const double level = half_step(s, up), sign = f.l > level ? -1.0 : 1.0;
    double before = f.l;
    for (int n = 1; n <= steps; ++n) {
      const Station there = {.target = s.target + sign * n * length * up};
      const double l = potential_(observer_of(there), target_of(there), 0.0);
      if ((l > level) != (f.l > level)) return sign * length * (n - 1 + (level - before) / (l - before));
      before = l;
    }
    return sign * bias_reach;
  }

  void look_at_angles() {
    const auto half_angle =
        [this](const std::function<bool(const Station&)>& is_out) -> std::optional<HalfAngle> {
      double r = v_.options.reach / 2;  // a distance at which the axis lies within the limit
      for (int n = 0; n < 10 && is_out(seen_at({r, 0, 0}, mount_)); ++n) r /= 1.5;
      if (is_out(seen_at({r, 0, 0}, mount_))) return {};
      HalfAngle cone{pi, 0.0};
      for (int n = 0; n < 48; ++n) {
        const double roll = n * pi / 24;
        const auto turned = [&](double angle) {
          return seen_at({r * std::cos(angle), r * std::sin(angle) * std::cos(roll),
                          r * std::sin(angle) * std::sin(roll)},
                         mount_);
        };
        double in = 0.0, out = 0.0;
        while (out < pi && !is_out(turned(out))) in = out, out += pi / 180;
        for (int k = 0; k < 40; ++k) (is_out(turned(0.5 * (in + out))) ? out : in) = 0.5 * (in + out);
        cone = {std::min(cone.least, in), std::max(cone.greatest, in)};
      }
      return cone;
    };
    v_.of_limit = half_angle([this](const Station& s) { return violation(s) > 0; });
    if (std::isfinite(sloped(seen_at({1, 0, 0}, mount_)))) {
      v_.of_step = half_angle([this](const Station& s) { return sloped(s) > 0; });
    }
  }

  /// Descends from each local minimum of a grid.
  void look_for_traps() {
    constexpr int n = 33;
    constexpr std::size_t most = 200;
    constexpr double deep = 1e-7;  // required depth below its neighbours, to exclude a plateau
    const auto place = [&](int i) { return v_.options.reach * (2.0 * i / (n - 1) - 1); };
    std::vector<Station> grid;
    for (int i = 0; i < n * n * n; ++i) {
      grid.push_back(seen_at({place(i / (n * n)), place(i / n % n), place(i % n)}, mount_));
    }
    const auto values = field_(grid);
    std::size_t found = 0;
    for (int i = 1; i + 1 < n; ++i) {
      for (int j = 1; j + 1 < n; ++j) {
        for (int k = 1; k + 1 < n && found < most; ++k) {
          const int here = (i * n + j) * n + k;
          bool least = violation(grid[at(here)]) > 0;
          for (int m = 0; m < 27 && least; ++m) {
            const int there = here + (m / 9 - 1) * n * n + (m / 3 % 3 - 1) * n + m % 3 - 1;
            least = there == here || values[at(here)].l < values[at(there)].l - deep;
          }
          if (!least) continue;
          ++found;
          const Rest rest = descend(field_, grid[at(here)], position);
          const Vec3<double> p_S = in_sensor_frame(rest.station, mount_);
          const bool known = std::any_of(v_.traps.begin(), v_.traps.end(),
                                         [&](const Trap& t) { return norm(t.p_S - p_S) < 0.05; });
          if (rest.is_minimum && !known && violation(rest.station) > 0) v_.traps.push_back({p_S, rest.l});
        }
      }
    }
  }

  void look_for_traps_in_yaw() {
    constexpr int headings = 120, places = 200;
    Share trapped;
    for (int n = 0; n < places; ++n) {
      const auto [u, v, w] = spread(n);
      const Vec3<double> p = bin * direction(u, v) + (v_.options.reach - bin) * w * direction(u, v);
      std::vector<Station> turn;
      for (int k = 0; k < headings; ++k) turn.push_back({.target = p, .psi = 2 * pi * k / headings});
      const auto values = field_(turn);
      const auto l = [&](int k) { return values[at((k + headings) % headings)].l; };
      bool seen = false, trap = false;
      for (int k = 0; k < headings; ++k) {
        const bool breaks = violation(turn[at(k)]) > 0;
        seen = seen || !breaks;
        trap = trap || (breaks && l(k) < l(k - 1) - 1e-9 && l(k) < l(k + 1) - 1e-9);
      }
      if (seen) trapped.count(trap);
    }
    v_.traps_in_yaw = trapped.value();
  }

  Potential potential_;
  Field field_;
  const SensorMount* mount_;
  Verdict v_;
  std::vector<Station> volume_;
  std::vector<FieldValue> values_;
  std::vector<bool> outside_;
};

/// The least of a few rounding widths with a second derivative of at most stiff / 2.
std::optional<Cure> cure_of(const Potential& potential, const VerdictOptions& options) {
  const std::optional<Rounding> rounding = potential.rounding();
  if (!rounding) return {};
  for (const double smooth : {0.003, 0.01, 0.03, 0.1}) {
    if (smooth <= rounding->width) continue;
    const double left = TermJudge(potential.smoothed_over(smooth), options).verdict().curvature_worst;
    if (left <= stiff / 2) return Cure{smooth, left};
  }
  return {};
}

}  // namespace

Verdict judge(const Potential& potential, const VerdictOptions& options) {
  constexpr double wider = 3.0, widest = 60.0;  // m
  Verdict verdict = TermJudge(potential, options).verdict();
  VerdictOptions next = options;
  while ((verdict.outside == 0 || verdict.outside == 1) && (next.reach *= wider) <= widest) {
    if (Verdict other = TermJudge(potential, next).verdict(); other.outside > 0 && other.outside < 1)
      verdict = std::move(other);
  }
  if (verdict.curvature_worst > stiff) verdict.cure = cure_of(potential, verdict.options);
  describe(verdict);
  return verdict;
}

}  // namespace sightline
