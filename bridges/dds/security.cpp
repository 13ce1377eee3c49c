#include "bridges/dds/security.hpp"

#include <fmt/format.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/security_plugins.hpp"

namespace sightline::dds {
namespace {

namespace fs = std::filesystem;

constexpr std::time_t keys_hold = 3600;  // minimum remaining validity of the keys [s]

using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using PrivateKey = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;
using PublicKey = PrivateKey;
using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

fs::path folder_of(const fs::path& keys, Identity who) {
  return keys / key_owners[who == Identity::vehicles];
}

[[noreturn]] void refuse_key(const fs::path& file, std::string_view what, std::string_view expected) {
  throw std::invalid_argument(
      fmt::format("fleet.security: {} {}, expected {}", file.native(), what, expected));
}

File opened(const fs::path& file) {
  File read(std::fopen(file.c_str(), "r"), std::fclose);
  if (!read) refuse_key(file, "cannot be read", "a file that scripts/dds_keys.sh makes");
  return read;
}

Certificate certificate(const fs::path& file) {
  Certificate read(PEM_read_X509(opened(file).get(), nullptr, nullptr, nullptr), X509_free);
  if (!read) refuse_key(file, "is no certificate", "one in PEM");
  return read;
}

std::string day_of(const ASN1_TIME* time) {
  std::tm day{};
  if (ASN1_TIME_to_tm(time, &day) != 1) return "a day that cannot be read";
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02} UTC", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday,
                     day.tm_hour, day.tm_min);
}

void check_certificate(const fs::path& folder) {
  const fs::path own = folder / "cert.pem", authority = folder / "identity_ca.cert.pem",
                 key_file = folder / "key.pem";
  const Certificate mine = certificate(own), theirs = certificate(authority);
  // Without this callback, OpenSSL would request a passphrase on the terminal.
  const auto no_passphrase = [](char*, int, int, void*) { return 0; };
  const PrivateKey key(PEM_read_PrivateKey(opened(key_file).get(), nullptr, no_passphrase, nullptr),
                       EVP_PKEY_free);
  if (!key) refuse_key(key_file, "is no private key", "one in PEM without a passphrase");
  if (X509_check_private_key(mine.get(), key.get()) != 1)
    refuse_key(key_file, "is not the key of cert.pem", "the two of one identity");
  const PublicKey signer(X509_get_pubkey(theirs.get()), EVP_PKEY_free);
  if (!signer || X509_verify(mine.get(), signer.get()) != 1)
    refuse_key(own, "is not signed by identity_ca.cert.pem", "the fleet's own authority");
  std::time_t now = std::time(nullptr), then = now + keys_hold;
  for (const auto& [file, shown] : {std::pair(own, mine.get()), std::pair(authority, theirs.get())}) {
    if (X509_cmp_time(X509_get0_notBefore(shown), &now) > 0)
      refuse_key(file, "holds from " + day_of(X509_get0_notBefore(shown)) + " on", "one that holds now");
    if (X509_cmp_time(X509_get0_notAfter(shown), &then) < 0)
      refuse_key(file, "holds until " + day_of(X509_get0_notAfter(shown)),
                 "one that holds for a flight, an hour");
  }
}

/// Escapes an XML value; names of key folders contain neither " nor $.
std::string in_xml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else
      escaped += c;
  }
  return escaped;
}

}  // namespace

SecurityPlugins plugins_found() {
  return {plugin_authentication, plugin_access_control, plugin_cryptography};
}

void check_keys(const fs::path& keys, Identity who, const SecurityPlugins& plugins) {
  for (const std::string& plugin : {plugins.authentication, plugins.access_control, plugins.cryptography}) {
    if (plugin.empty())
      throw std::invalid_argument(
          "fleet.security: this sightline was built without the security plugins of Cyclone DDS, expected "
          "one with them");
    if (!fs::exists(plugin))
      refuse_key(plugin, "is missing", "the library of Cyclone DDS that this sightline was built with");
  }
  const fs::path folder = folder_of(keys, who);
  for (const std::string_view file : key_files) (void)opened(folder / file);
  check_certificate(folder);
}

std::string security_xml(const fs::path& keys, Identity who, const SecurityPlugins& plugins) {
  const fs::path folder = fs::absolute(folder_of(keys, who));
  const auto library = [](const std::string& path, std::string_view what) {
    return fmt::format(R"(<Library path="{}" initFunction="init_{}" finalizeFunction="finalize_{}"/>)",
                       in_xml(path), what, what);
  };
  const auto file = [&](std::string_view element, std::string_view name) {
    return fmt::format("<{}>file:{}</{}>", element, in_xml((folder / name).native()), element);
  };
  return fmt::format(
      "<Security><Authentication>{}{}{}{}</Authentication><AccessControl>{}{}{}{}</AccessControl>"
      "<Cryptographic>{}</Cryptographic></Security>",
      library(plugins.authentication, "authentication"), file("IdentityCA", "identity_ca.cert.pem"),
      file("IdentityCertificate", "cert.pem"), file("PrivateKey", "key.pem"),
      library(plugins.access_control, "access_control"), file("PermissionsCA", "permissions_ca.cert.pem"),
      file("Governance", "governance.p7s"), file("Permissions", "permissions.p7s"),
      library(plugins.cryptography, "crypto"));
}

}  // namespace sightline::dds
