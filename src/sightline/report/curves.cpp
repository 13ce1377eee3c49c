#include "sightline/report/curves.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace sightline {
namespace {

constexpr std::size_t rows_min = 24;         // per curve
constexpr std::size_t rows_of_all = 16'000;  // rows per curve times bodies: bounds the page size

}  // namespace

std::string label(std::string_view name, std::size_t size) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if ((static_cast<unsigned char>(name[i]) & 0xC0) == 0x80) continue;
    if (++characters > size) return std::string(name.substr(0, i)) + "…";
  }
  return std::string(name);
}

std::vector<double> along(const std::vector<Vec3<double>>& p, double Vec3<double>::*axis) {
  std::vector<double> result;
  result.reserve(p.size());
  for (const Vec3<double>& point : p) result.push_back(point.*axis);
  return result;
}

Drawing::Curve thinned(std::string title, std::size_t colour, Drawing::Mark mark, std::span<const double> x,
                       std::span<const double> y, std::size_t rows) {
  const std::size_t size = std::min(x.size(), y.size());
  const std::array columns = {y.first(size), x.first(size)};
  const bool rising = std::is_sorted(x.begin(), x.end());  // then the ends are extremes
  Drawing::Curve result{std::move(title), colour, mark, {}, {}};
  for (const std::size_t i : rows_to_draw(std::span(columns).first(rising ? 1 : 2), rows)) {
    result.x.push_back(x[i]);
    result.y.push_back(y[i]);
  }
  return result;
}

Curves::Curves(const Recording& recording)
    : recording_(recording),
      rows_(std::clamp<std::size_t>(rows_of_all / std::max<std::size_t>(1, recording.bodies.size()), rows_min,
                                    rows_max)) {}

Drawing::Curve Curves::curve(std::string title, std::size_t colour, Drawing::Mark mark,
                             const std::vector<double>& x, const std::vector<double>& y) const {
  return thinned(std::move(title), colour, mark, x, y, rows_);
}

Drawing::Curve Curves::over_time(std::string title, std::size_t colour, Drawing::Mark mark,
                                 const std::vector<double>& y) const {
  return curve(std::move(title), colour, mark, recording_.time, y);
}

Drawing::Curve Curves::level(std::string title, std::size_t colour, double y) const {
  return {std::move(title), colour, Drawing::Mark::dashed, {recording_.time.front(), end()}, {y, y}};
}

double Curves::end() const { return recording_.end(); }

}  // namespace sightline
