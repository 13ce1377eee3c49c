/// An identification as a table, as a scenario template, as JSON, and as a page with measured and
/// predicted motion.
#pragma once

#include <string>

#include "sightline/analysis/identification/identify.hpp"

namespace sightline {

/// Table for the terminal, with the template at its end.
std::string to_string(const Identification& found);

/// `[template.NAME]` with the robot of this structure, its parameters, and `command_delay` if the
/// structure has a delay. A comment notes a structure that no robot of the library has.
std::string template_text(const Identification& found, const FittedModel& model, const std::string& name);

std::string to_json(const Identification& found);

/// HTML page with predictions of 1 s each over the held-out part.
std::string identification_html(const Identification& found, const FlownMotion& motion);

}  // namespace sightline
