#include "sightline/command_line.hpp"

#include <exception>
#include <sstream>

#include "cli/arguments.hpp"
#include "cli/output.hpp"

namespace sightline {
namespace {

int execute(int argc, char** argv, const Parts& parts) {
  using namespace cli;

  Arguments words;
  try {
    words.app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream out, err;
    const int code = words.app.exit(e, out, err);
    write_result(out.str());
    write_message(err.str());
    return code == 0 ? 0 : 2;
  }
  if (words.run_command->parsed()) return run(words.run, parts);
  if (words.fly_command->parsed()) return fly_fleet(words.fly, parts);
  if (words.vehicles_command->parsed()) return vehicles(words.vehicles, parts);
  if (words.doctor_command->parsed()) return doctor(words.doctor, parts);
  if (words.check_command->parsed()) return check(words.check, parts);
  if (words.report_command->parsed()) return report(words.folder);
  if (words.view_command->parsed()) return view(words.view, parts);
  if (words.replay_command->parsed()) return replay(words.replay, parts);
  if (words.identify_command->parsed()) return identify(words.identify, parts);
  if (words.potential_command->parsed()) return potential(words.potential, parts);
  if (words.explain_command->parsed()) return explain(words.explain, parts);
  if (words.campaign_command->parsed()) return campaign(words.campaign, parts);
  if (words.parts_command->parsed()) return list_parts(words.parts_as_json, parts);
  if (words.version_command->parsed()) return show_version();
  if (words.bench_command->parsed()) return bench(words.bench);
  return 2;
}

}  // namespace

int command_line(int argc, char** argv, const Parts& parts) {
  using namespace cli;
  open_streams();
  int code = 1;
  try {
    code = execute(argc, argv, parts);
  } catch (const std::exception& e) {
    tell("sightline: {}\n", e.what());
  }
  return finish(code);
}

}  // namespace sightline
