/// The text of a JSON value.
#pragma once

#include <string>

namespace sightline {

/// Throws nothing but std::bad_alloc: bytes that are no UTF-8, as the name of a file may have them, are U+FFFD.
/// @param json    of nlohmann's library, whose own dump() throws there
/// @param indent  spaces of a level; -1: all on one line
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace sightline
