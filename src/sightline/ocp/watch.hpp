/// When the events of a script happen: looks at the world once each period.
#pragma once

#include <atomic>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/ocp/event.hpp"
#include "sightline/ocp/roster.hpp"

namespace sightline {

class Watch {
 public:
  /// @param all  the bodies of the script
  Watch(const Script& script, const Team& all);

  /// What is known at a time.
  struct View {
    double t = 0.0;                      ///< [s]
    std::span<const double> x;           ///< states of all bodies (nx)
    std::span<const double> u;           ///< inputs of all robots (nu)
    std::span<const double> ages;        ///< of each body [s]; empty: all is new
    std::span<const Presence> presence;  ///< of each body; conditions on one that is absent do not hold
  };
  /// The events that happen now, in their order; a stage that one of them enters begins now. Allocates nothing.
  /// @return indices in the script, valid until the next call
  std::span<const std::size_t> look(const View& view) noexcept;

  /// From any thread: the message is there; the events that wait for it happen at the next look.
  /// @return whether an event of the script has this signal
  bool signal(std::string_view name) noexcept;

  std::string_view stage() const noexcept { return stages_[stage_]; }

 private:
  struct State {
    std::size_t stage = 0, enter = 0;  // in stages_, 0: none
    bool over = false;
    bool holds = false;  // the condition, with its hysteresis
    bool told = false;   // since it came to hold
    double since = 0.0;  // when it came to hold [s]
  };

  std::size_t stage_of(const std::string& name);
  bool happens(std::size_t event, const View& view) noexcept;
  bool comes_about(const Condition& when, State& state, const View& view) noexcept;

  Script script_;
  Team all_;
  std::vector<std::string> stages_;  // the first is no stage
  std::vector<State> states_;
  std::deque<std::atomic<bool>> signals_;  // of each event
  std::vector<std::size_t> happening_;
  std::size_t stage_;
  double stage_began_ = 0.0;
};

}  // namespace sightline
