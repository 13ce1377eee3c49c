#include "sightline/server/http.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

char lower_case(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return lower_case(c); });
  return lower;
}

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Splits off the text before a mark and removes the mark; without a mark, all of the text.
std::string_view cut(std::string_view& text, std::string_view mark) {
  const std::size_t at = text.find(mark);
  const std::string_view first = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + mark.size());
  return first;
}

bool is_printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

std::string_view reason_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    default:
      return "Service Unavailable";
  }
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
  for (std::string_view rest = header(name); !rest.empty();)
    if (lower_case(without_blanks(cut(rest, ","))) == word) return true;
  return false;
}

std::optional<HttpRequest> parse_request(std::string_view head) {
  std::string_view line = cut(head, "\r\n");
  HttpRequest request;
  request.method = cut(line, " ");
  std::string_view target = cut(line, " ");
  if (line != "HTTP/1.1" || !is_printable(request.method) || !is_printable(target)) return std::nullopt;
  request.path = cut(target, "?");
  request.query = target;
  if (request.method.empty() || !request.path.starts_with('/')) return std::nullopt;
  while (!head.empty()) {
    std::string_view value = cut(head, "\r\n");
    if (value.find(':') == std::string_view::npos) return std::nullopt;
    const std::string name = lower_case(cut(value, ":"));
    if (name.empty() || !is_printable(name)) return std::nullopt;
    if (!request.headers.emplace(name, without_blanks(value)).second) return std::nullopt;
  }
  const std::string_view length = request.header("content-length");
  if (request.headers.contains("transfer-encoding") || (!length.empty() && length != "0"))
    return std::nullopt;
  return request;
}

std::string http_response(int status, std::string_view type, std::string_view body, bool with_body) {
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
      status, reason_of(status), type, body.size(), with_body ? body : std::string_view());
}

}  // namespace sightline
