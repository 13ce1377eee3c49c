/// Columns of a run as curves of a figure, thinned so that a page stays small.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

inline constexpr std::size_t rows_max = 2000;  ///< of a curve

/// A name short enough for a legend: cut between two characters, and then it ends by an ellipsis.
std::string label(std::string_view name, std::size_t size = 18);

/// A coordinate of each point.
std::vector<double> along(const std::vector<Vec3<double>>& p, double Vec3<double>::*axis);

class Curves {
 public:
  /// @param recording  outlives this; has a period at least
  explicit Curves(const Recording& recording);

  /// y over x, with the extremes of both.
  Drawing::Curve curve(std::string title, std::size_t colour, Drawing::Mark mark,
                       const std::vector<double>& x, const std::vector<double>& y) const;
  Drawing::Curve over_time(std::string title, std::size_t colour, Drawing::Mark mark,
                           const std::vector<double>& y) const;
  /// A constant over all of the run.
  Drawing::Curve level(std::string title, std::size_t colour, double y) const;
  double end() const;  ///< of the run [s]

 private:
  const Recording& recording_;
  std::size_t rows_;  // of a curve, at most
};

}  // namespace sightline
