#include "sightline/solver/newton/groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr int turn_size = 8;  // independent of the lane width: all machines compute the same bits

/// Agents of one model with equal barriers, input scales and Sight components.
struct Kind {
  std::string_view robot;
  Seen seen;
  BlockProgram step;
  Program barriers;
  std::vector<double> scales, R_rate;
  std::shared_ptr<const StagePrograms> programs;
  std::vector<int> agents;
};

/// Sight components of each agent that the potentials depend on. If a potential depends on one
/// agent's tilt, equal agents include it too, because they share lanes.
std::vector<Seen> seen_of_agents(const Ocp& ocp, std::span<const BodyPotential> potentials) {
  const double h = ocp.horizon().h();
  std::vector<Seen> seen(ocp.agent_bodies().size(), Seen::pose);
  for (const BodyPotential& p : potentials) {
    if (p.a >= 0) seen[at(p.a)] = std::max(seen[at(p.a)], p.potential.sees(false));
    if (p.b >= 0) seen[at(p.b)] = std::max(seen[at(p.b)], p.potential.sees(true));
  }
  std::vector<std::pair<BlockProgram, Seen>> leaning;
  const auto like = [&](std::size_t a) {
    const BlockProgram own = trace_step(ocp.team().model(ocp.agent_bodies()[a]), h, Seen::leaning);
    const auto found = std::find_if(leaning.begin(), leaning.end(),
                                    [&](const auto& other) { return other.first.program == own.program; });
    return found == leaning.end() ? leaning.insert(found, {own, Seen::pose}) : found;
  };
  const auto leans = [](Seen s) { return s >= Seen::leaning; };
  for (std::size_t a = 0; a < seen.size(); ++a) {
    if (leans(seen[a])) like(a)->second = std::max(like(a)->second, seen[a]);
  }
  for (std::size_t a = 0; a < seen.size() && !leaning.empty(); ++a)
    seen[a] = std::max(seen[a], like(a)->second);
  return seen;
}

std::vector<Kind> sort_into_kinds(const Ocp& ocp, std::span<const BodyPotential> potentials) {
  std::vector<Kind> kinds;
  const std::vector<Seen> seen_by = seen_of_agents(ocp, potentials);
  const double h = ocp.horizon().h();
  for (int a = 0; a < static_cast<int>(ocp.agent_bodies().size()); ++a) {
    const Seen seen = seen_by[at(a)];
    const Model& model = ocp.team().model(ocp.agent_bodies()[at(a)]);
    const std::vector<RelaxedBarrier> limits = ocp.team().barriers(ocp.agent_bodies()[at(a)]);
    BlockProgram step = trace_step(model, h, seen);
    Program barriers = trace_barriers(model, limits);
    const Agent& agent = ocp.team().agents()[at(a)];
    std::vector<double> scales = input_scales(agent);
    const auto same = [&](const Kind& k) {
      return k.seen == seen && k.step.program == step.program && k.step.inputs == step.inputs &&
             k.step.outputs == step.outputs && k.barriers == barriers && k.scales == scales &&
             k.R_rate == agent.R_rate;
    };
    auto kind = std::find_if(kinds.begin(), kinds.end(), same);
    if (kind == kinds.end()) {
      auto programs = std::make_shared<const StagePrograms>(
          trace_stage(model, h, seen, limits, scales, {agent.R_rate, ocp.horizon().dt}));
      kind = kinds.insert(kinds.end(), {model.name(),
                                        seen,
                                        std::move(step),
                                        std::move(barriers),
                                        std::move(scales),
                                        agent.R_rate,
                                        std::move(programs),
                                        {}});
    }
    kind->agents.push_back(a);
  }
  return kinds;
}

/// Lane width: the narrowest packs that hold all robots of each kind at once, else the native
/// width.
int width_for(const std::vector<Kind>& kinds) {
  std::size_t most = 0;
  for (const Kind& kind : kinds) most = std::max(most, kind.agents.size());
  return most <= 2 ? 2 : most <= at(narrow_width) ? narrow_width : native_width;
}

}  // namespace

void Groups::copy_states(int group, double* x, std::ptrdiff_t stage,
                         std::span<const int> x_at) const noexcept {
  std::array<double*, native_width> to{};
  const std::vector<int>& members = members_[at(group)];
  for (std::size_t lane = 0; lane < members.size(); ++lane) to[lane] = x + x_at[at(members[lane])];
  groups_[at(group)]->copy_states(to.data(), stage, static_cast<int>(members.size()));
}

Groups::Groups(const Ocp& ocp, std::span<const BodyPotential> potentials, KernelChoice choice,
               std::span<const int> order)
    : h_(ocp.horizon().h()), dt_(ocp.horizon().dt), lean_(ocp.agent_bodies().size()) {
  for (const BodyId body : ocp.agent_bodies()) {
    const Model& model = ocp.team().model(body);
    limited_.push_back({model, ocp.team().barriers(body), std::vector<double>(at(model.nx())),
                        std::vector<double>(at(model.nu())), ocp.team().agent(body).R_rate});
  }
  std::vector<int> place(ocp.agent_bodies().size());
  for (std::size_t i = 0; i < place.size(); ++i)
    place[order.empty() ? i : at(order[i])] = static_cast<int>(i);
  std::vector<Kind> kinds = sort_into_kinds(ocp, potentials);
  layout_.stages = ocp.horizon().N;
  layout_.width = width_for(kinds);
  layout_.agents.resize(ocp.agent_bodies().size());
  std::vector<std::pair<int, int>> turns;  // position of the first agent, first group
  for (Kind& kind : kinds) {
    std::sort(kind.agents.begin(), kind.agents.end(),
              [&](int a, int b) { return place[at(a)] < place[at(b)]; });
    const int first = static_cast<int>(groups_.size()), n = static_cast<int>(kind.agents.size());
    const int in_turns = (n + turn_size - 1) / turn_size, most = (n + in_turns - 1) / in_turns;
    const int groups = in_turns * ((most + layout_.width - 1) / layout_.width);
    for (int t = 0; t < in_turns; ++t) turns.emplace_back(place[at(kind.agents[at(t)])], first + t);
    kernels_.add(
        fmt::format("robot {}", kind.robot),
        choice == KernelChoice::compiled_if_there && find_stage(*kind.programs, layout_.width) != nullptr);
    for (int g = 0; g < groups; ++g) {
      groups_.push_back(make_group(kind.programs, layout_.stages, layout_.width, choice));
      layout_.add(kind.programs->sizes.nu, kind.programs->sizes.ns);
    }
    members_.resize(groups_.size());
    for (int i = 0; i < n; ++i) {
      const int in_turn = i / in_turns, group = first + i % in_turns + in_turns * (in_turn / layout_.width);
      layout_.agents[at(kind.agents[at(i)])] = {group, in_turn % layout_.width};
      members_[at(group)].push_back(kind.agents[at(i)]);
    }
    for (int g = first; g < first + groups; ++g) {
      layout_.groups[at(g)].turn = first + (g - first) % in_turns;
      rests_as_.push_back(members_[at(g)].empty() ? kind.agents.back() : members_[at(g)].back());
    }
  }
  std::sort(turns.begin(), turns.end());
  for (Layout::Part& part : layout_.groups) {
    const auto its =
        std::find_if(turns.begin(), turns.end(), [&](const auto& t) { return t.second == part.turn; });
    part.turn = static_cast<int>(its - turns.begin());
  }
  settle_groups();
  // A lane without an agent has only input weights, so its inputs stay zero.
  for (const auto& group : groups_) {
    for (int lane = 0; lane < layout_.width; ++lane) {
      for (int i = 0; i < group->sizes().nu; ++i) group->weight(group->sizes().nx + i, lane) = 1.0;
    }
  }
  for (int a = 0; a < static_cast<int>(layout_.agents.size()); ++a) {
    const Agent& agent = ocp.team().agents()[at(a)];
    Group& group = group_of(a);
    const int lane = layout_.place(a).lane, nx = group.sizes().nx, nu = group.sizes().nu;
    const int own = nx - group.sizes().before;
    for (int i = 0; i < own; ++i) group.weight(i, lane) = 2.0 * h_ * agent.Q[at(i)];
    for (int i = 0; i < nu; ++i) group.weight(nx + i, lane) = 2.0 * h_ * agent.R[at(i)];
    set_u_ref(a, agent.u_ref.data());
    for (int i = 0; i < own; ++i) group.Q_f(i, lane) = agent.Q_f[at(i)];
  }
}

/// Places all groups in one block of memory, which may be large.
void Groups::settle_groups() {
  std::ptrdiff_t room = 0;
  for (const auto& group : groups_) room += group->room();
  memory_ = Rows(1, static_cast<int>(room));
  double* next = memory_[0];
  for (const auto& group : groups_) {
    group->settle(next);
    next += group->room();
  }
}

void Groups::set_u_ref(int agent, const double* u_ref) noexcept {
  Group& group = group_of(agent);
  const int nx = group.sizes().nx, nu = group.sizes().nu;
  for (int i = 0; i < nu; ++i) group.weight(nx + nu + i, layout_.place(agent).lane) = u_ref[i];
}

void Groups::rest_at(const double* x, std::span<const int> x_at) noexcept {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const int own = groups_[g]->sizes().nx - groups_[g]->sizes().before;
    const double* const of = x + x_at[at(rests_as_[g])];
    for (int lane = static_cast<int>(members_[g].size()); lane < layout_.width; ++lane) {
      for (int i = 0; i < own; ++i) groups_[g]->x(0, i, lane) = of[i];
    }
  }
}

void Groups::roll_out(int g, const double* u, double* s) noexcept {
  const Layout::Part& part = layout_.groups[at(g)];
  groups_[at(g)]->roll_out(u + part.u, s + part.s);
  constexpr int first = seen_size(Seen::pose_and_motion);
  if (part.ns < seen_size(Seen::leaning)) return;
  for (const int a : members_[at(g)]) {
    const Vec2<double>& lean = lean_[at(a)];
    if (lean.x == 0 && lean.y == 0) continue;
    const Layout::View of = layout_.s(a);
    for (int k = 0; k < layout_.stages; ++k) s[of(k, first)] += lean.x, s[of(k, first + 1)] += lean.y;
  }
}

void Groups::own_costs(int g, const double* u, double* of_lanes) noexcept {
  const Group& group = *groups_[at(g)];
  group.tracking_costs(u + layout_.groups[at(g)].u, of_lanes);
  for (const int a : members_[at(g)]) add_limits(group, u, a, of_lanes[layout_.place(a).lane]);
}

/// Adds the cost of an agent's barriers and input rates along the last roll-out, times h.
void Groups::add_limits(const Group& group, const double* u, int agent, double& cost) noexcept {
  const int lane = layout_.place(agent).lane;
  Limited& robot = limited_[at(agent)];
  const Layout::View input = layout_.u(agent);
  const int own = group.sizes().nx - group.sizes().before;
  for (int k = 0; k < layout_.stages; ++k) {
    for (int i = 0; i < group.sizes().before; ++i) {
      const double change = u[input(k, i)] - group.x(k, own + i, lane);
      cost += robot.R_rate[at(i)] / (k > 0 ? h_ : dt_) * change * change;
    }
  }
  if (robot.barriers.empty()) return;
  for (int k = 0; k < layout_.stages; ++k) {
    for (int i = 0; i < own; ++i) robot.x[at(i)] = group.x(k, i, lane);
    for (int i = 0; i < group.sizes().nu; ++i) robot.u[at(i)] = u[input(k, i)];
    const Sight<double> sight = robot.model.sight(robot.x.data(), robot.u.data());
    for (const RelaxedBarrier& barrier : robot.barriers) {
      cost += h_ * barrier(sight, std::span<const double>(robot.x), std::span<const double>(robot.u));
    }
  }
}

bool Groups::solve(int g, const double* u, const double* active, const double* c, double* H_u, double* du,
                   double* ds, Damping begins) noexcept {
  constexpr int attempts = 10;    // the damping has then grown by a factor of 1e9
  constexpr double first = 0.02;  // of 2 R h with R = 1 in an input's scale: small initial damping
  const Layout::Part& part = layout_.groups[at(g)];
  Group& group = *groups_[at(g)];
  bool damped = false;
  for (int lane = 0; lane < layout_.width; ++lane) {
    double& rho = group.rho(lane);
    if (begins == Damping::none) rho = 0.0;
    damped |= rho > 0.0;
  }
  for (int attempt = 0; attempt < attempts; ++attempt) {
    if (group.backward(u + part.u, active + part.u, c, H_u + part.u, du + part.u)) break;
    damped = true;
    for (int lane = 0; lane < layout_.width; ++lane) {
      double& rho = group.rho(lane);
      if (group.pivots_shifted(lane)) rho = rho > 0 ? 10.0 * rho : first * h_;
    }
  }
  group.forward(du + part.u, ds + part.s);
  return damped;
}

void Groups::solve(const double* u, const double* active, const double* c, double* H_u, double* du,
                   double* ds) noexcept {
  for (std::size_t g = 0; g < groups_.size(); ++g)
    solve(static_cast<int>(g), u, active, c + layout_.groups[g].c, H_u, du, ds);
}

}  // namespace sightline
