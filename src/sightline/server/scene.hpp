/// What a flight looks like, as simple bodies to be drawn: pure, no messages.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/judge/present_team.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline {

/// Each from 0 to 1.
struct Colour {
  float r = 0, g = 0, b = 0, a = 1;
};

/// One body, in G. Numbers of `form` are those of visualization_msgs/Marker.
struct Drawn {
  enum Form { arrow = 0, sphere = 2, line = 4, text = 9, triangles = 11 };
  std::string_view group;  ///< of bodies that are shown and hidden together
  int id = 0;              ///< in its group, the same at all times
  Form form = sphere;
  Colour colour{};
  Vec3<double> p{};            ///< [m]
  Quaternion q{};              ///< its axes in G
  Vec3<double> size{1, 1, 1};  ///< along its axes [m]; of a line, x is its width; of a text, z its height
  std::vector<Vec3<double>> points{};  ///< of lines, and of triangles three each [m]
  std::string words{};                 ///< of a text
};

/// Draws robots, targets and obstacles with their hard distance, who is to see whom, and how far those are from each other that are
/// coupled.
class Scene {
 public:
  explicit Scene(const Scenario& scenario);

  /// @param bodies  how each body is seen, in the order of the team; none: not known yet, and nothing of it is drawn
  /// @param t       [s]
  std::vector<Drawn> draw(std::span<const std::optional<Sight<double>>> bodies, double t) const;

  /// Two bodies with a coupling between them.
  struct Pair {
    BodyId a, b;
    std::optional<Observation> view{};  ///< a is to see b
  };
  const std::vector<Pair>& pairs() const { return pairs_; }

 private:
  void draw_body(std::vector<Drawn>& all, int body, const Sight<double>& seen) const;
  void draw_pair(std::vector<Drawn>& all, int id, const Pair& pair, const Sight<double>& a,
                 const Sight<double>& b, double t) const;

  Team team_;
  std::vector<Pair> pairs_;
  std::vector<double> d_hard_;  // of each body that is no robot [m]; 0: nobody keeps one
};

}  // namespace sightline
