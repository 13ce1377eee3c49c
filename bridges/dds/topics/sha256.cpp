#include "bridges/dds/topics/sha256.hpp"

#include <fmt/format.h>
#include <openssl/sha.h>

#include <array>

namespace sightline::dds {

std::string sha256(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  ::SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), hash.data());
  std::string digits;
  for (const unsigned char byte : hash) digits += fmt::format("{:02x}", byte);
  return digits;
}

}  // namespace sightline::dds
