"""Who is there, what is in force and what each term says of the poses: by the scenario and the events of its log."""

import numpy as np

from formula import excess, parameters, value

_same = 1e-9  # [s]


class Term:
    """A potential between two bodies, or of one (a == b), in force from `since` to `until` [s]."""

    def __init__(self, kind, keys, a, b, felt_by, name, since):
        self.kind, self.keys, self.a, self.b, self.felt_by, self.name = kind, keys, a, b, list(felt_by), name
        self.since, self.until = since, np.inf

    def again(self, since, before, now, robots):
        """The same from `since` on, with another body in the place of one."""
        swap = lambda name: now if name == before else name
        felt = [swap(name) for name in self.felt_by]
        return Term(self.kind, self.keys, swap(self.a), swap(self.b), [name for name in felt if name in robots], self.name, since)

    @property
    def is_limit(self):
        return self.kind != "relative_velocity"

    @property
    def is_view(self):
        return self.kind in ("bearing", "sensor_cone") or (self.kind == "region" and ("bearing" in str(self.keys) or "azimuth" in str(self.keys)))

    @property
    def keeps_apart(self):
        if self.kind == "region":
            return "distance >" in str(self.keys) or "hypot(r_x" in str(self.keys)
        return self.kind in ("too_near", "keep_out", "pass_right")

    @property
    def label(self):
        return f"{self.kind} {self.a}" if self.a == self.b else f"{self.kind} {self.a}-{self.b}"

    def excess(self, flight, sensor):
        """How far the limit is broken at each sample, in its unit."""
        a, b, keys = flight.bodies[self.a], flight.bodies[self.b], self.keys
        r = b.p - a.p
        distance = np.linalg.norm(r, axis=1)
        if self.kind in ("too_near", "keep_out"):
            return keys.get("d_min", 1.0) - distance
        if self.kind in ("too_far", "cohesion"):
            return distance - keys.get("d_max", 2.0)
        if self.kind == "altitude_band":
            return np.maximum(keys.get("z_min", 0.3) - a.p[:, 2], a.p[:, 2] - keys.get("z_max", 3.0))
        if self.kind == "geofence":
            return np.maximum(a.p - np.array(keys["high"]), np.array(keys["low"]) - a.p).max(axis=1)
        if self.kind == "pass_right":
            # Each is pushed off from where it has the other a little to its left.
            half = 0.5 * keys.get("delta", 0.2)
            x = -r[:, 0] + half * (a.d[:, 1] - b.d[:, 1])
            y = -r[:, 1] - half * (a.d[:, 0] - b.d[:, 0])
            return keys.get("d_min", 1.0) - np.sqrt(x * x + y * y + r[:, 2] ** 2)
        x, y, z = in_sensor(a, b, sensor)
        if self.kind in ("bearing", "sensor_cone"):
            return np.arctan2(np.hypot(y, z), x) - keys.get("alpha", 0.5)
        names = {**parameters(keys.get("parameters")), "x": x, "y": y, "z": z, "t": flight.times, "distance": distance,
                 "range": np.sqrt(x * x + y * y + z * z), "bearing": np.arctan2(np.hypot(y, z), x), "azimuth": np.arctan2(y, x),
                 "elevation": np.arctan2(z, np.hypot(x, y)), "r_x": r[:, 0], "r_y": r[:, 1], "r_z": r[:, 2]}  # fmt: skip
        for who, body in (("observer", a), ("target", b)):
            for i, axis in enumerate("xyz"):
                names[f"{who}__p_{axis}"], names[f"{who}__v_{axis}"] = body.p[:, i], body.v[:, i]
        return excess(keys["inside"], names) + 0 * distance


def in_sensor(a, b, sensor):
    """b in the frame of the sensor on a: along its axis, to the left, up."""
    (yaw, pitch, roll), offset = sensor
    x, y, up = (b.p - a.p).T
    ahead, left, up = x * a.d[:, 0] + y * a.d[:, 1] - offset[0], y * a.d[:, 0] - x * a.d[:, 1] - offset[1], up - offset[2]
    ahead, left = ahead * np.cos(yaw) + left * np.sin(yaw), left * np.cos(yaw) - ahead * np.sin(yaw)
    ahead, up = ahead * np.cos(pitch) - up * np.sin(pitch), ahead * np.sin(pitch) + up * np.cos(pitch)
    return ahead, left * np.cos(roll) + up * np.sin(roll), up * np.cos(roll) - left * np.sin(roll)


class Team:
    def __init__(self, scenario, flight, robots):
        self.scenario, self.flight, self.models = scenario, flight, robots
        self.robots = flight.robots
        self.terms, self.retuned, self.changed = [], [], set()  # changed: robots with new goals
        self.duties = {}
        for name in flight.names:
            there = all(scenario.get(kind, {}).get(name, {}).get("present", True) for kind in ("agent", "target", "obstacle"))
            self.duties[name] = [(-1.0, "steered" if there and name in self.robots else "hold" if there else "absent")]
        for at in scenario.get("couple", []):
            self._add_coupling(at, 0.0)
        for at in scenario.get("shape", []):
            self._add_shape(at)
        for at in scenario.get("constrain", []):
            self._add_constraint(at, 0.0)
        for time, kind, number in flight.events:
            if kind == "event_in_force":
                self._happen(flight.script[int(number)], time)

    # --- at the samples ---

    def duty(self, name):
        """Per sample: steered, hold, land or absent."""
        since = np.array([time for time, _ in self.duties[name]]) - _same
        return np.array([duty for _, duty in self.duties[name]])[np.searchsorted(since, self.flight.times, side="right") - 1]

    def lands(self, name):
        """Per sample: whether it lands by an event or by itself, or has landed."""
        lands = self.duty(name) == "land"
        place = self.flight.names.index(name)
        for time, kind, number in self.flight.events:
            if kind in ("land", "grounded") and int(number) == place:
                lands |= self.flight.times >= time - _same
        return lands

    def counts(self, term):
        """Per sample: whether the term is in force, with both bodies there and somebody who feels it."""
        times = self.flight.times
        counts = (times >= term.since - _same) & (times < term.until - _same)
        counts &= self.flight.bodies[term.a].there & self.flight.bodies[term.b].there
        felt = np.zeros(len(times), bool)
        for name in term.felt_by:
            felt |= self.duty(name) == "steered"
        return counts & felt

    def sensor(self, name):
        keys = self.scenario.get("agent", {}).get(name, {}).get("sensor", {})
        offset = keys.get("offset", 0.17)
        angles = keys.get("yaw", 0.0), keys.get("pitch", 0.5), keys.get("roll", 0.0)
        return angles, offset if isinstance(offset, list) else [offset, 0.0, 0.0]

    def excess(self, term):
        return term.excess(self.flight, self.sensor(term.a))

    def input_limits(self, name):
        """(u_min, u_max) in force at each sample, (samples, inputs)."""
        agent, times = self.scenario["agent"][name], self.flight.times
        low, high = self.models[name].limits()
        if "u_min" in agent:
            low = np.array(agent["u_min"], float)
        if "u_max" in agent:
            high = np.array(agent["u_max"], float)
        low, high = np.tile(low, (len(times), 1)), np.tile(high, (len(times), 1))
        if "limits" in agent:
            at = np.clip(np.searchsorted(np.array(agent["limits"]["times"]), times, side="right") - 1, 0, None)
            low, high = np.array(agent["limits"]["u_min"], float)[at], np.array(agent["limits"]["u_max"], float)[at]
        for robot, since, keys in self.retuned:
            if robot == name:
                now = times >= since - _same
                low[now] = np.array(keys["u_min"], float) if "u_min" in keys else low[now]
                high[now] = np.array(keys["u_max"], float) if "u_max" in keys else high[now]
        return low, high

    def hard_distance(self, a, b):
        for name in (a, b):
            for kind in ("target", "obstacle"):
                own = self.scenario.get(kind, {}).get(name, {})
                if "d_hard" in own:
                    return own["d_hard"]
        return self.scenario["safety"].get("d_hard", 0.6) if "safety" in self.scenario else None

    # --- what is in force ---

    def _add(self, potential, a, b, felt_by, name, since):
        for kind, keys in potential.items():
            if isinstance(keys, dict):
                self.terms.append(Term(kind, keys, a, b, felt_by, name, since))

    def _robots_of(self, *names):
        return [name for name in names if name in self.robots]

    def _add_coupling(self, at, since):
        a, b = at["between"]
        self._add(at["potential"], a, b, at.get("felt_by", self._robots_of(a, b)), at.get("name", ""), since)

    def _add_constraint(self, at, since):
        if "limit" not in at:
            self._add(at["potential"], at["agent"], at["agent"], [at["agent"]], at.get("name", ""), since)

    def _add_shape(self, at):
        line = at.get("chain") or at.get("ring") or []
        pairs = [(b, a) for a, b in zip(line, line[1:])]
        if "ring" in at:
            pairs.append((line[0], line[-1]))
        if "star" in at:
            pairs += [(name, at["star"]["centre"]) for name in at["star"]["observers"]]
        if "all_pairs" in at:
            everybody = self.robots if isinstance(at["all_pairs"], str) else at["all_pairs"]
            pairs += [(a, b) for i, a in enumerate(everybody) for b in everybody[i + 1 :]]
        relay = at.get("nearest")
        if relay:
            pairs = [(relay["observers"][0], relay["target"])]
        for a, b in pairs:
            felt = [a] if relay or at.get("felt_by") == "observer" else self._robots_of(a, b)
            for potential in at.get("potentials", [at.get("potential")]):
                self._add(potential, a, b, felt, f"relay of {a}" if relay else "", 0.0)

    def _end(self, name, time):
        for term in self.terms:
            if term.name == name and np.isinf(term.until):
                term.until = time

    def _happen(self, name, time):
        for place, event in enumerate(self.scenario.get("event", [])):
            if event.get("name", f"event[{place}]") == name:
                for key in ("remove", "add", "retune", "observe", "reference"):
                    for action in event[key] if isinstance(event.get(key), list) else [event[key]] if key in event else []:
                        self._act(key, action, time)
                return
        if " takes over from " in name:
            for at in self.scenario.get("shape", []):
                label = at.get("name", "nearest") + ": "
                if "nearest" in at and name.startswith(label):
                    now, before = name[len(label) :].split(" takes over from ")
                    self._end(f"relay of {before}", time)
                    for potential in at["potentials"]:
                        self._add(potential, now, at["nearest"]["target"], [now], f"relay of {now}", time)

    def _act(self, key, action, time):
        table = action if isinstance(action, dict) else {}
        body = action if isinstance(action, str) else next((table[kind] for kind in ("agent", "target", "obstacle") if kind in table), None)
        term = table.get("couple", table.get("constrain"))
        if key == "remove" and term is not None:
            self._end(term, time)
        elif key == "remove":
            self.duties[body].append((time, {"hold": "hold", "land": "land"}.get(table.get("then"), "absent")))
        elif key == "add" and "couple" in table:
            self._add_coupling(table["couple"], time)
        elif key == "add" and "constrain" in table:
            self._add_constraint(table["constrain"], time)
        elif key == "add":
            self.duties[body].append((time, "steered" if body in self.robots else "hold"))
        elif key == "observe":
            self._observe(table["observer"], table["target"], time)
        elif key == "reference" or "agent" in table:
            self.changed.add(body)
            if "u_min" in table or "u_max" in table:
                self.retuned.append((body, time, table))
        elif "potential" in table:
            old = next((one for one in self.terms if one.name == term and np.isinf(one.until)), None)
            if old is not None:
                old.until = time
                self._add(table["potential"], old.a, old.b, old.felt_by, term, time)

    def _observe(self, observer, target, time):
        """Views and what holds the observer to its target go over; what keeps apart stays, and the new target gets the same."""
        now = [term for term in self.terms if np.isinf(term.until)]
        looks = next((term for term in now if term.a == observer and term.is_view), None)
        if looks is None:
            return
        before = looks.b
        for term in now:
            if {term.a, term.b} != {observer, before} or (term.a == before and term.is_view):
                continue
            if not term.keeps_apart:
                term.until = time
                follower = term.again(time, before, target, self.robots)
                if follower.felt_by:
                    self.terms.append(follower)
