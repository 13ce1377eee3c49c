/// Recordings of vehicles that fly above one another, for the identification of their downwash.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/scenario/csv_lists.hpp"
#include "sightline/vehicle.hpp"

namespace sightline {

/// Motion and rotors of one vehicle, in G. All lists have the length of `t`.
struct RotorRecord {
  std::string name{};                  ///< of its recording
  Vehicle vehicle{};                   ///< mass, rotors and drag along z are used
  std::vector<double> t{};             ///< rising, by a clock that all vehicles of a flight share [s]
  std::vector<Vec3<double>> p{}, v{};  ///< [m], [m/s]
  std::vector<Vec3<double>> up{};      ///< the body's z axis, along the thrust, |up| = 1
  std::vector<double> a_z{};           ///< acceleration along z without gravity, 9.81 at rest [m/s^2]
  std::vector<double> power{};         ///< mean over the rotors of (duty cycle times battery voltage)^2
};

/// The vehicles of one flight.
using DownwashFlight = std::vector<RotorRecord>;

/// The record in a table with the columns t (or t_ms, t_us), x, y, z, vx, vy, vz, az (as a_z), the
/// attitude qx, qy, qz, qw, the duty cycles pwm1, pwm2, ... of the rotors, and perhaps battery [V].
/// @throws std::invalid_argument for a missing column, and for times that do not rise
RotorRecord rotor_record(const CsvColumns& table, const std::string& name, const Vehicle& vehicle);

/// A flight from several tables, which may be packed.
/// @param vehicles  one for each table, or one for all
/// @param columns   as read_csv()
/// @throws std::invalid_argument as above, for fewer than two tables, and for another number of
///   vehicles
DownwashFlight downwash_flight(const std::vector<std::filesystem::path>& tables,
                               const std::vector<Vehicle>& vehicles, const std::vector<std::string>& columns);

/// A vehicle by the name of a preset, or from a file with the keys of [agent.NAME.vehicle] (TOML).
/// @throws std::invalid_argument for neither, and for a vehicle out of range
Vehicle named_vehicle(const std::string& name);

}  // namespace sightline
