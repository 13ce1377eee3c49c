/// Text of a JSON value.
#pragma once

#include <string>

namespace sightline {

/// Converts a JSON value to text; throws only std::bad_alloc. Bytes that are not UTF-8, as in a
/// file name, become U+FFFD.
/// @param json    a value of nlohmann's library, whose own dump() throws on such bytes
/// @param indent  spaces per level; -1: all on one line
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace sightline
