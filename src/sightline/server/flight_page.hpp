/// A flight that is looked at while it is flown.
#pragma once

#include <memory>
#include <string>

#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/server/page_server.hpp"
#include "sightline/server/tuning.hpp"

namespace sightline {

/// Serves the page of a flight, and to Foxglove the topics that its log has. The loop hands its samples over; a thread of its own makes of the newest what watchers see, 30 times a
/// second, and another one sends it. Neither is waited for: where the first is held up, samples are dropped and counted.
class FlightPage {
 public:
  static constexpr double interval = 1.0 / 30;  ///< between two states [s]

  /// @param prototype  sized as the loop's samples are
  /// @param tuning     hears those who look on, and outlives this; none: the page is read-only
  /// @throws std::invalid_argument as PageServer
  FlightPage(const Scenario& scenario, const Sample& prototype, const ServeOptions& options = {},
             Tuning* tuning = nullptr);
  ~FlightPage();
  FlightPage(const FlightPage&) = delete;
  FlightPage& operator=(const FlightPage&) = delete;

  /// By the thread that flies: allocates nothing, locks nothing, waits for nobody.
  void show(const Sample& sample) noexcept;

  const std::string& url() const;
  /// As it is served, with the port and the token that it has, so that another page can take its place.
  ServeOptions served() const;
  ServeCounts counts() const;
  /// Samples that were not shown because the thread was held up.
  std::int64_t dropped() const noexcept;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
