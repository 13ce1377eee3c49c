"""The judge agrees with a flight, and notices each claim that is not so."""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from formula import excess, parameters, value
from judge import Judge

tree = Path(__file__).resolve().parents[2]
binary = os.environ.get("SIGHTLINE_BINARY", str(tree / "build/release/bin/sightline"))

# A robot that crosses a target's path, in view of another, between floor and ceiling.
scenario = """
[agent.a]
robot = "multirotor"
start = { p = [-2.0, 0.0, 1.0], heading = 0.0 }
Q = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]
R = [0.5, 0.5, 0.5, 0.5]
rate_max = [3.0, 3.0, 3.0, 3.0]
reference = { constant = { p = [1.0, 0.5, 1.5] } }
[agent.b]
robot = "multirotor"
start = { p = [-2.0, 2.0, 1.0], heading = -1.57 }
R = [0.5, 0.5, 0.5, 0.5]
sensor = { pitch = 0.1, offset = 0.1 }
[target.t]
p = [0.0, 0.1, 1.2]
v = [0.1, 0.0, 0.0]
[[couple]]
potential = { bearing = { alpha = 0.6, width = 0.1 } }
between = ["b", "a"]
felt_by = ["b"]
weight = 4.0
[[couple]]
potential = { region = { inside = "distance > 350 cm", slope = { softplus = { kappa_G = 1.0, kappa_H = 1.0 } }, kappa_A = 5.0 } }
between = ["a", "b"]
weight = 0.1
[safety]
d_hard = 0.2
floor = 0.5
ceiling = 3.0
[simulation]
duration = 4.0
settle = 1.0
rms_from = 1.0
"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flight")
    file = folder / "crossing.toml"
    file.write_text(scenario)
    run = subprocess.run([binary, "run", file, "-o", folder / "run"], capture_output=True, text=True, check=False)
    assert run.returncode in (0, 1), run.stderr
    return file, folder / "run", run.returncode


def test_it_agrees_with_a_flight(flown):
    assert Judge(*flown).judge() == []


def test_it_notices_another_exit_code(flown):
    file, folder, code = flown
    assert [claim for claim, _ in Judge(file, folder, 1 - code).judge()] == ["exit"]


def longer(number):
    return 1.01 * number + 0.01


changes = [
    ("updates", lambda s: s.update(updates=s["updates"] + 1)),
    ("allocations", lambda s: s.update(allocations_per_update=1)),
    ("min_distance", lambda s: s.update(min_distance=longer(s["min_distance"]))),
    ("applied_violations", lambda s: s.update(applied_violations=1)),
    ("input_violations", lambda s: s.update(input_violations=s["input_violations"] + 1)),
    ("max_abs_input", lambda s: s.update(max_abs_input=longer(s["max_abs_input"]))),
    ("hard_distance", lambda s: s["safety"]["hard_distances"][0].update(least=longer(s["safety"]["hard_distances"][0]["least"]))),
    ("wall_worst", lambda s: s["safety"]["walls"][0].update(worst=longer(s["safety"]["walls"][0]["worst"]))),
    ("wall_kept", lambda s: s["safety"]["walls"][0].update(kept=not s["safety"]["walls"][0]["kept"])),
    ("wall_missing", lambda s: s["safety"]["walls"].pop()),
    ("view", lambda s: s["pairs"][0].update(in_view_fraction=0.5 * s["pairs"][0]["in_view_fraction"])),
    ("view", lambda s: s["pairs"][0]["distance"].update(max=longer(s["pairs"][0]["distance"]["max"]))),
    ("view_missing", lambda s: s["pairs"].clear()),
    ("limit", lambda s: s["limits"][1].update(worst=longer(s["limits"][1]["worst"]))),
    ("limit", lambda s: s["limits"][1].update(fraction=0.5 * s["limits"][1]["fraction"])),
    ("limit_missing", lambda s: s["limits"].pop()),
    ("energy", lambda s: s["agents"][0].update(energy=longer(s["agents"][0]["energy"]))),
    ("rms", lambda s: s["agents"][0].update(rms_position_error=longer(s["agents"][0]["rms_position_error"]))),
]


@pytest.mark.parametrize("claim, change", changes, ids=[f"{i}_{claim}" for i, (claim, _) in enumerate(changes)])
def test_it_notices_a_claim_that_is_not_so(flown, claim, change):
    judge = Judge(*flown)
    judge.summary = json.loads(json.dumps(judge.summary))
    change(judge.summary)
    assert claim in [one for one, _ in judge.judge()]


def test_it_notices_commands_that_are_not_finite_beyond_limits_or_too_fast(flown):
    for value_of, claim in ((np.nan, "command"), (1.5, "command"), (0.9, "rate")):
        judge = Judge(*flown)
        judge.flight.bodies["a"].u[300, 2] = value_of
        assert claim in [one for one, _ in judge.judge()] and judge.wrong_commands > 0


def test_it_notices_a_landing_without_old_data(flown):
    judge = Judge(*flown)
    judge.flight.events.append((1.0, "land", 0))
    assert "landing" in [claim for claim, _ in judge.judge()]
    judge = Judge(*flown)
    judge.flight.events.append((3.0, "land", 0))
    judge.simulation = {**judge.simulation, "fault": [{"kind": "freeze", "body": "a", "from": 0.5}]}
    assert "landing" not in [claim for claim, _ in judge.judge()]


def test_it_finds_what_is_near_between_two_samples(flown):
    judge = Judge(*flown)
    low, high = judge._least("a", "t")  # pylint: disable=protected-access
    at_samples = np.linalg.norm(judge.flight.bodies["a"].p - judge.flight.bodies["t"].p, axis=1)
    assert low <= high <= at_samples.min() and high > at_samples.min() - 0.01


def test_formulas_have_units_and_chains():
    names = {"range": np.array([0.5, 3.0]), "half": np.pi / 6}
    assert np.allclose(excess("0.3 m < range < 250 cm", names), [-0.2, 0.5])
    assert np.allclose(excess({"not": "range > 1"}, names), [-0.5, 2.0])
    assert np.allclose(excess({"any_of": ["range < 1", "half < 20 deg"]}, names), [-0.5, np.pi / 18])
    assert parameters({"v": "36 km/s", "w": {"value": 90, "unit": "deg"}}) == {"v": 36000.0, "w": pytest.approx(np.pi / 2)}
    assert value("2 * r_z^2 - max(1, r_z)", {"r_z": 3.0}) == 15.0
