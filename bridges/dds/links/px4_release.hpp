/// Topic names and message layouts of the PX4 releases.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "bridges/dds/topics/message_type.hpp"

namespace sightline::dds {

/// First and last supported minor release, PX4 1.N.
inline constexpr int px4_first = 14, px4_last = 18;
inline constexpr std::array<std::string_view, px4_last - px4_first + 1> px4_releases = {
    "1.14", "1.15", "1.16", "1.17", "1.18"};

/// First release whose vehicles answer requests for their message layouts.
inline constexpr int px4_answers_formats_from = 15;

/// Layout of a message in a release: the newest one that is not newer than the release.
/// @param message  "VehicleStatus"
/// @throws std::invalid_argument if the release does not have the message
const MessageType& px4_type(std::string_view message, int release);

/// Version of the message, the suffix of its topic from 1.16 on; 0: no suffix.
int px4_version(std::string_view message, int release);

enum class Px4Side { out, in };
/// "/px4_1/fmu/out/vehicle_status_v1".
/// @param name_space  "" or "/px4_1"
std::string px4_topic(std::string_view name_space, Px4Side side, std::string_view message, int release);

}  // namespace sightline::dds
