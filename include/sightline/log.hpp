/// Logs of runs: written in flight, read as a recording, and replayed.
#pragma once

#include <fmt/format.h>

#include <atomic>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/mcap.hpp"
#include "sightline/model.hpp"
#include "sightline/scenario.hpp"
#include "sightline/sensors.hpp"
#include "sightline/team.hpp"
#include "sightline/world.hpp"

namespace sightline {

// Lock that gives one process exclusive write access to a folder.

/// Keeps every other process from writing into a folder during the lifetime of this object. The
/// kernel holds the lock, so it ends with the process, also after a crash. The file `.lock`
/// contains the process id; an orderly end removes it.
class FolderLock {
 public:
  /// Creates the folder if necessary and checks that it can be written. Changes no other file in
  /// the folder.
  /// @param files  names of the files that will be written in the folder; each must be a regular
  ///   file or absent
  /// @throws std::invalid_argument naming the folder or the file and the fault; for a locked
  ///   folder, the process that holds the lock
  FolderLock(std::filesystem::path folder, std::initializer_list<std::string_view> files);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  void lock();

  std::filesystem::path folder_, file_;
  int lock_ = -1;
};

/// True if a process writes into the folder now.
bool is_written(const std::filesystem::path& folder);

}  // namespace sightline

// Writer of logs in the MCAP format.

struct ZSTD_CCtx_s;

namespace sightline {

/// Identifier of a schema inside one log.
enum class SchemaId : std::uint16_t {};

/// Identifier of a channel inside one log.
enum class ChannelId : std::uint16_t {};
/// A channel and its message count so far.
struct McapChannel {
  ChannelId id{};
  std::uint32_t sequence = 0;
};

/// Destination of log messages: a file or subscribers.
class MessageSink {
 public:
  MessageSink() = default;
  MessageSink(const MessageSink&) = delete;
  MessageSink& operator=(const MessageSink&) = delete;
  virtual ~MessageSink() = default;

  /// Adds a message type.
  /// @param encoding  "ros2msg" or "jsonschema"
  virtual SchemaId schema(std::string_view name, std::string_view encoding, std::string_view text) = 0;

  /// Adds a topic whose messages follow `schema`.
  /// @param message_encoding  "cdr" or "json"
  virtual ChannelId channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                            const McapWords& metadata) = 0;

  /// Adds a message; allocates nothing once the buffers have reached their final size.
  /// @param log_time  [ns], also the time of publication
  virtual void message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time,
                       std::span<const std::byte> bytes) = 0;
};

/// Writes a log in the MCAP format (mcap.dev), which Foxglove, PlotJuggler and McapReader open.
///
/// Messages collect in a chunk. flush() compresses the chunk (zstd) and passes it to the kernel at
/// once by write(2). A killed run loses only the open chunk. Equal calls give equal bytes.
///
/// No disk failure throws. error() keeps the first failure as a sentence, later calls do nothing,
/// and the file is truncated to its last complete chunk. One thread at a time.
class McapWriter final : public MessageSink {
 public:
  /// Opens `path` for writing, truncates it and writes the header.
  /// @param profile  convention of the channels, "ros2"
  /// @param library  name and version of the writing program
  McapWriter(const std::filesystem::path& path, std::string_view profile, std::string_view library);
  ~McapWriter() override;  ///< Closes the log if close() was not called.

  SchemaId schema(std::string_view name, std::string_view encoding, std::string_view text) override;
  ChannelId channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                    const McapWords& metadata) override;
  /// Appends to the open chunk; a chunk above 4 MiB closes automatically.
  void message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time,
               std::span<const std::byte> bytes) override;

  /// Closes the open chunk and writes it; does nothing if it contains no message.
  void flush();

  /// Writes key-value pairs about the whole log, immediately.
  void metadata(std::string_view name, const McapWords& words);

  /// Renames the file to `path`, replacing an existing file; later writes go to the same file.
  void settle(const std::filesystem::path& path);

  /// Writes the open chunk, the summary and the footer, and closes the file.
  void close();

  /// Closes the file after its last complete chunk without summary and footer, as a killed run
  /// leaves it.
  void abandon() noexcept;

  bool ok() const { return error_.empty(); }           ///< True until the first failure.
  const std::string& error() const { return error_; }  ///< The first failure, a sentence; empty if none.
  std::uint64_t bytes_written() const { return position_; }  ///< Length of the intact part of the file [B].

 private:
  using Bytes = std::vector<std::byte>;
  struct Entry {
    std::uint64_t log_time;  // [ns]
    std::uint64_t offset;    // of the message's record in the uncompressed chunk [B]
  };
  struct Channel {
    std::vector<Entry> entries;  // messages of the open chunk
    std::uint64_t messages = 0;  // in the whole log
  };

  void write(const Bytes& bytes);
  void fail(std::string_view what, int error_number);
  void write_chunk_indexes(std::uint64_t data_end_at);
  bool read_back(std::uint64_t at, std::span<std::byte> bytes);
  void write_summary();

  std::string path_;
  std::string error_;
  int file_ = -1;               // -1: closed or failed
  std::uint64_t position_ = 0;  // bytes written
  std::uint64_t sound_ =
      std::numeric_limits<std::uint64_t>::max();  // start of the summary [B], which is valid only if complete
  std::uint32_t crc_ = 0;                         // of the data section, then of the summary section
  std::unique_ptr<ZSTD_CCtx_s, std::size_t (*)(ZSTD_CCtx_s*)> zstd_;

  Bytes chunk_;  // records of the open chunk, uncompressed
  Bytes out_;    // buffer of one write to the kernel
  std::uint64_t chunk_first_ = 0, chunk_last_ = 0, chunk_messages_ = 0;
  std::vector<Channel> channels_;

  // The summary as it grows, one sequence of records per kind.
  Bytes schema_records_, channel_records_, metadata_indexes_;
  std::uint64_t first_ = 0, last_ = 0, messages_ = 0;
  std::uint32_t chunks_ = 0, metadata_count_ = 0;
  std::uint16_t schemas_ = 0;
};

// JSON messages of the log, with numbers that read back to the same bits.

/// Converts a time [s] to log time [ns].
std::uint64_t nanoseconds(double time);

/// Writes messages {time, ...} of the log in one buffer; allocates nothing once the buffer has
/// reached its final size.
class LogMessage {
 public:
  explicit LogMessage(MessageSink& to) : to_(to) {}

  /// @param time  [s]
  void begin(double time);
  /// Adds the shortest text that reads back to the same bits; null for a number that is not finite.
  void put(std::string_view key, double value);
  void put(std::string_view key, std::span<const double> values);
  /// Adds a word without quotes and backslashes.
  void put(std::string_view key, std::string_view word);
  template <std::integral T>
  void put(std::string_view key, T value) {
    put_key(key);
    fmt::format_to(std::back_inserter(text_), "{}", value);
  }
  /// Closes the message and returns its text, valid until the next begin().
  std::string_view end();
  /// Ends the message and writes it.
  /// @param time  [s]
  void send(McapChannel& channel, double time);

 private:
  void put_key(std::string_view key);

  MessageSink& to_;
  std::string text_;
};

/// Schema of a message {time, ...} with more fields: "number, list[], word: string".
std::string json_schema(std::string_view fields);

/// Reads the flat JSON object of a message into reused memory; trusts no byte of the text.
class LogText {
 public:
  /// A message that is not of the expected kind.
  struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  /// @throws Error if the text is no object of numbers, words, null, true, false and
  ///   lists of numbers
  void read(std::string_view text);

  bool has(std::string_view key) const noexcept;
  /// Number with this key; NaN for null. @throws Error if the key is missing
  double number(std::string_view key) const;
  /// The same, a whole number. @throws Error also if it is none, or beyond int
  int whole(std::string_view key) const;
  /// List with this key; null reads as NaN. @throws Error if the key is missing
  std::span<const double> numbers(std::string_view key) const;
  /// The same, of a list of that many numbers. @throws Error if it has another length
  std::span<const double> numbers(std::string_view key, std::size_t count) const;
  /// True or false with this key. @throws Error if the key is missing
  bool truth(std::string_view key) const;
  /// Word with this key, without escapes. @throws Error if the key is missing
  std::string_view word(std::string_view key) const;

 private:
  enum class Kind { number, numbers, word, truth };
  struct Entry {
    std::string_view key, word;
    Kind kind;
    std::size_t first, count;  // in numbers_
  };
  const Entry& find(std::string_view key, Kind kind) const;
  [[noreturn]] void throw_invalid() const;
  void skip_space() noexcept;
  bool take(char c) noexcept;
  std::string_view quoted();
  void value();

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<Entry> entries_;
  std::vector<double> numbers_;
};

// A flight with its log, for `sightline run` and for programs: writes the files of a run and
// reports its faults.

/// Folders for the files of a flight and of its comparisons; locked for this process.
class RunFolder {
 public:
  /// @param in_parts  true if the flight of a partitioned team is compared with one solver for the
  ///   whole team
  /// @throws std::invalid_argument as FolderLock
  RunFolder(const std::filesystem::path& folder, const Scenario& scenario, bool in_parts = false);

  const std::filesystem::path& path() const { return locks_.front().folder(); }

 private:
  std::list<FolderLock> locks_;
};

/// Options of a flight beyond its scenario and its controllers.
struct FlightOptions {
  World* world = nullptr;                            ///< null: the scenario's simulated world
  TeamSwitcher* team_switcher = nullptr;             ///< of the Controls, if the scenario has one
  std::int64_t (*allocations)() noexcept = nullptr;  ///< allocations so far of the calling thread, if counted
  const std::atomic<bool>* stop = nullptr;           ///< when true, the flight ends at the next period
  std::function<void(double)> written{};  ///< see Log; called by the log's thread with the simulated time [s]
  std::map<std::string, std::string> flown{};  ///< how it is flown, see Log
  /// Returns a sink that replaces the log's sink and forwards to it; `prototype` is one item of the
  /// log's sink. The returned sink must outlive the flight.
  std::function<Sink<Sample>&(Sink<Sample>& log, const Sample& prototype)> watched{};
  /// Flies the loop; if empty, ClosedLoop::fly(). Must close the sink if it does not call
  /// ClosedLoop::fly().
  std::function<LoopOutcome(ClosedLoop&, Sink<Sample>&)> fly{};
  /// Returns the final text of summary.json, given its first version.
  std::function<std::string(std::string)> summarised{};
};

/// Results of a flight, beyond its files.
struct LoggedFlight {
  std::string summary;              ///< text of summary.json
  std::vector<std::string> faults;  ///< reasons why the run failed, one sentence each
  bool begun = false;               ///< the folder contains this flight's files, not earlier ones
  bool logged = false;              ///< these files are complete
  LoopOutcome outcome{};
};

/// Flies the scenario with its controllers; writes run.mcap, timing.csv and summary.json into the
/// folder. Allocates all memory before the first period.
/// @throws std::invalid_argument as make_world() and ClosedLoop, before anything is written
LoggedFlight fly_logged(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                        const Controllers& controllers, const FlightOptions& options = {});

// Measurements and commands of a flight in its log: a writer, and a world that replays them.
//
// /BODY/measurement has one message per period, the others as data arrives. A replay uses them, the
// topics of localization, /BODY/state (the truth), /ROBOT/input (the command) and /events (missed
// periods). Nothing depends on wall-clock time.

/// Writes measurements, detections, goals and changes of the team (record/log_table.hpp).
class MeasurementLog {
 public:
  MeasurementLog(const Team& team, MessageSink& sink, const std::vector<RobotGoals>& goals = {});

  /// Adds a sample; allocates nothing once the buffers have reached their final size and each
  /// observer has detected a body.
  void add(const Sample& sample);

 private:
  SchemaId detection();

  Team team_;
  MessageSink& sink_;
  LogMessage message_;
  struct Goals {
    std::shared_ptr<const GoalTrack> track;
    McapChannel channel{};
    std::size_t written = 0;
  };
  void add_goals(double time);

  std::vector<Goals> goals_;
  std::vector<Waypoint> waypoints_;
  std::vector<double> numbers_;
  std::vector<McapChannel> bodies_;                     // of each body
  std::vector<std::optional<McapChannel>> detections_;  // of each body with a detection
  std::optional<SchemaId> detection_{};
  McapChannel changes_;
};

/// One period of a recorded flight.
struct RecordedPeriod {
  double time = 0.0;                                       ///< [s]
  std::vector<double> measured{}, stamps{}, truth{}, u{};  ///< sizes nx, bodies, nx, nu
  std::vector<Detection> detections{};
  std::vector<RobotMotion> motions{};
  std::vector<BodyBroadcast> broadcasts{};
  /// Estimate of a localized robot.
  struct Localized {
    BodyId robot{};
    PoseEstimate estimate{};
  };
  std::vector<Localized> estimates{};
  std::vector<Status> status{};  ///< of each controller
  bool team_answered = false;
};

/// A recorded flight as the world and the clock of a loop: the same measurements in the same
/// periods; missed periods are missed again. Commands have no effect; a sink compares them.
class RecordedFlight final : public World, public Clock {
 public:
  /// Word in the metadata of a log: absent robots stayed in the world of the flight.
  static constexpr const char* absent_stay = "absent_robots_stay";

  /// @param team    of the scenario that was flown
  /// @param goals   of the team that received goals: their tracks are cleared and receive the
  ///   recorded goals
  /// @throws std::runtime_error with a sentence that names the file, if it cannot be read or
  ///   contains no measurements of this team
  RecordedFlight(const std::filesystem::path& log, Team team, std::vector<double> start, double period,
                 std::vector<RobotGoals> goals = {});

  const std::vector<RecordedPeriod>& periods() const noexcept { return periods_; }
  /// True if the log is truncated, as after a killed run.
  bool truncated() const noexcept { return truncated_; }
  /// Time after which samples were lost, so that later periods cannot be replayed [s]; empty if
  /// none was lost.
  std::optional<double> lost_after() const noexcept { return lost_after_; }
  /// Number of the period at a time [s]; 0 at the start of the flight.
  std::int64_t number(double time) const noexcept;

  const Team& team() const noexcept override { return team_; }
  std::span<const double> start() const noexcept override { return start_; }
  MeasuredMost measured_max() const noexcept override { return most_; }
  void set_presence(std::span<const Presence>) noexcept override {}
  bool absent_robots_stay() const noexcept override { return absent_robots_stay_; }
  Joining prepare(BodyId robot) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;

  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override;
  bool waits_for_log() const noexcept override { return true; }
  TeamDue team_due(std::int64_t k) const noexcept override;

 private:
  class Reader;

  Team team_;
  std::vector<double> start_;
  double period_;  // [s]
  std::vector<RecordedPeriod> periods_;
  struct RecordedGoal {
    double time;  // [s]
    std::shared_ptr<GoalTrack> track;
    std::vector<Waypoint> waypoints;
  };
  std::vector<RobotGoals> goals_;
  std::vector<RecordedGoal> sent_;
  struct RecordedJoining {
    std::int64_t number;  // of the period
    BodyId robot;
    Joining answer;
  };
  bool absent_robots_stay_ = false;
  std::vector<RecordedJoining> joinings_;
  std::size_t next_goal_ = 0;
  std::size_t next_ = 0;  // next period to be measured
  bool measured_ = false;
  MeasuredMost most_{};
  bool truncated_ = false;
  std::optional<double> lost_after_{};
};

// A run as read from its files: the input of a report.

struct McapMessage;

/// Contents of run.mcap and timing.csv of one folder. Each column has one row per period, at
/// `time`, unless it has its own time column. A number that was not finite is NaN.
struct Recording {
  /// Output of the filter of a vision-localized robot: estimates, and detections by their verdict.
  struct Localization {
    std::vector<double> time, error, sigma, nees;   ///< [s]; of position [m]; of both (nees)
    std::vector<double> estimated_time, estimated;  ///< time of the exposures [s]; y^T S^-1 y
    std::vector<double> refused_time, refused;      ///< likewise, of rejected detections
  };
  /// A camera's detection of a body with tags (Detection).
  struct Sighted {
    double stamp = 0.0;      ///< of the exposure [s]
    std::size_t target = 0;  ///< index in `bodies`
    Vec3<double> p{};        ///< in S [m]
    Quaternion q{};          ///< no_attitude if only the position is known
  };
  struct Body {
    std::string name;
    std::string robot;  ///< name of the model; "body" for a body without control
    bool is_agent = false;
    std::vector<Vec3<double>> p;         ///< [m], one per period
    std::vector<double> heading;         ///< psi [rad], unwrapped, one per period
    std::vector<Vec3<double>> v;         ///< in G [m/s], one per period
    std::vector<Vec2<double>> lean{};    ///< true tilt, forward and left [-], one per period; 0 if not logged
    bool leans = false;                  ///< true tilt is logged: a vehicle, or a body-fixed camera
    std::vector<double> planned_time{};  ///< [s], increasing, one for each predicted path
    std::vector<Sight<double>>
        planned{};                     ///< pose and tilt planned for planned_time, PlannedAhead::ahead before
    std::vector<std::string> inputs;   ///< names of the inputs
    std::vector<double> u_min, u_max;  ///< at the start, one for each input
    std::vector<std::vector<double>> u;     ///< applied, [input][period]
    std::vector<double> reference_time;     ///< [s], every 0.1 s; empty: position and heading are free
    std::vector<Vec3<double>> reference_p;  ///< empty if the position is free
    std::vector<double> reference_heading;  ///< psi [rad], unwrapped; empty if the heading is free
    std::vector<double> barrier;            ///< 1 if the barrier acts, one per period; else empty
    std::optional<Camera> camera{};         ///< size and focal length
    std::optional<Tags> tags{};             ///< on the body
    std::vector<Sighted> sighted{};         ///< by its camera, in the order of arrival
    Localization localization{};            ///< empty if the robot is not vision-localized
    std::vector<double> reserve;            ///< the barrier's [m], one per period; NaN: no body near
  };
  /// An observer and its target, from the coupling with a sensor; a limit that no coupling sets is
  /// NaN.
  struct Pair {
    std::size_t observer = 0, target = 0;  ///< indices in `bodies`
    SensorMount mount{};
    double alpha = 0.0;  ///< limit of the view angle [rad]
    double d_min = 0.0, d_max = 0.0;
  };
  /// Two bodies with couplings that affect the same robots of the pair; a body that is not a robot
  /// is never affected.
  struct Coupled {
    std::size_t first = 0, second = 0;  ///< indices in `bodies`
    bool first_feels = false, second_feels = false;
  };
  struct Event {
    double time = 0.0;
    std::string kind;
    int controller = 0;
    double value = 0.0;
  };
  struct Controller {
    std::string name;
    std::vector<std::string> status;  ///< one per period
    std::vector<double> residual;
    std::vector<int> iterations;
    std::vector<double> pairs;  ///< of robots kept apart, one per period; empty without keep_apart
  };

  /// Flight of the same scenario with another solver, in a subfolder of the run.
  struct Comparison {
    std::string summary;  ///< text of its summary.json
    std::string solver;
    std::vector<double> solve_us;  ///< measured [us], one per period
  };

  std::string name, scenario, version, compiler, solver;
  std::uint64_t seed = 0;
  double period = 0.0;       ///< [s]
  std::size_t stride = 1;    ///< periods from one row to the next
  double last = 0.0;         ///< if stride > 1: start of the last period, which may have no row [s]
  std::vector<double> time;  ///< [s]
  std::vector<double> cost;  ///< stage cost l [-], one per period
  std::vector<Body> bodies;
  std::vector<Pair> pairs;
  std::vector<Coupled> couplings;
  std::vector<std::vector<std::size_t>> swarms;  ///< of each, indices in `bodies` of its robots
  std::vector<double> d_hard;                    ///< all distinct hard distances, increasing [m]
  double floor = std::numeric_limits<double>::quiet_NaN(),
         ceiling = floor;                        ///< of [safety], else NaN [m]
  std::vector<std::vector<Vec2<double>>> zones;  ///< polygons of [[safety.zone]] [m]
  std::vector<Controller> controllers;
  std::vector<Event> events;
  std::vector<std::string> script;      ///< names of the scenario's [[event]]s
  std::vector<double> solve_us;         ///< measured [us], sum of all controllers, one per row of timing.csv
  std::vector<Comparison> comparisons;  ///< sorted by solver name
  bool complete = true;                 ///< false: the log is truncated because the run was killed
  std::optional<double> lost_after{};   ///< last row before lost periods that the loop did not miss [s]

  double row_time() const { return static_cast<double>(stride) * period; }  ///< from one row to the next [s]
  /// Duration of the run [s]; 0 without rows.
  double end() const { return time.empty() ? 0.0 : (stride > 1 ? last : time.back()) + period; }
};

/// Reads a run's folder; for a killed run, the intact part of the log. Rejects a log with a missing
/// or duplicate message that each period must have once.
/// @param visitor  receives each message of run.mcap after it is read; so its data matches the
///   recording, also for a growing log
/// @param stride   periods from one row to the next, >= 1
/// @throws std::runtime_error with a sentence that names the file, if it cannot be read
Recording read_recording(const std::filesystem::path& folder,
                         const std::function<void(const McapMessage&)>& visitor = {}, std::size_t stride = 1);

/// Reads a run's folder incrementally while the run is still being written.
class RecordingReader {
 public:
  /// Reads the metadata of the log, no rows yet.
  /// @throws as read_recording()
  explicit RecordingReader(const std::filesystem::path& folder, std::size_t stride = 1);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  /// Reads what was written since the last call.
  /// @param visitor  receives each message after it is read
  /// @throws as read_recording()
  void read_on(const std::function<void(const McapMessage&)>& visitor = {});

  /// The recording so far. The first rows() rows of each column are complete; some columns are
  /// longer. Headings are as logged, not unwrapped; there are no comparisons.
  const Recording& run() const;
  std::size_t rows() const;

 private:
  friend Recording read_recording(const std::filesystem::path& folder,
                                  const std::function<void(const McapMessage&)>& visitor, std::size_t stride);
  class Files;
  std::unique_ptr<Files> files_;
};

// Replay of a recorded flight: gives the same measurements to the same loop and compares its
// commands with the log.

/// How a recorded run was flown, from its log.
struct FlownAs {
  std::string name, text;  ///< of the scenario; text includes the tuned events at its end
  FileTexts files{};       ///< that the scenario names
  std::string solver;
  std::string version, compiler;
  std::string partition{}, order{};  ///< for a partitioned team; else empty
  int exchanges = 1;
};
/// Reads it from the metadata of a log.
/// @throws std::runtime_error with a sentence that names the file, if it is no log of a run
FlownAs flown_as(const std::filesystem::path& log);

/// The scenario of a log as it was flown, or with another solver or other values. Deadlines are
/// off, and there are no comparison flights. Signals from outside arrive when events occurred by
/// them.
/// @param log  path of the log
/// @param set  as in ScenarioChanges
/// @throws ScenarioError, std::invalid_argument as solver_named() and check_solvers(), and
///   std::runtime_error if the log cannot be read
Scenario flown_scenario(const FlownAs& flown, const std::filesystem::path& log, const Registry& registry,
                        const std::optional<std::string>& solver = {},
                        const std::vector<std::string>& set = {});

/// First command that differs from the recorded one.
struct FirstDifference {
  std::int64_t update = 0;  ///< number of the period since the start of the flight
  double time = 0.0;        ///< [s]
  std::string robot, input;
  double recorded = 0.0, replayed = 0.0;
};

/// First pose estimate that differs from the recorded one.
struct FirstEstimate {
  std::int64_t update = 0;  ///< number of the period since the start of the flight
  double time = 0.0;        ///< [s]
  std::string robot, what;  ///< "p.x", "covariance"; "known" if only one of them has an estimate
  double recorded = 0.0, replayed = 0.0;
};

/// Difference between the commands of one robot and the recorded ones.
struct RobotDifference {
  std::string name;
  std::int64_t differing = 0;       ///< number of commands with a different bit
  double largest = 0.0, rms = 0.0;  ///< of an input, over all commands
  double largest_at = 0.0;          ///< [s]
};

/// Compares each command and each pose estimate of a replay with the log, bit for bit; allocates
/// nothing.
class CommandComparison final : public Sink<Sample> {
 public:
  /// @param prototype  sized_sample() of the loop
  CommandComparison(const RecordedFlight& flight, Sample prototype);

  Sample* claim() noexcept override { return &sample_; }
  void publish() noexcept override;
  void close() noexcept override {}

  std::int64_t updates() const noexcept { return static_cast<std::int64_t>(updates_); }
  std::int64_t commands() const noexcept;
  std::int64_t differing() const noexcept;
  /// Number of updates with a different solver status.
  std::int64_t other_status() const noexcept { return other_status_; }
  std::optional<FirstDifference> first() const;
  /// Number of pose estimates, and number of those with a different bit.
  std::int64_t estimates() const noexcept { return estimates_; }
  std::int64_t differing_estimates() const noexcept { return differing_estimates_; }
  std::optional<FirstEstimate> first_estimate() const;
  /// One for each robot, in the order of the team.
  std::vector<RobotDifference> robots() const;

 private:
  struct Robot {
    BodyId body;
    std::size_t u, nu;
    std::int64_t differing = 0;
    double largest = 0.0, largest_at = 0.0, squares = 0.0;
  };

  void compare_estimates(const RecordedPeriod& recorded) noexcept;

  const RecordedFlight& flight_;
  Sample sample_;
  std::vector<Robot> robots_;
  std::int64_t estimates_ = 0, differing_estimates_ = 0;
  struct EstimatePlace {
    std::size_t update;
    BodyId robot;
    std::size_t what;
    double recorded, replayed;
  };
  std::optional<EstimatePlace> first_estimate_{};
  std::size_t updates_ = 0;
  std::int64_t other_status_ = 0;
  struct Place {
    std::size_t update, robot, input;
    double replayed;
  };
  std::optional<Place> first_{};
};

/// Results of the comparison as JSON; docs/replay.md lists the keys.
std::string comparison_json(const CommandComparison& compared, const Scenario& scenario,
                            const RecordedFlight& flight);

}  // namespace sightline
