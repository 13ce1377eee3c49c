/// What the releases of PX4 call their topics, and which layout their messages have.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "bridges/dds/message_type.hpp"

namespace sightline::dds {

/// PX4 1.N; the least and the greatest that are known.
inline constexpr int px4_first = 14, px4_last = 18;
inline constexpr std::array<std::string_view, px4_last - px4_first + 1> px4_releases = {
    "1.14", "1.15", "1.16", "1.17", "1.18"};

/// From here on a vehicle answers which layouts it takes.
inline constexpr int px4_answers_formats_from = 15;

/// The layout of a message in a release: the last one that is not newer.
/// @param message  "VehicleStatus"
/// @throws std::invalid_argument for a message that the release does not have
const MessageType& px4_type(std::string_view message, int release);

/// Its version, which ends the name of its topic from 1.16 on; 0: nothing does.
int px4_version(std::string_view message, int release);

enum class Px4Side { out, in };
/// "/px4_1/fmu/out/vehicle_status_v1".
/// @param name_space  "" or "/px4_1"
std::string px4_topic(std::string_view name_space, Px4Side side, std::string_view message, int release);

}  // namespace sightline::dds
