"""Teams, parts and solvers from Python: the same bits as from a scenario, the same sentences where they are refused."""

import json
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import sightline as sl


def paper_pair():
    """The pair of scenarios/paper_7_1.toml."""
    team = sl.Team()
    uav0 = team.add(sl.multirotor(), Q=[0, 0, 0, 0, 0, 0.7, 0.7], x_ref=[0] * 7)
    uav1 = team.add(sl.multirotor(), Q=[1.5, 1.5, 1.6, 1, 1, 0, 0], x_ref=sl.circle(centre=[0, 0, 1], radius=0.5, rate=0.3))
    team.couple(0.4 * sl.sensor_cone(alpha=0.5, kappa_G=0.01, kappa_A=2), (uav0, uav1), felt_by=uav0)
    team.couple(0.4 * sl.keep_out(d_min=1, kappa_H=4.5, kappa_G=0.001, kappa_A=3), (uav0, uav1), felt_by=uav0)
    team.couple(0.4 * sl.cohesion(d_max=2, kappa_H=1.5, kappa_G=0.001, kappa_A=3), (uav0, uav1), felt_by=uav0)
    return team


start = [-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0]


def flown(team, periods, **options):
    mpc, plant = sl.newton_riccati(team, T=1.0, N=20, dt=0.01, **options), sl.Plant(team, start)
    states = np.empty((periods, 14))
    for k in range(periods):
        states[k] = plant.x
        assert plant.step(mpc.step(0.01 * k, states[k]), 0.01)
    return states


def test_the_program_of_the_readme_flies_the_paper_s_pair_to_the_bits_of_the_command_line(scenarios, sightline, tmp_path):
    sightline("run", scenarios / "paper_7_1.toml", "-o", tmp_path)
    log = sl.Log(tmp_path)
    states = flown(paper_pair(), len(log))
    np.testing.assert_array_equal(states[:, :7], log["uav0"].x)
    np.testing.assert_array_equal(states[:, 7:], log["uav1"].x)


def test_the_team_of_a_scenario_flies_as_one_that_is_composed(scenarios):
    read = sl.Scenario.read(scenarios / "paper_7_1.toml")
    assert read.team.names == ["uav0", "uav1"] and read.x0.tolist() == start
    np.testing.assert_array_equal(flown(read.team, 50), flown(paper_pair(), 50))


def test_a_solution_keeps_its_numbers_after_the_next_update():
    team = paper_pair()
    mpc = sl.Solver(team, "newton_riccati", T=1.0, N=20, dt=0.01)
    first = mpc.solve(0.0, start)
    u = first.u.copy()
    assert first.x.shape == (21, 14) and first.u.shape == (8,) and first.elapsed > 0
    assert first.status in (sl.Status.converged, sl.Status.stepped, sl.Status.iteration_limit)
    np.testing.assert_array_equal(first.x[0], start)
    mpc.solve(0.01, np.asarray(start) + 0.1)
    np.testing.assert_array_equal(first.u, u)
    np.testing.assert_allclose(mpc.planned(0.01), mpc.planned(0.0), atol=1.0)
    assert np.isfinite(mpc.kkt(0.01, start))
    mpc.restart()
    np.testing.assert_array_equal(mpc.solve(0.0, start).u, u)


@pytest.mark.parametrize("name", ["newton_riccati", "cmscgmres", "cgmres"])
def test_each_solver_has_a_function_of_its_name(name):
    mpc = getattr(sl, name)(paper_pair(), T=1.0, N=10, dt=0.01)
    assert mpc.name == name
    assert np.all(np.abs(mpc.step(0.0, start)) <= 1.0)


def test_states_are_taken_without_a_copy_or_as_numpy_takes_them():
    mpc = sl.newton_riccati(paper_pair())
    u = mpc.step(0.0, np.asarray(start, dtype=float))
    for states in (start, tuple(start), np.asarray(start, dtype=object), np.repeat(start, 2)[::2]):
        mpc.restart()
        np.testing.assert_array_equal(mpc.step(0.0, states), u)
    with pytest.raises(ValueError, match="states has 3 numbers, expected 14"):
        mpc.step(0.0, [1, 2, 3])
    assert mpc.solve(0.0, [np.nan] * 14).status == sl.Status.invalid_state


def test_an_update_from_python_costs_a_few_microseconds_more():
    mpc, x = sl.newton_riccati(paper_pair()), np.asarray(start, dtype=float)
    beyond = []
    for k in range(2000):
        begin = time.perf_counter()
        solution = mpc.solve(0.01 * k, x)
        beyond.append(time.perf_counter() - begin - solution.elapsed)
    assert np.median(beyond) < 20e-6  # on a busy machine; scripts/accept/15.sh has the figure


def test_the_gradient_is_the_central_difference_of_the_optimum():
    g, states, step = np.linspace(-1.0, 1.0, 8), np.asarray(start, dtype=float), 1e-4
    mpc = sl.newton_riccati(paper_pair(), max_newton_steps=50, tolerance=1e-12, krylov_stop=1e-10, max_krylov=50)

    def value(x):
        assert mpc.solve(0.0, x).status == sl.Status.converged
        return g @ mpc.planned(0.0)

    value(states)
    gradient = mpc.gradient(g)
    assert {"uav0.Q[5]", "uav1.x_ref[0]", "couple[0].weight", "couple[1].d_min"} <= gradient.parameters.keys()
    for i in [0, 1, 2, 5, 6, 7, 8, 9, 12, 13]:  # no headings, which are normalised
        shift = step * np.eye(14)[i]
        assert gradient.states[i] == pytest.approx((value(states + shift) - value(states - shift)) / (2 * step), abs=1e-6)
    with pytest.raises(ValueError, match="g has 3 numbers, expected 8"):
        mpc.gradient([1, 2, 3])
    mpc.kkt(0.0, states)
    with pytest.raises(ValueError, match="the last call was no update"):
        mpc.gradient(g)
    with pytest.raises(ValueError, match="solver = cgmres, expected newton_riccati"):
        sl.cgmres(paper_pair()).gradient(g)


def test_the_gradient_of_a_closed_loop_is_its_central_difference():
    x0, periods = np.asarray(start, dtype=float), 20

    def flown(x):
        loop = sl.LoopGradient(paper_pair(), T=1.0, N=10, dt=0.05)
        states, inputs = loop.fly(x, periods)
        assert states.shape == (periods + 1, 14) and inputs.shape == (periods, 8)
        return loop, states

    loop, states = flown(x0)
    gradient = loop.differentiate(states)  # of half of the sum of squares
    for i in [0, 1, 2, 5, 8, 13]:
        shift = 1e-4 * np.eye(14)[i]
        difference = (flown(x0 + shift)[1] ** 2 - flown(x0 - shift)[1] ** 2).sum() / 4e-4
        assert gradient.states[i] == pytest.approx(difference, rel=1e-5)
    assert gradient.parameters["couple[0].weight"] != 0
    assert gradient.without_derivative == 0
    with pytest.raises(ValueError, match="by_x has 3 numbers in 1 dimensions, expected 21 x 14"):
        loop.differentiate([1, 2, 3])
    with pytest.raises(ValueError, match="periods = 0, expected >= 1"):
        loop.fly(x0, 0)


def test_updates_of_a_flight_without_a_derivative_are_counted():
    team = sl.Team()  # the reference looks away by 2.8 rad: it is turned, which has no derivative
    team.add(sl.multirotor(), Q=[1, 1, 1, 1, 1, 0, 0], x_ref=[0, 0, 1, np.cos(2.8), np.sin(2.8), 0, 0])
    loop = sl.LoopGradient(team, T=1.0, N=10, dt=0.05)
    states, _ = loop.fly([0, 0, 1, 1, 0, 0, 0], 40)
    assert 0 < loop.differentiate(states).without_derivative < 40


def test_the_example_with_torch_learns_or_says_that_there_is_none():
    example = Path(__file__).parents[2] / "examples/weights_by_torch.py"
    done = subprocess.run([sys.executable, str(example)], capture_output=True, text=True, check=True)
    losses = [float(line.split()[3]) for line in done.stdout.splitlines() if line.startswith("step")]
    assert done.stdout == "weights_by_torch: skipped, torch is not installed\n" or losses[-1] < losses[0]


def test_a_solver_refuses_a_second_thread():
    mpc = sl.newton_riccati(paper_pair(), max_newton_steps=50, tolerance=1e-12)
    refused = []

    def solve():
        for k in range(200):
            try:
                mpc.solve(0.01 * k, np.asarray(start) + 0.01 * k)
            except RuntimeError as error:
                refused.append(str(error))

    threads = [threading.Thread(target=solve) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all("expected one for each thread" in sentence for sentence in refused)


def test_parts_are_all_that_are_registered_with_their_parameters(sightline):
    listed = json.loads(sightline("parts", "--json"))
    text = json.dumps(listed)
    for name in (*sl.robots, *sl.potentials, *sl.references, *sl.limits):
        assert callable(getattr(sl, name)) and f'"{name}"' in text
    assert "d_min" in sl.keep_out.__doc__ and "[m]" in sl.keep_out.__doc__
    assert sl.keep_out(d_min=1.5).parameters["d_min"] == "1.5"


@pytest.mark.parametrize("call, error, sentence", [
    (lambda: sl.keep_out(d_min=-1), ValueError, r"keep_out\.d_min = -1, expected > 0 m"),
    (lambda: sl.keep_out(d_min="far"), ValueError, r"keep_out\.d_min = 'far', expected a number"),
    (lambda: sl.keep_out(d_min=[1, 2]), ValueError, r"keep_out\.d_min = \[1, 2\], expected a number"),
    (lambda: sl.keep_out(d_min=float("nan")), ValueError, r"keep_out\.d_min = nan"),
    (lambda: sl.keep_out(d_min=True), ValueError, r"keep_out\.d_min = True, expected a number"),
    (lambda: sl.keep_out(d_mn=1.0),  # type: ignore[call-arg]
     TypeError, r'keep_out\.d_mn = 1\.0, expected a known one, the nearest is "d_min"'),
    (lambda: sl.circle(radius=1.0), ValueError,  # type: ignore[call-arg]
     r"circle\.centre is missing"),
    (lambda: sl.circle(centre=[0, 0]), ValueError, r"circle\.centre = \[0, 0\], expected 3 numbers"),
    (lambda: sl.sensor_cone(form="round"), ValueError, r"sensor_cone\.form = 'round', expected one of"),
    (lambda: sl.waypoints(times=[0, 2, 1], p=[[0, 0, 1]] * 3), ValueError, r"waypoints\.times"),
    (lambda: sl.SensorMount(frame="earth"), ValueError, 'frame = "earth", expected one of'),
    (lambda: sl.newton_riccati(paper_pair(), tolerance=-1.0), ValueError, "tolerance"),
    (lambda: sl.newton_riccati(paper_pair(), toleranz=1.0), ValueError, 'the nearest is "tolerance"'),
    (lambda: sl.newton_riccati(paper_pair(), N=0), ValueError, "expected"),
    (lambda: sl.cgmres(paper_pair(), jacobian='exact"\nk_max = 3 #'), ValueError, r"jacobian = .*expected one of"),
    (lambda: sl.cgmres(paper_pair(), **{"k_max = 3\nzeta": 1.0}), ValueError,  # type: ignore[arg-type]
     "expected a known key"),
    (lambda: sl.cgmres(paper_pair(), name="newton_riccati"), ValueError, "name is given twice"),
    (lambda: sl.cgmres(paper_pair(), k_max=True), ValueError, "k_max = true, expected an integer"),
    (lambda: sl.cgmres(paper_pair(), k_max=np.bool_(True)), ValueError, "k_max = true, expected an integer"),
    (lambda: sl.cgmres(paper_pair(), k_max=2.0), ValueError, "k_max = 2.0, expected an integer, 1 to 1000, without a point"),
    (lambda: sl.cgmres(paper_pair(), k_max=2**70), ValueError, "expected a number of 64 bits"),
    (lambda: sl.cgmres(paper_pair(), zeta=float("nan")), ValueError, "zeta = nan, expected > 0"),
    (lambda: sl.cgmres(paper_pair(), zeta=[1.0]), TypeError, r"zeta = \[1\.0\], expected a number or a word"),
    (lambda: sl.newton_riccati(sl.Team()), ValueError, ""),
    (lambda: sl.Solver(paper_pair(), "newton"), ValueError, "solver = newton, expected one of"),
    (lambda: sl.Plant(paper_pair(), [0.0]), ValueError, ""),
    (lambda: sl.Team().add(sl.multirotor(), Q=[1.0]), ValueError, "Q"),
    (lambda: sl.Team().add(sl.multirotor(), Q="heavy"), TypeError, "'heavy', expected a list of numbers"),
    (lambda: sl.Team().add(sl.multirotor(), x_ref=lambda t: [0] * 7), TypeError, r"sightline\.reference"),
    (lambda: sl.Team().couple(0.4, (sl.Team().add(sl.multirotor()),) * 2), TypeError, "expected a potential"),
])
def test_what_is_refused_is_refused_with_the_key_and_what_was_expected(call, error, sentence):
    with pytest.raises(error, match=sentence):
        call()


def test_a_robot_a_target_and_a_limit_of_each_kind_fly_together():
    team = sl.Team()
    rover = team.add(sl.unicycle(), R=[1, 1], name="rover")
    uav = team.add(sl.multirotor(), Q=[1, 1, 1, 0, 0, 0, 0], x_ref=sl.constant(p=[0, 0, 1]), name="uav")
    wall = team.add_obstacle("wall")
    team.couple(sl.too_near(d_min=1.0), (uav, wall))
    team.couple(2.0 * sl.bearing(), (rover, uav), felt_by=[rover])
    team.constrain(sl.RelaxedBarrier(sl.speed(max=1.0)), uav)
    assert team.find("wall") == wall and not team.is_agent(wall) and len(team) == 3
    assert team.state(uav) == slice(6, 13, 1) and team.name(rover) == "rover"
    x = np.zeros(team.nx)
    x[team.state(rover)] = [0, 0, 0, 1, 0, 0]
    x[team.state(uav)] = [2, 0, 1, 1, 0, 0, 0]
    solution = sl.newton_riccati(team).solve(0.0, x)
    assert np.all(np.isfinite(solution.u)) and solution.status != sl.Status.not_finite


@pytest.mark.parametrize("whole", [int, np.int64, np.int32, np.uint8])
@pytest.mark.parametrize("real", [float, np.float64, np.float32])
def test_options_are_numbers_of_python_and_of_numpy(whole, real):
    given = sl.cgmres(paper_pair(), k_max=whole(3), zeta=real(25.0), tolerance=whole(1), jacobian="forward_difference")
    plain = sl.cgmres(paper_pair(), k_max=3, zeta=25.0, tolerance=1.0, jacobian="forward_difference")
    np.testing.assert_array_equal(given.solve(0.0, np.asarray(start)).u, plain.solve(0.0, np.asarray(start)).u)


def test_many_teams_leave_no_memory_behind():
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096

    for _ in range(100):
        flown(paper_pair(), 3)
    before = resident()
    for _ in range(1000):
        flown(paper_pair(), 3)
    assert resident() - before < 2_000_000
