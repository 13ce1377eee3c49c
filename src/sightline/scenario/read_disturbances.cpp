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
  read_keys(at, {"airflow", "noise", "odometry"}, d);
  if (at.has("wind")) d.wind = read_wind(at);
  at.table_or_empty("gust").read(
      {{"sigma", &d.gust_sigma, not_negative(">= 0 m/s^2")}, {"time", &d.gust_time, positive("> 0 s")}});
  read_keys(at.table_or_empty("airflow"), {}, d.airflow);
  read_keys(at.table_or_empty("noise"), {}, d.noise);
  d.odometry = read_part<Odometry>(TableSource(at.table_or_empty("odometry")));
  at.checked([&] { d.check(); });
  return d;
}

}  // namespace sightline
