#include "sightline/server/admission.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace sightline {

std::string random_token() {
  std::array<unsigned char, 24> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("the kernel gives no random numbers, expected some for a token");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_secret(std::string_view given, std::string_view secret) noexcept {
  if (secret.empty()) return given.empty();
  unsigned difference = given.size() == secret.size() ? 0U : 1U;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const unsigned a = static_cast<unsigned char>(given[i]);
    difference |= a ^ static_cast<unsigned char>(secret[i % secret.size()]);
  }
  return difference == 0;
}

void check_origin(std::string_view origin) {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz0123456789.-:[]";
  const bool of_a_file = origin == "file://";
  const std::size_t scheme = origin.starts_with("http://")    ? 7
                             : origin.starts_with("https://") ? 8
                                                              : origin.size();
  const std::string_view host = origin.substr(scheme);
  if (!of_a_file && (host.empty() || host.find_first_not_of(letters) != std::string_view::npos))
    throw std::invalid_argument(fmt::format(
        "--allow-origin {}, expected what a browser says of a page: scheme and host in small letters, "
        "https://app.foxglove.dev, or file://",
        origin));
}

Admission::Admission(std::uint16_t port, std::string token, std::vector<std::string> origins)
    : port_(fmt::format(":{}", port)), token_(std::move(token)), origins_(std::move(origins)) {}

bool Admission::is_allowed(std::string_view origin) const {
  return std::find(origins_.begin(), origins_.end(), origin) != origins_.end();
}

bool Admission::is_host(std::string_view host) const {
  if (!host.ends_with(port_)) return false;
  const std::string name(host.substr(0, host.size() - port_.size()));
  if (name == "127.0.0.1" || name == "localhost") return true;
  in_addr ignored{};
  return !token_.empty() && ::inet_pton(AF_INET, name.c_str(), &ignored) == 1;
}

std::string_view Admission::refusal(const HttpRequest& request, Requested requested) const {
  const std::string_view host = request.header("host"), origin = request.header("origin");
  if (!is_host(host)) return "the host is a name, expected the address and port that were printed";
  if (request.headers.contains("origin") && origin != fmt::format("http://{}", host) &&
      !(requested == Requested::topics && is_allowed(origin)))
    return "the request comes from a page of another origin, expected this one";
  if (requested != Requested::open_file &&
      !same_secret(token_.empty() ? std::string_view() : request.parameter("token"), token_))
    return "the token is missing or wrong, expected the address as it was printed";
  return {};
}

}  // namespace sightline
