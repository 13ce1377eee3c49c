/// Live page of a flight.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/page_server.hpp"
#include "sightline/server/tuning.hpp"

namespace sightline {

/// Serves the page of a flight, and the topics of its log to Foxglove. The loop passes its samples
/// through a queue. One thread converts the newest sample into a state 30 times a second; another
/// thread sends it. The loop waits for neither: if the queue is full, samples are dropped and
/// counted.
class FlightPage {
 public:
  static constexpr double interval = 1.0 / 30;  ///< between two states [s]

  /// @param prototype  a sample with the sizes of the loop's samples
  /// @param tuning  receives the watchers' messages; must outlive this object; null: the page is
  ///   read-only
  /// @throws std::invalid_argument as PageServer
  FlightPage(const Scenario& scenario, const Sample& prototype, const ServeOptions& options = {},
             Tuning* tuning = nullptr);
  ~FlightPage();
  FlightPage(const FlightPage&) = delete;
  FlightPage& operator=(const FlightPage&) = delete;

  /// Called by the flight's thread: does not allocate, lock or wait.
  void show(const Sample& sample) noexcept;

  /// Adds or replaces the file of a path. For any thread.
  void put(std::string_view path, PageFile file);

  const std::string& url() const;
  /// The options in use, with the actual port and token, so that another page can take its place.
  ServeOptions served() const;
  ServeCounts counts() const;
  /// Samples that were dropped because the queue was full.
  std::int64_t dropped() const noexcept;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
