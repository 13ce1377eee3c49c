/// What the trigger of an event is asked about: what is known at a time, and the event's own past.
#pragma once

#include <span>

#include "sightline/base/index.hpp"
#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

/// What is known at a time.
struct EventContext {
  double t = 0.0;                      ///< [s]
  std::span<const double> x;           ///< states of all bodies (nx)
  std::span<const double> u;           ///< inputs of all robots (nu)
  std::span<const double> ages;        ///< of each body [s]; empty: all is new
  std::span<const Presence> presence;  ///< of each body; conditions on one that is absent do not hold
};

/// What an event remembers of its condition.
struct ConditionState {
  bool holds = false;  ///< the condition, with its hysteresis
  bool fired = false;  ///< since it came to hold
  double since = 0.0;  ///< when it came to hold [s]
};

class ViewChooser;

/// What is known when an event is asked whether it happens.
struct EventInstant {
  const Team& all;
  const EventContext& known;
  double began;    ///< its stage [s]
  bool signalled;  ///< a signal of it came since the moment before
  ConditionState& condition;
  std::span<const ViewChooser> choosers{};  ///< of the script's choices

  bool is_there(BodyId body) const noexcept {
    return known.presence.empty() || known.presence[at(body)] != Presence::absent;
  }
  bool is_steered(BodyId body) const noexcept {
    return known.presence.empty() || known.presence[at(body)] == Presence::steered;
  }
  double age(BodyId body) const noexcept { return known.ages.empty() ? 0.0 : known.ages[at(body)]; }
  Sight<double> sight(BodyId body) const noexcept {
    const double* const u = all.is_agent(body) ? known.u.data() + all.input_offset(body) : nullptr;
    return all.model(body).sight(known.x.data() + all.state_offset(body), u);
  }
};

}  // namespace sightline
