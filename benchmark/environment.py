"""A task of the benchmark as an environment for learning, with the interface of Gymnasium.

    env = KeepInView("adversary")
    observation, info = env.reset(seed=3)
    observation, reward, terminated, truncated, info = env.step(action)

It needs the Python module `sightline`; gymnasium is used where it is installed, and numpy alone otherwise. Starts are
those of the task's file, noise and wind those of the seed.
"""

import math
import pathlib
import tomllib

import numpy as np
import sightline as sl

try:
    import gymnasium
    from gymnasium.spaces import Box
except ImportError:
    gymnasium, Box = None, None

TASKS = pathlib.Path(__file__).resolve().parent / "tasks"


class KeepInView(gymnasium.Env if gymnasium else object):
    """One observer of a task; newton_riccati steers the other robots.

    action: inputs of the observer, within their limits (4)
    observation: the target's position [m] and velocity [m/s] in the observer's frame V (x ahead, y left, z up), and the
        observer's own v_f and v_s [m/s]; as measured (8)
    reward: 1 in a period with the target within alpha and between d_min and d_max, else 0
    terminated: nearer to the target than half of d_min; truncated: the task's duration is over
    """

    def __init__(self, task="adversary"):
        self.scenario = sl.Scenario.read(TASKS / f"{task}.toml")
        couples = tomllib.loads(self.scenario.expanded)["couple"]
        kinds = [next(iter(couple["potential"].items())) for couple in couples]
        views = [i for i, (kind, _) in enumerate(kinds) if kind in ("bearing", "sensor_cone")]
        if len(views) != 1:
            raise ValueError(f"task = {task}, expected one observer, it has {len(views)}")
        between = couples[views[0]]["between"]
        own = {kind: keys for couple, (kind, keys) in zip(couples, kinds) if couple["between"] == between}
        self.alpha = kinds[views[0]][1]["alpha"]
        self.d_min = (own.get("too_near") or own["keep_out"])["d_min"]
        self.d_max = (own.get("too_far") or own["cohesion"])["d_max"]
        self.world = sl.World(self.scenario)
        self.others = sl.Solver.of(self.scenario)
        team = self.world.team
        robot, self.target = map(team.find, between)
        self.model, self.target_model = team.model(robot), team.model(self.target)
        self.state, self.target_state, self.input = team.state(robot), team.state(self.target), team.input(robot)
        sensor = tomllib.loads(self.scenario.expanded)["agent"][between[0]]["sensor"]
        yaw, pitch, arm = sensor.get("yaw", 0.0), sensor["pitch"], sensor["offset"]
        self.axis = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
        self.offset = np.array(arm if isinstance(arm, list) else [arm, 0.0, 0.0])
        if Box:
            self.action_space = Box(-1.0, 1.0, (4,), np.float64)
            self.observation_space = Box(-np.inf, np.inf, (8,), np.float64)

    def seen(self, states):
        """Target's position and velocity in V, and the robot's own velocity."""
        x, of_target = states[self.state], states[self.target_state]
        robot = self.model.sight(x, np.zeros(self.model.nu))
        target = self.target_model.sight(of_target, np.zeros(self.target_model.nu))
        turn = np.array([[x[3], x[4], 0], [-x[4], x[3], 0], [0, 0, 1]])
        return np.concatenate([turn @ (target.p - robot.p), turn @ target.v, x[5:7]])

    def angle(self, q):
        """Angle of a place in V off the axis of the sensor [rad]; the sensor is level."""
        r = q - self.offset
        return math.atan2(np.linalg.norm(np.cross(self.axis, r)), self.axis @ r)

    def reset(self, *, seed=None, options=None):
        if gymnasium:
            super().reset(seed=seed)
        self.world.restart(seed)
        self.others.restart()
        return self.seen(self.world.x), {}

    def step(self, action):
        u = np.array(self.others.step(self.world.time, self.world.x))
        u[self.input] = np.clip(action, -1.0, 1.0)
        self.world.step(u)
        q = self.seen(self.world.truth)[:3]
        distance = float(np.linalg.norm(q))
        in_view = self.angle(q) <= self.alpha
        reward = float(in_view and self.d_min <= distance <= self.d_max)
        over = self.world.time >= self.scenario.duration - 0.5 * self.world.dt
        return self.seen(self.world.x), reward, distance < 0.5 * self.d_min, over, {"in_view": in_view}
