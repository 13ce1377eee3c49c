/// Keys of fleets, and programs that are not of the fleet.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "bridges/dds/domain.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/command.hpp"

namespace sightline::dds {

/// Makes keys as a person does. @return their folder
inline std::filesystem::path made_keys(const std::filesystem::path& folder,
                                       const std::string& arguments = "") {
  const auto made = test::shell("scripts/dds_keys.sh " + arguments, folder.parent_path());
  if (made.code != 0) throw std::runtime_error(made.err);
  return folder;
}
inline std::filesystem::path keys_in(const std::filesystem::path& folder, const std::string& options = "",
                                     const std::string& names = "") {
  return made_keys(folder, options + " '" + folder.string() + "' " + names);
}

/// A program of its own, as far as the network sees: a second domain of this one that speaks on the
/// network of own_domain().
class OtherProgram {
 public:
  OtherProgram(const FleetNetwork& network, Identity who) {
    static dds_domainid_t number = 0;  // below those of own_domain(); governance knows 0 to 230
    std::string xml = domain_xml(network, {}, who);
    xml.insert(xml.find("<ParticipantIndex>"),
               fmt::format("<ExternalDomainId>{}</ExternalDomainId>", network.domain));
    domain_ = dds_create_domain(++number, xml.c_str());
    if (domain_ > 0) participant_ = dds_create_participant(number, nullptr, nullptr);
  }
  ~OtherProgram() {
    if (domain_ > 0) dds_delete(domain_);
  }
  OtherProgram(const OtherProgram&) = delete;
  OtherProgram& operator=(const OtherProgram&) = delete;

  /// Negative where it is refused.
  dds_entity_t participant() const { return participant_; }

 private:
  dds_entity_t domain_ = 0, participant_ = -1;
};

}  // namespace sightline::dds
