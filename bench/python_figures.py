"""Figures of the Python module, one section a call:  python_figures.py solve|threads|formula|cycles [--short]

Prints what was measured, and ends with 1 where that is beyond its limit; --short measures less, by wider limits.
"""

import gc
import sys
import threading
import time
from pathlib import Path

import numpy as np

import sightline as sl

scenarios = Path(__file__).resolve().parents[1] / "scenarios"
short = "--short" in sys.argv
wide = 3.0 if short else 1.0  # on a machine that does other things too


def paper_pair(cone, keep_out, cohesion):
    team = sl.Team()
    uav0 = team.add(sl.multirotor(), Q=[0, 0, 0, 0, 0, 0.7, 0.7], x_ref=[0] * 7)
    uav1 = team.add(sl.multirotor(), Q=[1.5, 1.5, 1.6, 1, 1, 0, 0], x_ref=sl.circle(centre=[0, 0, 1], radius=0.5, rate=0.3))
    for potential in (cone, keep_out, cohesion):
        team.couple(0.4 * potential, (uav0, uav1), felt_by=uav0)
    return team


def built_in():
    return paper_pair(sl.sensor_cone(alpha=0.5, kappa_G=0.01, kappa_A=2), sl.keep_out(d_min=1), sl.cohesion(d_max=2))


start = np.array([-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0])


def solve():
    """What an update costs from Python beyond its own time."""
    mpc, plant, clock = sl.newton_riccati(built_in()), sl.Plant(built_in(), start), time.perf_counter
    beyond, own = [], []
    for k in range(2000 if short else 20000):
        x = plant.x
        begin = clock()
        solution = mpc.solve(0.01 * k, x)
        beyond.append(clock() - begin - solution.elapsed)
        own.append(solution.elapsed)
        plant.step(solution.u, 0.01)
    microseconds = 1e6 * np.median(beyond)
    print(f"solve of two robots: {1e6 * np.median(own):.2f} us, from Python {microseconds:.2f} us more (median), at most 3")
    return microseconds <= 3.0 * wide


def threads():
    """Updates of eight threads with a solver each, and of one."""
    scenario = sl.Scenario.read(scenarios / "chain8.toml")

    def rate(n):
        solvers = [sl.Solver(scenario.team, T=scenario.horizon.T, N=100, dt=scenario.horizon.dt) for _ in range(n)]
        done, stop = [0] * n, threading.Event()

        def work(i):
            while not stop.is_set():
                solvers[i].step(0.0, scenario.x0)
                done[i] += 1

        workers = [threading.Thread(target=work, args=(i,)) for i in range(n)]
        for worker in workers:
            worker.start()
        time.sleep(2.0 if short else 10.0)
        stop.set()
        for worker in workers:
            worker.join()
        return sum(done)

    ratio = np.median([rate(8) / rate(1) for _ in range(1 if short else 3)])
    least = 1.0 if short else 1.8
    print(f"eight threads do {ratio:.2f} times the updates of one, at least {least} on two cores")
    return ratio >= least


def formula():
    """Updates with the paper's potentials as text, and as Python functions."""

    def cone(seen, alpha=0.5, kappa_G=0.01, kappa_A=2.0):
        x, y, z = seen
        off = y**2 + z**2
        step = lambda c: sl.logistic(kappa_A * c)
        return step(-x) * (1 + kappa_G * (x**2 + off)) + step(off - (x * np.sin(alpha)) ** 2) * step(x) * (1 + kappa_G * off)

    def keep_out(observer, target, d_min=1.0, kappa_H=4.5, kappa_G=0.001, kappa_A=3.0):
        r = target.p - observer.p
        return sl.logistic(kappa_A * (d_min**2 - r @ r)) * (kappa_H - kappa_G * (r @ r))

    def cohesion(observer, target, d_max=2.0, kappa_H=1.5, kappa_G=0.001, kappa_A=3.0):
        r = target.p - observer.p
        return sl.logistic(kappa_A * (r @ r - d_max**2)) * (kappa_H + kappa_G * (r @ r))

    text = sl.Scenario.read(scenarios / "paper_7_1_text.toml").team
    own = paper_pair(*(sl.potential(f) for f in (cone, keep_out, cohesion)))
    solvers = [sl.newton_riccati(text), sl.newton_riccati(own)]
    plants = [sl.Plant(text, start), sl.Plant(own, start)]
    times = [[], []]
    for k in range(1000 if short else 20000):
        for mpc, plant, own_times in zip(solvers, plants, times):
            solution = mpc.solve(0.01 * k, plant.x)
            own_times.append(solution.elapsed)
            plant.step(solution.u, 0.01)
    of_text, of_python = (1e6 * np.median(t) for t in times)
    apart = np.max(np.abs(plants[0].x - plants[1].x))
    print(f"an update by text {of_text:.2f} us, by Python functions {of_python:.2f} us, {of_python / of_text:.3f} times, "
          f"at most 1.02; states differ by {apart:.1e}")
    return of_python / of_text <= 1.02 * (1.3 if short else 1.0) and apart < 1e-5


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def cycles():
    """Memory after many teams were made, flown and deleted."""

    def once():
        mpc, plant = sl.newton_riccati(built_in()), sl.Plant(built_in(), start)
        for k in range(10):
            plant.step(mpc.step(0.01 * k, plant.x), 0.01)

    for _ in range(100):
        once()
    gc.collect()
    before = resident()
    n = 200 if short else 1000
    for _ in range(n):
        once()
    gc.collect()
    grown = (resident() - before) / 1e6
    print(f"{n} teams were made, flown and deleted: {grown:.2f} MB more, at most 2")
    return grown <= 2.0


if __name__ == "__main__":
    sections = {f.__name__: f for f in (solve, threads, formula, cycles)}
    section = next((word for word in sys.argv[1:] if not word.startswith("-")), "")
    if section not in sections:
        sys.exit(f"python_figures.py: SECTION = {section}, expected one of {', '.join(sections)}")
    sys.exit(0 if sections[section]() else 1)
