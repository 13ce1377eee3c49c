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

/// The names of all commands, as messages list them.
std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

int execute(int argc, char** argv, const Registry& registry) {
  using namespace cli;

  Arguments words;
  const std::vector<std::string> commands = command_names(words.app);
  const std::string_view first = argc > 1 ? argv[1] : "";
  if (!first.starts_with('-') && std::find(commands.begin(), commands.end(), first) == commands.end()) {
    const std::vector<std::string_view> known(commands.begin(), commands.end());
    const auto near = nearest(first, known);
    print_sentence(first.empty()
                       ? fmt::format("the command is missing, expected one of {}", fmt::join(commands, ", "))
                       : fmt::format("{} is no command, expected one of {}{}", first,
                                     fmt::join(commands, ", "),
                                     near ? fmt::format(", the nearest is {}", *near) : std::string()));
    return 2;
  }
  for (int i = 2; i < argc; ++i) {
    const std::string_view option(argv[i]), name = option.substr(0, option.find('='));
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
  if (words.run_command->parsed()) return run(words.run, registry);
  if (words.fly_command->parsed()) return fly_fleet(words.fly, registry);
  if (words.vehicles_command->parsed()) return vehicles(words.vehicles, registry);
  if (words.doctor_command->parsed()) return doctor(words.doctor, registry);
  if (words.check_command->parsed()) return check(words.check, registry);
  if (words.report_command->parsed()) return report(words.folder);
  if (words.view_command->parsed()) return view(words.view, registry);
  if (words.replay_command->parsed()) return replay(words.replay, registry);
  if (words.identify_command->parsed()) return identify(words.identify, registry);
  if (words.potential_command->parsed()) return potential(words.potential, registry);
  if (words.explain_command->parsed()) return explain(words.explain, registry);
  if (words.campaign_command->parsed()) return campaign(words.campaign, registry);
  if (words.parts_command->parsed()) return list_parts(words.parts_as_json, registry);
  if (words.version_command->parsed()) return show_version();
  if (words.bench_command->parsed()) return bench(words.bench, argv);
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
