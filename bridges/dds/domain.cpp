#include "bridges/dds/domain.hpp"

#include <dds/ddsrt/log.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>
#include <mutex>
#include <stdexcept>

#include "bridges/dds/topics/channel.hpp"
#include "sightline/base/c_callback.hpp"

namespace sightline::dds {
namespace {

std::atomic<std::int64_t> complaint_count{0};
std::mutex complaint_lock;  // guards complaint_line against Cyclone DDS threads and callers
std::string complaint_line;

// Each bad packet produces a log line. The lines are counted instead of printed; the flight reports
// their number.
void count_complaint(void*, const dds_log_data_t* line) {
  ++complaint_count;
  const std::scoped_lock lock(complaint_lock);
  complaint_line.assign(line->message, line->size);
  while (!complaint_line.empty() && complaint_line.back() == '\n') complaint_line.pop_back();
}

// Larger messages are not reassembled from fragments. The limit exceeds payload_max, because
// readers count messages above that one.
constexpr std::size_t sample_max = 4 * payload_max;

// rmw_fastrtps_cpp announces itself by multicast alone, so a robot that starts after us is discovered when we next
// announce ourselves: by default each 8 s, nearly the 10 s after which a flight is refused.
constexpr int announced_each = 2000;  // [ms]

std::string of_return(dds_return_t code) { return dds_strretcode(-code); }

}  // namespace

std::int64_t complaints() { return complaint_count; }

std::string last_complaint() {
  const std::scoped_lock lock(complaint_lock);
  return complaint_line;
}

std::string domain_xml(const FleetNetwork& network, std::optional<int> receive_priority, Identity who) {
  const bool multicast = network.multicast == Multicast::on;
  std::string interfaces, peers, one_receiver, threads;
  for (const std::string& name : network.interfaces) {
    const bool local = name == "lo";
    interfaces += fmt::format(R"(<NetworkInterface name="{}" multicast="{}"/>)", name,
                              multicast && !local ? "default" : "false");
  }
  for (const std::string& peer : network.peers) peers += fmt::format(R"(<Peer Address="{}"/>)", peer);
  if (receive_priority) {
    // A single receive thread, because only this one can be named.
    one_receiver = "<MultipleReceiveThreads>false</MultipleReceiveThreads>";
    threads = fmt::format(
        R"(<Threads><Thread Name="recv"><Scheduling><Class>realtime</Class><Priority>{}</Priority></Scheduling></Thread></Threads>)",
        *receive_priority);
  }
  return fmt::format(
      R"(<CycloneDDS><Domain Id="any"><General><Interfaces>{}</Interfaces><AllowMulticast>{}</AllowMulticast></General>)"
      R"(<Discovery><SPDPInterval>{} ms</SPDPInterval><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex>)"
      R"(<Peers>{}</Peers></Discovery><Internal><MaxSampleSize>{}B</MaxSampleSize>{}</Internal>{}{}</Domain></CycloneDDS>)",
      interfaces, multicast ? "true" : "false", announced_each, network.participants, peers, sample_max,
      one_receiver, threads, network.keys.empty() ? "" : security_xml(network.keys, who));
}

Domain::Domain(const FleetNetwork& network, std::optional<int> receive_priority, Identity who)
    : number_(network.domain) {
  if (!network.keys.empty()) check_keys(network.keys, who);
  dds_set_log_sink(c_callback<count_complaint>, nullptr);
  const std::int64_t before = complaints();
  const auto refused = [&](dds_return_t code) {
    return std::runtime_error(fmt::format(
        "fleet.domain = {} on {}: {}{}, expected interfaces of this machine, and at most {} programs on it",
        number_, fmt::join(network.interfaces, ", "), of_return(code),
        complaints() > before ? " (" + last_complaint() + ")" : "", network.participants));
  };
  // Must throw here: dds_create_participant() would otherwise create a domain with defaults, which
  // multicast on all interfaces.
  domain_ = dds_create_domain(static_cast<dds_domainid_t>(number_),
                              domain_xml(network, receive_priority, who).c_str());
  if (domain_ < 0) throw refused(domain_);
  participant_ = dds_create_participant(static_cast<dds_domainid_t>(number_), nullptr, nullptr);
  if (participant_ < 0) {
    const dds_return_t code = participant_;
    dds_delete(domain_);
    throw refused(code);
  }
}

Domain::~Domain() { dds_delete(domain_); }

dds_entity_t Domain::another_participant() const {
  const dds_entity_t made = dds_create_participant(static_cast<dds_domainid_t>(number_), nullptr, nullptr);
  if (made < 0) throw std::runtime_error(fmt::format("fleet.domain = {}: {}", number_, of_return(made)));
  return made;
}

}  // namespace sightline::dds
