"""How bodies move between the samples of a log: the formulas of docs/robots.md, integrated from each sample.

Where the next sample is elsewhere, as wind or noise of the world make it, the difference is spread over the period as
that of an acceleration, and a part of it counts as not known.
"""

import numpy as np

from formula import parameters, value

fine = 0.01  # [s] between two places of a motion

_multirotor = dict(b_z=1.0, b_psi=1.6, a_f=-0.5092, b_f=1.458, a_s=-0.5092, b_s=1.458)
_rover = dict(b_psi=1.5, a_f=-2.5, b_f=2.5, a_s=-2.5, b_s=2.5)
_hover = {
    "x500": dict(b_z=1.08, b_psi=1.6, a_f=-0.123, b_f=2.0, a_s=-0.123, b_s=2.0),
    "crazyflie": dict(b_z=1.0, b_psi=1.585, a_f=-0.484, b_f=2.03, a_s=-0.484, b_s=2.03),
    "ar_drone": _multirotor,
}
_velocity = {
    "px4": dict(tau_f=0.5, tau_s=0.5, tau_z=0.35, tau_psi=0.2, v_max=3.0, climb_max=1.0, yaw_max=0.78),
    "ar_drone": dict(tau_f=1 / 0.5092, tau_s=1 / 0.5092, tau_z=0.3, tau_psi=0.2, v_max=1.458 / 0.5092, climb_max=1.0, yaw_max=1.6),
}
_text_inputs = {"multirotor": 4, "angle_multirotor": 4, "velocity_multirotor": 4, "hover_multirotor": 4, "omni_rover": 3, "unicycle": 2, "point_mass": 3}
_gravity = 9.81


class Robot:
    """A robot of a scenario, by its table [agent.NAME]."""

    def __init__(self, table):
        robot = table["robot"]
        self.kind = robot if isinstance(robot, str) else "text"
        self.text = None if isinstance(robot, str) else robot["text"]
        given = parameters({k: v for k, v in table.get("parameters", {}).items() if k not in ("preset", "frame")})
        preset = table.get("parameters", {}).get("preset")
        self.level = table.get("parameters", {}).get("frame") == "level"
        defaults = {
            "hover_multirotor": {**_hover.get(preset or "x500", {}), "tau": 0.0, "tau_z": 0.0, "tau_psi": 0.0},
            "velocity_multirotor": _velocity.get(preset or "px4"),
            "point_mass": {"drag": 0.0},
            "omni_rover": _rover,
            "unicycle": _rover,
        }.get(self.kind, _multirotor)
        self.of = given if self.text else {**defaults, **given}

    @property
    def has_height(self):
        """Whether its height ever changes."""
        if self.text:
            return self.text["f"][self.text["position"][2]] != 0
        return self.kind not in ("omni_rover", "unicycle")

    def limits(self):
        """(u_min, u_max) where the scenario states none."""
        if self.kind == "velocity_multirotor":
            most = np.array([self.of["v_max"], self.of["v_max"], self.of["climb_max"], self.of["yaw_max"]])
        elif self.text:
            if "u_min" in self.text:
                return np.array(self.text["u_min"], float), np.array(self.text["u_max"], float)
            most = np.ones(len(self.text["inputs"]))
        else:
            most = np.ones(_text_inputs[self.kind])
        return -most, most

    def position(self, x):
        if not self.text:
            return x[:, :3]
        return x[:, [self.text["states"].index(name) for name in self.text["position"]]]

    def heading_angle(self, x):
        if self.text:
            heading, states = self.text["heading"], self.text["states"]
            if isinstance(heading, str):
                return x[:, states.index(heading)]
            return np.arctan2(x[:, states.index(heading[1])], x[:, states.index(heading[0])])
        if self.kind == "angle_multirotor":
            return x[:, 3]
        if self.kind == "point_mass":
            return np.zeros(len(x))
        return np.arctan2(x[:, 4], x[:, 3])

    def rate(self, x, u):
        """f(x, u); rows are samples."""
        if self.text:
            names = {**self.of, **dict(zip(self.text["states"], x.T)), **dict(zip(self.text["inputs"], u.T))}
            rates = [value(self.text["f"][state], names) for state in self.text["states"]]
            return np.stack([np.broadcast_to(rate, len(x)) for rate in rates], axis=1)
        return getattr(self, "_" + self.kind)(x, u, self.of)

    @staticmethod
    def _point_mass(x, u, of):
        return np.concatenate([x[:, 3:6], u - of["drag"] * x[:, 3:6]], axis=1)

    @staticmethod
    def _angle_multirotor(x, u, of):
        c, s = np.cos(x[:, 3]), np.sin(x[:, 3])
        return np.stack([c * x[:, 4] - s * x[:, 5], s * x[:, 4] + c * x[:, 5], of["b_z"] * u[:, 2], of["b_psi"] * u[:, 3],
                         of["a_f"] * x[:, 4] + of["b_f"] * u[:, 0], of["a_s"] * x[:, 5] - of["b_s"] * u[:, 1]], axis=1)  # fmt: skip

    @staticmethod
    def _plane(x, climb, turn, ahead, left, more=()):
        """Of the states p, d, v_f, v_s, ... by their rates."""
        dx, dy = x[:, 3], x[:, 4]
        return np.stack([dx * x[:, 5] - dy * x[:, 6], dy * x[:, 5] + dx * x[:, 6], climb, -dy * turn, dx * turn, ahead, left, *more], axis=1)

    def _multirotor(self, x, u, of):
        return self._plane(x, of["b_z"] * u[:, 2], of["b_psi"] * u[:, 3], of["a_f"] * x[:, 5] + of["b_f"] * u[:, 0],
                           of["a_s"] * x[:, 6] - of["b_s"] * u[:, 1])  # fmt: skip

    def _omni_rover(self, x, u, of):
        return self._plane(x, 0 * u[:, 0], of["b_psi"] * u[:, 2], of["a_f"] * x[:, 5] + of["b_f"] * u[:, 0],
                           of["a_s"] * x[:, 6] - of["b_s"] * u[:, 1])  # fmt: skip

    @staticmethod
    def _unicycle(x, u, of):
        turn = of["b_psi"] * u[:, 1]
        return np.stack([x[:, 3] * x[:, 5], x[:, 4] * x[:, 5], 0 * turn, -x[:, 4] * turn, x[:, 3] * turn,
                         of["a_f"] * x[:, 5] + of["b_f"] * u[:, 0]], axis=1)  # fmt: skip

    def _velocity_multirotor(self, x, u, of):
        climbs, turns = of["tau_z"] > 0, of["tau_psi"] > 0
        climb = x[:, 7] if climbs else u[:, 2]
        turn = x[:, -1] if turns else u[:, 3]
        ahead, left = (u[:, 0] - x[:, 5]) / of["tau_f"], (u[:, 1] - x[:, 6]) / of["tau_s"]
        if self.level:
            ahead, left = ahead + turn * x[:, 6], left - turn * x[:, 5]
        more = [(u[:, 2] - x[:, 7]) / of["tau_z"]] if climbs else []
        more += [(u[:, 3] - x[:, -1]) / of["tau_psi"]] if turns else []
        return self._plane(x, climb, turn, ahead, left, more)

    def _hover_multirotor(self, x, u, of):
        ahead, left, climb, turn, more = of["b_f"] * u[:, 0], -of["b_s"] * u[:, 1], of["b_z"] * u[:, 2], of["b_psi"] * u[:, 3], []
        if of["tau"] > 0:
            lift = (climb - x[:, 9]) / of["tau_z"]
            more = [(ahead - x[:, 7]) / of["tau"], (left - x[:, 8]) / of["tau"], lift, (turn - x[:, 10]) / of["tau_psi"]]
            ahead, left = (1 + lift / _gravity) * x[:, 7], (1 + lift / _gravity) * x[:, 8]
            climb, turn = x[:, 9], x[:, 10]
        ahead = of["a_f"] * x[:, 5] + ahead + turn * x[:, 6]
        left = of["a_s"] * x[:, 6] + left - turn * x[:, 5]
        return self._plane(x, climb, turn, ahead, left, more)


class Piece:
    """Samples [first] whose periods are cut alike: places (n, cuts + 1, 3) of each body, and by how much they may err [m]. Periods are also
    cut where commands come into force."""

    def __init__(self, first, span, arrivals):
        self.first, self.span = first, span
        self.places, self.err, self.ends = {}, {}, {}
        cuts = np.linspace(0.0, 1.0, max(1, int(np.ceil(span / fine - 1e-9))) + 1)
        within = arrivals[(arrivals > 1e-9) & (arrivals < span - 1e-9)] / span
        self.at = np.union1d(cuts, within)


def _modelled(robot, body, piece, commands):
    """Places by the model under `commands` (n, cuts): of which sample they are, -1: none, and the robot rests."""
    x = body.x[piece.first]
    places = [robot.position(x)]
    with np.errstate(all="ignore"):
        for h, command in zip(np.diff(piece.at) * piece.span, commands.T):
            u = np.where(command[:, None] >= 0, body.u[command], 0.0)
            a = robot.rate(x, u)
            b = robot.rate(x + h / 2 * a, u)
            c = robot.rate(x + h / 2 * b, u)
            d = robot.rate(x + h * c, u)
            x = x + h / 6 * (a + 2 * b + 2 * c + d)
            places.append(robot.position(x))
    return np.stack(places, axis=1)


def _hermite(body, piece, after):
    """From positions and horizontal velocities; heights by the slopes between samples."""
    k, s = piece.first, piece.at[None, :, None]
    p0, p1 = body.p[k], body.p[after]
    v0, v1 = body.v[k].copy(), body.v[after].copy()
    slope = np.gradient(body.p[:, 2]) / piece.span if len(body.p) > 1 else np.zeros(len(body.p))
    v0[:, 2], v1[:, 2] = slope[k], slope[after]
    p0, p1, v0, v1 = (np.nan_to_num(a)[:, None, :] for a in (p0, p1, v0 * piece.span, v1 * piece.span))
    return (2 * s**3 - 3 * s**2 + 1) * p0 + (s**3 - 2 * s**2 + s) * v0 + (3 * s**2 - 2 * s**3) * p1 + (s**3 - s**2) * v1


def motions(flight, robots, vehicles, jumps, delay):
    """Pieces of the whole flight. `vehicles`: whether the world moves robots by other dynamics than their models'; `jumps`: when a body is
    put elsewhere; `delay`: from a command to its effect [s]."""
    steps = flight.steps
    last = np.append(np.diff(steps), 1)
    # Between commands, as in periods that were missed, the one before is in force. After the last
    # one the motion goes on for a period, whether its end is in the log or not.
    given = np.flatnonzero(flight.commanded)

    def in_force(piece, delay):
        """Of which sample the command is that is in force in each part of each period; -1: none has come yet."""
        middle = 0.5 * (piece.at[:-1] + piece.at[1:]) * piece.span
        times = (steps[piece.first] * flight.period)[:, None] + middle
        arrived = np.searchsorted(steps[given] * flight.period + delay, times, side="right") - 1
        return np.where(arrived >= 0, given[np.maximum(arrived, 0)], -1)

    first = np.flatnonzero(flight.commanded | (np.arange(len(steps)) < len(steps) - 1))
    pieces = []
    for length in sorted(set(last[first])):
        span = length * flight.period
        pieces.append(Piece(first[last[first] == length], span, delay % flight.period + np.arange(length) * flight.period))
    for piece in pieces:
        after = np.minimum(piece.first + 1, len(steps) - 1)
        logged = piece.first + 1 < len(steps)
        commands = in_force(piece, delay)
        for name, body in flight.bodies.items():
            there = body.there[piece.first]
            stays = there & logged & body.there[after]
            if name in jumps:
                stays &= (jumps[name] < flight.times[piece.first] - 1e-9) | (jumps[name] > flight.times[after] + 1e-9)
            p0, p1 = body.p[piece.first], body.p[after]
            straight = p0[:, None, :] + piece.at[None, :, None] * np.where(stays[:, None], p1 - p0, piece.span * np.nan_to_num(body.v[piece.first]))[:, None, :]
            err = np.zeros(len(piece.first))
            if not body.is_robot:
                places = straight
                if piece.span > 1.5 * flight.period:
                    err = np.linalg.norm(p0 + piece.span * np.nan_to_num(body.v[piece.first]) - straight[:, -1], axis=1)
            elif vehicles:
                places = np.where(stays[:, None, None], _hermite(body, piece, after), straight)
                err = np.linalg.norm(places - straight, axis=2).max(axis=1) + np.where(stays, 0, 0.5 * piece.span)
                if delay > 0:  # commands that change within a period bend the motion
                    moved = _modelled(robots[name], body, piece, commands) - _modelled(robots[name], body, piece, in_force(piece, 0.0))
                    bends = moved - piece.at[None, :, None] * moved[:, -1:]
                    err += np.nan_to_num(np.linalg.norm(bends, axis=2).max(axis=1))
            else:
                places = _modelled(robots[name], body, piece, commands)
                off = np.where(stays[:, None], p1 - places[:, -1], 0.0)
                places = places + piece.at[None, :, None] ** 2 * off[:, None, :]
                err = 0.3 * np.linalg.norm(off, axis=1)
            piece.places[name], piece.err[name] = places, err
            piece.ends[name] = np.where(there, np.where(stays | ~logged, 2, 1), 0)
    return pieces


def nearest(piece, a, b):
    """Of two bodies: least distance in each period of the piece, as if both were there."""
    r = piece.places[a] - piece.places[b]
    step = r[:, 1:] - r[:, :-1]
    length2 = np.einsum("ijk,ijk->ij", step, step)
    with np.errstate(all="ignore"):
        part = np.clip(-np.einsum("ijk,ijk->ij", r[:, :-1], step) / np.where(length2 > 0, length2, 1.0), 0.0, 1.0)
    return np.linalg.norm(r[:, :-1] + part[:, :, None] * step, axis=2).min(axis=1)
