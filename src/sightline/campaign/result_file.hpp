/// campaign.json, the results of a campaign for citation, and machines.json, the computers that
/// flew it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/campaign/page.hpp"

namespace sightline {

/// A computer that flew runs.
struct Machine {
  std::string name, system, processor;
  int cores = 0;

  bool operator==(const Machine&) const = default;
};
Machine this_machine();

/// Adds a machine to the machines.json of a folder, unless it is there.
/// @throws std::runtime_error if it cannot be written
void note_machine(const std::filesystem::path& folder, const Machine& machine);
/// The machines of all folders, each once; a folder without machines.json has none.
/// @throws std::invalid_argument naming a file with other content
std::vector<Machine> machines_of(const std::vector<std::filesystem::path>& folders);
void write_machines(const std::filesystem::path& folder, const std::vector<Machine>& machines);

/// Scenario, seed, version, compiler, machines, digests of text and rows; outcomes with Wilson's
/// bounds and medians with bootstrap bounds. Further tables add the same and the paired tests with
/// the first.
/// @throws std::runtime_error if a table cannot be read
std::string campaign_json(const std::vector<CampaignTable>& tables, const std::vector<Machine>& machines);

}  // namespace sightline
