#include "sightline/analysis/identification/downwash_flight.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "sightline/base/text_file.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/readers/recorded_motion.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

constexpr std::string_view record_columns =
    "t (or t_ms, t_us), x, y, z, vx, vy, vz, az, qx, qy, qz, qw, pwm1, pwm2, ... and perhaps battery";

const std::vector<double>& record_column(const CsvColumns& table, std::string_view name) {
  const std::vector<double>* const found = table.find(name);
  if (found == nullptr) throw_invalid("no column \"{}\", expected the columns {}", name, record_columns);
  return *found;
}

/// Times in s.
std::vector<double> record_times(const CsvColumns& table) {
  struct Clock {
    std::string_view name;
    double unit;
  };
  for (const Clock& clock : {Clock{"t_ms", 1e-3}, Clock{"t_us", 1e-6}, Clock{"t", 1.0}}) {
    if (table.find(clock.name) == nullptr && clock.unit < 1) continue;
    std::vector<double> t = record_column(table, clock.name);
    for (double& one : t) one *= clock.unit;
    return t;
  }
  return {};
}

}  // namespace

RotorRecord rotor_record(const CsvColumns& table, const std::string& name, const Vehicle& vehicle) {
  RotorRecord record{.name = name, .vehicle = vehicle, .t = record_times(table)};
  const auto of = [&](std::string_view column) -> const std::vector<double>& {
    return record_column(table, column);
  };
  const std::array place = {&of("x"), &of("y"), &of("z")}, velocity = {&of("vx"), &of("vy"), &of("vz")};
  const std::array q = {&of("qx"), &of("qy"), &of("qz"), &of("qw")};
  std::vector<const std::vector<double>*> duty = {&of("pwm1")};
  for (const std::vector<double>* next = nullptr;
       (next = table.find(fmt::format("pwm{}", duty.size() + 1))) != nullptr;)
    duty.push_back(next);
  const std::vector<double>* const battery = table.find("battery");
  record.a_z = of("az");
  for (std::size_t k = 0; k < record.t.size(); ++k) {
    if (k > 0 && !(record.t[k] > record.t[k - 1]))
      throw_invalid("t = {} s in row {} of numbers after {} s, expected times that rise", record.t[k], k + 1,
                    record.t[k - 1]);
    record.p.push_back({(*place[0])[k], (*place[1])[k], (*place[2])[k]});
    record.v.push_back({(*velocity[0])[k], (*velocity[1])[k], (*velocity[2])[k]});
    const auto attitude = recorded_attitude({(*q[3])[k], (*q[0])[k], (*q[1])[k], (*q[2])[k]});
    if (!attitude)
      throw_invalid("the attitude in row {} of numbers is 0, 0, 0, 0, expected a quaternion", k + 1);
    record.up.push_back(attitude->z);
    double squares = 0.0;
    for (const std::vector<double>* one : duty) squares += square((*one)[k]);
    record.power.push_back(squares / static_cast<double>(duty.size()) *
                           (battery != nullptr ? square((*battery)[k]) : 1.0));
  }
  return record;
}

DownwashFlight downwash_flight(const std::vector<std::filesystem::path>& tables,
                               const std::vector<Vehicle>& vehicles,
                               const std::vector<std::string>& columns) {
  if (tables.size() < 2)
    throw_invalid("{} recording of a flight, expected at least two: FILE,FILE", tables.size());
  if (vehicles.size() != 1 && vehicles.size() != tables.size())
    throw_invalid("{} vehicles for {} recordings of a flight, expected one for all or one for each",
                  vehicles.size(), tables.size());
  DownwashFlight flight;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::string file = tables[i].native();
    const CsvColumns table = read_csv(read_packed_file(tables[i]), file, columns);
    std::string name = tables[i].filename().native();
    name.resize(std::min(name.find('.', 1), name.size()));
    try {
      flight.push_back(rotor_record(table, name, vehicles.size() == 1 ? vehicles[0] : vehicles[i]));
    } catch (const std::invalid_argument& error) {
      throw_invalid("{}: {}", file, error.what());
    }
  }
  return flight;
}

Vehicle named_vehicle(const std::string& name) {
  std::vector<std::string_view> presets;
  for (const Preset<Vehicle>& one : Vehicle::presets()) {
    if (one.name == name) return one.part;
    presets.push_back(one.name);
  }
  if (!std::filesystem::is_regular_file(name))
    throw_invalid("vehicle = {}, expected one of {}, or a file with the keys of [agent.NAME.vehicle]", name,
                  fmt::join(presets, ", "));
  const TomlDocument document = parse_toml(read_text(name), name);
  const TomlTable at(document);
  Vehicle vehicle = read_part<Vehicle>(TableSource(at));
  at.checked([&] { vehicle.check(); });
  return vehicle;
}

}  // namespace sightline
