#include <fmt/format.h>

#include <charconv>

#include "sightline/analysis.hpp"
#include "sightline/base.hpp"

namespace sightline {

Shard shard_of(std::string_view text) {
  Shard shard{-1, -1};
  const auto slash = text.find('/');
  const auto read = [](std::string_view word, int& number) {
    const auto end = word.data() + word.size();
    const auto [at, error] = std::from_chars(word.data(), end, number);
    return error == std::errc() && at == end;
  };
  const bool read_both = slash != std::string_view::npos && read(text.substr(0, slash), shard.number) &&
                         read(text.substr(slash + 1), shard.of);
  if (!read_both || shard.of < 1 || shard.of > shards_max || shard.number < 0 || shard.number > shard.of) {
    throw_invalid("shard = {}, expected I/N, of N shards (at most {}) the I-th, as 3/8", text, shards_max);
  }
  return shard;
}

std::string to_string(const Shard& shard) {
  return fmt::format("{}/{}", shard.first() == 0 ? shard.of : shard.first(), shard.of);
}

}  // namespace sightline
