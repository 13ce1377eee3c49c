#include "sightline/analysis/identification/downwash_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "sightline/base/json_text.hpp"
#include "sightline/base/quantile.hpp"

namespace sightline {
namespace {

constexpr double gap_most = 0.2;                    // between samples of a vehicle that are interpolated [s]
constexpr double flies_from = 0.7;                  // of its weight, the thrust from which a vehicle flies
constexpr double calm_least = 2.0;                  // outside of the downwash, for c [s]
constexpr double inside_least = 0.5;                // in the downwash, for a scale that predicts others [s]
constexpr double cluster_time = 1.0;                // over which residuals correlate [s]
constexpr double lag_step = 0.005, lag_most = 0.3;  // [s]
constexpr double lag_usual = 0.1;                   // that decides who flies, and who is in the downwash [s]
constexpr int fifths = 5;
constexpr double quantile_95 = 1.96;  // 97.5 % quantile of the normal distribution

/// Thrust per c of a record: its power behind the lag.
std::vector<double> lagged(const RotorRecord& record, double lag) {
  std::vector<double> thrust = record.power;
  for (std::size_t k = 1; k < thrust.size(); ++k) {
    const double share = 1 - std::exp(-(record.t[k] - record.t[k - 1]) / lag);
    thrust[k] = thrust[k - 1] + share * (record.power[k - 1] - thrust[k - 1]);
  }
  return thrust;
}

/// Median ratio of acceleration to thrust while the rotors turn: c, were there no downwash.
double usual_c(const RotorRecord& record, const std::vector<double>& thrust) {
  const double turns = 0.5 * quantile(thrust, 0.9);
  std::vector<double> ratios;
  for (std::size_t k = 0; k < thrust.size(); ++k) {
    if (thrust[k] > turns && thrust[k] > 0) ratios.push_back(record.a_z[k] / thrust[k]);
  }
  return ratios.empty() ? 0.0 : quantile(ratios, 0.5);
}

/// Thrust of each vehicle of a flight, were there no downwash: c times that per c.
struct FlightThrust {
  std::vector<std::vector<double>> per_c{};
  std::vector<double> c{};

  FlightThrust(const DownwashFlight& flight, double lag) {
    for (const RotorRecord& one : flight) {
      per_c.push_back(lagged(one, lag));
      c.push_back(usual_c(one, per_c.back()));
    }
  }
};

/// What one vehicle contributes: y = c S - scale D + e, row by row.
struct BelowOthers {
  std::string robot{};
  int flight = 0;
  std::vector<double> t{}, y{}, S{}, D{};
  std::vector<bool> calm{};  ///< whether it is outside of the downwash

  std::size_t size() const { return t.size(); }

  /// Of the rows for which `counts(k)` holds [s].
  template <class Counts>
  double seconds(Counts&& counts) const {
    double sum = 0.0;
    for (std::size_t k = 1; k < size(); ++k) sum += counts(k) ? std::min(t[k] - t[k - 1], gap_most) : 0.0;
    return sum;
  }
};

/// The rows of the vehicles that were below another one. Which they are is decided by the usual lag, so
/// that fits at different lags are of the same rows.
std::vector<BelowOthers> rows_of(const DownwashFlight& flight, int number, double lag) {
  const FlightThrust at_lag(flight, lag), usual(flight, lag_usual);
  std::vector<BelowOthers> all;
  for (std::size_t i = 0; i < flight.size(); ++i) {
    const RotorRecord& below = flight[i];
    const double drag = below.vehicle.drag.z / below.vehicle.mass;
    std::vector<std::size_t> place(flight.size(), 0);  // of the next sample of each vehicle
    BelowOthers rows{.robot = below.name, .flight = number};
    bool inside = false;
    for (std::size_t k = 0; k < below.t.size(); ++k) {
      double w = 0.0, usual_w = 0.0;
      bool known = usual.c[i] * usual.per_c[i][k] > flies_from * gravity;
      for (std::size_t j = 0; j < flight.size(); ++j) {
        if (j == i) continue;
        const RotorRecord& above = flight[j];
        std::size_t& next = place[j];
        while (next < above.t.size() && above.t[next] <= below.t[k]) ++next;
        known = known && next > 0 && next < above.t.size() && above.t[next] - above.t[next - 1] <= gap_most;
        if (!known) break;
        const double share = (below.t[k] - above.t[next - 1]) / (above.t[next] - above.t[next - 1]);
        const auto between = [&](const auto& of) { return of[next - 1] + share * (of[next] - of[next - 1]); };
        const Vehicle& rotors = above.vehicle;
        Jet jet{.p = between(above.p),
                .down = -1.0 * between(above.up),
                .radius2 = rotors.disc_radius2(),
                .v = between(above.v)};
        const auto down = [&](const FlightThrust& by) {
          jet.thrust = std::max(0.0, rotors.mass * by.c[j] * between(by.per_c[j]));
          return -jet.air(below.p[k]).z;
        };
        w += down(at_lag), usual_w += down(usual);
      }
      if (!known) continue;
      rows.t.push_back(below.t[k]);
      rows.y.push_back(below.a_z[k] + drag * below.v[k].z);
      rows.S.push_back(at_lag.per_c[i][k] * below.up[k].z);
      rows.D.push_back(drag * w);
      rows.calm.push_back(!(drag * usual_w > downwash_calm));
      inside = inside || !rows.calm.back();
    }
    if (inside) all.push_back(std::move(rows));
  }
  return all;
}

/// @throws std::invalid_argument if no vehicle is in the downwash of another, or one that is has too few
///   rows outside for its c
std::vector<BelowOthers> rows_of(const std::vector<DownwashFlight>& flights, double lag) {
  std::vector<BelowOthers> all;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    for (BelowOthers& one : rows_of(flights[f], static_cast<int>(f), lag)) all.push_back(std::move(one));
  }
  if (all.empty())
    throw_invalid(
        "no vehicle is in the downwash of another, which would accelerate it by more than {} m/s^2: expected "
        "vehicles above one another, of one clock",
        downwash_calm);
  for (const BelowOthers& rows : all) {
    const double calm = rows.seconds([&](std::size_t k) { return rows.calm[k]; });
    if (!(calm >= calm_least))
      throw_invalid("{} was outside of the downwash for {:.3g} s, expected at least {} s", rows.robot, calm,
                    calm_least);
  }
  return all;
}

/// Which part of the rows a fold leaves out: a flight, or a fifth of the only one.
struct Fold {
  std::string without{};  ///< the beginning of a sentence on the rows that it keeps
  int flight = -1;
  double from = -infinity, to = infinity;  // [s]

  bool has(const BelowOthers& rows, std::size_t k) const {
    return rows.flight == flight && rows.t[k] >= from && rows.t[k] < to;
  }
};

/// Of a vehicle, to eliminate c.
struct ThrustSums {
  double SS = 0.0, SD = 0.0, Sy = 0.0;
};

struct ScaleFit {
  double scale = 0.0, cost = infinity;
  std::vector<double> c;  ///< of each of the rows
};

/// The least squares at a lag, without the rows of the fold; c is eliminated.
ScaleFit fit_at(const std::vector<BelowOthers>& all, const Fold& without) {
  std::vector<ThrustSums> sums(all.size());
  double DD = 0.0, Dy = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const BelowOthers& rows = all[i];
    ThrustSums& of = sums[i];
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (without.has(rows, k)) continue;
      of.SS += square(rows.S[k]), of.SD += rows.S[k] * rows.D[k], of.Sy += rows.S[k] * rows.y[k];
      DD += square(rows.D[k]), Dy += rows.D[k] * rows.y[k], yy += square(rows.y[k]);
    }
    if (!(of.SS > 0)) continue;
    DD -= square(of.SD) / of.SS, Dy -= of.SD * of.Sy / of.SS, yy -= square(of.Sy) / of.SS;
  }
  ScaleFit fit;
  if (!(DD > 0)) return fit;
  fit.scale = -Dy / DD;
  fit.cost = yy - square(Dy) / DD;
  for (const ThrustSums& of : sums) fit.c.push_back(of.SS > 0 ? (of.Sy + fit.scale * of.SD) / of.SS : 0.0);
  return fit;
}

struct RowsAtLag {
  double lag;
  std::vector<BelowOthers> rows;
};

/// The rows at all lags that are tried.
std::vector<RowsAtLag> all_lags(const std::vector<DownwashFlight>& flights) {
  std::vector<RowsAtLag> all;
  for (int i = 1; lag_step * i <= lag_most; ++i)
    all.push_back({lag_step * i, rows_of(flights, lag_step * i)});
  return all;
}

/// The index of the best lag, and the fit there.
std::pair<std::size_t, ScaleFit> best_fit(const std::vector<RowsAtLag>& lags, const Fold& without = {}) {
  std::pair<std::size_t, ScaleFit> best;
  for (std::size_t i = 0; i < lags.size(); ++i) {
    ScaleFit fit = fit_at(lags[i].rows, without);
    if (fit.cost < best.second.cost) best = {i, std::move(fit)};
  }
  return best;
}

/// Removes from `a` its part along `b`; both are zero for rows that are not in use.
void remove_along(std::vector<double>& a, const std::vector<double>& b, std::size_t from, std::size_t to) {
  double ab = 0.0, bb = 0.0;
  for (std::size_t k = from; k < to; ++k) ab += a[k] * b[k], bb += square(b[k]);
  if (!(bb > 0)) return;
  for (std::size_t k = from; k < to; ++k) a[k] -= ab / bb * b[k];
}

/// Half the width of the 95 % interval of the scale.
double scale_interval(const std::vector<RowsAtLag>& lags, std::size_t best, const ScaleFit& fit) {
  const std::size_t next = best + 1 < lags.size() ? best + 1 : best - 1;
  const std::vector<BelowOthers>& here = lags[best].rows;
  const std::vector<BelowOthers>& there = lags[next].rows;
  std::vector<double> D, S, slope, e;
  std::vector<int> cluster;
  int clusters = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    const BelowOthers &a = here[i], &b = there[i];
    const std::size_t from = D.size();
    double end = -infinity;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (!(a.t[k] < end)) ++clusters, end = a.t[k] + cluster_time;
      D.push_back(a.D[k]), S.push_back(a.S[k]), cluster.push_back(clusters - 1);
      e.push_back(a.y[k] - fit.c[i] * a.S[k] + fit.scale * a.D[k]);
      slope.push_back(fit.c[i] * (b.S[k] - a.S[k]) - fit.scale * (b.D[k] - a.D[k]));
    }
    remove_along(D, S, from, D.size());
    remove_along(slope, S, from, D.size());
  }
  remove_along(D, slope, 0, D.size());
  std::vector<double> scores(size(clusters));
  double DD = 0.0, ee = 0.0;
  for (std::size_t k = 0; k < D.size(); ++k) {
    scores[size(cluster[k])] += D[k] * e[k];
    DD += square(D[k]), ee += square(e[k]);
  }
  double between = 0.0;
  for (const double one : scores) between += square(one);
  const double independent = ee / static_cast<double>(e.size()) / DD, correlated = between / square(DD);
  return quantile_95 * std::sqrt(std::max(independent, correlated));
}

/// A predicted sample.
struct Predicted {
  double d, e, e_without;  ///< acceleration by the downwash; errors with and without it
  bool inside;
};

/// Predictions for the rows of the fold by the scale of others. c is that of all samples of the vehicle
/// that are outside of the downwash.
std::vector<Predicted> predict(const BelowOthers& rows, double scale, const Fold& fold) {
  double SS = 0.0, Sy = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows.calm[k]) SS += square(rows.S[k]), Sy += rows.S[k] * rows.y[k];
  }
  std::vector<Predicted> all;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (!fold.has(rows, k)) continue;
    const double d = scale * rows.D[k], e = rows.y[k] - Sy / SS * rows.S[k];
    all.push_back({d, e + d, e, rows.D[k] > downwash_calm});
  }
  return all;
}

/// The least bound that holds 95 % of the errors, outside and inside.
DownwashBound bound_of(const std::vector<const std::vector<Predicted>*>& predictions) {
  std::vector<double> calm, gusty;
  for (const auto* of : predictions) {
    for (const Predicted& one : *of) {
      if (!one.inside) calm.push_back(std::abs(one.e));
    }
  }
  DownwashBound bound{.calm = calm.empty() ? 0.0 : quantile(calm, 0.95)};
  for (const auto* of : predictions) {
    for (const Predicted& one : *of) {
      if (one.inside)
        gusty.push_back(std::sqrt(std::max(0.0, square(one.e) - square(bound.calm)) / std::sqrt(one.d)));
    }
  }
  if (!gusty.empty()) bound.gusty = quantile(gusty, 0.95);
  return bound;
}

/// Adds up; the means are taken at the end.
void add(DownwashErrors& sums, const Predicted& one, const DownwashBound& bound) {
  for (DownwashError* const of : {&sums.all, &sums.inside}) {
    if (of == &sums.inside && !one.inside) continue;
    ++of->samples;
    of->with += square(one.e), of->without += square(one.e_without);
    of->covered += std::abs(one.e) <= bound.at(one.d) ? 1.0 : 0.0;
  }
}

DownwashErrors means(DownwashErrors sums) {
  for (DownwashError* const of : {&sums.all, &sums.inside}) {
    const auto samples = static_cast<double>(std::max<std::size_t>(of->samples, 1));
    of->with = std::sqrt(of->with / samples), of->without = std::sqrt(of->without / samples);
    of->covered /= samples;
  }
  return sums;
}

/// The folds of a cross-validation: each flight, or each fifth of the only one.
/// @throws std::invalid_argument if the rows that a fold keeps are too few in the downwash for a scale
std::vector<Fold> folds_of(const std::vector<BelowOthers>& all, std::size_t flights) {
  std::vector<Fold> folds;
  if (flights > 1) {
    for (int f = 0; size(f) < flights; ++f)
      folds.push_back({.without = fmt::format("without flight {}, ", f), .flight = f});
  } else {
    double begin = infinity, end = -infinity;
    for (const BelowOthers& rows : all)
      begin = std::min(begin, rows.t.front()), end = std::max(end, rows.t.back());
    for (int i = 0; i < fifths; ++i)
      folds.push_back({.without = fmt::format("without fifth {} of the flight, ", i + 1),
                       .flight = 0,
                       .from = i == 0 ? -infinity : begin + (end - begin) * i / fifths,
                       .to = i + 1 == fifths ? infinity : begin + (end - begin) * (i + 1) / fifths});
  }
  for (const Fold& fold : folds) {
    double inside = 0.0;
    for (const BelowOthers& rows : all)
      inside += rows.seconds([&](std::size_t k) { return !rows.calm[k] && !fold.has(rows, k); });
    if (!(inside >= inside_least))
      throw_invalid(
          "{}vehicles were in the downwash for {:.3g} s, expected at least {} s: give another flight",
          fold.without, inside, inside_least);
  }
  return folds;
}

/// Predictions of a fold, for each of the rows.
using FoldPredictions = std::vector<std::vector<Predicted>>;

FoldPredictions predict(const std::vector<BelowOthers>& all, double scale, const Fold& fold) {
  FoldPredictions predictions;
  for (const BelowOthers& rows : all) predictions.push_back(predict(rows, scale, fold));
  return predictions;
}

DownwashBound bound_without(const std::vector<FoldPredictions>& folds, std::optional<std::size_t> without) {
  std::vector<const std::vector<Predicted>*> all;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    if (without && f == *without) continue;
    for (const auto& of : folds[f]) all.push_back(&of);
  }
  return bound_of(all);
}

double seconds_of(const std::vector<BelowOthers>& all) {
  double seconds = 0.0;
  for (const BelowOthers& rows : all) seconds += rows.seconds([](std::size_t) { return true; });
  return seconds;
}

void refuse_no_downwash(const ScaleFit& fit, const std::string& place) {
  if (!(fit.scale > 0))
    throw_invalid("{}the downwash is {:.3g} of that of momentum theory, expected one above 0", place,
                  fit.scale);
}

}  // namespace

double DownwashBound::at(double d) const {
  return std::sqrt(square(calm) + square(gusty) * std::sqrt(std::abs(d)));
}

DownwashIdentification identify_downwash(const std::vector<DownwashFlight>& flights,
                                         const std::vector<DownwashFlight>& held_out) {
  const std::vector<RowsAtLag> lags = all_lags(flights);
  const std::vector<Fold> folds = folds_of(lags.front().rows, flights.size());
  const auto [best, fit] = best_fit(lags);
  refuse_no_downwash(fit, "");
  DownwashIdentification found{.scale = fit.scale, .lag = lags[best].lag};
  const std::vector<BelowOthers>& rows = lags[best].rows;
  found.seconds = seconds_of(rows);
  found.interval = scale_interval(lags, best, fit);
  if (!(found.low() > 0))
    throw_invalid("the downwash is {:.3g} to {:.3g} of that of momentum theory, expected one above 0",
                  found.low(), found.high());
  try {
    DownwashOptions{found.scale}.check();
  } catch (const std::invalid_argument& error) {
    throw_invalid("{}; check mass, rotors and drag of the vehicles", error.what());
  }

  std::vector<FoldPredictions> predictions;
  for (const Fold& fold : folds) {
    const auto [at, others] = best_fit(lags, fold);
    refuse_no_downwash(others, fold.without);
    predictions.push_back(predict(lags[at].rows, others.scale, fold));
  }
  found.bound = bound_without(predictions, {});
  if (!held_out.empty()) {
    found.judged_on = "held-out flights";
    for (const BelowOthers& one : rows_of(held_out, found.lag)) {
      DownwashErrors sums{.robot = one.robot, .flight = one.flight};
      for (const Predicted& sample : predict(one, found.scale, Fold{.flight = one.flight}))
        add(sums, sample, found.bound);
      found.errors.push_back(means(sums));
    }
    return found;
  }
  found.judged_on =
      flights.size() > 1 ? "each flight by the others" : "each fifth of the flight by the others";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    DownwashErrors sums{.robot = rows[i].robot, .flight = rows[i].flight};
    for (std::size_t f = 0; f < folds.size(); ++f) {
      const DownwashBound bound = bound_without(predictions, f);
      for (const Predicted& one : predictions[f][i]) add(sums, one, bound);
    }
    found.errors.push_back(means(sums));
  }
  return found;
}

namespace {

std::string world_text(const DownwashIdentification& found) {
  return fmt::format("[world]\nkind = \"rotors\"\ndownwash = {:.3f}  # 95 %: {:.3f} to {:.3f}\n", found.scale,
                     found.low(), found.high());
}

}  // namespace

std::string to_string(const DownwashIdentification& found) {
  std::string text = fmt::format(
      "{:.1f} s of flight below others\n\n"
      "downwash {:>8.3f}     95 %: {:.3f} to {:.3f}; speed of the air over that of momentum theory\n"
      "lag      {:>8.3f} s   of the thrust behind the duty cycles\n\n"
      "{}, RMS errors of the vertical acceleration\n"
      "{:<32} {:>6} {:>16} {:>13} {:>6} {:>10}\n",
      found.seconds, found.scale, found.low(), found.high(), found.lag, found.judged_on, "robot", "flight",
      "without [m/s^2]", "with downwash", "ratio", "in 95 %");
  for (const DownwashErrors& one : found.errors) {
    for (const DownwashError* const of : {&one.all, &one.inside}) {
      text += fmt::format("{:<32} {:>6} {:>16.3f} {:>13.3f} {:>6.2f} {:>8.1f} %\n",
                          of == &one.all ? one.robot : "  in the downwash", one.flight, of->without, of->with,
                          of->ratio(), 100 * of->covered);
    }
  }
  return text + fmt::format(
                    "\nthe interval of 95 % is +-{:.2f} m/s^2, and +-{:.2f} m/s^2 where the downwash is 1 "
                    "m/s^2\n\n{}",
                    found.bound.at(0), found.bound.at(1), world_text(found));
}

std::string to_json(const DownwashIdentification& found) {
  using Json = nlohmann::ordered_json;
  Json errors = Json::array();
  for (const DownwashErrors& one : found.errors) {
    const auto of = [](const DownwashError& e) {
      return Json{
          {"samples", e.samples}, {"without_rms", e.without}, {"with_rms", e.with}, {"covered", e.covered}};
    };
    errors.push_back(
        {{"robot", one.robot}, {"flight", one.flight}, {"all", of(one.all)}, {"inside", of(one.inside)}});
  }
  const Json json = {{"downwash", found.scale},
                     {"low", found.low()},
                     {"high", found.high()},
                     {"lag", found.lag},
                     {"seconds", found.seconds},
                     {"bound_calm", found.bound.calm},
                     {"bound_gusty", found.bound.gusty},
                     {"judged_on", found.judged_on},
                     {"errors", std::move(errors)},
                     {"template", world_text(found)}};
  return json_text(json, 2) + "\n";
}

}  // namespace sightline
