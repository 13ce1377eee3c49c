/// Random damage to the bytes of a file.
#pragma once

#include <cstddef>
#include <random>
#include <string>

namespace sightline::test {

/// The bytes with up to four changes: bytes replaced, removed, copied to another place, or cut off.
inline std::string mutated(std::string bytes, std::mt19937& random) {
  for (unsigned changes = random() % 4 + 1; changes > 0 && !bytes.empty(); --changes) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 6) {
      case 0:
      case 1:
        bytes[at] = static_cast<char>(random());
        break;
      case 2:
        bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ (1U << random() % 8));
        break;
      case 3:
        bytes.erase(at, random() % 9);
        break;
      case 4:
        bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 40));
        break;
      default:
        if (random() % 4 == 0) bytes.resize(at);
        break;
    }
  }
  return bytes;
}

}  // namespace sightline::test
