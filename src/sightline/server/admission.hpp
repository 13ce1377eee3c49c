/// Who may look on: this machine alone, or whoever has the token; never a page of another origin.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/server/http.hpp"

namespace sightline {

/// 192 bits of the kernel's random numbers, as 48 hexadecimal digits.
/// @throws std::runtime_error where the kernel gives none
std::string random_token();

/// In a time that depends on the length of `given` alone.
bool same_secret(std::string_view given, std::string_view secret) noexcept;

/// Checks a page's origin as a browser says it, "https://app.foxglove.dev"; "file://" is that of desktop applications.
/// @throws std::invalid_argument with a sentence; "null", which any page can be, is none
void check_origin(std::string_view origin);

/// Decides about requests by what they say of host, origin and token.
///
/// A page of another origin reaches 127.0.0.1 in its user's browser. By its own name it says a foreign Origin. By a name that it
/// turns to 127.0.0.1 (DNS rebinding) Origin and Host agree, but the Host is that name: only addresses are hosts here, and
/// localhost.
class Admission {
 public:
  /// What a request asks for.
  enum class Requested {
    flight,
    open_file,  ///< holds nothing of a flight: no token is asked for
    topics      ///< Foxglove's protocol, which tells only: other origins may be allowed
  };

  /// @param token    that a request must have as `?token=`; empty: none is asked for, and only loopback's names are hosts
  /// @param origins  of pages that may ask for topics, checked
  Admission(std::uint16_t port, std::string token, std::vector<std::string> origins = {});

  /// @return why it is refused, a sentence; empty: it is not
  std::string_view refusal(const HttpRequest& request, Requested requested = Requested::flight) const;

 private:
  bool is_host(std::string_view host) const;
  bool is_allowed(std::string_view origin) const;

  std::string port_;  // ":8765"
  std::string token_;
  std::vector<std::string> origins_;
};

}  // namespace sightline
