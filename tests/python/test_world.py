"""The world of a scenario, period by period, for a controller of one's own."""

import matplotlib
import numpy as np
import pytest

import sightline as sl
from sightline import plot

matplotlib.use("Agg")


def flown(scenario, periods, **given):
    world, mpc = sl.World(scenario, **given), sl.Solver.of(scenario)
    states = [world.truth]
    for _ in range(periods - 1):
        world.step(mpc.step(world.time, world.x))
        states.append(world.truth)
    return np.array(states)


@pytest.mark.parametrize("name", ["paper_7_1", "cooperative_localization"])
def test_a_loop_in_python_flies_the_states_of_a_run(scenarios, tmp_path, name):
    scenario = sl.Scenario.read(scenarios / f"{name}.toml", set=["simulation.duration=2.0"])
    log = sl.run(scenario, out=tmp_path).log
    whole = np.hstack([body.x for body in log.bodies.values()])
    np.testing.assert_array_equal(flown(scenario, len(log)), whole)


def test_the_same_seed_gives_the_same_flight_and_another_one_another(scenarios):
    scenario = sl.Scenario.read(scenarios / "localize.toml")
    world = sl.World(scenario, seed=3)
    first = [world.x]
    for _ in range(50):
        world.step(np.zeros(world.team.nu))
        first.append(world.x)
    for seed, same in ((3, True), (4, False)):
        world.restart(seed=seed)
        assert world.time == 0.0 and world.seed == seed
        again = [world.x]
        for _ in range(50):
            world.step(np.zeros(world.team.nu))
            again.append(world.x)
        assert np.array_equal(first, again, equal_nan=True) == same


def test_detections_arrive_after_they_were_made(scenarios):
    world = sl.World(sl.Scenario.read(scenarios / "localize.toml"))
    seen = []
    for _ in range(100):
        world.step(np.zeros(world.team.nu))
        for d in world.detections:
            assert d.stamp <= d.arrival <= world.time + 1e-9
            np.testing.assert_allclose(d.covariance, d.covariance.T)
            assert np.all(np.linalg.eigvalsh(d.covariance) > 0) and d.p.shape == (3,) and abs(np.linalg.norm(d.q) - 1) < 1e-9
            seen.append((d.observer, d.target))
    assert set(seen) == {("uav0", "uav1")} and len(seen) > 10


def test_inputs_are_clamped_and_those_that_are_no_numbers_refused(scenarios):
    world = sl.World(sl.Scenario.read(scenarios / "paper_7_1.toml"))
    world.step(np.full(8, 100.0))
    np.testing.assert_array_equal(world.u, np.ones(8))
    with pytest.raises(ValueError, match=r"u\[2\] = nan, expected a finite number"):
        world.step([0, 0, np.nan, 0, 0, 0, 0, 0])
    with pytest.raises(ValueError, match="u has 3 numbers, expected 8"):
        world.step([0, 0, 0])
    assert world.time == 0.01


def test_a_team_that_changes_in_flight_is_refused(scenarios):
    with pytest.raises(ValueError, match="the team changes in flight, expected one that stays"):
        sl.World(sl.Scenario.read(scenarios / "join_and_leave.toml"))


def test_an_end_of_the_world_is_told_and_restart_begins_anew(scenarios):
    scenario = sl.Scenario.read(scenarios / "rotors/cooperative_localization.toml")
    world = sl.World(scenario)
    down = world.team.nu // 2
    with pytest.raises(RuntimeError):
        for _ in range(5000):
            world.step(np.tile([0, 0, -1, 0], down)[: world.team.nu])
    with pytest.raises(RuntimeError, match="has ended, expected restart"):
        world.step(np.zeros(world.team.nu))
    world.restart()
    world.step(np.zeros(world.team.nu))


def test_a_log_is_a_frame_and_pictures(scenarios, tmp_path):
    log = sl.run(sl.Scenario.read(scenarios / "paper_7_1.toml", set=["simulation.duration=1.0"]), out=tmp_path).log
    frame = log.frame()
    assert len(frame) == len(log) and frame.index.name == "t"
    np.testing.assert_array_equal(frame["uav0", "p_x"].to_numpy(), log["uav0"].p[:, 0])
    assert len(plot.paths(log).lines) == 4
    (line,) = plot.distance(log).lines
    np.testing.assert_allclose(line.get_ydata(), np.linalg.norm(log["uav0"].p - log["uav1"].p, axis=1))
    assert len(plot.inputs(log, "uav1").lines) == 4
