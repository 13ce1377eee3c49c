"""Potentials and references as Python functions: derivatives, the bits of the same formula as text, and what is refused."""

import inspect
import math

import numpy as np
import pytest

import sightline as sl


def cone(seen, observer, target, t, reach=4.0):
    x, y, z = seen
    off_axis = y**2 + z**2
    r = target.p - observer.p
    return (sl.softplus(3.0 * (off_axis - (0.5 * x) ** 2)) + sl.logistic(-x) * (1 + 0.01 * off_axis)
            + np.sqrt(r @ r) / reach + 0.1 * np.exp(-(t**2)) * sl.cos(target.v[0]) + abs(observer.lean[1]))


def drawn(generator):
    psi = generator.uniform(-math.pi, math.pi)
    return sl.Sight(p=generator.uniform(-2, 2, 3), d=[math.cos(psi), math.sin(psi)], v=generator.uniform(-1, 1, 3),
                    lean=generator.uniform(0.05, 0.3, 2))


def moved(sight, i, h):
    z = np.concatenate([sight.p, sight.d, sight.v, sight.lean])
    z[i] += h
    return sl.Sight(z[0:3], z[3:5], z[5:8], z[8:10])


def test_gradients_are_those_of_finite_differences():
    potential = sl.potential(cone, reach=3.0)
    generator = np.random.default_rng(1)
    h = 1e-6
    for _ in range(50):
        a, b, t = drawn(generator), drawn(generator), generator.uniform(0, 2)
        slopes = potential.gradient(a, b, t)
        assert slopes.shape == (2, 10)
        for i in range(10):
            of_a = (potential(moved(a, i, h), b, t) - potential(moved(a, i, -h), b, t)) / (2 * h)
            of_b = (potential(a, moved(b, i, h), t) - potential(a, moved(b, i, -h), t)) / (2 * h)
            np.testing.assert_allclose(slopes[:, i], [of_a, of_b], rtol=2e-5, atol=2e-7)


def test_a_recorded_formula_gives_what_its_function_computes_on_numbers():
    generator = np.random.default_rng(2)
    functions = [lambda observer, target: (target.p - observer.p) @ observer.v,
                 lambda observer, target: sl.atan2(target.p[1], target.p[0]) * 2 - 1,
                 lambda observer, target: np.linalg.norm(target.p - observer.p) ** 3,
                 lambda observer, target: sl.maximum(observer.p[0], target.p[0]) + np.minimum(observer.p[1], 0.3),
                 lambda observer, target: (2 + observer.d[0]) ** -1.5 + np.log(3 + target.d[1]),
                 lambda observer, target: np.hypot(observer.p[0], target.p[1]) + np.sum(np.square(target.v)),
                 lambda observer, target: (np.float64(2.0) * observer.p[0] - np.array([1.0, 2.0]) @ target.d
                                           + np.pi / (3 + target.d[0])),
                 lambda observer, target: 1.5]
    for function in functions:
        potential = sl.potential(function)
        for _ in range(20):
            a, b = drawn(generator), drawn(generator)
            assert potential(a, b) == pytest.approx(function(a, b), rel=1e-9, abs=2e-6)


def test_what_is_seen_is_the_target_in_the_sensor_frame_of_its_mount():
    ahead = sl.potential(lambda seen: seen[0], mount=sl.SensorMount(pitch=0.0, offset=0.0))
    assert ahead(sl.Sight([1, 0, 0]), sl.Sight([3, 0, 0])) == pytest.approx(2.0)
    assert ahead(sl.Sight([1, 0, 0], [0, 1]), sl.Sight([1, 5, 0])) == pytest.approx(5.0)
    down = ahead.seen_from(sl.SensorMount(pitch=math.pi / 4, offset=0.0))
    assert down(sl.Sight([0, 0, 1]), sl.Sight([1, 0, 0])) == pytest.approx(math.sqrt(2.0))


def test_a_limit_says_where_it_is_broken():
    near = sl.potential(lambda observer, target, d: 1.0 / ((target.p - observer.p) @ (target.p - observer.p)),
                        limit=lambda observer, target, d: d - sl.sqrt((target.p - observer.p) @ (target.p - observer.p)), d=2.0)
    assert near.violation(sl.Sight([0, 0, 0]), sl.Sight([0.5, 0, 0])) == pytest.approx(1.5)
    assert near.violation(sl.Sight([0, 0, 0]), sl.Sight([3, 0, 0])) == pytest.approx(-1.0)
    assert sl.potential(cone).violation(sl.Sight([0, 0, 0]), sl.Sight([9, 0, 0])) == -math.inf


def test_it_is_called_once_and_no_python_runs_in_a_flight():
    calls = 0

    @sl.potential
    def counted(observer, target):
        nonlocal calls
        calls += 1
        r = target.p - observer.p
        return sl.softplus(3 * (sl.sqrt(r @ r) - 1.5)) + sl.softplus(3 * (1.2 - sl.sqrt(r @ r)))

    assert calls == 1 and counted.name == "counted" and counted.is_pair
    fly(pair(counted)[0], 100)
    assert calls == 1


def pair(potential, **given):
    team = sl.Team()
    uav0 = team.add(sl.multirotor(), Q=[0, 0, 0, 0, 0, 0.7, 0.7])
    uav1 = team.add(sl.multirotor(), Q=[1.5, 1.5, 1.6, 1, 1, 0, 0], x_ref=given.get("x_ref", sl.circle(centre=[0, 0, 1])))
    team.couple(0.4 * potential, (uav0, uav1), felt_by=uav0)
    return team, uav0


def fly(team, periods):
    mpc = sl.newton_riccati(team)
    plant = sl.Plant(team, [-1.5, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0])
    for k in range(periods):
        solution = mpc.solve(0.01 * k, plant.x)
        assert solution.status != sl.Status.not_finite
        assert plant.step(solution.u, 0.01)
    return plant.x


def test_it_keeps_its_target_at_the_distance_that_it_asks_for():
    def band(observer, target):
        r = target.p - observer.p
        d = sl.sqrt(r @ r)
        return sl.softplus(10 * (d - 1.6)) + sl.softplus(10 * (1.4 - d))

    x = fly(pair(sl.potential(band))[0], 1500)
    assert 1.2 < np.linalg.norm(x[7:10] - x[0:3]) < 1.8


def test_one_robot_and_a_reference_of_one_s_own():
    def low(robot, t):
        return sl.softplus(8 * (robot.p[2] - 1.0)) + 0.0 * t

    reference = sl.reference(lambda t: [0.5 * sl.cos(0.3 * t), 0.5 * sl.sin(0.3 * t), 1, 0, 0, 0, 0])
    x = reference(2.0, sl.multirotor())
    np.testing.assert_allclose(x, sl.circle(centre=[0, 0, 1], radius=0.5, rate=0.3)(2.0, sl.multirotor()), atol=1e-15)
    team, uav0 = pair(sl.potential(cone), x_ref=reference)
    team.constrain(2.0 * sl.potential(low), uav0)
    assert np.all(np.isfinite(fly(team, 200)))
    assert not sl.potential(low).is_pair


def car(x, u, drag=0.5):
    psi, v = x[3], x[4]
    return [v * sl.cos(psi), v * sl.sin(psi), 0, u[1], u[0] - drag * v]


car_words = {"states": ["p_x", "p_y", "p_z", "psi", "v"], "inputs": ["a", "w"], "heading": ["psi"]}


def test_a_robot_of_one_s_own_moves_as_its_function_says_and_follows_another():
    model = sl.robot(car, **car_words, u_max=[2.0, 1.0], drag=0.7)
    assert (model.nx, model.nu, model.name) == (5, 2, "car") and model.u_min.tolist() == [-1.0, -1.0]
    generator = np.random.default_rng(4)
    for _ in range(20):
        x, u = generator.uniform(-1, 1, 5), generator.uniform(-1, 1, 2)
        np.testing.assert_allclose(model.f(x, u), car(x, u, drag=0.7), rtol=1e-12, atol=1e-14)
    seen = model.sight([1, 2, 0, math.pi / 2, 0.5], [0, 0])
    np.testing.assert_allclose([*seen.p, *seen.d, *seen.v], [1, 2, 0, 0, 1, 0, 0.5, 0], atol=1e-12)

    team = sl.Team()
    follower = team.add(model)
    leader = team.add(sl.unicycle(), Q=[1, 1, 0, 0, 0, 0], x_ref=sl.circle(centre=[0, 0, 0], radius=1.0, rate=0.1))
    team.couple(sl.too_far(d_max=1.0), (follower, leader), felt_by=follower)
    plant = sl.Plant(team, [-3, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0])
    mpc = sl.newton_riccati(team)
    for k in range(2000):
        assert plant.step(mpc.step(0.01 * k, plant.x), 0.01)
    assert np.linalg.norm(plant.x[0:2] - plant.x[5:7]) < 1.5


@pytest.mark.parametrize("given, sentence", [
    ({"states": ["p_x", "p_y", "p_z", "psi"]}, "out of bounds|IndexError|index 4"),
    ({"position": ["p_x", "p_y", "q"]}, 'position = "q", expected the name of a state'),
    ({"heading": ["psi", "v", "p_x"]}, "a heading of 3 states"),
    ({"inputs": ["sin", "w"]}, 'an input "sin", expected a name of its own'),
    ({"u_max": [1.0]}, "limits of 1 inputs for 2"),
    ({"states": ["p_x", "p_y", "p_z", "psi", "v", "z"]}, "5 rates for 6 states"),
])
def test_a_robot_that_does_not_fit_together_is_refused(given, sentence):
    with pytest.raises(sl.TraceError, match=sentence):
        sl.robot(car, **{**car_words, **given})


def loops_while(observer):
    d = observer.p[0]
    while d < 3:
        d = d + 1
    return d


def is_too_long(observer, target):
    total = observer.p[0]
    for k in range(2000):
        total = total * 1.01 + target.p[1] * float(k + 1)
    return total


kept = []


def keeps(observer):
    kept.append(observer.p[0])
    return observer.p[0]


sl.potential(keeps)

cases = [
    ("compares what is recorded", lambda observer, target: 1.0 if observer.p[0] > target.p[0] else 0.0),
    ("compares what is recorded", lambda observer, target: max(observer.p[0], target.p[0])),
    ("compares what is recorded", lambda observer: np.where(observer.p > 0, 1.0, 0.0)[0]),
    ("compares what is recorded", lambda observer, target: float(observer.p[0] == target.p[0])),
    ("compares what is recorded", loops_while),
    ("compares what is recorded", lambda observer: sorted(observer.p)[0]),
    ("compares what is recorded", lambda observer: np.clip(observer.p, 0, 1)[0]),
    ("decides by what is recorded", lambda observer: 1.0 if observer.p[0] else 0.0),
    ("decides by what is recorded", lambda observer, target: observer.p[0] and target.p[0]),
    (r"use sl\.sin", lambda observer: math.sin(observer.p[0])),
    (r"use sl\.cos", lambda observer: math.cos(observer.p[0])),
    (r"use sl\.exp", lambda observer: math.exp(observer.p[0])),
    (r"use sl\.sqrt", lambda observer: math.sqrt(observer.p[0])),
    (r"use sl\.atan2", lambda observer, target: math.atan2(observer.p[0], target.p[0])),
    (r"use sl\.sqrt", lambda observer, target: math.hypot(observer.p[0], target.p[0])),
    (r"use sl\.sin\(x\) / sl\.cos\(x\)", lambda observer: math.tan(observer.p[0])),
    (r"use 2 \* sl\.logistic", lambda observer: np.tanh(observer.p[0])),
    ("expected", lambda observer: math.floor(observer.p[0])),
    ("expected", lambda observer: np.floor(observer.p[0])),
    ("asks for a number", lambda observer: float(observer.p[0])),
    ("asks for a number", lambda observer: int(observer.p[0])),
    ("asks for a number", lambda observer: complex(observer.p[0])),
    ("asks for a number", lambda observer: round(observer.p[0])),
    ("asks for a number", lambda observer: sum(1.0 for _ in range(observer.p[0]))),
    ("remainder", lambda observer: observer.p[0] % 2),
    ("remainder", lambda observer: observer.p[0] // 2),
    ("use sl.exp", lambda observer: 2.0 ** observer.p[0]),
    ("the power 0.3", lambda observer: observer.p[0] ** 0.3),
    ("unhashable", lambda observer: {observer.p[0]: 1.0}[observer.p[0]]),
    ("expected an expression", lambda observer: observer.q[0]),
    ("returns ndarray, expected one number", lambda observer: observer.p),
    ("returns NoneType, expected one number", lambda observer: None),
    ("returns bool, expected one number", lambda observer: True),
    ("expected a finite one", lambda observer: math.inf),
    ("expected one or more of observer", lambda a, b: a.p[0]),
    ("the argument gain, expected one of observer", lambda observer, gain: gain * observer.p[0]),
    ("the argument .*rest, expected arguments with names", lambda observer, *rest: observer.p[0]),
    ("no argument for the parameter gain", (lambda observer: observer.p[0], {"gain": 1.0})),
    ("more than 1000 operations", is_too_long),
    ("another function recorded", lambda observer: observer.p[0] + kept[0]),
]


@pytest.mark.parametrize("sentence, function", cases)
def test_what_cannot_be_recorded_is_refused_with_its_line_and_the_word_to_use(sentence, function):
    function, given = function if isinstance(function, tuple) else (function, {})
    with pytest.raises(sl.TraceError, match=sentence) as refusal:
        sl.potential(function, **given)
    lines, first = inspect.getsourcelines(function)
    place, line = str(refusal.value).split(": ", 1)[0].rsplit(":", 1)
    assert place.endswith("test_tracing.py")
    assert first <= int(line) < first + len(lines)


def test_a_reference_is_a_list_of_numbers_of_the_time():
    for function, sentence in [(lambda t: t, "expected a list"), (lambda t: [], "expected 1 to 64"),
                               (lambda t: [math.sin(t)], r"use sl\.sin"), (lambda x: [x], "expected one of t")]:
        with pytest.raises(sl.TraceError, match=sentence):
            sl.reference(function)


def test_it_flies_as_the_same_formula_of_the_library():
    def keep_out(observer, target, d_min=1.0, kappa_H=4.5, kappa_G=0.001, kappa_A=3.0):
        r = target.p - observer.p
        d2 = r @ r
        return sl.logistic(kappa_A * (d_min**2 - d2)) * (kappa_H - kappa_G * d2)

    a, b = sl.potential(keep_out), sl.keep_out(d_min=1, kappa_H=4.5, kappa_G=0.001, kappa_A=3)
    generator = np.random.default_rng(3)
    differ = [a(p, q) - b(p, q) for p, q in ((drawn(generator), drawn(generator)) for _ in range(100))]
    np.testing.assert_allclose(differ, 0.0, atol=1e-9)
    np.testing.assert_allclose(fly(pair(a)[0], 300), fly(pair(b)[0], 300), atol=1e-6)
