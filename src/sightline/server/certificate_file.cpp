#include "sightline/server/certificate_file.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using CertificateJson = nlohmann::ordered_json;

/// A part of a certificate, with its place in the file for sentences: "events[0]."
struct Part {
  const CertificateJson& object;
  std::string place{};

  const CertificateJson& at(const char* key, CertificateJson::value_t kind, const char* expected) const {
    const auto value = object.find(key);  // the end, if it is no table
    const bool is_number = kind == CertificateJson::value_t::number_float;
    if (value != object.end() && (is_number ? value->is_number() : value->type() == kind)) return *value;
    throw std::invalid_argument(
        fmt::format("{}{} is missing or of another kind, expected {}, as campaign --certify writes it", place,
                    key, expected));
  }
  double number(const char* key, double low, double high) const {
    const auto value = at(key, CertificateJson::value_t::number_float, "a number").get<double>();
    if (value >= low && value <= high) return value;
    throw std::invalid_argument(fmt::format("{}{} = {}, expected {} to {}", place, key, value, low, high));
  }
  std::string text(const char* key) const {
    return at(key, CertificateJson::value_t::string, "a text").get<std::string>();
  }
  const CertificateJson& list(const char* key) const {
    return at(key, CertificateJson::value_t::array, "a list");
  }
  Part part(const char* key) const {
    return {at(key, CertificateJson::value_t::object, "a table"), fmt::format("{}{}.", place, key)};
  }
};

void check_bounds(const Part& found) {
  const double runs = found.number("runs", 1.0, 1e9);
  (void)found.number("seen", 0.0, runs);
  (void)found.number("high", found.number("low", 0.0, 1.0), 1.0);
}

void check(const CertificateJson& json, std::string_view scenario) {
  const Part certificate{json};
  if (const std::string name = certificate.text("scenario"); name != scenario)
    throw std::invalid_argument(
        fmt::format("scenario = \"{}\", expected that of the flight, \"{}\"", name, scenario));
  (void)certificate.number("confidence", 0.0, 1.0);
  (void)certificate.number("view_within", 0.0, 1e9);
  for (const CertificateJson& premise : certificate.list("premises"))
    if (!premise.is_string())
      throw std::invalid_argument("premises are no texts, expected a list of sentences");
  const CertificateJson& events = certificate.list("events");
  if (events.empty()) throw std::invalid_argument("events are none, expected bounds of probabilities");
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Part event{events[i], fmt::format("events[{}].", i)};
    (void)event.text("event");
    check_bounds(event.part("independent"));
    if (!events[i].contains("importance_sampling")) continue;
    check_bounds(event.part("importance_sampling"));
    (void)event.part("importance_sampling").number("probability", 0.0, infinity);
  }
}

}  // namespace

PageFile no_certificate() { return {"application/json", "null"}; }

PageFile certificate_file(const std::filesystem::path& folder, std::string_view scenario) {
  const std::filesystem::path file = folder / "certificate.json";
  std::error_code ignored;  // reading reports the error of an inaccessible file
  if (!std::filesystem::exists(file, ignored))
    throw std::invalid_argument(
        fmt::format("{}: is missing, expected the folder of a campaign with --certify", file.native()));
  try {
    std::string text = read_text(file);
    check(CertificateJson::parse(text), scenario);
    return {"application/json", std::move(text)};
  } catch (const std::exception& error) {
    throw std::invalid_argument(fmt::format("--certificate {}: {}", file.native(), sentence_of(error)));
  }
}

}  // namespace sightline
