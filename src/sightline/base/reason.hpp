#pragma once

#include <string>
#include <system_error>

namespace sightline {

/// The system's description of an error, by its errno.
inline std::string reason(int error_number) { return std::generic_category().message(error_number); }

}  // namespace sightline
