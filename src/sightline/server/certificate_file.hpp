/// The certificate of a campaign as a file of a page.
#pragma once

#include <filesystem>
#include <string_view>

#include "sightline/server/page_server.hpp"

namespace sightline {

inline constexpr std::string_view certificate_path = "/certificate.json";

/// A page without a certificate.
PageFile no_certificate();

/// Reads and checks certificate.json, as certificate_json() writes it.
/// @param folder    of a campaign with --certify
/// @param scenario  name that the certificate must have
/// @throws std::invalid_argument if the file is missing, malformed, or of another scenario; names it
PageFile certificate_file(const std::filesystem::path& folder, std::string_view scenario);

}  // namespace sightline
