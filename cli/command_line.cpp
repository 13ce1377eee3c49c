#include "sightline/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <exception>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/arguments.hpp"
#include "cli/components.hpp"
#include "cli/output.hpp"
#include "sightline/base.hpp"
#include "sightline/base/nearest.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/registry.hpp"

namespace sightline {
namespace {

/// Options renamed since version 0.2.
constexpr std::array<std::pair<std::string_view, std::string_view>, 2> renamed_options = {
    {{"--beside", "--compare-with"}, {"--listen", "--bind"}}};

int execute(int argc, char** argv, const Registry& registry) {
  using namespace cli;

  Arguments words;
  std::vector<std::string_view> known;
  for (const auto& [command, unused] : words.commands) known.push_back(command->get_name());
  const std::string_view first = argc > 1 ? argv[1] : "";
  if (!first.starts_with('-') && std::find(known.begin(), known.end(), first) == known.end()) {
    if (const std::string_view component = missing_component(first); !component.empty()) {
      print_sentence(left_out(first, component));
      return 2;
    }
    const auto near = nearest(first, known);
    print_sentence(first.empty()
                       ? fmt::format("the command is missing, expected one of {}", fmt::join(known, ", "))
                       : fmt::format("{} is no command, expected one of {}{}", first, fmt::join(known, ", "),
                                     near ? fmt::format(", the nearest is {}", *near) : std::string()));
    return 2;
  }
  for (int i = 2; i < argc; ++i) {
    const std::string_view option(argv[i]), name = option.substr(0, option.find('='));
    if (name == "--view" && !has("server")) {
      print_sentence(left_out(name, "server"));
      return 2;
    }
    for (const auto& [old, present] : renamed_options) {
      if (name != old) continue;
      print_sentence(fmt::format("{}, expected {}, its name since 0.2", old, present));
      return 2;
    }
  }
  try {
    words.app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream out, err;
    const int code = words.app.exit(e, out, err);
    write_result(out.str());
    write_message(err.str());
    return code == 0 ? 0 : 2;
  }
  for (const auto& [command, run] : words.commands)
    if (command->parsed()) return run(registry, argv);
  return 2;
}

}  // namespace

int command_line(int argc, char** argv, const Registry& registry) {
  using namespace cli;
  open_streams();
  report_failures_to([](std::string_view line) noexcept { write_message(line); });
  int code = 1;
  try {
    code = execute(argc, argv, with_links(registry));
  } catch (const std::exception& e) {
    print_message("sightline: {}\n", sentence_of(e));
  }
  return finish(code);
}

}  // namespace sightline
