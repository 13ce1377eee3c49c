/// Waits for a flight on a separate thread while other Python threads run.
#pragma once

#include <atomic>
#include <chrono>
#include <future>

#include "python/bindings.hpp"
#include "sightline/base.hpp"

namespace sightline::python {

/// Waits and checks for Ctrl-C meanwhile. On Ctrl-C, or if `progress` raises, it sets `stop`, waits
/// for the flight to end, and rethrows.
/// @param reported  argument of `progress`
/// @param progress  called a few times a second; None: no calls
template <class Result, class Reported>
Result waited_for(std::future<Result>& flight, std::atomic<bool>& stop, const std::atomic<Reported>& reported,
                  const py::object& progress) {
  constexpr auto interval = std::chrono::milliseconds(50);
  const auto ended = [&](bool to_the_end) {
    const py::gil_scoped_release others_run;
    if (to_the_end) flight.wait();
    return flight.wait_for(interval) == std::future_status::ready;
  };
  while (!ended(false)) {
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none()) progress(reported.load());
    } catch (...) {
      stop = true;
      ended(true);
      throw;
    }
  }
  return flight.get();
}

}  // namespace sightline::python
