#include "sightline/analysis/verdict_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/base/json_text.hpp"

namespace sightline {
namespace {

// Thresholds of the warnings.
constexpr double much_volume = 0.005;  // fraction with disagreement
constexpr double much_angle = 0.01;    // rad
constexpr double much_flat = 0.2;      // fraction of the volume outside the limit
constexpr double much_behind = 0.5;    // fraction of the volume behind the sensor
constexpr double much_away = 0.05;     // fraction
constexpr double much_bias = 0.25;     // m
constexpr double exact = 1e-6;         // m

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

std::string angle(const HalfAngle& a) {
  return a.greatest - a.least < 1e-3 ? fmt::format("{:.3f} rad", a.greatest)
                                     : fmt::format("{:.3f} to {:.3f} rad", a.least, a.greatest);
}

/// Collects the sentences; a warning belongs to both lists.
class Writer {
 public:
  explicit Writer(Verdict& v) : v_(v) {}
  void add(bool warns, std::string sentence) {
    if (warns) v_.warnings.push_back(sentence);
    v_.words.push_back(std::move(sentence));
  }

 private:
  Verdict& v_;
};

void describe_region(const Verdict& v, Writer& to) {
  const double R = v.options.reach;
  if (v.outside == 0) {
    to.add(false, fmt::format("its limit is broken nowhere within {:.3g} m, or it states none", R));
    return;
  }
  to.add(v.outside == 1,
         fmt::format("{} of the volume within {:.3g} m breaks its limit", percent(v.outside), R));
  if (v.of_step && v.of_limit) {
    const bool differ = std::fabs(v.of_step->greatest - v.of_limit->greatest) > much_angle ||
                        std::fabs(v.of_step->least - v.of_limit->least) > much_angle;
    to.add(differ,
           differ ? fmt::format("the half-angle of its region is {}, not the {} of its limit",
                                angle(*v.of_step), angle(*v.of_limit))
                  : fmt::format("the half-angle of its region is {}, as its limit says", angle(*v.of_limit)));
  }
  const bool agrees = v.step_disagrees == 0;
  to.add(v.step_disagrees > much_volume,
         agrees ? "its unit step is 0 where the limit holds and 1 where not, in every sample"
                : fmt::format("its unit step and its limit disagree in {} of the volume",
                              percent(v.step_disagrees)));
  to.add(false,
         fmt::format("l is {:.3g} at the limit; l above that and the limit disagree in {} of the volume",
                     v.level, percent(v.sigmoid_disagrees)));
  if (std::fabs(v.bias_worst) < exact) {
    to.add(false, "its sigmoid is worth half of its step at the limit: no bias");
  } else {
    to.add(std::fabs(v.bias) > much_bias,
           fmt::format("its sigmoid is worth half of its step {:.2g} m{} beyond the limit (< 0: inside), at "
                       "worst {:.2g} m",
                       v.bias, v.has_view ? fmt::format(" or {:.2g} rad", v.bias_angle) : "", v.bias_worst));
  }
}

void describe_gradient(const Verdict& v, Writer& to) {
  const double R = v.options.reach, flat = v.options.flat;
  if (v.outside == 0) return;
  to.add(v.flat_in_position > much_flat && !v.flat_beyond,
         fmt::format(
             "nothing pulls (|gradient| < {:.3g} 1/m) in {} of what is outside the limit within {:.3g} m",
             flat, percent(v.flat_in_position), R));
  if (v.flat_beyond) {
    to.add(true,
           fmt::format(
               "its gradient vanishes beyond {:.3g} m: below {:.3g} 1/m from there to {:.3g} m, a target "
               "there is lost",
               *v.flat_beyond, flat, R));
  }
  if (v.flat_within) {
    to.add(true, fmt::format("its gradient vanishes within {:.3g} m: below {:.3g} 1/m, nothing pushes out",
                             *v.flat_within, flat));
  }
  if (!v.sees_heading) {
    to.add(false, "it does not depend on the heading of the observer");
    return;
  }
  to.add(
      false,
      fmt::format("nothing turns the observer (|dl/dpsi| < {:.3g} 1/rad) in {} of what is outside the limit, "
                  "nothing turns or pulls it in {}",
                  flat, percent(v.flat_in_yaw), percent(v.flat_in_both)));
  if (v.has_view) {
    const bool none = v.flat_in_yaw_behind > much_behind;
    to.add(none,
           none ? fmt::format(
                      "no gradient in yaw behind the sensor: |dl/dpsi| < {:.3g} 1/rad in {} of it within "
                      "{:.3g} m, a target there is lost",
                      flat, percent(v.flat_in_yaw_behind), R)
                : fmt::format("behind the sensor |dl/dpsi| < {:.3g} 1/rad in {} of the volume", flat,
                              percent(v.flat_in_yaw_behind)));
  }
  if (v.flat_in_yaw_from) {
    to.add(false, fmt::format("further than {:.3g} rad off the axis nothing turns the observer",
                              *v.flat_in_yaw_from));
  }
  if (v.turns_away > 0) {
    to.add(v.turns_away > much_away,
           fmt::format("it turns the observer away from its target in {} of what is outside the limit",
                       percent(v.turns_away)));
  }
}

void describe_rest(const Verdict& v, Writer& to) {
  for (const Trap& t : v.traps) {
    to.add(true, fmt::format(
                     "it has a local minimum outside its limit, at ({:.3g}, {:.3g}, {:.3g}) m in the sensor "
                     "frame, worth {:.3g}",
                     t.p_S.x, t.p_S.y, t.p_S.z, t.l));
  }
  if (v.traps.empty()) to.add(false, "it has no local minimum outside its limit, by the position");
  if (v.sees_heading) {
    to.add(
        v.traps_in_yaw > much_away,
        fmt::format("turning stops with the target out of view, though it could be in, from {} of the places",
                    percent(v.traps_in_yaw)));
  }
  to.add(v.curvature_worst > stiff,
         fmt::format(
             "its Hessian at the limit has a condition number of {:.3g} (worst {:.3g}); its greatest second "
             "derivative is {:.3g} 1/m^2{}",
             v.condition, v.condition_worst, v.curvature_worst,
             v.sees_heading ? fmt::format(", {:.3g} 1/rad^2 in yaw", v.curvature_in_yaw) : ""));
  if (v.cure) {
    to.add(true,
           fmt::format(
               "commands may oscillate at its corners: smooth = {:.3g} rounds them off, and its greatest "
               "second derivative is {:.3g} 1/m^2",
               v.cure->smooth, v.cure->curvature));
  }
}

template <class T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

nlohmann::ordered_json or_null(const std::optional<HalfAngle>& a) {
  if (!a) return {};
  return {{"least", a->least}, {"greatest", a->greatest}};
}

}  // namespace

void describe(Verdict& v) {
  Writer to(v);
  v.words.clear();
  v.warnings.clear();
  if (v.around) {
    to.add(false,
           fmt::format("it depends on where in G the two are: looked at with the observer at its start, "
                       "({:.3g}, {:.3g}, {:.3g}) m",
                       v.around->x, v.around->y, v.around->z));
  }
  describe_region(v, to);
  describe_gradient(v, to);
  describe_rest(v, to);
}

std::string to_json(const Verdict& v) {
  using nlohmann::ordered_json;
  ordered_json traps = ordered_json::array();
  for (const Trap& t : v.traps) traps.push_back({{"p_S", {t.p_S.x, t.p_S.y, t.p_S.z}}, {"l", t.l}});
  return json_text(
      ordered_json{
          {"potential", v.name},
          {"radius", v.options.reach},
          {"threshold", v.options.flat},
          {"samples", v.options.samples},
          {"sees_heading", v.sees_heading},
          {"around", v.around ? ordered_json{v.around->x, v.around->y, v.around->z} : ordered_json()},
          {"outside", v.outside},
          {"region",
           {{"step_disagrees", v.step_disagrees},
            {"sigmoid_disagrees", v.sigmoid_disagrees},
            {"half_angle", or_null(v.of_step)},
            {"half_angle_of_limit", or_null(v.of_limit)}}},
          {"limit",
           {{"level", v.level},
            {"bias", v.bias},
            {"bias_worst", v.bias_worst},
            {"bias_angle", v.has_view ? ordered_json(v.bias_angle) : ordered_json()},
            {"condition", v.condition},
            {"condition_worst", v.condition_worst}}},
          {"gradient_vanishes",
           {{"in_position", v.flat_in_position},
            {"in_yaw", v.sees_heading ? ordered_json(v.flat_in_yaw) : ordered_json()},
            {"in_both", v.sees_heading ? ordered_json(v.flat_in_both) : ordered_json()},
            {"in_yaw_behind", v.sees_heading ? ordered_json(v.flat_in_yaw_behind) : ordered_json()},
            {"in_yaw_from_angle", or_null(v.flat_in_yaw_from)},
            {"turns_away", v.sees_heading ? ordered_json(v.turns_away) : ordered_json()},
            {"beyond", or_null(v.flat_beyond)},
            {"within", or_null(v.flat_within)}}},
          {"minima_outside", traps},
          {"minima_in_yaw", v.sees_heading ? ordered_json(v.traps_in_yaw) : ordered_json()},
          {"worst_second_derivative",
           {{"position", v.curvature_worst},
            {"yaw", v.sees_heading ? ordered_json(v.curvature_in_yaw) : ordered_json()},
            {"smooth", v.cure ? ordered_json(v.cure->smooth) : ordered_json()}}},
          {"words", v.words},
          {"warnings", v.warnings}},
      2);
}

}  // namespace sightline
