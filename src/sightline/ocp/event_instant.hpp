/// Whether a trigger occurs, by the state of a period and the history of its event.
#pragma once

#include <span>

#include "sightline/base/index.hpp"
#include "sightline/ocp/event.hpp"
#include "sightline/ocp/surroundings.hpp"

namespace sightline {

/// State of a period.
struct EventContext {
  double t = 0.0;                      ///< [s]
  std::span<const double> x;           ///< states of all bodies (nx)
  std::span<const double> u;           ///< inputs of all robots (nu)
  std::span<const double> ages;        ///< of the last measurement of each body [s]; empty: all 0
  std::span<const Presence> presence;  ///< of each body; conditions on an absent body do not hold
};

/// History of an event's condition.
struct ConditionState {
  bool holds = false;  ///< the condition, with its hysteresis
  bool fired = false;  ///< since it last began to hold
  double since = 0.0;  ///< when it began to hold [s]
};

/// State of a period at which a trigger is evaluated.
struct EventInstant {
  const Team& all;
  const EventContext& known;
  double began;    ///< begin of its stage [s]
  bool signalled;  ///< its signal arrived since the last evaluation
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

/// To be called once in each period; neither allocates nor throws.
bool occurs(const Trigger& trigger, const EventInstant& now) noexcept;

}  // namespace sightline
