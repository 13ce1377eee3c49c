/// Columns of a run as curves of a figure, thinned to limit the size of a page.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/report.hpp"

namespace sightline {

inline constexpr std::size_t rows_max = 2000;  ///< per curve

/// A name for a legend, truncated between two characters with an ellipsis if it exceeds `size`.
std::string label(std::string_view name, std::size_t size = 18);

/// One coordinate of each point.
std::vector<double> along(const std::vector<Vec3<double>>& p, double Vec3<double>::*axis);

/// y over x with at most `rows` points; keeps the extremes of both.
Drawing::Curve thinned(std::string title, std::size_t colour, Drawing::Mark mark, std::span<const double> x,
                       std::span<const double> y, std::size_t rows = rows_max);

class Curves {
 public:
  /// @param recording  must outlive this object; has at least one period
  explicit Curves(const Recording& recording);

  /// y over x, thinned.
  Drawing::Curve curve(std::string title, std::size_t colour, Drawing::Mark mark,
                       const std::vector<double>& x, const std::vector<double>& y) const;
  Drawing::Curve over_time(std::string title, std::size_t colour, Drawing::Mark mark,
                           const std::vector<double>& y) const;
  /// A constant over the whole run.
  Drawing::Curve level(std::string title, std::size_t colour, double y) const;
  double end() const;  ///< of the run [s]

 private:
  const Recording& recording_;
  std::size_t rows_;  // most rows of a curve
};

}  // namespace sightline
