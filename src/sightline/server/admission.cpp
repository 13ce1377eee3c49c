#include "sightline/server/admission.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

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

Admission::Admission(std::uint16_t port, std::string token)
    : port_(fmt::format(":{}", port)), token_(std::move(token)) {}

bool Admission::is_host(std::string_view host) const {
  if (!host.ends_with(port_)) return false;
  const std::string name(host.substr(0, host.size() - port_.size()));
  if (name == "127.0.0.1" || name == "localhost") return true;
  in_addr ignored{};
  return !token_.empty() && ::inet_pton(AF_INET, name.c_str(), &ignored) == 1;
}

std::string_view Admission::refusal(const HttpRequest& request, bool open) const {
  const std::string_view host = request.header("host"), origin = request.header("origin");
  if (!is_host(host)) return "the host is a name, expected the address and port that were printed";
  if (request.headers.contains("origin") && origin != fmt::format("http://{}", host))
    return "the request comes from a page of another origin, expected this one";
  if (!open && !same_secret(token_.empty() ? std::string_view() : request.parameter("token"), token_))
    return "the token is missing or wrong, expected the address as it was printed";
  return {};
}

}  // namespace sightline
