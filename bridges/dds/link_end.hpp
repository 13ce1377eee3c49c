/// Our end of the link to one robot, whatever it speaks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/delay_histogram.hpp"
#include "bridges/dds/link_machine.hpp"
#include "bridges/dds/pose_subscriber.hpp"
#include "bridges/dds/robot_state.hpp"
#include "bridges/dds/surroundings.hpp"

namespace sightline::dds {

/// look(), facts() and send() are the control thread's: they allocate, lock, throw and print nothing. The others may.
class LinkEnd {
 public:
  virtual ~LinkEnd() = default;

  /// The newest motion. @return false where there was none yet
  virtual bool look(SeenMotion& seen) noexcept = 0;
  virtual LinkFacts facts(Nanoseconds now) noexcept = 0;
  /// Sends what is to be sent; `command` counts for Setpoint::task.
  virtual void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept = 0;

  /// Takes note of who else is there; a few times a second, by one thread.
  virtual void watch(std::span<const SeenWriter> writers) = 0;
  /// What is found of it before a flight: what it is flown by, and what keeps it from being armed. By the thread that looks; it
  /// may allocate.
  virtual void examine(const Surroundings& around, FindingList& to) = 0;
  /// Ends what serves examine() alone: before it is to arm.
  virtual void stop_examining() {}
  /// By what it is known where it is, and how it moves.
  virtual PoseSubscriber& subscriber() noexcept = 0;
  /// Where on earth its local frame begins, where it says.
  virtual std::optional<GeoPoint> reference() const { return std::nullopt; }
  /// What was received and refused, in words.
  virtual std::string counts() const = 0;
  /// From the stamps of its poses to us, where its clock is ours; none otherwise.
  virtual const DelayHistogram* arrivals() const noexcept { return nullptr; }
};

/// Of the kind that the link says.
/// @throws std::invalid_argument for a model that is not flown so, std::runtime_error where a topic cannot be had
std::unique_ptr<LinkEnd> made_end(const Port& at, const Link& link, std::string_view name, const Model& model,
                                  const FleetNetwork& network);

}  // namespace sightline::dds
