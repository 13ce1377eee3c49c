/// Links of a team's bodies to real robots: [fleet], and `link` of robots, targets and obstacles.
/// Only a bridge knows what they hold.
#pragma once

#include <memory>
#include <string>

namespace sightline {

struct Agent;
struct Scenario;
class GoalTrack;
class Team;
class TomlTable;

/// The links of a scenario.
class Links {
 public:
  virtual ~Links() = default;
  /// Lines for the summary of a scenario.
  virtual std::string in_words(const Team& team) const = 0;
  /// The links of the part of the team that is planned here.
  /// @param part  its scenario, with the links of `whole`
  virtual std::shared_ptr<const Links> of_part(const Scenario& whole, const Scenario& part) const = 0;
};

/// Reads links; a program adds it to its Registry by with_links(). Throws ScenarioError.
class LinkReader {
 public:
  virtual ~LinkReader() = default;
  /// The goals that a robot accepts in flight, by the link in [agent.NAME]; null: none.
  virtual std::shared_ptr<GoalTrack> read_goals(const TomlTable& agent, const Agent& robot) const = 0;
  /// All links of a document with [fleet], whose bodies and goals the scenario has already.
  virtual std::shared_ptr<const Links> read_links(const TomlTable& root, const Scenario& scenario) const = 0;
};

}  // namespace sightline
