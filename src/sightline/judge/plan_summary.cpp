#include "sightline/judge/plan_summary.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/judge/summary_keys.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

PlanSummary::PlanSummary(const Scenario& scenario, std::size_t controllers)
    : period_(scenario.horizon.dt), hold_after_(hold_after(scenario)), gaps_(controllers) {}

void PlanSummary::add(const Sample& sample) {
  for (std::size_t c = 0; c < gaps_.size(); ++c) gaps_[c].add(sample.time, period_, sample.solvers[c]);
}

PlanGap PlanSummary::longest() const {
  PlanGap longest;
  for (const PlanGaps& gaps : gaps_) {
    if (gaps.any().longest > longest.longest) longest = gaps.any();
  }
  return longest;
}

std::vector<std::string> PlanSummary::failures() const {
  std::vector<std::string> sentences;
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    const PlanGap& gap = gaps_[c].failed();
    if (gap.longest <= hold_after_ + same_time) continue;
    sentences.push_back(
        fmt::format("the solver{} gave no plan for {:.2f} s from {:.2f} s on ({}), expected one within {} s",
                    gaps_.size() > 1 ? fmt::format(" of controller {}", c) : "", gap.longest, gap.from,
                    to_string(gap.status), hold_after_));
  }
  return sentences;
}

std::string PlanSummary::json() const {
  const PlanGap gap = longest();
  Json json = {{"longest"_key, gap.longest}, {"from"_key, nullptr}, {"status"_key, nullptr}};
  if (gap.longest > 0) {
    json["from"_key] = gap.from;
    json["status"_key] = to_string(gap.status);
  }
  return json_text(json);
}

std::string describe_without_plan(std::string_view json) {
  const Json gap = Json::parse(json);
  if (!(gap.at("longest").get<double>() > 0)) return {};
  return fmt::format("at most {:.2f} s on end, from {:.2f} s on ({})", gap.at("longest").get<double>(),
                     gap.at("from").get<double>(), gap.at("status").get<std::string>());
}

}  // namespace sightline
