#include "sightline/scenario/link_fault.hpp"

#include <fmt/format.h>

#include <cmath>

namespace sightline {

std::string in_words(const LinkFault& fault) {
  const LinkFaultText& text = text_of(fault.kind);
  std::string words(text.name);
  if (!text.size.empty()) words += fmt::format(" {}", fault.size);
  if (text.size == "s" || text.size == "m") words += fmt::format(" {}", text.size);
  if (std::isfinite(fault.duration)) words += fmt::format(" for {} s", fault.duration);
  return words + fmt::format(", {} s after {}", fault.at,
                             fault.since == FaultClock::start ? "the start" : "it is first steered");
}

std::string link_fault_table() {
  std::string table = "| `kind` | key | of | `size` | default | what happens |\n|---|---|---|---|---|---|\n";
  for (const LinkFaultText& text : link_faults) {
    const bool every = text.of.px4 && text.of.crazyswarm2 && text.of.ros2;
    std::string of;
    for (const auto& [has, name] :
         {std::pair{text.of.px4, "px4"}, {text.of.crazyswarm2, "crazyswarm2"}, {text.of.ros2, "ros2"}})
      if (has) of += fmt::format("{}`{}`", of.empty() ? "" : ", ", name);
    const bool sized = !text.size.empty();
    table += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", text.name, text.key,
                         text.of.camera ? "with a camera"
                         : every        ? "all"
                                        : of,
                         sized ? fmt::format("{}, {}", text.size, text.bounds.words) : "",
                         sized ? fmt::format("{}", text.fallback) : "", text.meaning);
  }
  return table;
}

}  // namespace sightline
