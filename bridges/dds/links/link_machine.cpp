#include "bridges/dds/links/link_machine.hpp"

#include <algorithm>
#include <utility>

namespace sightline::dds {
namespace {

template <std::size_t n, class Enum>
std::string_view word_of(const std::array<std::string_view, n>& words, Enum value) {
  const auto place = static_cast<std::size_t>(value);
  return place < n ? words[place] : "?";
}

/// Condition of a row.
enum class When {
  emergency,  // orders from here
  handed_over,
  to_land,
  to_take_off,  // and the minimum time in ready has passed
  to_hold,
  to_task,
  ready,  // facts from here
  armed,
  armed_to_land,
  disarmed,
  disarmed_on_ground,
  refused,
  failsafe,
  taken,  // another mode is active
  taken_after_takeoff,
  not_offboard,
  offboard,
  contested,
  restarted,
  unfit,  // in `ready` only with an order to take off
  lost,
  gone,        // lost for long
  late,        // the maximum time of the state has passed
  unanswered,  // offboard was requested and its time limit has passed
};

}  // namespace

std::string_view to_string(LinkState state) {
  static constexpr std::array<std::string_view, link_states> words = {
      "waiting", "ready", "arming", "taking_off", "flying", "holding", "landing", "done", "pilot"};
  return word_of(words, state);
}

std::string_view to_string(LinkReason reason) {
  static constexpr std::array<std::string_view, link_reasons> words = {
      "as requested",
      "it was not ready in time",
      "it refused to arm",
      "it did not arm in time",
      "it refused the request",
      "it took too long",
      "it was disarmed",
      "nothing came from it any more",
      "a pilot has it",
      "its failsafe has it",
      "it waited too long for its task",
      "its task had no end",
      "it did not land in time",
      "it is left to its autopilot",
      "another program writes set-points to it",
      "it was restarted, or another one speaks in its place",
      "its battery is low",
      "its estimator is not valid",
      "its estimator jumped too far",
      "its motors were stopped by the operator",
      "poses come, but their stamps do not rise",
      "it is not at its start",
      "its poses are late by its radio",
      "it left the place of its take-off"};
  return word_of(words, reason);
}

struct LinkMachine::Row {
  unsigned from;  // a set of states, one bit each
  When when;
  LinkState to;
  LinkReason why;
};

bool LinkMachine::holds(const Row& row, const LinkFacts& f, LinkOrder order, double t) const noexcept {
  const bool takes_off = order >= LinkOrder::take_off && order < LinkOrder::land;
  switch (row.when) {
    case When::emergency:
      return order == LinkOrder::emergency;
    case When::handed_over:
      return order == LinkOrder::hand_over;
    case When::to_land:
      return order == LinkOrder::land;
    case When::to_take_off:
      return t - since_ >= times_.received && takes_off;
    case When::to_hold:
      return order == LinkOrder::hold;
    case When::to_task:
      return order == LinkOrder::task;
    case When::ready:
      return f.there && f.checked && !f.armed && !f.contested && f.mode != AutopilotMode::offboard;
    case When::armed:
      return f.armed;
    case When::armed_to_land:
      return f.armed && order == LinkOrder::land;
    case When::disarmed:
      return !f.armed && (state_ != LinkState::landing || !f.landed);
    case When::disarmed_on_ground:
      return !f.armed && f.landed &&
             (f.mode != AutopilotMode::offboard ||
              (requested_ == Request::hold && t - first_requested_at_ >= times_.offboard));
    case When::refused:
      return f.refused;
    case When::failsafe:
      return f.failsafe;
    case When::taken:
      return f.mode == AutopilotMode::other && (state_ != LinkState::landing || !f.landed);
    case When::taken_after_takeoff:
      return took_off_ && f.mode == AutopilotMode::other;
    case When::not_offboard:
      return f.mode != AutopilotMode::offboard;
    case When::offboard:
      return requested_ == Request::offboard && f.mode == AutopilotMode::offboard;
    case When::restarted:
      return f.restarted;
    case When::contested:
      return f.contested;
    case When::unfit:
      return f.unfit != LinkReason::as_requested && (state_ != LinkState::ready || takes_off);
    case When::lost:
      return !f.there;
    case When::gone:
      return t - there_at_ >= times_.gone;
    case When::late:
      return t - since_ >= longest(state_);
    case When::unanswered:
      return requested_ == Request::offboard && t - first_requested_at_ >= times_.offboard;
  }
  return false;
}

double LinkMachine::longest(LinkState state) const noexcept {
  switch (state) {
    case LinkState::waiting:
      return times_.ready;
    case LinkState::ready:
      return times_.called;
    case LinkState::arming:
      return times_.arming;
    case LinkState::taking_off:
      return times_.takeoff;
    case LinkState::flying:
      return times_.task;
    case LinkState::holding:
      return times_.holding;
    case LinkState::landing:
      return times_.landing;
    default:
      return 0.0;
  }
}

void LinkMachine::request(Request request, double t, const LinkFacts& facts, LinkOutput& output) noexcept {
  const bool anew = std::exchange(requested_, request) != request,
             over = request != Request::land && (facts.answered || attempts_ == times_.attempts);
  if (anew) attempts_ = 0, first_requested_at_ = t;
  if (!anew && (over || t - requested_at_ < times_.again)) return;
  ++attempts_;
  requested_at_ = t;
  output.request = request;
}

// The first row of the state whose condition holds is taken. No row leaves done or pilot.
const std::array<LinkMachine::Row, 38> LinkMachine::table = [] {
  using S = LinkState;
  using R = LinkReason;
  constexpr auto bit = [](S state) { return 1U << static_cast<unsigned>(state); };
  constexpr unsigned waiting = bit(S::waiting), ready = bit(S::ready), arming = bit(S::arming),
                     taking_off = bit(S::taking_off), holding = bit(S::holding), flying = bit(S::flying),
                     landing = bit(S::landing), steered = holding | flying, in_air = taking_off | steered,
                     unarmed = waiting | ready, ours = arming | in_air | landing;
  return std::array<Row, 38>{{
      {unarmed, When::emergency, S::done, R::as_requested},
      {ours, When::emergency, S::done, R::emergency},
      {unarmed | ours, When::handed_over, S::done, R::handed_over},
      {unarmed, When::to_land, S::done, R::as_requested},
      {ours, When::restarted, S::done, R::restarted},

      {waiting, When::ready, S::ready, R::as_requested},
      {waiting, When::late, S::done, R::not_ready},

      {ready, When::lost, S::done, R::silent},
      {ready, When::armed, S::pilot, R::pilot},
      {ready, When::contested, S::done, R::contested},
      {ready, When::unfit, S::done, R::as_requested},
      {ready, When::to_take_off, S::arming, R::as_requested},
      {ready, When::late, S::done, R::no_task},

      {arming, When::armed_to_land, S::landing, R::as_requested},
      {arming, When::armed, S::taking_off, R::as_requested},
      {arming, When::refused, S::done, R::arming_refused},
      {arming, When::late, S::done, R::no_answer},

      {in_air, When::disarmed, S::done, R::disarmed},
      {in_air, When::failsafe, S::pilot, R::failsafe},
      {taking_off, When::taken_after_takeoff, S::pilot, R::pilot},
      {steered, When::not_offboard, S::pilot, R::pilot},
      {in_air, When::to_land, S::landing, R::as_requested},
      {taking_off, When::refused, S::landing, R::refused},
      {in_air, When::contested, S::landing, R::contested},
      {in_air, When::unfit, S::landing, R::as_requested},
      {in_air, When::lost, S::landing, R::silent},
      {taking_off, When::offboard, S::holding, R::as_requested},
      {taking_off, When::unanswered, S::landing, R::refused},
      {taking_off, When::late, S::landing, R::too_long},
      {holding, When::to_task, S::flying, R::as_requested},
      {holding, When::late, S::landing, R::no_task},
      {flying, When::to_hold, S::holding, R::as_requested},
      {flying, When::late, S::landing, R::no_end},

      {landing, When::disarmed_on_ground, S::done, R::as_requested},
      {landing, When::disarmed, S::done, R::disarmed},
      {landing, When::taken, S::pilot, R::pilot},
      {landing, When::gone, S::done, R::silent},
      {landing, When::late, S::done, R::did_not_land},
  }};
}();

LinkOutput LinkMachine::step(double t, const LinkFacts& facts, LinkOrder order) noexcept {
  if (!std::exchange(begun_, true)) since_ = there_at_ = t;
  if (facts.there) there_at_ = t;
  took_off_ |= state_ == LinkState::taking_off && facts.mode == AutopilotMode::takeoff;
  LinkOutput output;
  const auto row =
      std::find_if(table.begin(), table.end(), [&, here = 1U << static_cast<unsigned>(state_)](const Row& r) {
        return (r.from & here) != 0 && holds(r, facts, order, t);
      });
  if (row != table.end()) {
    if (row->why == LinkReason::emergency) output.request = Request::emergency;
    state_ = row->to;
    since_ = t;
    if (reason_ == LinkReason::as_requested) reason_ = row->when == When::unfit ? facts.unfit : row->why;
  }
  const bool offboard = facts.mode == AutopilotMode::offboard;
  const bool idle = !facts.armed && facts.landed;
  switch (state_) {
    case LinkState::waiting:
      if (!facts.there || !idle || facts.contested) break;
      if (offboard)
        request(Request::hold, t, facts, output);
      else if (facts.unplaced)
        request(Request::origin, t, facts, output);
      break;
    case LinkState::arming:
      request(Request::arm, t, facts, output);
      break;
    case LinkState::taking_off:
      if (requested_ == Request::offboard || (facts.airborne && order >= LinkOrder::hold))
        request(Request::offboard, t, facts, output);
      else if (requested_ != Request::take_off || facts.landed)
        request(Request::take_off, t, facts, output);
      break;
    case LinkState::landing:
      if (idle || facts.mode != AutopilotMode::land || requested_ != Request::land)
        request(idle ? Request::hold : Request::land, t, facts, output);
      if (offboard && !idle) output.setpoint = Setpoint::zero;
      break;
    case LinkState::holding:
      output.setpoint = flown_ ? Setpoint::zero : Setpoint::climb;
      break;
    case LinkState::flying:
      flown_ = true;
      output.setpoint = Setpoint::task;
      break;
    default:
      break;
  }
  const bool lands_by_itself = state_ == LinkState::landing && facts.mode == AutopilotMode::land;
  output.heartbeat = (state_ == LinkState::ready || in_our_hands()) && !lands_by_itself;
  return output;
}

}  // namespace sightline::dds
