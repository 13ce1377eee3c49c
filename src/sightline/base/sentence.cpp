#include "sightline/base/sentence.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <variant>

#include "sightline/base/reason.hpp"

namespace sightline {
namespace {

std::string of_files(const std::filesystem::filesystem_error& error) {
  const std::string& file = error.path2().empty() ? error.path1().native() : error.path2().native();
  return fmt::format("{}: cannot be used ({}), expected a file or a folder", file,
                     reason(error.code().value()));
}

}  // namespace

std::string sentence_of(const std::exception& error) {
  if (const auto* of_file = dynamic_cast<const std::filesystem::filesystem_error*>(&error))
    return of_files(*of_file);
  if (const auto* parsed = dynamic_cast<const nlohmann::json::parse_error*>(&error))
    return fmt::format("no JSON from byte {} on", parsed->byte);
  if (dynamic_cast<const nlohmann::json::exception*>(&error) != nullptr)
    return "a value of the JSON is missing or of another kind";
  if (dynamic_cast<const std::bad_variant_access*>(&error) != nullptr) return "a value is of another kind";
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return "there is not enough memory";
  return error.what();
}

}  // namespace sightline
