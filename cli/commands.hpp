/// The commands of the program. Each prints results on stdout and messages on stderr, and returns
/// the exit code: 0 done, 1 the flight failed or output was lost, 2 bad input. `registry` holds the
/// parts that a scenario may name.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/fleet/bridge.hpp"
#include "sightline/analysis/identification/excitation.hpp"
#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline::cli {

/// A scenario as given on a command line.
struct NamedScenario {
  std::filesystem::path file;
  std::vector<std::string> set;  ///< "KEY=VALUE"; replaces values of the file

  /// @throws std::invalid_argument as read_scenario()
  Scenario read(const Registry& registry) const { return read_scenario(file, registry, set); }
};

/// Default port of a page.
inline constexpr std::uint16_t page_port = 8765;

/// Whether and where a flight is shown on a page.
struct ShowOptions {
  bool show = false;
  bool tune = false;  ///< users of the page may change the flight
  ServeOptions serve{.port = page_port};
};

struct CheckCommand {
  NamedScenario scenario;
  bool expanded = false;  ///< print the scenario expanded, as TOML
  bool fix = false;       ///< rewrite the file with the present names
};

struct ExplainCommand {
  NamedScenario scenario;
};

struct RunOptions {
  NamedScenario scenario;
  std::filesystem::path output;  ///< empty: out/NAME
  std::optional<std::string> solver;
  std::optional<std::uint64_t> seed;
  bool realtime = false;
  int threads = 1;  ///< threads that share each update of a large team
  ShowOptions view;
  std::optional<std::string>
      partition;  ///< "a,b | c,d": subteams, each with its own solver; none: one solver for all
  std::string order = "gauss_seidel";
  int exchanges = 1;
};

struct BenchCommand {
  std::optional<std::string> name;  ///< of one case; none: all
  std::string solver = "newton_riccati";
  bool json = false;
  int threads = 1;          ///< threads that share each update of a large team
  int updates = 6000;       ///< of the closed loop
  bool times_only = false;  ///< without the comparison with the optimum
};

struct PotentialOptions {
  NamedScenario scenario;
  std::filesystem::path output;     ///< empty: out/NAME/potential
  std::optional<long long> couple;  ///< none: all
};

struct FlyCommand {
  NamedScenario fleet;           ///< a scenario with a [fleet]
  std::filesystem::path output;  ///< empty: out/NAME
  bool dry_run = false;          ///< all steps except arming
  ShowOptions view;
  int threads = 1;        ///< threads that share each update of a large team
  bool wait = false;      ///< arm when the service ~/start is called
  std::string part;       ///< part of [partition] planned here; empty: by the scenario
  std::string partition;  ///< "front: a,b | back: c,d", replaces the scenario's; empty: the scenario's
};

struct VehiclesCommand {
  NamedScenario fleet;
  double seconds = 1e9;  ///< duration, or until Ctrl-C
};

struct DoctorCommand {
  NamedScenario fleet;
  std::optional<double> seconds;  ///< duration of listening; none: 10, with `watch` until Ctrl-C
  bool watch = false;             ///< print only the robots' positions, once a second
  bool json = false;
};

struct ViewCommand {
  NamedScenario of;  ///< a scenario, or the folder of a run
  ServeOptions serve{.port = page_port};
  bool open = false;             ///< open the page in the browser
  std::optional<double> speed;   ///< simulated time per wall-clock time; none: 1
  bool paused = false;           ///< pause after the first period, until Enter
  bool tune = false;             ///< users of the page may change the flight, which is then logged
  std::filesystem::path output;  ///< of a tuned flight; empty: out/NAME/tuned
  double seconds = 1e9;          ///< duration, or until Ctrl-C
};

struct ReplayCommand {
  std::filesystem::path folder;       ///< of a run
  std::optional<std::string> solver;  ///< none: the solver of the flight
  std::vector<std::string> set;       ///< applied to the scenario in the log
  bool json = false;
};

struct IdentifyCommand {
  NamedScenario of;              ///< a scenario, or the folder of a run
  std::filesystem::path output;  ///< empty: out/NAME/identify; for a run its own folder
  std::string agent;             ///< empty: the only multirotor of the scenario
  std::string excitation = "steps";
  double seconds = 20.0, radius = 3.0;
  std::optional<double> height;       ///< none: the scenario's, at least 2 m
  std::optional<std::uint64_t> seed;  ///< none: the scenario's
  bool json = false;
};

/// Requests of a job array. Empty or 0 leaves the choice to Slurm and to SBATCH_* in the
/// environment.
struct SlurmOptions {
  bool submit = false, dry_run = false;
  int shards = 8;
  int cpus = 0;                     ///< of each shard; 0: SBATCH_CPUS_PER_TASK, or 1
  std::string partition{}, time{};  ///< of Slurm
};

struct CampaignCommand {
  NamedScenario scenario;              ///< its `set` applies to the compared scenario too
  std::filesystem::path output;        ///< empty: out/NAME/campaign
  std::filesystem::path compare_with;  ///< another scenario that flies the same draws; empty: none
  int runs = 200;
  std::optional<std::uint64_t> seed;         ///< none: the scenario's
  int threads = 0;                           ///< 0: number of cores
  std::optional<int> only;                   ///< one run, into an ordinary run folder
  std::string shard;                         ///< "I/N": the runs of this shard; empty: all
  bool resume = false;                       ///< the folder must contain runs already
  std::vector<std::filesystem::path> merge;  ///< folders of shards; empty: none
  SlurmOptions slurm;
};

/// Flies a scenario and writes run.mcap, timing.csv, summary.json and report.html into the output
/// folder.
int run(const RunOptions& options, const Registry& registry);

struct PartitionChoice;
/// Robots on links, instead of a simulated world.
struct LinkedFlight {
  LinkedWorld& world;
  Arming arming = Arming::real;
  const Interrupts& interrupts;
  std::atomic<bool>& stop;  ///< ends the loop
};
/// As run(), for a scenario that is already read. Its team plans in subteams, or, without a
/// partition, as one.
int fly(Scenario scenario, const RunFolder& folder, Clock& clock, const ShowOptions& view = {},
        const PartitionChoice* partition = nullptr, LinkedFlight* linked = nullptr);
/// Prints a message if this program contains no page.
void print_without_page();
/// Flies a fleet over the program's bridge: takes off, flies the task, lands. Ctrl-C lands; a
/// second Ctrl-C leaves the robots to their autopilots. Writes the files of run().
int fly_fleet(const FlyCommand& command, const Registry& registry);
/// Excites one robot of a fleet over its link: takes off, moves within the walls, lands; Ctrl-C
/// lands it.
/// @throws std::invalid_argument if the robot does not take off, or the flight ends early
FlownMotion excite_over_link(const Scenario& fleet, AgentId robot, const ExcitationOptions& options,
                             const Registry& registry);
/// Simulates the vehicles of a fleet.
int vehicles(const VehiclesCommand& command, const Registry& registry);
/// Checks the robots of a fleet and this machine before a flight; sends no command that a robot
/// could execute. Returns 1 if a check is red.
int doctor(const DoctorCommand& command, const Registry& registry);
/// Flies the runs of a scenario's [campaign]; writes campaign.sqlite and campaign.html. Returns 1
/// if a run is not recovered.
int campaign(const CampaignCommand& command, const Registry& registry);
/// Reads a scenario and prints its summary or its errors; or prints it expanded, as TOML.
int check(const CheckCommand& command, const Registry& registry);
/// Writes report.html again from the files of a run.
int report(const std::filesystem::path& folder);
/// Flies a scenario in real time, or replays the log of a run, and serves a page that shows it
/// until Ctrl-C. Writes no files, except for a tuned flight.
int view(const ViewCommand& command, const Registry& registry);
/// As view(), for a flight that users of the page may change and restart with another seed; each
/// flight writes its log.
/// @param announce  receives the address of the page
int view_tuned(const ViewCommand& command, const Registry& registry,
               const std::function<void(const std::string&)>& announce);
/// Time at which the page closes, unless it is closed earlier.
std::chrono::steady_clock::time_point end_of(const ViewCommand& command);
/// Prints the counts of the page's clients.
void report_counts(const ServeCounts& counts);
/// Feeds the measurements of a run through its loop again and compares each command bit for bit;
/// returns 1 if one differs. With another solver or other values it prints the distance of the
/// commands from the recorded ones.
int replay(const ReplayCommand& command, const Registry& registry);
/// Fits multirotor models to an excitation flight or to the log of a run: identify.json and
/// identify.html.
int identify(const IdentifyCommand& command, const Registry& registry);
/// Plots and evaluates the potentials of a scenario: index.html and verdict.json.
int potential(const PotentialOptions& options, const Registry& registry);
/// Prints which limits of a scenario can hold together, and the value of each.
int explain(const ExplainCommand& command, const Registry& registry);
/// Lists the parts that a scenario may name, with their parameters: Markdown tables, or JSON.
int list_parts(bool json, const Registry& registry);
int show_version();
/// Version of the library and of the compiler that built it.
std::string version_text();
/// Flies the benchmark's cases and prints times, errors and costs, as a table or as JSON. It starts
/// the program sightline_bench beside this one, with the same arguments.
int bench(const BenchCommand& command, char** argv);

}  // namespace sightline::cli
