/// Scene of a flight as drawable primitives, without messages.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/judge/present_team.hpp"
#include "sightline/scenario.hpp"
#include "sightline/world.hpp"

namespace sightline {

/// Components from 0 to 1.
struct Colour {
  float r = 0, g = 0, b = 0, a = 1;
};

/// One primitive, in G. Values of `form` are those of visualization_msgs/Marker.
struct Drawn {
  enum Form { arrow = 0, sphere = 2, line = 4, text = 9, triangles = 11 };
  std::string_view group;  ///< primitives that are shown and hidden together
  int id = 0;              ///< unique in its group and constant over time
  Form form = sphere;
  Colour colour{};
  Vec3<double> p{};                    ///< [m]
  Quaternion q{};                      ///< orientation in G
  Vec3<double> size{1, 1, 1};          ///< along its axes [m]; x: width of a line; z: height of a text
  std::vector<Vec3<double>> points{};  ///< of lines; of triangles, three each [m]
  std::string words{};                 ///< content of a text
};

/// Lower and upper end of a drawn zone [m]; one without a bound is drawn 3 m high.
std::pair<double, double> drawn_heights(const Zone& zone) noexcept;

/// Draws zones, robots, targets and obstacles with their hard distances, the views of observers,
/// and the distances of coupled bodies.
class Scene {
 public:
  explicit Scene(const Scenario& scenario);

  /// @param bodies  sight of each body, in the order of the team; none: unknown and not drawn
  /// @param t       [s]
  std::vector<Drawn> draw(std::span<const std::optional<Sight<double>>> bodies, double t) const;

  /// Two coupled bodies.
  struct Pair {
    BodyId a, b;
    std::optional<Observation> view{};  ///< a observes b
  };
  const std::vector<Pair>& pairs() const { return pairs_; }

 private:
  void draw_body(std::vector<Drawn>& all, int body, const Sight<double>& seen) const;
  void draw_pair(std::vector<Drawn>& all, int id, const Pair& pair, const Sight<double>& a,
                 const Sight<double>& b, double t) const;

  Team team_;
  std::vector<Pair> pairs_;
  std::vector<double> d_hard_;  // of each body that is no robot [m]; 0: none
  std::vector<Drawn> zones_;
};

}  // namespace sightline
