/// Access control of the server: only this machine, or holders of the token; never a page of
/// another origin that is not allowed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/server/http.hpp"

namespace sightline {

/// 192 random bits of the kernel, as 48 hexadecimal digits.
/// @throws std::runtime_error if the kernel provides none
std::string random_token();

/// Compares in a time that depends only on the length of `given`.
bool same_secret(std::string_view given, std::string_view secret) noexcept;

/// Checks an origin in the form of a browser's Origin header, "https://app.foxglove.dev". Desktop
/// applications send "file://".
/// @throws std::invalid_argument with a sentence; also for "null", which any page can send
void check_origin(std::string_view origin);

/// Accepts or refuses requests by their host, origin and token.
///
/// A page of another origin can reach 127.0.0.1 through its user's browser. Under its own name it
/// sends a foreign Origin. With a name that it resolves to 127.0.0.1 (DNS rebinding), Origin and
/// Host agree, but Host is that name. Therefore only addresses and localhost are accepted as hosts.
class Admission {
 public:
  /// Resource of a request.
  enum class Requested {
    flight,
    open_file,  ///< contains nothing of a flight and needs no token
    topics      ///< over Foxglove's protocol, read-only: other origins may be allowed
  };

  /// @param token  required as `?token=`; empty: no token is required, and only loopback names are
  ///   hosts
  /// @param origins  of pages that may request topics; already checked
  Admission(std::uint16_t port, std::string token, std::vector<std::string> origins = {});

  /// @return the reason of a refusal, a sentence; empty: accepted
  std::string_view refusal(const HttpRequest& request, Requested requested = Requested::flight) const;

 private:
  bool is_host(std::string_view host) const;
  bool is_allowed(std::string_view origin) const;

  std::string port_;  // ":8765"
  std::string token_;
  std::vector<std::string> origins_;
};

}  // namespace sightline
