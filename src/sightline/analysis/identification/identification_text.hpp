/// An identification as a table, as a template for a scenario, as JSON, and as a page with measured and predicted motion.
#pragma once

#include <string>

#include "sightline/analysis/identification/identify.hpp"

namespace sightline {

/// The table that is printed, with the template at its end.
std::string to_string(const Identification& found);

/// `[template.NAME]` with the robot that has this structure, its parameters, and `command_delay` where it has a delay;
/// a comment where no robot of the library has the structure.
std::string template_text(const Identification& found, const FittedModel& model, const std::string& name);

std::string to_json(const Identification& found);

/// The page: predictions of a second each over the held-out part.
/// @throws std::runtime_error where gnuplot is missing or fails
std::string identification_html(const Identification& found, const FlownMotion& motion);

}  // namespace sightline
