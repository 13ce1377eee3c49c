/// The commands. Each prints results on stdout and messages on stderr, and returns the exit code:
/// 0 done, 1 the flight failed or output was lost, 2 bad input. `parts` are what a scenario may call by name.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/identification/excitation.hpp"
#include "sightline/record/logged_flight.hpp"
#include "sightline/run/clock.hpp"
#include "sightline/scenario/bridge.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline::cli {

/// A scenario as a command line names it.
struct NamedScenario {
  std::filesystem::path file;
  std::vector<std::string> set;  ///< "KEY=VALUE", read over what the file says

  /// @throws std::invalid_argument as read_scenario()
  Scenario read(const Registry& registry) const { return read_scenario(file, registry, set); }
};

/// Where a page is served, unless told otherwise.
inline constexpr std::uint16_t page_port = 8765;

/// Whether a flight is shown on a page, and where.
struct ShowOptions {
  bool show = false;
  bool tune = false;  ///< may be changed by those who look on
  ServeOptions serve{.port = page_port};
};

struct CheckCommand {
  NamedScenario scenario;
  bool expanded = false;  ///< print it, as TOML
  bool fix = false;       ///< rewrite the file with present names
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
  int threads = 1;  ///< that share each update of a large team
  ShowOptions view;
  std::optional<std::string>
      partition;  ///< "a,b | c,d": the parts that plan by themselves; none: one solver for all
  std::string order = "gauss_seidel";
  int exchanges = 1;
};

struct BenchCommand {
  std::optional<std::string> name;  ///< of one case; none: all
  std::string solver = "newton_riccati";
  bool json = false;
  int threads = 1;          ///< that share each update of a large team
  int updates = 6000;       ///< of the closed loop
  bool times_only = false;  ///< not compared with the optimum
};

struct PotentialOptions {
  NamedScenario scenario;
  std::filesystem::path output;     ///< empty: out/NAME/potential
  std::optional<long long> couple;  ///< none: all
};

struct FlyCommand {
  NamedScenario fleet;           ///< a scenario with a [fleet]
  std::filesystem::path output;  ///< empty: out/NAME
  bool dry_run = false;          ///< all but arm
  ShowOptions view;
  int threads = 1;        ///< that share each update of a large team
  bool wait = false;      ///< arms when the service ~/start is called
  std::string part;       ///< of the scenario's [partition], that is planned here; empty: the scenario says
  std::string partition;  ///< "front: a,b | back: c,d", in place of the scenario's; empty: the scenario's
};

struct VehiclesCommand {
  NamedScenario fleet;
  double seconds = 1e9;  ///< until Ctrl-C
};

struct DoctorCommand {
  NamedScenario fleet;
  std::optional<double> seconds;  ///< how long it listens; none: 10, and watching until Ctrl-C
  bool watch = false;             ///< where the robots are, once a second, and nothing else
  bool json = false;
};

struct ViewCommand {
  NamedScenario of;  ///< a scenario, or the folder of a run
  ServeOptions serve{.port = page_port};
  bool open = false;             ///< in the browser
  std::optional<double> speed;   ///< simulated time by that of the wall clock; none: 1
  bool paused = false;           ///< after the first period, until Enter
  bool tune = false;             ///< may be changed by those who look on; then it is logged
  std::filesystem::path output;  ///< of a flight that is tuned; empty: out/NAME/tuned
  double seconds = 1e9;          ///< until Ctrl-C
};

struct ReplayCommand {
  std::filesystem::path folder;       ///< of a run
  std::optional<std::string> solver;  ///< none: the flight's own
  std::vector<std::string> set;       ///< of the scenario in the log
  bool json = false;
};

struct IdentifyCommand {
  NamedScenario of;              ///< a scenario, or the folder of a run
  std::filesystem::path output;  ///< empty: out/NAME/identify, of a run its own folder
  std::string agent;             ///< empty: the only multirotor there is
  std::string excitation = "steps";
  double seconds = 20.0, radius = 3.0;
  std::optional<double> height;       ///< none: the scenario's, at least 2 m
  std::optional<std::uint64_t> seed;  ///< none: the scenario's
  bool json = false;
};

/// What a job array is to ask for; what is empty or 0 is left to Slurm, and to SBATCH_* of the environment.
struct SlurmOptions {
  bool submit = false, dry_run = false;
  int shards = 8;
  int cpus = 0;                     ///< of each shard; 0: SBATCH_CPUS_PER_TASK, or 1
  std::string partition{}, time{};  ///< of Slurm
};

struct CampaignCommand {
  NamedScenario scenario;              ///< its `set` is of the one beside, too
  std::filesystem::path output;        ///< empty: out/NAME/campaign
  std::filesystem::path compare_with;  ///< another scenario that flies the same draws; empty: none
  int runs = 200;
  std::optional<std::uint64_t> seed;         ///< none: the scenario's
  int threads = 0;                           ///< 0: as many as there are cores
  std::optional<int> only;                   ///< one run, into an ordinary run folder
  std::string shard;                         ///< "I/N": which of the runs; empty: all
  bool resume = false;                       ///< there must be runs already
  std::vector<std::filesystem::path> merge;  ///< folders of shards; empty: none
  SlurmOptions slurm;
};

/// Flies a scenario and leaves run.mcap, timing.csv, summary.json and report.html in the output folder.
int run(const RunOptions& options, const Registry& registry);

struct PartitionChoice;
/// Robots on links, in place of a simulated world.
struct LinkedFlight {
  LinkedWorld& world;
  Arming arming = Arming::real;
  const Interrupts& interrupts;
  std::atomic<bool>& stop;  ///< ends the loop
};
/// As run(), for a scenario that is read already; its team plans in parts, or, without a choice, as one.
int fly(Scenario scenario, const RunFolder& folder, Clock& clock, const ShowOptions& view = {},
        const PartitionChoice* partition = nullptr, LinkedFlight* linked = nullptr);
/// Says so where this program carries no page.
void tell_without_page();
/// Flies a fleet over the program's bridge: takes off, flies the task, lands; Ctrl-C lands, a second one leaves the robots to their
/// autopilots. Files as run().
int fly_fleet(const FlyCommand& command, const Registry& registry);
/// Excites a robot of a fleet over its link, alone: takes off, moves within the walls, lands; Ctrl-C lands it.
/// @throws std::invalid_argument where it does not take off, or not to the end
FlownMotion excite_over_link(const Scenario& fleet, AgentId robot, const ExcitationOptions& options,
                             const Registry& registry);
/// Stands in for the robots of a fleet.
int vehicles(const VehiclesCommand& command, const Registry& registry);
/// Looks at the robots of a fleet before a flight, and at this machine; sends nothing that a robot could obey. 1 where something is
/// red.
int doctor(const DoctorCommand& command, const Registry& registry);
/// Flies a scenario many times as its [campaign] says; leaves campaign.sqlite and campaign.html. 1 where a run is
/// not recovered.
int campaign(const CampaignCommand& command, const Registry& registry);
/// Reads a scenario and says what it describes, or what is wrong with it; or prints it expanded, as TOML.
int check(const CheckCommand& command, const Registry& registry);
/// Makes report.html again from what a run left.
int report(const std::filesystem::path& folder);
/// Flies a scenario in real time, or takes the log of a run, and serves a page that shows it, until Ctrl-C. Writes no files but those of a
/// flight that is tuned.
int view(const ViewCommand& command, const Registry& registry);
/// The same of a flight that those who look on may change, and begin anew with another seed: each leaves its log.
/// @param announce  called with the address of the page
int view_tuned(const ViewCommand& command, const Registry& registry,
               const std::function<void(const std::string&)>& announce);
/// When the page is closed, if nobody ends it before.
std::chrono::steady_clock::time_point end_of(const ViewCommand& command);
/// What became of those who looked on.
void report_counts(const ServeCounts& counts);
/// Feeds the measurements of a run through its loop again and compares each command, bit for bit: 1 where one differs.
/// With another solver or other values, says how far the commands are from the recorded ones.
int replay(const ReplayCommand& command, const Registry& registry);
/// Fits models of a multirotor to a flight that excites it, or to the log of a run: identify.json and identify.html.
int identify(const IdentifyCommand& command, const Registry& registry);
/// Draws and judges the potentials of a scenario: index.html and verdict.json.
int potential(const PotentialOptions& options, const Registry& registry);
/// Says which limits of a scenario can hold together and what each is worth.
int explain(const ExplainCommand& command, const Registry& registry);
/// Says which parts a scenario may call by name, with their parameters: tables of Markdown, or JSON.
int list_parts(bool json, const Registry& registry);
int show_version();
/// Of the library, and of the compiler that built it.
std::string version_text();
/// Flies the benchmark's cases and prints times, errors and costs, as a table or as JSON: by the program sightline_bench beside this
/// one, which gets the same arguments.
int bench(const BenchCommand& command, char** argv);

}  // namespace sightline::cli
