#include "sightline/scenario/read_disturbances.hpp"

#include "sightline/base.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

Vec3<double> read_wind(const TomlTable& at) {
  constexpr std::string_view key = "wind";
  if (!at.value(key, "").is_table()) return at.vec3(key);
  double size = 0.0, direction = 0.0;
  at.table(key).read({{"size", &size, not_negative(">= 0 m/s^2")}, {"direction", &direction}});
  const SinCos<double> towards = sincos(direction);
  return {size * towards.cos, size * towards.sin, 0.0};
}

}  // namespace

Disturbances read_disturbances(const TomlTable& at) {
  Disturbances d;
  constexpr Range delay = {0.0, 1.0, "0 to 1 s"};
  at.read({{"input_delay", &d.input_delay, delay},
           {"yaw_lag", &d.yaw_lag, not_negative("0 or >= 0.001 s")},
           {"input_gain", &d.input_gain, positive("> 0")},
           {"slip", &d.slip, {0.0, 0.9, "0 to 0.9"}},
           {"delay", &d.measurement_delay, delay}},
          {"wind", "gust", "airflow", "noise", "odometry"});
  if (at.has("wind")) d.wind = read_wind(at);
  at.table_or_empty("gust").read(
      {{"sigma", &d.gust_sigma, not_negative(">= 0 m/s^2")}, {"time", &d.gust_time, positive("> 0 s")}});
  at.table_or_empty("airflow").read({{"amplitude", &d.airflow.amplitude, not_negative(">= 0 m/s^2")},
                                     {"distance", &d.airflow.distance, positive("> 0 m")},
                                     {"frequency", &d.airflow.frequency, not_negative(">= 0 Hz")}});
  at.table_or_empty("noise").read({{"position", &d.noise.position, not_negative(">= 0 m")},
                                   {"heading", &d.noise.heading, not_negative(">= 0 rad")},
                                   {"velocity", &d.noise.velocity, not_negative(">= 0 m/s")}});
  d.odometry = read_part<Odometry>(TableSource(at.table_or_empty("odometry")));
  at.checked([&] { d.check(); });
  return d;
}

}  // namespace sightline
