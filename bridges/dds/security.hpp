/// DDS security: the keys by which the programs of a fleet know each other, and what Cyclone DDS is told of them.
#pragma once

#include <filesystem>
#include <string>

namespace sightline::dds {

/// Which program of a fleet this is: each has keys of its own.
enum class Identity { flyer, vehicles };

/// The libraries by which Cyclone DDS checks and encrypts. It wants whole paths; empty ones where it was built without.
struct SecurityPlugins {
  std::string authentication, access_control, cryptography;
};

/// Those that were found when this was built.
SecurityPlugins plugins_found();

/// Refuses what could not speak for the next hour: no plugins, a key that is not the certificate's, a certificate that its
/// authority did not sign or that ends before. What Cyclone DDS refuses besides, such as permissions of another name, it says itself.
/// @param keys  of the fleet: folders flyer and vehicles, key_files in each
/// @throws std::invalid_argument  fleet.security...
void check_keys(const std::filesystem::path& keys, Identity who,
                const SecurityPlugins& plugins = plugins_found());

/// The element <Security> of Cyclone DDS' configuration.
std::string security_xml(const std::filesystem::path& keys, Identity who,
                         const SecurityPlugins& plugins = plugins_found());

}  // namespace sightline::dds
