/// DDS security: the keys of a fleet's programs and their Cyclone DDS configuration.
#pragma once

#include <filesystem>
#include <string>

namespace sightline::dds {

/// Program of a fleet; each has its own keys.
enum class Identity { flyer, vehicles };

/// Paths of the Cyclone DDS security plugins; must be absolute. Empty if built without them.
struct SecurityPlugins {
  std::string authentication, access_control, cryptography;
};

/// The plugins found at build time.
SecurityPlugins plugins_found();

/// Rejects keys that cannot work for the next hour: missing plugins, a key that does not match the
/// certificate, a certificate that its authority did not sign or that expires earlier.
/// Cyclone DDS itself reports other errors, such as permissions for another name.
/// @param keys  of the fleet: folders flyer and vehicles, key_files in each
/// @throws std::invalid_argument  fleet.security...
void check_keys(const std::filesystem::path& keys, Identity who,
                const SecurityPlugins& plugins = plugins_found());

/// The <Security> element of the Cyclone DDS configuration.
std::string security_xml(const std::filesystem::path& keys, Identity who,
                         const SecurityPlugins& plugins = plugins_found());

}  // namespace sightline::dds
