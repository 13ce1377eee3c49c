/// A short flight of the paper's pair with an obstacle and an event, to be looked at.
#pragma once

#include <string>

namespace sightline::test {

/// Two multirotors, of which the first has a sensor; what follows is of the second.
inline const std::string viewed_pair = R"toml(
[horizon]
duration = 1.0
stages = 20
period = 0.01

[agent.uav0]
robot = "multirotor"
start = { p = [-0.6, -0.3, 0.6], heading = 0.0 }
Q = [0.0, 0.0, 0.0, 0.0, 0.0, 0.7, 0.7]
R = [1.0, 1.0, 1.0, 1.0]

[agent.uav0.sensor]
pitch = 0.5
offset = 0.17

[agent.uav1]
robot = "multirotor"
start = { p = [0.9, 0.0, 0.5], heading = 0.0 }
Q = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]
R = [1.0, 1.0, 1.0, 1.0]
)toml";

inline const std::string view_scenario =
    viewed_pair + R"toml(reference = { state = [0.9, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0] }

[obstacle.post]
p = [4.0, 0.0, 1.0]
d_hard = 0.5

[[couple]]
potential = { sensor_cone = { alpha = 0.5, kappa_G = 0.01, kappa_A = 2.0 } }
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 0.4
name = "view"

[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 0.4

[[event]]
name = "look away"
at = 0.5
remove = { couple = "view" }

[simulation]
duration = 1.0
)toml";

/// uav0 and a ball stay 1 to 2 m apart.
inline const std::string ball_distances = R"toml(
[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["ball", "uav0"]
felt_by = ["uav0"]
weight = 0.4
[[couple]]
potential = { cohesion = { d_max = 2.0 } }
between = ["uav0", "ball"]
weight = 0.4
)toml";

}  // namespace sightline::test
