#!/usr/bin/env python3
"""An independent judge of a flight:  judge.py SCENARIO FOLDER EXIT_CODE [--realtime]

Reads the scenario and run.mcap, computes what was kept and broken by formulas of its own, and compares that with the exit code
and with summary.json. A sentence for each difference; exit 1 if there is one.
"""

import argparse
import json
import sys
import tomllib
from pathlib import Path

import numpy as np

from flight_log import Flight
from motion import Robot, motions, nearest
from team import Team, in_sensor

near = 1e-3  # by which two ways to compute a distance may differ [m]
lost_after = 2.0  # [s]
shown = 8  # entries of a kind in summary.json
failed = ("not_finite", "invalid_state")


class Verdict:
    """Reasons for a failure: those beyond doubt, and those that are a matter of the last bit or period."""

    def __init__(self):
        self.certain, self.open = [], []

    def add(self, sentence, certain=True):
        (self.certain if certain else self.open).append(sentence)


class Judge:
    def __init__(self, scenario_file, folder, code, realtime=False):
        with open(scenario_file, "rb") as file:
            self.scenario = tomllib.load(file)
        self.flight = Flight(Path(folder) / "run.mcap")
        self.summary = json.loads((Path(folder) / "summary.json").read_text())
        self.code, self.realtime = code, realtime
        self.robots = {name: Robot(self.scenario["agent"][name]) for name in self.flight.robots}
        self.team = Team(self.scenario, self.flight, self.robots)
        self.vehicles = self.scenario.get("world", {}).get("kind", "model") != "model"
        self.simulation = self.scenario.get("simulation", {})
        delay = float(self.simulation.get("disturbance", {}).get("input_delay", 0.0))
        self.pieces = motions(self.flight, self.robots, self.vehicles, self._jumps(), delay)
        self.begins_outside = self.scenario.get("safety", {}).get("start_outside", False)
        self.verdict = Verdict()
        self.differences = []  # (claim, sentence)
        self.wrong_commands = 0

    def _jumps(self):
        """When a body is put elsewhere, as a hand that appears: {name: time}."""
        bodies = {**self.scenario.get("target", {}), **self.scenario.get("obstacle", {})}
        return {name: keys["motion"]["hand"].get("at", 0.0) for name, keys in bodies.items() if "hand" in keys.get("motion", {})}

    def differ(self, claim, sentence):
        if sum(1 for one, _ in self.differences if one == claim) < 5:
            self.differences.append((claim, sentence))

    def expect(self, claim, what, reported, low, high=None):
        """A number of the summary, null for none, against the least and the greatest that are right."""
        high = low if high is None else high
        if reported is None or not np.isfinite(low):
            if (reported is None) != (not np.isfinite(low)):
                self.differ(claim, f"{what}: the summary has {reported}, the judge {low:.6g}")
        elif not low - 1e-12 <= reported <= high + 1e-12:
            self.differ(claim, f"{what}: the summary has {reported:.6g}, the judge {low:.6g} to {high:.6g}")

    def judge(self):
        """(claim, sentence) of each difference."""
        with np.errstate(all="ignore"):  # a state that is not finite is a verdict, too
            self._judge()
        return self.differences

    def _judge(self):
        flight = self.flight
        updates = int(flight.commanded.sum())
        if self.summary["updates"] != updates:
            self.differ("updates", f"{self.summary['updates']} updates in the summary, {updates} in the log")
        if (allocations := self.summary["allocations_per_update"]) != 0:
            self.differ("allocations", f"{allocations} allocations in an update")
        self._end()
        self._landings()
        self._commands()
        self._rates()
        self._plans()
        self._distances()
        self._walls()
        self._views()
        self._limits()
        self._errors()
        self._exit()

    # --- the flight itself ---

    def _end(self):
        flight = self.flight
        for name, body in flight.bodies.items():
            values = [body.x[flight.commanded]] + ([body.u[flight.commanded], body.raw[flight.commanded]] if body.is_robot else [])
            if not all(np.isfinite(one).all() for one in values):
                self.verdict.add(f"a state or an input of {name} is not finite")
        duration = self.simulation.get("duration", 60.0)
        if flight.end < duration - 1.5 * flight.period and not self.realtime:
            self.verdict.add(f"the flight ended at {flight.end:.3f} s, expected {duration} s")
        gaps = np.diff(flight.steps[flight.commanded]) - 1
        missed = sum(int(value) for _, kind, value in flight.events if kind == "missed_period")
        if any(kind == "samples_dropped" for _, kind, _ in flight.events):
            self.verdict.add("samples were dropped")
        elif gaps.sum() > missed:
            self.differ("log", f"{gaps.sum()} periods have no sample, {missed} were missed")

    def _landings(self):
        """No robot lands without an event whose data were not old; periods that are missed make all data old."""
        for time, kind, number in self.flight.events:
            name = self.flight.names[int(number)] if kind == "land" and not self.realtime else None
            if name is None or self.team.duty(name)[self.flight.step_of(time)] == "land" or self._may_be_old(name, time):
                continue
            self.differ("landing", f"{name} lands at {time:.3f} s, and its data were not old")

    def _may_be_old(self, name, until):
        """Whether faults kept its measurements or its plan away for so long that it may land. The longest of them counts from the start,
        since measurements that were refused are accepted again only after some good ones."""
        settling, rarely = 0.6, 0.6  # [s], probability
        now = self.flight.times <= until + 1e-9
        times, body, safety = self.flight.times[now], self.flight.bodies[name], self.scenario.get("safety", {})
        supervisor = safety.get("supervisor", {})
        good, longest = np.ones(len(times)), self.simulation.get("disturbance", {}).get("delay", 0.0)
        for fault in self.simulation.get("fault", []):
            acts = (times >= fault.get("from", 0.0)) & (times <= fault.get("until", np.inf) + settling) & (fault.get("body", name) == name)
            if acts.any():
                longest = max(longest, fault.get("delay", 0.0))
            if fault["kind"] not in ("delay", "late_plan"):
                good[acts] *= 0.0 if fault["kind"] == "freeze" else 1.0 - fault.get("probability", 1.0)
        if (np.abs(body.p[now]) > safety.get("world", 100.0)).any() or (np.linalg.norm(body.v[now], axis=1) > supervisor.get("v_max", 5.0)).any():
            return True
        without_plan = [any(one in (*failed, "deadline") for one in status) for status in np.array(self.flight.status, object)[now]]
        for lacks in (good < 1.0 - rarely, without_plan):
            run = 0
            for lack in lacks:
                run = run + 1 if lack else 0
                longest = max(longest, run * self.flight.period)
        return longest > supervisor.get("land_after", 2.0) - settling

    def _commands(self):
        """Finite and within the limits in force, in each period."""
        flight, beyond, raw_beyond, largest = self.flight, 0, 0, 0.0
        for name in flight.robots:
            body, commanded = flight.bodies[name], flight.commanded
            low, high = self.team.input_limits(name)
            wrong = ~np.isfinite(body.u) & commanded[:, None]

            def outside(u, rows, low=low, high=high):
                return rows[:, None] & ~((u >= low - 1e-9) & (u <= high + 1e-9))

            off, raw = outside(body.u, body.there & commanded), outside(body.raw, body.there & commanded)
            beyond, raw_beyond = beyond + int(off.sum()), raw_beyond + int(raw.sum())
            # Through periods that the loop missed its last inputs were held; the states after the
            # last command are of no period.
            last = np.maximum.accumulate(np.where(commanded, np.arange(len(commanded)), 0))
            missed = ~commanded & (np.arange(len(commanded)) < len(commanded) - 1) & body.there
            beyond += int(outside(body.u[last], missed).sum())
            here = body.raw[body.there & commanded]
            largest = max(largest, float(np.nanmax(np.abs(here)))) if np.isfinite(here).any() else largest
            for k, i in np.argwhere(wrong | off)[:1]:
                self.differ("command", f"input {i} of {name} is {body.u[k, i]:.9g} at {flight.times[k]:.4g} s, limits {low[k, i]:.9g} and {high[k, i]:.9g}")
            self.wrong_commands += int((wrong | off).sum())
        if beyond:
            self.verdict.add(f"{beyond} applied inputs are beyond their limits")
        self.expect("applied_violations", "applied_violations", self.summary["applied_violations"], beyond)
        self.expect("input_violations", "input_violations", self.summary["input_violations"], raw_beyond)
        if np.isfinite(largest):
            self.expect("max_abs_input", "max_abs_input", self.summary["max_abs_input"], largest - 1e-9, largest + 1e-9)

    def _rates(self):
        """No faster than rate_max, but where the limits in force or a barrier ask for it."""
        flight = self.flight
        for name in flight.robots:
            rate_max = self.scenario["agent"][name].get("rate_max")
            if rate_max is None:
                continue
            body, commanded = flight.bodies[name], np.flatnonzero(flight.commanded)
            low, high = (limit[commanded[1:]] for limit in self.team.input_limits(name))
            u, now = body.u[commanded[:-1]], body.u[commanded[1:]]
            most = np.array(rate_max) * np.diff(flight.times[commanded])[:, None]
            least_next = np.minimum(np.maximum(u - most, low), high)
            most_next = np.maximum(np.minimum(u + most, high), low)
            free = body.there[commanded[:-1]] & body.there[commanded[1:]] & (body.active[commanded[1:], 0] != 1.0)
            off = free[:, None] & ((now < least_next - 1e-9) | (now > most_next + 1e-9))
            self.wrong_commands += int(off.sum())
            for k, i in np.argwhere(off)[:1]:
                self.differ("rate", f"input {i} of {name} goes from {u[k, i]:.6g} to {now[k, i]:.6g} at {flight.times[commanded[k + 1]]:.4g} s, "
                            f"rate_max {rate_max[i]}, limits {low[k, i]:.6g} and {high[k, i]:.6g}")  # fmt: skip

    def _plans(self):
        """The time without a plan, from a failed update on."""
        flight = self.flight
        hold_after = self.scenario.get("safety", {}).get("supervisor", {}).get("hold_after", 0.5)
        guarded = "supervisor" in self.scenario.get("safety", {})
        longest = {True: 0.0, False: 0.0}  # with failures of the measurements, or not
        for doubtful in longest:
            since = None
            for k in np.flatnonzero(flight.commanded):
                for status in flight.status[k]:
                    fails = status == "not_finite" or (status == "invalid_state" and (doubtful or not guarded))
                    if status in ("converged", "stepped", "iteration_limit") or (status == "deadline" and self.realtime):
                        since = None
                    elif fails and since is None:
                        since = flight.times[k]
                if since is not None:
                    longest[doubtful] = max(longest[doubtful], flight.times[k] + flight.period - since)
        if longest[True] > hold_after - 1e-9:
            sure = longest[False] > hold_after + (1e-6 if not self.realtime else flight.period)
            self.verdict.add(f"no plan for {longest[True]:.4g} s", sure)

    # --- distances and walls ---

    def _pairs(self):
        for i, a in enumerate(self.flight.names):
            for b in self.flight.names[i + 1 :]:
                if a in self.robots or b in self.robots:
                    yield a, b

    def _least(self, a, b, kept=None):
        """Least distance of the motion: (lowest, highest) that it may be [m]; infinity where they never were there both.
        With `kept` [m], from the first sample on in which they are so far apart."""
        low = high = np.inf
        at_samples = np.linalg.norm(self.flight.bodies[a].p - self.flight.bodies[b].p, axis=1)
        since = int(np.argmax(at_samples >= kept)) if kept is not None else 0
        if np.isfinite(at_samples[since:]).any():
            low = high = float(np.nanmin(at_samples[since:]))
        for piece in self.pieces:
            ends, err = np.minimum(piece.ends[a], piece.ends[b]), piece.err[a] + piece.err[b]
            ends = np.where(piece.first >= since, ends, 0)
            found = nearest(piece, a, b)
            if (ends == 2).any():
                high = min(high, float((found + err)[ends == 2].min()))
            if (ends >= 1).any():
                low = min(low, float((found - err)[ends >= 1].min()))
        return max(0.0, low) if np.isfinite(low) else low, high

    def _distances(self):
        reported = {(one["a"], one["b"]): one for one in self.summary.get("safety", {}).get("hard_distances", [])}
        all_low = all_high = np.inf
        margins = {}
        for a, b in self._pairs():
            low, high = self._least(a, b)
            all_low, all_high = min(all_low, low), min(all_high, high)
            d_hard = self.team.hard_distance(a, b)
            if d_hard is None:
                continue
            all_of_it = low
            if self.begins_outside:
                low, high = self._least(a, b, d_hard)
            one = reported.get((a, b)) or reported.get((b, a))
            if one is not None:
                self.expect("hard_distance", f"least distance of {a} and {b}", one["least"], all_of_it - near, high + near)
                self.expect("hard_distance", f"d_hard of {a} and {b}", one["d_hard"], d_hard)
            margins[a, b] = low - d_hard, high - d_hard
            if low < d_hard + near:
                self.verdict.add(f"{a} comes within {high:.6g} m of {b}, d_hard is {d_hard} m", high < d_hard - near)
        self.expect("min_distance", "min_distance", self.summary["min_distance"], all_low - near, all_high + near)
        if margins and len(reported) < min(shown, len(margins)):
            self.differ("hard_distance", f"{len(reported)} hard distances in the summary, expected {min(shown, len(margins))}")
        worst_reported = max((margins.get(pair, margins.get(pair[::-1], (0, 0)))[1] for pair in reported), default=np.inf)
        for (a, b), (_, margin) in margins.items():
            if (a, b) not in reported and (b, a) not in reported and margin < worst_reported - 2 * near:
                self.differ("hard_distance", f"{a} and {b} have a margin of {margin:.6g} m and are not among the worst in the summary")

    def _walls(self):
        safety = self.scenario.get("safety")
        if safety is None:
            return
        judged = safety.get("barrier", "off") != "off"
        reported = {(one["name"], one["wall"]): one for one in self.summary.get("safety", {}).get("walls", [])}
        for wall, usual in (("floor", 0.3), ("ceiling", 10.0), ("world", 100.0)):
            if not judged and wall not in safety:
                continue
            for name, robot in self.robots.items():
                if wall == "world" or robot.has_height:
                    self._wall(name, wall, float(safety.get(wall, usual)), reported)

    def _wall(self, name, wall, limit, reported):
        flight, body = self.flight, self.flight.bodies[name]
        lands = self.team.lands(name) if wall == "floor" else np.zeros(len(flight.steps), bool)

        def beyond(places):
            if wall == "world":
                return np.maximum(np.abs(places[..., 0]), np.abs(places[..., 1])) - limit
            return limit - places[..., 2] if wall == "floor" else places[..., 2] - limit

        counts = body.there & ~lands
        if not counts.any():
            return
        # Of each sample and the period after it, the greatest excess is between these.
        low, high = beyond(body.p), beyond(body.p)
        last = np.append(lands[1:], False)
        for piece in self.pieces:
            most, err, sure = beyond(piece.places[name]).max(axis=1), piece.err[name], piece.ends[name] == 2
            low[piece.first] = np.where(sure & ~last[piece.first], np.maximum(low[piece.first], most - err), low[piece.first])
            high[piece.first] = np.fmax(high[piece.first], most + err)
        counts = self._judged_from_within(counts, lands, body.there, beyond(body.p) > 1e-6)
        if not counts.any():
            return
        lowest, highest = float(low[counts].max()), float(high[counts].max())
        sentence = f"{name} is {highest:.6g} m beyond the {wall} of {limit} m"
        if highest > 1e-6:
            self.verdict.add(sentence, lowest > near)
        one = reported.get((name, wall))
        if one is None:
            if sum(1 for _, kind in reported if kind == wall) < shown:
                self.differ("wall_missing", f"{name} has no {wall} in the summary; {sentence}")
            return
        sign = -1 if wall == "floor" else 1
        worst = sorted((limit + sign * lowest, limit + sign * highest))
        self.expect("wall_worst", f"{wall} of {name}", one["worst"], worst[0] - near, worst[1] + near)
        if one["kept"] and lowest > near:
            self.differ("wall_kept", f"by the summary {name} keeps the {wall}; {sentence}")
        if not one["kept"] and highest <= 1e-6:
            self.differ("wall_kept", f"by the summary {name} breaks the {wall}; {sentence}")

    def _judged_from_within(self, counts, lands, there, is_beyond):
        """Of the samples that count, those that are judged: where a start beyond is meant, and after a landing, from when the limit is first
        kept. Who never keeps it, until it leaves or the flight ends, has broken it; who lands is forgiven."""
        judged, held, excused = counts.copy(), [], False
        for k in range(len(counts)):
            if not counts[k]:
                if held and there[k]:
                    judged[held] = False
                held, excused = [], False
                continue
            if k == 0 or not counts[k - 1]:
                excused = bool(is_beyond[k]) and (self.begins_outside or (k > 0 and bool(there[k - 1] and lands[k - 1])))
            if excused and is_beyond[k]:
                held.append(k)
            elif excused:
                judged[held] = False
                held, excused = [], False
        return judged

    # --- views and soft limits ---

    def _views(self):
        flight = self.flight
        pairs = {}
        for term in self.team.terms:
            if term.is_view:
                pairs.setdefault((term.a, term.b), []).append(term)
        settled = flight.times >= self.simulation.get("settle", 6.0) - 1e-9
        for (a, b), terms in pairs.items():
            out, force = np.zeros(len(flight.times), bool), np.zeros(len(flight.times), bool)
            for term in terms:
                counts = self.team.counts(term) & ~force
                out[counts] = (self.team.excess(term) > 0)[counts]
                force |= counts
            self._lost(a, b, out, force)
            if len(terms) > 1 and len({str(term.keys) for term in terms}) > 1:
                continue
            reported = [one for one in self.summary["pairs"] if one["observer"] == a and one["target"] == b]
            if not reported:
                if force.any():
                    self.differ("view_missing", f"{a} observes {b}, and the summary has no such pair")
                continue
            one = reported[0]
            x, y, z = in_sensor(flight.bodies[a], flight.bodies[b], self.team.sensor(a))
            angle, distance = np.arctan2(np.hypot(y, z), x), np.linalg.norm(flight.bodies[a].p - flight.bodies[b].p, axis=1)
            self._span("view", f"view angle of {a} on {b}", one["view_angle_max"], angle, force & settled, np.max, 1e-6)
            self._span("view", f"least distance of {a} and {b} after settle", one["distance"]["min"], distance, force & settled, np.min, near)
            self._span("view", f"greatest distance of {a} and {b} after settle", one["distance"]["max"], distance, force & settled, np.max, near)
            self._span("view", f"share of the time in which {a} sees {b}", one["in_view_fraction"], 1.0 - out, force & settled, np.mean, 1e-9)

    def _span(self, claim, what, reported, values, use, measure, tolerance):
        """Over the samples that have a command: places alone are judged after the last one."""
        use = use & self.flight.commanded
        found = measure(values[use]) if use.any() else np.nan
        self.expect(claim, what, reported, found - tolerance, found + tolerance)

    def _lost(self, a, b, out, force):
        """Out of view during all of the last 2 s."""
        flight = self.flight
        if not out[-1] or not force[-1]:
            last = int(np.flatnonzero(flight.commanded)[-1])
            if not (out[last] and force[last]):
                return
        last, since = len(out) - 1, None
        while last > 0 and not (out[last] and force[last]):
            last -= 1
        while last >= 0 and out[last] and force[last]:
            since = last
            last -= 1
        begun = flight.times[since]
        without = flight.end - begun
        doubt = 1.5 * flight.period
        if without >= lost_after - doubt:
            self.verdict.add(f"{a} has not seen {b} since {begun:.3f} s", without > lost_after + doubt and bool(out[-1] and force[-1]))

    def _limits(self):
        flight = self.flight
        quiet = not self.scenario.get("event") and not any("nearest" in at for at in self.scenario.get("shape", []))
        reported, found = {}, {}
        for one in self.summary["limits"]:
            reported.setdefault(one["name"], []).append(one)
        for term in self.team.terms:
            if term.is_limit:
                found.setdefault(term.label, []).append(term)
        for label, terms in found.items():
            worst = []
            for term in terms:
                counts = self.team.counts(term)
                over = np.where(counts, self.team.excess(term), -np.inf)
                steps = over[flight.commanded]
                worst.append((max(0.0, steps.max(initial=0.0)), max(0.0, over.max(initial=0.0)), term))
            if label not in reported:
                if max(one[0] for one in worst) > 1e-6:
                    self.differ("limit_missing", f"{label} is broken by {max(one[0] for one in worst):.4g}, and the summary has no such limit")
                continue
            most = max((one["worst"] for one in reported[label] if one["worst"] is not None), default=0.0)
            least_right = max(one[0] for one in worst)
            tolerance = 1e-6 + 1e-6 * least_right
            if most < least_right - tolerance:
                self.differ("limit", f"{label} is broken by {least_right:.6g}, the summary has {most:.6g}")
            if quiet and most > max(one[1] for one in worst) + tolerance:
                self.differ("limit", f"{label} is broken by {max(one[1] for one in worst):.6g} at most, the summary has {most:.6g}")
            if quiet and len(terms) == 1 == len(reported[label]):
                term, one = terms[0], reported[label][0]
                broken = (self.team.excess(term) > 0) & self.team.counts(term)
                self._span("limit", f"share of the time in which {label} is broken", one["fraction"], broken * 1.0, self.team.counts(term), np.mean, 1e-9)

    # --- errors and energy ---

    def _reference(self, name, times):
        """(places, headings or None); None where the scenario states it in another way."""
        agent = self.scenario["agent"][name]
        reference = agent.get("reference", {})
        if "constant" in reference:
            keys = reference["constant"]
            return np.tile(np.array(keys["p"], float), (len(times), 1)), keys.get("heading")
        if "circle" in reference:
            keys = reference["circle"]
            turn, radius = keys.get("rate", 0.3) * times, keys.get("radius", 0.5)
            return np.array(keys["centre"], float) + radius * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), None
        for kind in ("waypoints", "steps"):
            if kind in reference:
                when, places = np.array(reference[kind]["times"], float), np.array(reference[kind]["p"], float)
                if kind == "steps":
                    return places[np.clip(np.searchsorted(when, times + 1e-12, side="right") - 1, 0, None)], None
                return np.stack([np.interp(times, when, places[:, i]) for i in range(3)], axis=1), None
        return None

    def _errors(self):
        flight = self.flight
        reported = {one["name"]: one for one in self.summary["agents"]}
        for name in flight.robots:
            agent, one, body = self.scenario["agent"][name], reported.get(name), flight.bodies[name]
            if one is None:
                self.differ("errors", f"the summary has no agent {name}")
                continue
            steered = (self.team.duty(name) == "steered") & body.there
            if name in self.team.changed:
                continue
            use = steered & flight.commanded
            energy = float(np.sum(np.array(agent["R"]) * body.u[use] ** 2) * flight.period) if "R" in agent else None
            if energy is not None and np.isfinite(energy):
                self.expect("energy", f"energy of {name}", one["energy"], energy * (1 - 1e-9) - 1e-9, energy * (1 + 1e-9) + 1e-9)
            use = steered & (flight.times >= self.simulation.get("rms_from", 10.0) - 1e-9)
            tracks = "Q" in agent and any(weight > 0 for weight in agent["Q"][:3])
            reference = self._reference(name, flight.times)
            if reference is None or not tracks:
                continue
            square = np.sum((body.p - reference[0]) ** 2, axis=1)
            self._span("rms", f"RMS position error of {name}", one["rms_position_error"], square, use, lambda e: np.sqrt(np.mean(e)), near)
            heading = one.get("rms_heading_error")
            if heading is not None and reference[1] is not None:
                off = np.angle(np.exp(1j * (np.arctan2(body.d[:, 1], body.d[:, 0]) - reference[1])))
                self._span("rms", f"RMS heading error of {name}", heading, off**2, use, lambda e: np.sqrt(np.mean(e)), 1e-3)

    def _exit(self):
        certain, doubtful = self.verdict.certain, self.verdict.open
        if self.code == 0 and certain:
            self.differ("exit", "exit 0, and " + "; ".join(certain[:4]))
        if self.code == 1 and not certain and not doubtful:
            self.differ("exit", "exit 1, and the judge finds no reason")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", help="file of the scenario")
    parser.add_argument("folder", help="of the run: run.mcap and summary.json")
    parser.add_argument("code", type=int, help="exit code of the run")
    parser.add_argument("--realtime", action="store_true", help="the flight was one in real time")
    arguments = parser.parse_args()
    differences = Judge(arguments.scenario, arguments.folder, arguments.code, arguments.realtime).judge()
    for claim, sentence in differences:
        print(f"{arguments.scenario}: {claim}: {sentence}")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
