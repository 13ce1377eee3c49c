/// HTTP/1.1 as far as a page needs it: requests without a body, and their answers. Trusts no byte of a request.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sightline {

/// Longest head of a request that is read [B].
inline constexpr std::size_t request_limit = 8192;

struct HttpRequest {
  std::string method, path;                                   ///< "GET", "/live"
  std::string query;                                          ///< what follows the question mark, as it is
  std::map<std::string, std::string, std::less<>> headers{};  ///< names in lower case

  /// Empty where it is missing.
  std::string_view header(std::string_view name) const;
  /// What the query says for a key, as it is; empty where it says nothing.
  std::string_view parameter(std::string_view key) const;
  /// Whether a list of words in a header holds this one, in any case: "keep-alive, Upgrade".
  bool lists(std::string_view name, std::string_view word) const;
};

/// Reads a head: from its first line to the one before the empty line.
/// @return none where it is not sound, says a header twice, or announces a body
std::optional<HttpRequest> parse_request(std::string_view head);

/// An answer that ends the connection.
/// @param with_body  else its length alone is said, as to HEAD
std::string http_response(int status, std::string_view type, std::string_view body, bool with_body = true);

}  // namespace sightline
