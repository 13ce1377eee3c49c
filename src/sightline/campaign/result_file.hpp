/// campaign.json: what a paper cites of a campaign, and machines.json: where it was flown.
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

/// Adds a machine to the machines.json of a folder, once.
/// @throws std::runtime_error where it cannot be written
void note_machine(const std::filesystem::path& folder, const Machine& machine);
/// Those of all folders, each once; of a folder without machines.json none.
/// @throws std::invalid_argument naming a file that holds something else
std::vector<Machine> machines_of(const std::vector<std::filesystem::path>& folders);
void write_machines(const std::filesystem::path& folder, const std::vector<Machine>& machines);

/// Scenario, seed, version, compiler, machines, digests of text and rows; outcomes with Wilson's bounds, medians with those of the
/// bootstrap; of tables beside, the same and the tests of pairs with the first.
/// @throws std::runtime_error where a table cannot be read
std::string campaign_json(const std::vector<CampaignTable>& tables, const std::vector<Machine>& machines);

}  // namespace sightline
