#include <exception>
#include <sstream>

#include "cli/arguments.hpp"
#include "cli/output.hpp"

namespace {

int execute(int argc, char** argv) {
  using namespace sightline::cli;

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
  if (words.run_command->parsed()) return run(words.run);
  if (words.check_command->parsed()) return check(words.scenario, words.expanded);
  if (words.report_command->parsed()) return report(words.folder);
  if (words.replay_command->parsed()) return replay(words.replay);
  if (words.potential_command->parsed()) return potential(words.potential);
  if (words.explain_command->parsed()) return explain(words.scenario);
  if (words.campaign_command->parsed()) return campaign(words.campaign);
  if (words.version_command->parsed()) return version();
  if (words.bench_command->parsed()) return bench(words.bench);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sightline::cli;
  open_streams();
  int code = 1;
  try {
    code = execute(argc, argv);
  } catch (const std::exception& e) {
    tell("sightline: {}\n", e.what());
  }
  return finish(code);
}
