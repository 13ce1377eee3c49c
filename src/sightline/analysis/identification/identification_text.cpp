#include "sightline/analysis/identification/identification_text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sightline/base/json_text.hpp"
#include "sightline/report/page.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr double shortest_delay = 0.001;  // the least delay with a key [s]

/// A number with 4 digits, with a decimal point as in TOML.
std::string digits(double value) {
  std::string text = fmt::format("{:.4g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string range_text(const FoundNumber& one) {
  if (!one.moved) return "not known";
  return fmt::format("{:.4g} to {:.4g}", one.low(), one.high());
}

std::string error_row(const Identification::Candidate& one) {
  const PredictionError& e = one.error;
  return fmt::format("{:<32} {:>8.4f} {:>9.1f} {:>9.1f} {:>9.3f} {:>9.3f} {:>9.2f}", one.structure.name(),
                     e.r2, 1e3 * e.position, 1e3 * e.height, e.velocity, e.heading, e.acceleration);
}

const FoundNumber* number_of(const FittedModel& model, std::string_view key) {
  for (const FoundNumber& one : model.found) {
    if (one.number.key == key) return &one;
  }
  return nullptr;
}

Json as_json(const FittedModel& model) {
  Json numbers = Json::array();
  for (const FoundNumber& one : model.found) {
    Json row = {{"key", one.number.key}, {"value", one.value},      {"low", one.low()},
                {"high", one.high()},    {"unit", one.number.unit}, {"known", one.known()}};
    if (!one.moved) row["low"] = row["high"] = nullptr;
    numbers.push_back(std::move(row));
  }
  return {{"structure", model.structure.name()}, {"numbers", std::move(numbers)}};
}

Json as_json(const PredictionError& e) {
  return {{"predictions", e.predictions},       {"r2", e.r2},
          {"position_rms", e.position},         {"height_rms", e.height},
          {"velocity_rms", e.velocity},         {"heading_rms", e.heading},
          {"acceleration_999", e.acceleration}, {"of_truth", e.of_truth}};
}

}  // namespace

std::string template_text(const Identification& found, const FittedModel& model, const std::string& name) {
  const ModelStructure& s = model.structure;
  const bool tilts = s.commands == Commands::tilt;
  const bool plain = tilts && !s.coriolis && !s.lags;
  std::string text = fmt::format("[template.{}]\nrobot = \"{}\"\n", name,
                                 !tilts  ? "velocity_multirotor"
                                 : plain ? "multirotor"
                                         : "hover_multirotor");
  std::string numbers;
  double delay = 0.0;
  for (const FoundNumber& one : model.found) {
    if (one.number.of_flight) continue;
    if (one.number.key == "delay") {
      delay = one.value;
      continue;
    }
    numbers += fmt::format("{}{} = {}", numbers.empty() ? "" : ", ", one.number.key, digits(one.value));
  }
  if (!tilts)
    numbers += fmt::format(", v_max = {}, climb_max = {}, yaw_max = {}, frame = \"{}\"",
                           digits(std::max(found.u_max[0], found.u_max[1])), digits(found.u_max[2]),
                           digits(found.u_max[3]), s.coriolis ? "level" : "heading");
  text += fmt::format("parameters = {{ {} }}\n", numbers);
  if (s.delay && delay >= shortest_delay) text += fmt::format("command_delay = {:.3f}\n", delay);
  if (tilts && s.lags && !s.coriolis)
    text += "# the flight does not show the Coriolis term r x v, which hover_multirotor has\n";
  return text;
}

std::string to_string(const Identification& found) {
  const PredictionError& e = found.error();
  std::string text = fmt::format("{}: {}, {:.1f} s of flight, of which the last {:.1f} s judge\n\n",
                                 found.robot, found.model, found.seconds, found.held_out);
  text += fmt::format("{:<32} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "predicted over 1 s", "R^2 of v",
                      "p [mm]", "p_z [mm]", "v [m/s]", "psi [rad]", "a [m/s^2]");
  for (std::size_t i = 0; i < found.candidates.size(); ++i)
    text += error_row(found.candidates[i]) + (i == found.chosen ? "  chosen\n" : "\n");
  text += fmt::format("\n{:<8} {:>10} {:<6}  {:<24} {}\n", found.best.structure.name(), "", "",
                      "95 % confidence", "");
  for (const FoundNumber& one : found.best.found)
    text += fmt::format("{:<8} {:>10.4g} {:<6}  {:<24} {}\n", one.number.key, one.value, one.number.unit,
                        range_text(one), one.number.meaning);
  if (found.lumped) {
    if (const FoundNumber* const delay = number_of(*found.lumped, "delay"))
      text += fmt::format("{:<8} {:>10.4g} {:<6}  {:<24} {}\n", "lumped", delay->value, "s",
                          range_text(*delay), "delay of a model without lags");
  }
  text += fmt::format(
      "\nover 1 s, {}: R^2 {:.4f} of the change of velocity, position {:.1f} mm RMS\n"
      "acceleration that is left over 0.1 s: {:.2f} m/s^2 (99.9 %)\n",
      e.of_truth ? "against the true motion" : "noise of the measurement included", e.r2, 1e3 * e.position,
      e.acceleration);
  for (const std::string& sentence : found.missing) text += sentence + "\n";
  text += "\n" + template_text(found, found.best, found.robot);
  if (found.lumped) text += "\n" + template_text(found, *found.lumped, found.robot + "_lumped");
  return text;
}

std::string to_json(const Identification& found) {
  Json candidates = Json::array();
  for (const Identification::Candidate& one : found.candidates) {
    Json row = {{"structure", one.structure.name()}};
    row.update(as_json(one.error));
    candidates.push_back(std::move(row));
  }
  Json json = {{"robot", found.robot},
               {"kind", found.model},
               {"seconds", found.seconds},
               {"held_out", found.held_out},
               {"best", as_json(found.best)},
               {"lumped", found.lumped ? as_json(*found.lumped) : Json()},
               {"error", as_json(found.error())},
               {"candidates", std::move(candidates)},
               {"missing", found.missing},
               {"template", template_text(found, found.best, found.robot)}};
  json["template_lumped"] =
      found.lumped ? Json(template_text(found, *found.lumped, found.robot + "_lumped")) : Json();
  return json_text(json, 2) + "\n";
}

std::string identification_html(const Identification& found, const FlownMotion& motion) {
  const auto rows = [&](double seconds) {
    return static_cast<std::size_t>(std::lround(seconds / motion.period));
  };
  const ModelStructure& structure = found.best.structure;
  const MotionPrediction prediction(motion, structure, found.best.numbers);
  const bool true_starts = !motion.truth.empty();
  const std::size_t before = true_starts ? 0 : rows(0.5), ahead = rows(1.0),
                    from = motion.size() - rows(found.held_out);
  Drawing drawing{
      .title = "Measured and predicted",
      .caption = fmt::format("Dots: measured. Lines: predictions of 1 s each, by {}.", structure.name())};
  struct Shown {
    const char* label;
    double (*of)(const SeenMotion&);
  };
  const std::array<Shown, 4> shown = {{{"v_f [m/s]", [](const SeenMotion& m) { return m.v_f; }},
                                       {"v_s [m/s]", [](const SeenMotion& m) { return m.v_s; }},
                                       {"p_z [m]", [](const SeenMotion& m) { return m.p.z; }},
                                       {"psi [rad]", [](const SeenMotion& m) { return m.psi; }}}};
  for (std::size_t s = 0; s < shown.size(); ++s) {
    Drawing::Panel panel{.x_label = s + 1 == shown.size() ? "t [s]" : "", .y_label = shown[s].label};
    Drawing::Curve measured{.title = s == 0 ? "measured" : "", .colour = 0, .mark = Drawing::Mark::points};
    Drawing::Curve predicted{.title = s == 0 ? "predicted" : "", .colour = 1, .mark = Drawing::Mark::line};
    for (std::size_t k = from; k < motion.size(); k += 2) {
      measured.x.push_back(motion.period * static_cast<double>(k));
      measured.y.push_back(shown[s].of(motion.measured[k]));
    }
    for (std::size_t k = from; k + before + ahead < motion.size(); k += ahead) {
      const SeenMotion start = true_starts ? motion.truth[k] : fitted_start(motion, prediction, k, before);
      prediction.run(k, before + ahead, start, [&](std::size_t j, const SeenMotion& m) {
        if (j < before) return;
        predicted.x.push_back(motion.period * static_cast<double>(k + j));
        predicted.y.push_back(shown[s].of(m));
      });
      predicted.x.push_back(predicted.x.back());
      predicted.y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    panel.curves = {std::move(measured), std::move(predicted)};
    drawing.panels.push_back(std::move(panel));
  }
  const std::string page = page_head(fmt::format("Identification of {}", found.robot));
  return page + fmt::format("<pre>{}</pre>\n", escaped(to_string(found))) +
         page_figures({std::move(drawing)}) + page_end();
}

}  // namespace sightline
