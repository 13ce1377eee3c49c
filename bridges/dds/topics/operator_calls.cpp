#include "bridges/dds/topics/operator_calls.hpp"

namespace sightline::dds {
namespace {

constexpr CallAnswer is_over = {false, "the flight is over"};

}  // namespace

CallAnswer OperatorCalls::start() noexcept {
  switch (phase_.load()) {
    case FlightPhase::checking:
      return {false, "not all robots are ready yet"};
    case FlightPhase::waiting:
      if (to_land()) return {false, "they were commanded to land"};
      started_ = true;
      return {true, "they take off"};
    case FlightPhase::over:
      return is_over;
    default:
      return {false, "they have taken off already"};
  }
}

CallAnswer OperatorCalls::stop() noexcept {
  if (phase_.load() == FlightPhase::over) return is_over;
  if (phase_.load() != FlightPhase::task)
    return {false, "there is no task now; land ends a flight at any time"};
  land_ = true;
  return {true, "the task ends, all land"};
}

CallAnswer OperatorCalls::land() noexcept {
  if (phase_.load() == FlightPhase::over) return is_over;
  land_ = true;
  return {true, "all land"};
}

CallAnswer OperatorCalls::emergency() noexcept {
  if (phase_.load() == FlightPhase::over) return is_over;
  emergency_ = true;
  land_ = true;
  return {true, "the motors of all robots stop that this program armed"};
}

}  // namespace sightline::dds
