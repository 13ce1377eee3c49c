/// A finished flight, from its folder.
#pragma once

#include <filesystem>
#include <string>

#include "sightline/scenario/scenario.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline {

/// All moments of a log, as a list of JSON: each period, or of a long flight or a large team fewer, evenly, so that no more than
/// `numbers` are said of bodies. Predictions and events are at the first moment that is not before them.
/// @param scenario  that was flown
/// @throws std::runtime_error with a sentence that names the file where it cannot be read, or is of another team
std::string log_moments(const std::filesystem::path& folder, const Scenario& scenario,
                        std::size_t numbers = 1'000'000);

/// The page of a log, with what it draws: /scene.json and /moments.json.
/// @throws as log_moments()
PageFiles log_page(const std::filesystem::path& folder, const Scenario& scenario);

}  // namespace sightline
