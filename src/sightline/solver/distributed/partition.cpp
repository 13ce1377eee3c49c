#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/base/character.hpp"
#include "sightline/base/nearest.hpp"
#include "sightline/base/now.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

constexpr std::string_view around_names = " \t\n";

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Checks that every robot is in exactly one subteam.
void check(const Partition& partition, const Team& team) {
  if (partition.empty()) throw_invalid("the partition has no part, expected at least one");
  std::vector<int> taken(at(team.bodies()), 0);
  for (const std::vector<AgentId>& subteam : partition) {
    if (subteam.empty())
      throw_invalid("the partition has a part without robots, expected at least one in each");
    for (const AgentId agent : subteam) {
      if (agent.index < 0 || agent.index >= team.bodies() || !team.is_agent(agent))
        throw_invalid("the partition names body {}, expected a robot of the team", agent.index);
      if (++taken[at(agent.index)] > 1)
        throw_invalid("the partition names \"{}\" twice, expected every robot in one part", team.name(agent));
    }
  }
  for (int i = 0; i < team.bodies(); ++i) {
    if (team.is_agent(BodyId{i}) && taken[at(i)] == 0)
      throw_invalid("the partition leaves out \"{}\", expected every robot in one part",
                    team.name(BodyId{i}));
  }
}

/// The worse of two statuses: the later one in the list of Status.
Status worse(Status a, Status b) { return std::max(a, b); }

}  // namespace

std::string_view to_string(ExchangeOrder order) {
  return order == ExchangeOrder::jacobi ? "jacobi" : "gauss_seidel";
}

ExchangeOrder exchange_order(std::string_view word) {
  for (const ExchangeOrder order : {ExchangeOrder::jacobi, ExchangeOrder::gauss_seidel}) {
    if (word == to_string(order)) return order;
  }
  throw_invalid("order = \"{}\", expected jacobi or gauss_seidel", word);
}

std::vector<PartSpec> parse_parts(std::string_view text) {
  std::vector<PartSpec> parts;
  for (std::string_view words : split(text, '|')) {
    words = trimmed(words, around_names);
    PartSpec part;
    if (const auto colon = words.find(':'); colon != words.npos) {
      const std::string_view name = trimmed(words.substr(0, colon), around_names);
      if (std::any_of(parts.begin(), parts.end(), [&](const PartSpec& one) { return one.name == name; }))
        throw_invalid("partition = \"{}\" has part \"{}\" twice, expected each name once", text, name);
      part.name = name;
      words = trimmed(words.substr(colon + 1), around_names);
    }
    if (!words.empty())
      for (const std::string_view word : split(words, ','))
        part.robots.emplace_back(trimmed(word, around_names));
    parts.push_back(std::move(part));
  }
  return parts;
}

Partition read_partition(std::string_view text, const Team& team) {
  std::vector<std::string_view> names;
  for (const Agent& agent : team.agents()) names.push_back(agent.name);
  if (names.empty()) throw_invalid("the team has no robot, expected at least one");
  Partition partition;
  for (const PartSpec& part : parse_parts(text)) {
    if (part.robots.empty())
      throw_invalid("partition = \"{}\" has a part without robots, expected at least one in each", text);
    std::vector<AgentId>& subteam = partition.emplace_back();
    for (const std::string& word : part.robots) {
      const BodyId body = word.empty() ? BodyId{} : team.find(word);
      if (body.index < 0 || !team.is_agent(body)) {
        throw_invalid("partition = \"{}\": \"{}\" is no robot of the team, expected one{}", text, word,
                      hint(word, names));
      }
      subteam.push_back(AgentId{body});
    }
  }
  check(partition, team);
  return partition;
}

void check_options(const PartitionOptions& options) {
  if (options.exchanges < 1 || options.exchanges > 1000)
    throw_invalid("exchanges = {}, expected 1 to 1000", options.exchanges);
  if (options.messages && (options.order != ExchangeOrder::jacobi || options.exchanges != 1))
    throw_invalid("order = {}, exchanges = {}, expected jacobi and 1 where messages take time",
                  to_string(options.order), options.exchanges);
  if (options.threads < 1 || options.threads > ThreadPool::most)
    throw_invalid("threads = {}, expected 1 to {}", options.threads, ThreadPool::most);
  if (options.threads > 1 && options.order == ExchangeOrder::gauss_seidel)
    throw_invalid(
        "threads = {}, expected 1 in gauss_seidel order, where each part waits for the one before, or jacobi",
        options.threads);
}

PartitionedSolver::PartitionedSolver(const Team& whole_team, const Partition& partition,
                                     const MakeSolver& make, const PartitionOptions& options)
    : options_((check_options(options), options)), pool_(options.threads) {
  check(partition, whole_team);
  whole_ = make(whole_team);
  whole_planner_ = &team_planner_of(*whole_, "a team that plans in parts");
  const Team& team = whole_->ocp().team();
  for (const std::vector<AgentId>& own : partition) {
    Member member;
    member.subteam = std::make_unique<Subteam>(team, own, make);
    member.u.resize(at(member.subteam->ocp().nu()));
    for (std::vector<double>* u : {&member.before, &member.u_ref}) u->resize(member.u.size());
    member.lean.resize(at(member.subteam->ocp().team().bodies()));
    members_.push_back(std::move(member));
  }
  part_of_.resize(at(team.bodies()), -1);
  std::vector<std::vector<Prediction>> received;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    for (const AgentId robot : partition[i]) part_of_[at(robot.index)] = static_cast<int>(i);
    const auto predictions = members_[i].subteam->predictions();
    received.emplace_back(predictions.begin(), predictions.end());
  }
  if (options.messages) messages_.emplace(*options.messages, whole_->ocp().horizon(), received);
  x_now_.resize(at(team.nx()));
  for (std::vector<double>* u : {&u_, &raw_u_, &u_stage_}) u->resize(at(team.nu()));
  x_.resize(at(team.nx()) * at(whole_->ocp().horizon().N + 1));
}

bool PartitionedSolver::accepts(double time, std::span<const double> states) noexcept {
  if (!std::isfinite(time) || states.size() != x_now_.size()) return false;
  std::copy(states.begin(), states.end(), x_now_.begin());
  const Team& team = ocp().team();
  for (int b = 0; b < team.bodies(); ++b) {
    if (!team.model(BodyId{b}).normalise(&x_now_[at(team.state_offset(BodyId{b}))])) return false;
  }
  return true;
}

void PartitionedSolver::send(const Member& sender) noexcept {
  for (const Prediction& prediction : sender.subteam->predictions()) {
    for (const Member& other : members_) {
      if (&other != &sender) other.subteam->receive(prediction);
    }
  }
}

void PartitionedSolver::send_all(double time, std::span<const double> states) noexcept {
  if (states.size() != x_now_.size()) return;
  for (const Member& member : members_) member.subteam->predict(time, states);
  for (const Member& member : members_) send(member);
}

/// Simulates the message exchange before the first update: each part then knows clock offsets and
/// poses.
void PartitionedSolver::talk_before(double time, std::span<const double> states) noexcept {
  const double dt = ocp().horizon().dt;
  for (const Member& member : members_) member.subteam->predict(time, states);
  for (int k = messages_->talk_periods(); k > 0; --k) {
    const double t = time - k * dt;
    for (int to = 0; to < static_cast<int>(members_.size()); ++to) messages_->receive(to, t);
    for (std::size_t i = 0; i < members_.size(); ++i)
      messages_->send(static_cast<int>(i), t, members_[i].subteam->predictions());
  }
}

/// Delivers the messages received by now; removes predictions that are too old.
void PartitionedSolver::receive(int to, double time) noexcept {
  messages_->receive(to, time);
  Subteam& subteam = *members_[at(to)].subteam;
  for (int from = 0; from < static_cast<int>(members_.size()); ++from) {
    if (from == to) continue;
    const ReceivedMessage news = messages_->news(to, from);
    if (news.ended)
      for (const Prediction& prediction : members_[at(from)].subteam->predictions())
        subteam.forget(prediction.who);
    if (news.message == nullptr) continue;
    for (const Prediction& prediction : news.message->predictions) subteam.receive(prediction, news.time);
  }
}

bool PartitionedSolver::receives_from(BodyId robot, BodyId other) const noexcept {
  const int here = part_of(robot), there = part_of(other);
  return !messages_ || here < 0 || there < 0 || here == there || messages_->receives_from(here, there);
}

bool PartitionedSolver::is_received(BodyId body) const noexcept {
  const int part = part_of(body);
  if (!messages_ || part < 0) return true;
  for (int other = 0; other < static_cast<int>(members_.size()); ++other)
    if (other != part && !messages_->receives_from(other, part)) return false;
  return true;
}

template <class Of>
void PartitionedSolver::for_each(Of&& of) noexcept {
  pool_.share(static_cast<int>(members_.size()), [&](int i, int) noexcept { timed(i, of); });
}

template <class Of>
void PartitionedSolver::timed(int subteam, Of&& of) noexcept {
  const FlushSubnormals guard;  // per thread
  // Without waiting, as with one computer per part.
  const std::int64_t begin = thread_time();
  of(subteam);
  members_[at(subteam)].elapsed += to_seconds(thread_time() - begin);
}

/// Solves every subteam once and sends the predictions.
void PartitionedSolver::exchange(double time, std::span<const double> states) noexcept {
  const auto solve = [&](int i) { members_[at(i)].solution = members_[at(i)].subteam->solve(time, states); };
  if (options_.order == ExchangeOrder::gauss_seidel) {
    for (int i = 0; i < static_cast<int>(members_.size()); ++i) {
      timed(i, solve);
      send(members_[at(i)]);
    }
    return;
  }
  for_each(solve);
  if (messages_)
    for_each([&](int i) { messages_->send(i, time, members_[at(i)].subteam->predictions()); });
  else
    for (const Member& member : members_) send(member);
}

void PartitionedSolver::gather(const Subteam& subteam, std::span<const double> of_whole,
                               std::span<double> of_subteam) const noexcept {
  const Team& team = subteam.ocp().team();
  for (const BodyId body : subteam.ocp().agent_bodies()) {
    const auto from = of_whole.begin() + ocp().team().input_offset(subteam.in_whole(body));
    std::copy_n(from, team.model(body).nu(), of_subteam.begin() + team.input_offset(body));
  }
}

void PartitionedSolver::scatter(const Subteam& subteam, std::span<const double> of_subteam,
                                std::span<double> of_whole) const noexcept {
  const Team& team = subteam.ocp().team();
  for (const BodyId body : subteam.ocp().agent_bodies()) {
    const auto to = of_whole.begin() + ocp().team().input_offset(subteam.in_whole(body));
    std::copy_n(of_subteam.begin() + team.input_offset(body), team.model(body).nu(), to);
  }
}

/// States of robots as their subteams plan them; uncontrolled bodies keep their velocity.
void PartitionedSolver::write_states(std::span<const double> states) noexcept {
  const Team& team = ocp().team();
  const int N = ocp().horizon().N;
  const double h = ocp().horizon().h();
  for (int b = 0; b < team.bodies(); ++b) {
    if (team.is_agent(BodyId{b})) continue;
    const double* const from = states.data() + team.state_offset(BodyId{b});
    for (int k = 0; k <= N; ++k) {
      double* const to = &x_[at(k * team.nx() + team.state_offset(BodyId{b}))];
      for (int i = 0; i < 3; ++i) {
        to[i] = from[i] + k * h * from[3 + i];
        to[3 + i] = from[3 + i];
      }
    }
  }
  for (const Member& member : members_) {
    const Subteam& subteam = *member.subteam;
    const int nx = subteam.ocp().nx();
    const std::span<const double> planned = member.solution.x;
    for (const BodyId body : subteam.ocp().agent_bodies()) {
      const int from = subteam.ocp().team().state_offset(body),
                to = team.state_offset(subteam.in_whole(body));
      for (int k = 0; k <= N; ++k) {
        std::copy_n(planned.begin() + k * nx + from, subteam.ocp().team().model(body).nx(),
                    x_.begin() + k * team.nx() + to);
      }
    }
  }
}

Solution PartitionedSolver::solve(double time, std::span<const double> states) noexcept {
  const Clock::time_point begin = Clock::now();
  const FlushSubnormals guard;
  const bool accepted = accepts(time, states);
  Solution solution{.u = u_, .raw_u = raw_u_, .x = {}, .status = Status::converged};
  for (Member& member : members_) member.elapsed = 0.0;
  if (messages_ && accepted) {
    if (!messages_->begun()) talk_before(time, states);
    for_each([&](int to) { receive(to, time); });
  }
  for (int i = 0; i < (accepted ? options_.exchanges : 1); ++i) {
    exchange(time, accepted ? states : std::span<const double>());
    for (const Member& member : members_) solution.iterations += member.solution.iterations;
  }
  for (const Member& member : members_) {
    scatter(*member.subteam, member.solution.u, u_);
    scatter(*member.subteam, member.solution.raw_u, raw_u_);
    solution.status = worse(solution.status, member.solution.status);
  }
  const bool usable = gives_plan(solution.status);
  if (usable) write_states(x_now_);
  solution.elapsed = seconds_since(begin);
  if (!usable) return solution;
  solution.x = x_;
  has_plan_ = true;
  solution.residual = kkt(time, states);
  if (solution.status == Status::deadline) return solution;
  solution.status =
      solution.residual <= tolerance() ? Status::converged : worse(solution.status, Status::stepped);
  return solution;
}

double PartitionedSolver::kkt(double time, std::span<const double> states) noexcept {
  for (int k = 0; has_plan_ && k < ocp().horizon().N; ++k) {
    plan(k, u_stage_);
    whole_planner_->set_plan(k, u_stage_);
  }
  return whole_->kkt(time, states);
}

void PartitionedSolver::planned(double time, std::span<double> u) const noexcept {
  if (u.size() != u_.size()) return;
  for (const Member& member : members_) {
    member.subteam->planned(time, member.u);
    scatter(*member.subteam, member.u, u);
  }
}

void PartitionedSolver::plan(int k, std::span<double> u) const noexcept {
  if (u.size() != u_.size()) return;
  for (const Member& member : members_) {
    member.subteam->plan(k, member.u);
    scatter(*member.subteam, member.u, u);
  }
}

void PartitionedSolver::set_plan(int k, std::span<const double> u) noexcept {
  if (u.size() != u_.size() || k < 0 || k >= ocp().horizon().N) return;
  has_plan_ = true;
  for (Member& member : members_) {
    gather(*member.subteam, u, member.u);
    member.subteam->set_plan(k, member.u);
  }
}

void PartitionedSolver::set_applied(const AppliedInputs& applied) noexcept {
  if (applied.previous.size() != u_.size() || applied.offset.size() != u_.size()) return;
  whole_->set_applied(applied);
  for (Member& member : members_) {
    gather(*member.subteam, applied.previous, member.before);
    gather(*member.subteam, applied.offset, member.u);
    const bool leans = applied.lean.size() == at(ocp().team().bodies());
    for (int b = 0; b < static_cast<int>(member.lean.size()) && leans; ++b)
      member.lean[at(b)] = applied.lean[at(member.subteam->in_whole(BodyId{b}))];
    const bool refers = applied.u_ref.size() == u_.size();
    if (refers) gather(*member.subteam, applied.u_ref, member.u_ref);
    member.subteam->set_applied({member.before, member.u, member.lean,
                                 std::span(member.u_ref).first(refers ? member.u_ref.size() : 0)});
  }
}

void PartitionedSolver::set_prediction(const Prediction& prediction) noexcept {
  const Team& team = ocp().team();
  if (prediction.who.index < 0 || prediction.who.index >= team.bodies() || team.is_agent(prediction.who))
    return;
  whole_planner_->set_prediction(prediction);
  for (const Member& member : members_) member.subteam->set_prediction(prediction);
}

void PartitionedSolver::restart() noexcept {
  whole_->restart();
  has_plan_ = false;
  std::fill(x_.begin(), x_.end(), 0.0);
  if (messages_) messages_->restart();
  for (Member& member : members_) member.subteam->restart();
}

double PartitionedSolver::slowest() const noexcept {
  double most = 0.0;
  for (const Member& member : members_) most = std::max(most, member.elapsed);
  return most;
}

}  // namespace sightline
