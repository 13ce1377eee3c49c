#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/drawn_layout.hpp"

namespace sightline {
namespace {

using test::Chooses;
using test::LayoutFigures;

/// `best` beside whoever is nearest, of all robots and of the anchors alone.
TEST(ViewChoice, EightRobotsWithTwoAnchorsInAHundredDrawnLayouts) {
  constexpr int layouts = 100;
  fmt::print("area  observes            sigma    blind   no path  changes a minute  between changes\n");
  for (const double area : {5.0, 8.0, 12.0}) {
    const auto fly = [&](Chooses how, std::string_view name, int at_most = 100) {
      const LayoutFigures f = fly_layouts({.area = area, .at_most = at_most}, how, layouts);
      fmt::print("{:2.0f} m  {:18} {:6.1f} mm  {:4.1f} %  {:5.1f} %  {:8.1f}          {:.2f} s\n", area, name,
                 1e3 * f.sigma(), 100 * f.share(f.blind), 100 * f.share(f.rootless), f.changes_a_minute(),
                 f.least_between);
      return f;
    };
    const LayoutFigures best = fly(Chooses::best, "best"), two = fly(Chooses::best, "best, at most 2", 2);
    EXPECT_LE(two.most_observers, 2);
    for (const auto& [how, name] : {std::pair{Chooses::nearest_anchor, "the nearest anchor"},
                                    std::pair{Chooses::nearest, "the nearest"}}) {
      const LayoutFigures nearest = fly(how, name);
      EXPECT_LE(best.sigma(), 0.8 * nearest.sigma()) << name << ' ' << area;
      EXPECT_LE(best.share(best.blind), nearest.share(nearest.blind) / 3) << name << ' ' << area;
      if (area == 5.0) {
        EXPECT_LE(best.changes_a_minute(), 0.5 * nearest.changes_a_minute()) << name;
      }
    }
    for (const LayoutFigures& f : {best, two}) {
      EXPECT_GE(f.least_between, ViewChoice{}.dwell - 1e-9) << area;
    }
    EXPECT_EQ(best.rootless, 0) << area;
  }
}

}  // namespace
}  // namespace sightline
