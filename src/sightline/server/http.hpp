/// Subset of HTTP/1.1 for a page: requests without a body, and responses. Parses untrusted bytes.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sightline {

/// Longest accepted head of a request [B].
inline constexpr std::size_t request_limit = 8192;

struct HttpRequest {
  std::string method, path;                                   ///< "GET", "/live"
  std::string query;                                          ///< text after the question mark, not decoded
  std::map<std::string, std::string, std::less<>> headers{};  ///< names in lower case

  /// Value of a header; empty if it is missing.
  std::string_view header(std::string_view name) const;
  /// Value of a key in the query, not decoded; empty if it is missing.
  std::string_view parameter(std::string_view key) const;
  /// Whether a header's comma-separated list contains a word (lower case), in any case:
  /// "keep-alive, Upgrade".
  bool lists(std::string_view name, std::string_view word) const;
};

/// Parses a head: from its first line to the line before the empty one.
/// @return none if it is malformed, repeats a header, or announces a body
std::optional<HttpRequest> parse_request(std::string_view head);

/// A response that ends the connection.
/// @param with_body  if false, only the length of the body is sent, as for HEAD
std::string http_response(int status, std::string_view type, std::string_view body, bool with_body = true);

}  // namespace sightline
