/// Topics of a run's log, period by period.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/judge/present_team.hpp"
#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/record/camera_log.hpp"
#include "sightline/record/localization_log.hpp"
#include "sightline/record/tuned_log.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Converts samples to the messages of run.mcap (log_table.hpp), for the log and for
/// subscribers.
class LogTopics {
 public:
  /// Opens the topics.
  /// @param controllers  number of solver records in each sample
  /// @param to           receives the messages; must outlive this object
  LogTopics(const Scenario& scenario, std::size_t controllers, MessageSink& to);

  /// Adds a sample; allocates nothing once the buffers have reached their final size.
  /// @param present  the team at the sample; must have processed the sample with follow()
  /// @param cost     stage cost of the sample; NaN if unknown
  /// @return true for the first sample in each 0.1 s of simulated time
  bool add(const Sample& sample, const PresentTeam& present, double cost);
  /// Adds a sample without an update.
  void add_states(const Sample& sample);

 private:
  struct BodyChannels {
    BodyId body;
    StateRoles roles;
    McapChannel state, pose, twist;
    std::optional<McapChannel> measured{}, input{}, path{}, reference{}, barrier{}, view{}, attitude{};
    std::size_t robot = 0;  // index among the robots
  };

  void open_body(BodyId body, bool is_measured, bool has_barrier);
  void send_bytes(McapChannel& channel, double time) {
    to_.message(channel.id, channel.sequence++, nanoseconds(time), bytes_);
  }

  void add_body(BodyChannels& channels, const Sample& sample);
  void add_place(BodyChannels& channels, const Sample& sample);
  void open_attitudes(const Scenario& scenario);
  void add_attitude(BodyChannels& channels, const Sample& sample);
  void add_pose(McapChannel& channel, const Model& model, const double* x, double time);
  void add_agent(BodyChannels& channels, const Sample& sample);
  void add_path(BodyChannels& channels, const Sample& sample);
  void add_reference(BodyChannels& channels, const PresentTeam& present, double time);
  void add_barrier(BodyChannels& channels, const Sample& sample);
  void add_view(BodyChannels& channels, const Sample& sample);
  void add_records(const Sample& sample, double cost);
  void add_events(const Sample& sample);

  Team team_;
  MessageSink& to_;
  struct Schemas {
    SchemaId pose, twist, path, state, input, reference, solver, event, barrier;
    std::optional<SchemaId> view, attitude;
  } schemas_{};
  std::vector<BodyChannels> bodies_;
  std::size_t robots_ = 0;
  std::vector<McapChannel> solvers_;
  McapChannel events_;
  std::optional<MeasurementLog> measurements_;
  std::optional<LocalizationLog> localization_;
  std::optional<CameraLog> cameras_;
  std::optional<TunedLog> tuned_;
  std::int64_t tenth_ = -1;  // index of the 0.1 s of simulated time that contains the last sample

  std::vector<std::byte> bytes_;
  LogMessage message_{to_};
  std::vector<StampedPose> path_;
  std::vector<double> x_ref_, no_input_;
};

}  // namespace sightline
