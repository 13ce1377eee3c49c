#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "bridges/dds/fleet/bridge.hpp"
#include "bridges/dds/fleet/link.hpp"
#include "cli/arguments.hpp"
#include "cli/fleet.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/identification/downwash_fit.hpp"
#include "sightline/analysis/identification/identification_text.hpp"
#include "sightline/analysis/identification/recorded_flight_motion.hpp"
#include "sightline/base.hpp"
#include "sightline/base/character.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/log.hpp"
#include "sightline/run/realtime.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline::cli {
namespace {

/// What a motion comes from.
enum class MotionSource : std::uint8_t { scenario, run, recording, flights };
constexpr std::array motion_sources = {"a scenario", "a run", "a recording",
                                       "recordings of a flight (FILE,FILE)"};

struct IdentifyCommand {
  NamedScenario of;
  std::filesystem::path output;
  std::string agent, excitation = "steps";
  double seconds = 20.0, radius = 3.0;
  std::optional<double> height;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> columns;
  std::string body, commands;
  std::vector<std::string> flights, held_out, vehicles;
  std::vector<std::pair<const CLI::Option*, std::vector<MotionSource>>> used_by;  ///< other sources refuse it
  bool json = false;
};

namespace fs = std::filesystem;

ExcitationKind kind_of(const std::string& name) {
  const auto found = std::find(excitation_names.begin(), excitation_names.end(), name);
  if (found == excitation_names.end()) {
    throw std::invalid_argument(
        fmt::format("--excitation = {}, expected one of {}", name, fmt::join(excitation_names, ", ")));
  }
  return static_cast<ExcitationKind>(found - excitation_names.begin());
}

/// Returns the result of `make`; errors receive the place as a prefix, unless they begin with it.
template <class Make>
auto in(const fs::path& place, Make&& make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    if (std::string_view(error.what()).starts_with(place.native())) throw;
    throw std::invalid_argument(fmt::format("{}: {}", place.native(), error.what()));
  }
}

/// @throws std::invalid_argument for a given option that motions of this source do not use
void refuse_unused(const IdentifyCommand& command, MotionSource source) {
  const auto shown = [](MotionSource one) { return motion_sources[static_cast<std::size_t>(one)]; };
  for (const auto& [option, sources] : command.used_by) {
    if (option->count() == 0 || std::find(sources.begin(), sources.end(), source) != sources.end()) continue;
    std::vector<std::string_view> expected;
    for (const MotionSource one : sources) expected.emplace_back(shown(one));
    throw std::invalid_argument(fmt::format("{} of {}, expected only for {}", option->get_name(),
                                            shown(source), fmt::join(expected, ", ")));
  }
}

/// The flown motion of the robot from the log of a run.
FlownMotion flown(const IdentifyCommand& command, const Registry& registry) {
  const fs::path log = log_of(command.of.file);
  const FlownAs flight = flown_as(log);
  const Scenario scenario =
      parse_scenario(flight.text, log, registry, {.files = flight.files, .set = command.of.set});
  const RecordedFlight recorded(log, scenario.team, scenario.x0, scenario.horizon.dt);
  return in(command.of.file, [&] { return motion_of(recorded, scenario.horizon.dt, command.agent); });
}

/// Excites one robot of a fleet over its link: takes off, moves within the walls, lands; Ctrl-C
/// lands it.
/// @throws std::invalid_argument if the robot does not take off, or the flight ends early
FlownMotion excite_over_link(const Scenario& fleet, AgentId robot, const ExcitationOptions& options,
                             const Registry& parts) {
  refuse_without_bridge(parts);
  if (options.height)
    throw std::invalid_argument(
        "--height of a robot on a link, expected none: it begins where it took off to");
  const std::vector<Link>& links = fleet_of(fleet).links;
  const auto reached =
      std::find_if(links.begin(), links.end(), [&](const Link& link) { return link.robot == BodyId(robot); });
  if (reached != links.end() && reached->poses.estimated())
    throw std::invalid_argument(fmt::format(
        "agent.{}.localization = vision, expected \"global\": what it does is measured by its poses",
        fleet.team.name(BodyId(robot))));
  Scenario alone = fleet;
  std::erase_if(own_fleet(alone).links, [&](const Link& link) { return link.robot != BodyId(robot); });
  const std::unique_ptr<LinkedWorld> world = parts.bridge->connect(alone);
  outlive_the_terminal();
  listen_to_interrupts();
  FlownMotion motion;
  std::string why = "it did not take off";
  run_apart([&] {
    offer_sentence(become_realtime(control_priority).sentence());
    if (!world->take_off(Arming::real, interrupts(), offer_sentence)) return;
    SteadyClock clock;
    try {
      motion = fly_excitation(alone, robot, options, *world, clock, stop_flight());
      why.clear();
    } catch (const std::exception& error) {
      why = sentence_of(error);
    }
    world->land(interrupts(), offer_sentence);
  });
  (void)say_end(*world);
  if (!why.empty()) throw std::invalid_argument(why);
  return motion;
}

/// The recordings of a flight, FILE,FILE; one where the text has no comma or is the name of a file.
std::vector<fs::path> recordings_of(const std::string& text) {
  std::error_code ignored;
  std::vector<fs::path> files;
  if (fs::exists(text, ignored)) return {text};
  for (const std::string_view file : split(text, ',')) files.emplace_back(file);
  return files;
}

/// @throws std::invalid_argument for a recording that two flights, or two vehicles of one, have in common:
///   what teaches does not judge
void refuse_in_common(const IdentifyCommand& command) {
  std::vector<fs::path> before;
  const auto add = [&](std::string_view key, const std::string& text) {
    for (const fs::path& file : recordings_of(text)) {
      std::error_code ignored;  // the reading reports the error of a missing file
      for (const fs::path& other : before) {
        if (fs::equivalent(file, other, ignored))
          throw std::invalid_argument(fmt::format(
              "{} = {}: {} was given before, expected other recordings for each vehicle and flight", key,
              text, file.native()));
      }
      before.push_back(file);
    }
  };
  add("SCENARIO", command.of.file.native());
  for (const std::string& text : command.flights) add("--flight", text);
  for (const std::string& text : command.held_out) add("--held-out", text);
}

/// The downwash of vehicles above one another, from their recordings.
int identify_flights(const IdentifyCommand& command) {
  std::optional<FolderLock> lock;
  DownwashIdentification found;
  try {
    refuse_unused(command, MotionSource::flights);
    std::vector<Vehicle> vehicles;
    for (const std::string& name : command.vehicles) vehicles.push_back(named_vehicle(name));
    if (vehicles.empty()) throw std::invalid_argument("--vehicle is missing, expected a preset or a file");
    refuse_in_common(command);
    const auto read = [&](const std::string& text) {
      return downwash_flight(recordings_of(text), vehicles, command.columns);
    };
    std::vector<DownwashFlight> flights = {read(command.of.file.native())}, held_out;
    for (const std::string& text : command.flights) flights.push_back(read(text));
    for (const std::string& text : command.held_out) held_out.push_back(read(text));
    found = identify_downwash(flights, held_out);
    lock.emplace(command.output.empty() ? fs::path("out") / flights[0][0].name / "identify" : command.output,
                 std::initializer_list<std::string_view>{"identify.json"});
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
  const std::string json = to_json(found);
  print("{}", command.json ? json : to_string(found) + "\n");
  const fs::path file = lock->folder() / "identify.json";
  write_text(file, json);
  if (!command.json) print("{}\n", file.native());
  return 0;
}

int identify(const IdentifyCommand& command, const Registry& registry) {
  if (recordings_of(command.of.file.native()).size() > 1) return identify_flights(command);
  std::error_code ignored;  // the reading reports the error of an inaccessible file
  const bool of_log = fs::is_directory(command.of.file, ignored);
  const RecordingKind recording = kind_at(command.of.file).recording;
  std::optional<FolderLock> lock;
  FlownMotion motion;
  std::optional<Identification> found;
  const auto lock_in = [&](const fs::path& otherwise) {
    lock.emplace(command.output.empty() ? otherwise : command.output,
                 std::initializer_list<std::string_view>{"identify.json", "identify.html"});
  };
  try {
    if (recording != RecordingKind::none && recording != RecordingKind::run) {
      refuse_unused(command, MotionSource::recording);
      found = in(command.of.file, [&] {
        motion = recorded_motion(command.of.file, recording,
                                 {command.agent, command.columns, command.body, command.commands});
        return sightline::identify(motion);
      });
      lock_in(fs::path("out") / motion.robot / "identify");
    } else if (of_log) {
      refuse_unused(command, MotionSource::run);
      motion = flown(command, registry);
      lock_in(command.of.file);
      found = in(command.of.file, [&] { return sightline::identify(motion); });
    } else {
      refuse_unused(command, MotionSource::scenario);
      const Scenario scenario = command.of.read(registry);
      const AgentId robot =
          in(command.of.file, [&] { return identified_robot(scenario.team, command.agent); });
      const ExcitationOptions options{.kind = kind_of(command.excitation),
                                      .seconds = command.seconds,
                                      .seed = command.seed.value_or(scenario.simulation.seed),
                                      .height = command.height,
                                      .radius = command.radius};
      options.check();
      lock_in(fs::path("out") / scenario.name / "identify");
      motion = scenario.links ? excite_over_link(scenario, robot, options, registry)
                              : fly_excitation(scenario, robot, options);
      found = in(command.of.file, [&] { return sightline::identify(motion, options.kind); });
    }
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }

  const std::string json = to_json(*found);
  if (command.json) {
    print("{}", json);
  } else {
    print("{}\n", to_string(*found));
  }
  const fs::path& folder = lock->folder();
  write_text(folder / "identify.json", json);
  if (!command.json) print("{}\n", (folder / "identify.json").native());
  try {
    write_text(folder / "identify.html", identification_html(*found, motion));
    if (!command.json) print("{}\n", (folder / "identify.html").native());
  } catch (const std::runtime_error& error) {
    print_sentence(fmt::format("no identify.html: {}", sentence_of(error)));
  }
  return 0;
}

}  // namespace

Execute describe_identify(CLI::App& app) {
  const auto command = std::make_shared<IdentifyCommand>();
  app.description(
      "Fit the model of a multirotor to a flight that excites it, to a run, or to a recording; fit downwash "
      "to recordings of vehicles above one another");
  add_scenario(app, command->of, "SCENARIO",
               "Scenario file (TOML), the folder of a run, a log of PX4 (ULog), a bag of ROS 2 (MCAP) or a "
               "table (CSV); FILE,FILE: tables of vehicles that fly above one another");
  app.add_option("--agent", command->agent,
                 "Robot [the only multirotor; of a recording, the name of its file]");
  app.add_option("--excitation", command->excitation, "steps, chirp, 3211 or bang_bang, in a scenario")
      ->capture_default_str();
  app.add_option("--seconds", command->seconds, "Time of the excitation [s]")->capture_default_str();
  app.add_option("--height", command->height, "Where it begins [m]; the scenario's, but at least 2 m");
  app.add_option("--radius", command->radius, "Farthest from the start, level [m]")->capture_default_str();
  app.add_option("--seed", command->seed, "Seed of steps and noise, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  app.add_option("--columns", command->columns,
                 "Names of the columns of a table, t,x,y,z,-,vx; -: not used [its first line]")
      ->delimiter(',');
  app.add_option("--body", command->body,
                 "Topic or name of the motion in a bag, /odom, /poses:cf1 or cf1 [the only one]");
  app.add_option("--commands", command->commands, "Topic of the velocity commands in a bag [the only one]");
  app.add_option("--vehicle", command->vehicles,
                 "Preset or file (TOML) of the vehicles of a flight: one for all, or one for each recording")
      ->delimiter(',');
  app.add_option("--flight", command->flights, "Another flight, FILE,FILE; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--held-out", command->held_out,
                 "A flight that judges alone; may be repeated [each flight, or fifth of the only one, by the "
                 "others]")
      ->allow_extra_args(false);
  app.add_option("-o,--output", command->output,
                 "Folder for the results [out/NAME/identify; of a run, its own]");
  app.add_flag("--json", command->json, "JSON instead of a table");
  using enum MotionSource;
  const auto used_by = [&](std::vector<MotionSource> sources, std::initializer_list<const char*> names) {
    for (const char* const name : names) command->used_by.emplace_back(app.get_option(name), sources);
  };
  used_by({scenario, run}, {"--set"});
  used_by({scenario, run, recording}, {"--agent"});
  used_by({scenario}, {"--excitation", "--seconds", "--height", "--radius", "--seed"});
  used_by({recording, flights}, {"--columns"});
  used_by({recording}, {"--body", "--commands"});
  used_by({flights}, {"--vehicle", "--flight", "--held-out"});
  return [command](const Registry& registry, char**) { return identify(*command, registry); };
}

}  // namespace sightline::cli
