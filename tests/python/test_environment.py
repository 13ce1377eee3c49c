"""The benchmark's environment for learning: a task, an observer of one's own."""

import importlib.util
import pathlib

import numpy as np
import pytest

FILE = pathlib.Path(__file__).resolve().parents[2] / "benchmark" / "environment.py"
spec = importlib.util.spec_from_file_location("environment", FILE)
environment = importlib.util.module_from_spec(spec)
spec.loader.exec_module(environment)


def pursuit(observation, env):
    """Turns to the target, keeps the middle of the distances, and stays above."""
    q, v = observation[:3], observation[6:]
    bearing, distance = np.arctan2(q[1], q[0]), np.hypot(q[0], q[1])
    wanted = 0.5 * (env.d_min + env.d_max)
    speed = 0.8 * (distance - wanted) / distance
    above = -env.axis[2] / env.axis[0] * (wanted - env.offset[0])
    return np.array([1.5 * (speed * q[0] - v[0]), -1.5 * (speed * q[1] - v[1]), q[2] + above, 1.5 * bearing])


def flown(env, seed, policy, steps=800):
    observation, _ = env.reset(seed=seed)
    rewards, seen = [], [observation]
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(policy(observation, env))
        assert reward <= info["in_view"]
        assert not terminated and not truncated
        rewards.append(reward)
        seen.append(observation)
    return np.mean(rewards), np.array(seen)


def test_a_pursuit_scores_and_resting_does_not():
    env = environment.KeepInView("adversary")
    moved, seen = flown(env, 3, pursuit)
    assert moved > 0.9
    assert seen.shape == (801, 8)
    rested, _ = flown(env, 4, lambda observation, env: np.array([0.0, 0.0, 1.0, 0.0]))
    assert rested < 0.5


def test_a_seed_repeats_an_episode():
    env = environment.KeepInView("paper_7_2")
    first, again, other = (flown(env, seed, pursuit, 200)[1] for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_the_angle_is_that_between_the_axis_and_the_target():
    env = environment.KeepInView("adversary")
    for q in np.random.default_rng(1).uniform(-2, 2, (100, 3)):
        from_sensor = q - env.offset
        assert env.angle(q) == pytest.approx(np.arccos(from_sensor @ env.axis / np.linalg.norm(from_sensor)), abs=1e-6)


def test_a_task_of_several_observers_is_refused():
    with pytest.raises(ValueError, match="task = chain, expected one observer, it has 3"):
        environment.KeepInView("chain")
