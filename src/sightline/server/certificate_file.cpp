#include "sightline/server/certificate_file.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <system_error>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using CertificateJson = nlohmann::ordered_json;

double checked(const CertificateJson& object, const char* key, double low, double high) {
  const auto value = object.at(key).get<double>();
  if (value >= low && value <= high) return value;
  throw std::invalid_argument(fmt::format("{} = {}, expected {} to {}", key, value, low, high));
}

void check_bounds(const CertificateJson& found) {
  const double runs = checked(found, "runs", 1.0, 1e9);
  (void)checked(found, "seen", 0.0, runs);
  (void)checked(found, "high", checked(found, "low", 0.0, 1.0), 1.0);
}

void check(const CertificateJson& certificate, std::string_view scenario) {
  if (const auto name = certificate.at("scenario").get<std::string>(); name != scenario)
    throw std::invalid_argument(
        fmt::format("scenario = \"{}\", expected that of the flight, \"{}\"", name, scenario));
  (void)checked(certificate, "confidence", 0.0, 1.0);
  (void)checked(certificate, "view_within", 0.0, 1e9);
  for (const CertificateJson& premise : certificate.at("premises")) (void)premise.get<std::string>();
  if (certificate.at("events").empty())
    throw std::invalid_argument("events are none, expected bounds of probabilities");
  for (const CertificateJson& event : certificate.at("events")) {
    (void)event.at("event").get<std::string>();
    check_bounds(event.at("independent"));
    if (!event.contains("importance_sampling")) continue;
    check_bounds(event.at("importance_sampling"));
    (void)checked(event.at("importance_sampling"), "probability", 0.0, infinity);
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
    const CertificateJson certificate = CertificateJson::parse(read_text(file));
    check(certificate, scenario);
    return {"application/json", json_text(certificate) + "\n"};
  } catch (const std::exception& error) {
    throw std::invalid_argument(fmt::format("--certificate {}: {}", file.native(), sentence_of(error)));
  }
}

}  // namespace sightline
