#include "sightline/scenario.hpp"

namespace sightline {

std::vector<std::string> drawn_names(const CampaignPlan& plan) {
  std::vector<std::string> names;
  for (const StartDraw& start : plan.starts) {
    for (const char* what : {".range", ".bearing", ".height"}) names.push_back(start.agent + what);
    if (start.heading) names.push_back(start.agent + ".heading");
    if (!start.velocity) continue;
    for (const char* what : {".v_f", ".v_s"}) names.push_back(start.agent + what);
  }
  for (const NumberDraw& draw : plan.draws) names.push_back(draw.key);
  return names;
}

}  // namespace sightline
