#include "sightline/server/http.hpp"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <boost/beast/http.hpp>

#include "sightline/base/character.hpp"

namespace sightline {
namespace {

namespace http = boost::beast::http;

/// Splits off the text before a mark and removes the mark; without a mark, all of the text.
std::string_view cut(std::string_view& text, std::string_view mark) {
  const std::size_t at = text.find(mark);
  const std::string_view first = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + mark.size());
  return first;
}

}  // namespace

std::string_view HttpRequest::header(std::string_view name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? std::string_view() : std::string_view(found->second);
}

std::string_view HttpRequest::parameter(std::string_view key) const {
  for (std::string_view rest = query; !rest.empty();) {
    std::string_view value = cut(rest, "&");
    if (cut(value, "=") == key) return value;
  }
  return {};
}

bool HttpRequest::lists(std::string_view name, std::string_view word) const {
  const std::string_view list = header(name);
  return http::token_list({list.data(), list.size()}).exists({word.data(), word.size()});
}

std::optional<HttpRequest> parse_request(std::string_view head) {
  http::request_parser<http::empty_body> parser;
  boost::beast::error_code fault;
  const std::string with_end = fmt::format("{}\r\n\r\n", head);
  parser.header_limit(request_limit + 4);
  parser.put(boost::asio::buffer(with_end), fault);
  if (fault || !parser.is_done() || parser.get().version() != 11) return std::nullopt;
  const auto& read = parser.get();
  const std::string whole_target(read.target());
  std::string_view target = whole_target;
  HttpRequest request{std::string(read.method_string()), std::string(cut(target, "?")), std::string(target)};
  if (!request.path.starts_with('/')) return std::nullopt;
  for (const auto& field : read)
    if (!request.headers.emplace(lower_case(std::string(field.name_string())), std::string(field.value()))
             .second)
      return std::nullopt;
  return request;
}

std::string http_response(int status, std::string_view type, std::string_view body, bool with_body) {
  const std::string reason(http::obsolete_reason(static_cast<http::status>(status)));
  // The headers forbid foreign and inline content, frames and use by other pages, and keep the
  // token out of referrers.
  return fmt::format(
      "HTTP/1.1 {} {}\r\n"
      "Content-Type: {}\r\n"
      "Content-Length: {}\r\n"
      "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
      "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"
      "Cross-Origin-Opener-Policy: same-origin\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\n"
      "Referrer-Policy: no-referrer\r\n"
      "X-Content-Type-Options: nosniff\r\n"
      "Cache-Control: no-store\r\n"
      "Connection: close\r\n\r\n{}",
      status, reason, type, body.size(), with_body ? body : std::string_view());
}

}  // namespace sightline
