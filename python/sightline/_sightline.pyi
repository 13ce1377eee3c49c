# Made by python/packaging/stubs.py.
import os
from collections.abc import Sequence
from typing import Any, ClassVar, Optional

import numpy as np
import numpy.typing as npt

class Agent:
    """A robot that is controlled."""

class Body:
    """Anything that has a position: a robot, a target, an obstacle."""
    @property
    def index(self) -> int: ...

class Checked:
    """What is known of a scenario before it flies."""
    @property
    def remarks(self) -> list[str]:
        """Corners that are rounded off, a sentence each."""
    @property
    def summary(self) -> str:
        """A few words per robot, coupling and setting."""
    @property
    def warnings(self) -> list[str]:
        """A sentence each."""

class Detection:
    """A body seen by a camera: its pose in the frame S of the observer's first camera, x along the axis."""
    @property
    def arrival(self) -> float:
        """When the observer has it [s]."""
    @property
    def covariance(self) -> npt.NDArray[np.float64]:
        """Of position [m] and turn [rad] in S, 6 x 6."""
    @property
    def observer(self) -> str: ...
    @property
    def p(self) -> npt.NDArray[np.float64]:
        """Of the target in S [m]."""
    @property
    def q(self) -> npt.NDArray[np.float64]:
        """The target's axes in S, w first; NaN where the position alone is known."""
    @property
    def stamp(self) -> float:
        """When it was so [s]."""
    @property
    def tags(self) -> int: ...
    @property
    def target(self) -> str: ...

class Expression:
    """A recorded formula."""
    def __len__(self) -> int: ...
    def uses(self, variable: int) -> bool: ...

class Flown:
    @property
    def faults(self) -> list[str]: ...
    @property
    def folder(self) -> os.PathLike[str]: ...
    @property
    def summary(self) -> str: ...

class Gradient:
    """Derivatives of g' u, u the inputs of an update, or of a cost of a flight."""
    @property
    def parameters(self) -> dict:
        """By each weight, reference and parameter of a potential: name to number, as uav0.Q[3], uav0.x_ref[2] (a shift of the reference), couple[0].weight, couple[0].d_min."""
    @property
    def previous(self) -> npt.NDArray[np.float64]:
        """By the inputs in force before the update (nu); of a flight empty."""
    @property
    def states(self) -> npt.NDArray[np.float64]:
        """By the measured states of all bodies, or their start (nx)."""
    @property
    def without_derivative(self) -> int:
        """Updates of a flight that have no derivative: their inputs count as constant."""

class Horizon:
    """T: length [s]; N: stages; dt: control period [s]."""
    @property
    def N(self) -> int: ...
    @property
    def T(self) -> float: ...
    @property
    def dt(self) -> float: ...

class Limit:
    """A limit c(x, u) <= 0 of one robot."""
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict: ...

class Log:
    """The log of a run, of its folder; of a killed run as far as it is sound."""
    def __getitem__(self, arg0: str) -> LoggedBody: ...
    def __init__(self, folder: str | os.PathLike[str]) -> None:
        """Raises RuntimeError with a sentence where it cannot be read."""
    def __len__(self) -> int: ...
    @property
    def bodies(self) -> dict:
        """By their names, in the order of the team."""
    @property
    def complete(self) -> bool:
        """False: the run was killed, the log ends in the middle, or it lacks periods."""
    @property
    def cost(self) -> npt.NDArray[np.float64]:
        """Stage cost l, n."""
    @property
    def events(self) -> list[tuple[float, str, float]]:
        """(time [s], kind, value) each."""
    @property
    def folder(self) -> os.PathLike[str]: ...
    def frame(self):
        """The log as a pandas DataFrame: a row a period, columns (body, what), by the time [s]."""
    @property
    def iterations(self) -> list[int]: ...
    @property
    def name(self) -> str: ...
    @property
    def period(self) -> float:
        """[s]"""
    @property
    def residual(self) -> npt.NDArray[np.float64]:
        """[1/s], n"""
    @property
    def scenario(self) -> str:
        """Text of the scenario."""
    @property
    def seed(self) -> int: ...
    @property
    def solve_us(self) -> npt.NDArray[np.float64]:
        """Measured times [us], a row of timing.csv each."""
    @property
    def solver(self) -> str: ...
    @property
    def status(self) -> list[str]:
        """A word a period."""
    @property
    def time(self) -> npt.NDArray[np.float64]:
        """[s], n"""
    @property
    def version(self) -> str: ...

class LoggedBody:
    """A body of a log; one row a period, read-only."""
    @property
    def heading(self) -> npt.NDArray[np.float64]:
        """psi [rad], unwrapped, n."""
    @property
    def inputs(self) -> list[str]:
        """Names of the inputs."""
    @property
    def is_agent(self) -> bool: ...
    @property
    def lean(self) -> npt.NDArray[np.float64]:
        """Forward and to the left, n x 2."""
    @property
    def name(self) -> str: ...
    @property
    def p(self) -> npt.NDArray[np.float64]:
        """True position in G [m], n x 3."""
    @property
    def reference_p(self) -> npt.NDArray[np.float64]:
        """[m], empty where the place is free."""
    @property
    def reference_time(self) -> npt.NDArray[np.float64]:
        """[s]"""
    @property
    def robot(self) -> str:
        """Its model; "body" of no robot."""
    @property
    def u(self) -> npt.NDArray[np.float64]:
        """Applied inputs, n x nu, a copy."""
    @property
    def v(self) -> npt.NDArray[np.float64]:
        """True velocity in G [m/s], n x 3."""
    @property
    def x(self) -> npt.NDArray[np.float64]:
        """True state, n x nx, all bits of it."""

class LoopGradient:
    """A closed loop of a team's models and newton_riccati, and derivatives of its costs."""
    def __init__(self, team: Team, *, T: float = ..., N: int = ..., dt: float = ..., delay: int = ...) -> None:
        """delay: of the commands, in periods"""
    def differentiate(self, by_x: npt.ArrayLike, by_u: Optional[npt.ArrayLike] = ...) -> Gradient:
        """Gradient of a cost of the last flight, from its derivatives by the states (K+1 x nx) and the inputs (K x nu)."""
    def fly(self, x0: npt.ArrayLike, periods: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Flies K periods from x0 (nx): the states (K+1 x nx) and the inputs (K x nu)."""

class Model:
    """A robot: x' = f(x, u), and what is seen of it."""
    def f(self, x: npt.ArrayLike, u: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """x' = f(x, u)."""
    @property
    def inputs(self) -> list[str]: ...
    @property
    def name(self) -> str: ...
    @property
    def nu(self) -> int: ...
    @property
    def nx(self) -> int: ...
    @property
    def parameters(self) -> dict: ...
    def sight(self, x: npt.ArrayLike, u: npt.ArrayLike) -> Sight:
        """What is seen of it at state x under input u."""
    @property
    def states(self) -> list[str]: ...
    @property
    def u_max(self) -> npt.NDArray[np.float64]: ...
    @property
    def u_min(self) -> npt.NDArray[np.float64]: ...

class Plant:
    """The simulated world: the continuous models of all bodies, undisturbed."""
    def __init__(self, team: Team, x0: npt.ArrayLike, seed: int = ...) -> None:
        """x0: states of all bodies in the order of the team (nx)"""
    def step(self, u: npt.ArrayLike, dt: float) -> bool:
        """Advances by dt [s] under the inputs u (nu). False where a state is no longer finite."""
    @property
    def time(self) -> float:
        """[s]"""
    @property
    def x(self) -> npt.NDArray[np.float64]:
        """States of all bodies (nx), a copy."""

class Potential:
    """A potential between two bodies, or of one."""
    def __call__(self, observer: Sight, target: Sight = ..., t: float = ...) -> float:
        """l [-] at time t [s]."""
    def __rmul__(self, arg0: float) -> Weighted: ...
    def gradient(self, observer: Sight, target: Sight = ..., t: float = ...) -> npt.NDArray[np.float64]:
        """Derivatives of l by p, d, v, lean of the observer (row 0) and of the target (row 1), 2 x 10."""
    @property
    def is_pair(self) -> bool: ...
    @property
    def name(self) -> str: ...
    @property
    def parameters(self) -> dict: ...
    def seen_from(self, mount: SensorMount) -> Potential:
        """The same with the observer's sensor there."""
    def violation(self, observer: Sight, target: Sight = ..., t: float = ...) -> float:
        """> 0 where the limit is broken, in its unit; -inf where it states none."""

class Recorder:
    """Records a formula over variables; its steps are known by their numbers."""
    def __init__(self, variables: int) -> None: ...
    def absolute(self, arg0: int) -> int: ...
    def add(self, arg0: int, arg1: int) -> int: ...
    def atan2(self, arg0: int, arg1: int) -> int: ...
    def constant(self, arg0: float) -> int: ...
    def cos(self, arg0: int) -> int: ...
    def divide(self, arg0: int, arg1: int) -> int: ...
    def exp(self, arg0: int) -> int: ...
    def finish(self, arg0: int) -> Expression: ...
    def log(self, arg0: int) -> int: ...
    def logistic(self, arg0: int) -> int: ...
    def maximum(self, arg0: int, arg1: int) -> int: ...
    def minimum(self, arg0: int, arg1: int) -> int: ...
    def multiply(self, arg0: int, arg1: int) -> int: ...
    def negate(self, arg0: int) -> int: ...
    def power(self, arg0: int, arg1: int) -> int: ...
    def sin(self, arg0: int) -> int: ...
    def softplus(self, arg0: int) -> int: ...
    def sqrt(self, arg0: int) -> int: ...
    def subtract(self, arg0: int, arg1: int) -> int: ...
    def variable(self, arg0: int) -> int: ...

class Reference:
    """x*(t) of a robot: a state, or a pose at rest."""
    def __call__(self, t: float, model: Model) -> npt.NDArray[np.float64]:
        """x*(t) of a robot (nx); NaN where it is of another length."""
    def __init__(self, state: npt.ArrayLike) -> None:
        """A constant state (nx)."""
    @property
    def length(self) -> int:
        """Numbers of the state; 0 for a pose."""

class RelaxedBarrier:
    """The cost of a limit c(x, u) <= 0 (docs/equations.md, 12)."""
    def __init__(self, limit: Limit, mu: float = ..., delta: float = ...) -> None:
        """mu: weight, the smaller, the nearer one comes to the limit; delta: where the parabola takes over"""

class Scenario:
    """Everything a run needs, from one TOML file."""
    @property
    def duration(self) -> float:
        """[s]"""
    @property
    def expanded(self) -> str:
        """Its text with templates and layers written out."""
    @property
    def file(self) -> os.PathLike[str]: ...
    @property
    def horizon(self) -> Horizon: ...
    @property
    def name(self) -> str: ...
    @staticmethod
    def parse(text: str, file: str | os.PathLike[str] = ..., set: list[str] = ...) -> Scenario:
        """The same from a text; `file` stands in refusals, and gives the scenario its name."""
    @staticmethod
    def read(file: str | os.PathLike[str], set: list[str] = ...) -> Scenario:
        """Reads a file; `set` are "KEY=VALUE" over its values.

        Raises ScenarioError, "file:line: key = value, expected ...".
        """
    @property
    def seed(self) -> int: ...
    @property
    def solver(self) -> str: ...
    @property
    def team(self) -> Team: ...
    @property
    def text(self) -> str:
        """As it was read; with values set, the equivalent text."""
    @property
    def world(self) -> str: ...
    @property
    def x0(self) -> npt.NDArray[np.float64]:
        """States of all bodies at the start (nx)."""

class ScenarioError(ValueError): ...

class SensorMount:
    """Where the sensor sits on the robot, (45)."""
    def __init__(self, pitch: float = ..., offset: npt.ArrayLike = ..., frame: str = ..., sigmas: float = ..., yaw: float = ..., roll: float = ...) -> None:
        """pitch [rad], > 0 looks down; offset: lever arm (ahead, left, up) [m], or a number ahead; frame: "level" or "body"; sigmas: standard deviations of what is seen by which regions of view shrink, >= 0; yaw [rad], > 0 looks to the left; roll [rad], about the axis, > 0: left side up"""
    @property
    def offset(self) -> npt.NDArray[np.float64]: ...
    @property
    def pitch(self) -> float: ...
    @property
    def roll(self) -> float: ...
    @property
    def sigmas(self) -> float: ...
    @property
    def yaw(self) -> float: ...

class Sight:
    """What a potential sees of a body: pose, velocity and lean in G."""
    def __init__(self, p: npt.ArrayLike, d: npt.ArrayLike = ..., v: npt.ArrayLike = ..., lean: npt.ArrayLike = ...) -> None:
        """p: position [m], 3; d: heading (cos psi, sin psi); v: velocity [m/s], 3; lean: forward and to the left"""
    @property
    def d(self) -> npt.NDArray[np.float64]: ...
    @property
    def lean(self) -> npt.NDArray[np.float64]: ...
    @property
    def p(self) -> npt.NDArray[np.float64]: ...
    @property
    def v(self) -> npt.NDArray[np.float64]: ...

class Solution:
    """The outcome of one update."""
    @property
    def elapsed(self) -> float:
        """Wall time of the update [s]."""
    @property
    def iterations(self) -> int:
        """Of the Krylov method."""
    @property
    def raw_u(self) -> npt.NDArray[np.float64]:
        """The same before they were clamped to their limits (nu)."""
    @property
    def residual(self) -> float:
        """Infinity norm of the optimality conditions [1/s]; inf: not known."""
    @property
    def status(self) -> Status: ...
    @property
    def u(self) -> npt.NDArray[np.float64]:
        """Inputs to apply now, of all robots (nu)."""
    @property
    def x(self) -> npt.NDArray[np.float64]:
        """Predicted states of all bodies (N+1 x nx): the trajectory that was linearised."""

class Solver:
    """A solver of a team over a horizon. For one thread; solve, step and kkt let other threads run."""
    def __init__(self, team: Team, name: str = ..., *, T: float = ..., N: int = ..., dt: float = ..., **kwargs: Any) -> None:
        """T: horizon [s]; N: stages; dt: control period [s]; options as [solver] of a scenario has them"""
    def gradient(self, g: npt.ArrayLike) -> Gradient:
        """Derivatives of g' u (g: nu) by all that u, the inputs of the last update, depends on. Call it next after solve or step; for newton_riccati."""
    def kkt(self, time: float, states: npt.ArrayLike) -> float:
        """Projected KKT infinity norm of the present iterate at these states."""
    @property
    def name(self) -> str: ...
    @staticmethod
    def of(scenario: Scenario) -> Solver:
        """The solver of a scenario's team, with its options."""
    def planned(self, time: float) -> npt.NDArray[np.float64]:
        """Inputs (nu) that the last good plan has for `time` [s]."""
    def restart(self) -> None:
        """Forgets the iterate: the next update starts as the first did."""
    def solve(self, time: float, states: npt.ArrayLike) -> Solution:
        """One update: from the measured states of all bodies (nx) at `time` [s] to a Solution."""
    def step(self, time: float, states: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """solve() for who wants the inputs alone (nu)."""

class Status:
    """How an update ended, the better first."""
    def __init__(self, value: int) -> None: ...
    @property
    def __members__(self) -> dict: ...
    converged: ClassVar[Status]
    deadline: ClassVar[Status]
    invalid_state: ClassVar[Status]
    iteration_limit: ClassVar[Status]
    @property
    def name(self) -> str:
        """name(self: object) -> str"""
    not_finite: ClassVar[Status]
    stepped: ClassVar[Status]
    @property
    def value(self) -> int: ...

class Team:
    """Robots, targets and obstacles, and what couples them; checked as it is composed."""
    def __init__(self) -> None: ...
    def __len__(self) -> int: ...
    def add(self, model: Model, *, Q: Any = ..., R: Any = ..., Q_f: Any = ..., x_ref: Any = ..., u_ref: Any = ..., u_min: Any = ..., u_max: Any = ..., name: str = ..., rate_max: Any = ..., R_rate: Any = ...) -> Agent:
        """Adds a robot with the cost (x* - x)' Q (x* - x) + (u* - u)' R (u* - u), at the end Q_f.

        Q, Q_f: nx, >= 0, 0 if not given; R: nu, > 0, 1 if not given; x_ref: a Reference or a state; u_ref: nu;
        u_min, u_max: nu, the model's if not given; name: uav0, uav1, ... if not given;
        rate_max: nu, > 0 [1/s]; R_rate: nu, >= 0 [s^2]
        """
    def add_obstacle(self, name: str, *, has_heading: bool = ...) -> Body:
        """Adds a body that is not controlled, predicted with constant velocity: a target or an obstacle."""
    def constrain(self, term: Any, agent: Agent) -> None:
        """A potential that one robot feels by itself, or a RelaxedBarrier of a limit."""
    def couple(self, term: Any, between: Sequence[Any], felt_by: Any = ..., third: Optional[Body] = ...) -> None:
        """Couples two bodies by a weighted potential, the observer first; felt by both robots, or by those listed. A potential that looks past a third body, as a Region with third.p_x, needs that one."""
    def find(self, arg0: str) -> Body: ...
    def input(self, body: Body) -> slice:
        """Where a robot's input stands in the stacked u."""
    def is_agent(self, body: Body) -> bool: ...
    def keep_apart(self, term: Any, agents: list[Agent], radius: float = ..., capacity: int = ...) -> None:
        """A potential between all pairs of these robots that are nearer than the radius [m]; of more than
        `capacity` pairs the nearest count.
        """
    def model(self, body: Body) -> Model: ...
    def name(self, body: Body) -> str: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def nu(self) -> int:
        """Numbers in the stacked input."""
    @property
    def nx(self) -> int:
        """Numbers in the stacked state."""
    def state(self, body: Body) -> slice:
        """Where a body's state stands in the stacked x."""

class Weighted:
    """A potential times its weight, as 0.4 * potential."""
    @property
    def potential(self) -> Potential: ...
    @property
    def weight(self) -> float: ...

class World:
    """What a scenario flies, with its sensors, wind and seed, period by period, for a controller of one's own. For one thread."""
    def __init__(self, scenario: Scenario, seed: Optional[int] = ...) -> None: ...
    @property
    def detections(self) -> list[Detection]:
        """That arrived in this period, a Detection each."""
    @property
    def dt(self) -> float:
        """Control period [s]."""
    def restart(self, seed: Optional[int] = ...) -> None:
        """Begins anew, with another seed where one is given."""
    @property
    def seed(self) -> int: ...
    @property
    def stamps(self) -> npt.NDArray[np.float64]:
        """Of each body, when that was so [s]; -inf: never."""
    def step(self, u: npt.ArrayLike) -> None:
        """Applies the inputs of all robots (nu), clamped to their limits, for one period.

        Raises ValueError where one is not finite, RuntimeError with a sentence where the world cannot go on.
        """
    @property
    def team(self) -> Team: ...
    @property
    def time(self) -> float:
        """Now [s]."""
    @property
    def truth(self) -> npt.NDArray[np.float64]:
        """True states of all bodies (nx)."""
    @property
    def u(self) -> npt.NDArray[np.float64]:
        """As applied last (nu)."""
    @property
    def x(self) -> npt.NDArray[np.float64]:
        """What is measured of all bodies now (nx)."""

__version__: str

def altitude_band(*, z_min: npt.ArrayLike = ..., z_max: npt.ArrayLike = ..., kappa_G: npt.ArrayLike = ..., kappa_A: npt.ArrayLike = ...) -> Potential:
    """The potential "altitude_band" of scenarios.

    z_min: least height [m], finite; 0.3 if not given
    z_max: greatest height, above z_min [m], finite; 3 if not given
    kappa_G: slope outside [1/m^2], >= 0; 0.1 if not given
    kappa_A: sharpness of the step [1/m], > 0; 10 if not given
    """

def angle_multirotor(*, b_z: npt.ArrayLike = ..., b_psi: npt.ArrayLike = ..., a_f: npt.ArrayLike = ..., b_f: npt.ArrayLike = ..., a_s: npt.ArrayLike = ..., b_s: npt.ArrayLike = ...) -> Model:
    """The robot "angle_multirotor" of scenarios.

    b_z: climb per command [m/s], finite; 1 if not given
    b_psi: yaw rate per command [rad/s], finite; 1.6 if not given
    a_f: forward drag [1/s], finite; -0.5092 if not given
    b_f: forward acceleration per command [m/s^2], finite; 1.458 if not given
    a_s: sideward drag [1/s], finite; -0.5092 if not given
    b_s: sideward acceleration per command [m/s^2], finite; 1.458 if not given
    """

def bearing(*, alpha: npt.ArrayLike = ..., width: npt.ArrayLike = ..., tilt: npt.ArrayLike = ...) -> Potential:
    """The potential "bearing" of scenarios.

    alpha: angle up to which the target counts as in view [rad], in (0, pi]; 0.5 if not given
    width: nearer than this to the sensor l is smoothed [m], > 0; 0.1 if not given
    tilt: to the left, of the axis with the target behind [rad], in [0, 0.2]; 0.2 if not given
    """

def campaign_lines(name: str, file: str | os.PathLike[str]) -> list[tuple[str, str]]: ...

def cgmres(team: Team, *, T: float = ..., N: int = ..., dt: float = ..., **kwargs: Any) -> Solver:
    """The Solver of this name."""

def check(scenario: Scenario) -> Checked:
    """The report of `sightline check`. Raises ValueError where it cannot be flown."""

def circle(*, centre: npt.ArrayLike, radius: npt.ArrayLike = ..., rate: npt.ArrayLike = ...) -> Reference:
    """The reference "circle" of scenarios.

    centre: middle of the circle [m], finite; must be given
    radius: radius [m], >= 0; 0.5 if not given
    rate: how fast it goes round, anticlockwise [rad/s], finite; 0.3 if not given
    """

def cmscgmres(team: Team, *, T: float = ..., N: int = ..., dt: float = ..., **kwargs: Any) -> Solver:
    """The Solver of this name."""

def cohesion(*, d_max: npt.ArrayLike = ..., kappa_H: npt.ArrayLike = ..., kappa_G: npt.ArrayLike = ..., kappa_A: npt.ArrayLike = ...) -> Potential:
    """The potential "cohesion" of scenarios.

    d_max: greatest distance [m], > 0; 2 if not given
    kappa_H: height of the step, > 0; 1.5 if not given
    kappa_G: slope outside [1/m^2], >= 0; 0.001 if not given
    kappa_A: sharpness of the step [1/m^2], > 0; 3 if not given
    """

compiler: str

def constant(*, p: npt.ArrayLike) -> Reference:
    """The reference "constant" of scenarios.

    p: position [m], finite; must be given
    heading: left out: free [rad], finite; may be left out
    """

def explain(scenario: Scenario) -> str:
    """Which of its limits can hold together and what each is worth, as `sightline explain`."""

def fly_campaign(scenario: Scenario, out: str | os.PathLike[str], runs: int, seed: Optional[int], threads: int, progress: Any) -> os.PathLike[str]: ...

def geofence(*, low: npt.ArrayLike = ..., high: npt.ArrayLike = ..., kappa_G: npt.ArrayLike = ..., kappa_A: npt.ArrayLike = ...) -> Potential:
    """The potential "geofence" of scenarios.

    low: corner [m], finite; [-10, -10, 0] if not given
    high: opposite corner, above low in each axis [m], finite; [10, 10, 5] if not given
    kappa_G: slope outside [1/m^2], >= 0; 0.1 if not given
    kappa_A: sharpness of the step [1/m], > 0; 10 if not given
    """

def hover_multirotor(*, b_z: npt.ArrayLike = ..., b_psi: npt.ArrayLike = ..., a_f: npt.ArrayLike = ..., b_f: npt.ArrayLike = ..., a_s: npt.ArrayLike = ..., b_s: npt.ArrayLike = ..., tau: npt.ArrayLike = ..., tau_z: npt.ArrayLike = ..., tau_psi: npt.ArrayLike = ...) -> Model:
    """The robot "hover_multirotor" of scenarios.

    preset: the start for all others, one of x500 crazyflie ar_drone

    b_z: climb per command [m/s], finite; 1.08 if not given
    b_psi: yaw rate per command [rad/s], finite; 1.6 if not given
    a_f: forward drag [1/s], finite; -0.123 if not given
    b_f: forward acceleration per command [m/s^2], finite; 2 if not given
    a_s: sideward drag [1/s], finite; -0.123 if not given
    b_s: sideward acceleration per command [m/s^2], finite; 2 if not given
    tau: lag of the tilt; 0 with the other two: no state lags [s], 0 or 0.001 to 1000; 0 if not given
    tau_z: lag of the climb [s], 0 or 0.001 to 1000; 0 if not given
    tau_psi: lag of the yaw rate [s], 0 or 0.001 to 1000; 0 if not given
    """

def input_disc(*, radius: npt.ArrayLike = ..., i: npt.ArrayLike = ..., j: npt.ArrayLike = ...) -> Limit:
    """The limit "input_disc" of scenarios.

    radius: in the unit of the inputs, > 0; 1 if not given
    i: the one input, from 0; of a multirotor u_f, 0 to 1000; 0 if not given
    j: the other; of a multirotor u_s, 0 to 1000; 1 if not given
    """

def keep_out(*, d_min: npt.ArrayLike = ..., kappa_H: npt.ArrayLike = ..., kappa_G: npt.ArrayLike = ..., kappa_A: npt.ArrayLike = ...) -> Potential:
    """The potential "keep_out" of scenarios.

    d_min: least distance [m], > 0; 1 if not given
    kappa_H: height of the step, > 0; 4.5 if not given
    kappa_G: slope inside [1/m^2], >= 0; 0.001 if not given
    kappa_A: sharpness of the step [1/m^2], > 0; 3 if not given
    """

limits: tuple[str, ...]

def localize_recording(recording: str | os.PathLike[str], out: str | os.PathLike[str], landmarks: str, robots: str, anchor: str, start: str, identities: bool, noise: str | os.PathLike[str], set: list[str], identify_noise: bool, seed: int, pixels: str) -> str: ...

def multirotor(*, b_z: npt.ArrayLike = ..., b_psi: npt.ArrayLike = ..., a_f: npt.ArrayLike = ..., b_f: npt.ArrayLike = ..., a_s: npt.ArrayLike = ..., b_s: npt.ArrayLike = ...) -> Model:
    """The robot "multirotor" of scenarios.

    b_z: climb per command [m/s], finite; 1 if not given
    b_psi: yaw rate per command [rad/s], finite; 1.6 if not given
    a_f: forward drag [1/s], finite; -0.5092 if not given
    b_f: forward acceleration per command [m/s^2], finite; 1.458 if not given
    a_s: sideward drag [1/s], finite; -0.5092 if not given
    b_s: sideward acceleration per command [m/s^2], finite; 1.458 if not given
    """

def newton_riccati(team: Team, *, T: float = ..., N: int = ..., dt: float = ..., **kwargs: Any) -> Solver:
    """The Solver of this name."""

def omni_rover(*, b_psi: npt.ArrayLike = ..., a_f: npt.ArrayLike = ..., b_f: npt.ArrayLike = ..., a_s: npt.ArrayLike = ..., b_s: npt.ArrayLike = ...) -> Model:
    """The robot "omni_rover" of scenarios.

    b_psi: yaw rate per command [rad/s], finite; 1.5 if not given
    a_f: forward drag [1/s], finite; -2.5 if not given
    b_f: forward acceleration per command; b_f / -a_f is the top speed [m/s^2], finite; 2.5 if not given
    a_s: sideward drag [1/s], finite; -2.5 if not given
    b_s: sideward acceleration per command [m/s^2], finite; 2.5 if not given
    """

def pass_right(*, d_min: npt.ArrayLike = ..., delta: npt.ArrayLike = ..., kappa: npt.ArrayLike = ...) -> Potential:
    """The potential "pass_right" of scenarios.

    d_min: least distance, but for delta [m], > 0; 1 if not given
    delta: how far to its left each has the other, below d_min; 0: as too_near [m], >= 0; 0.2 if not given
    kappa: sharpness of the bend at d_min [1/m], > 0; 10 if not given
    """

def point_mass(*, drag: npt.ArrayLike = ...) -> Model:
    """The robot "point_mass" of scenarios.

    drag: how fast it slows down by itself [1/s], >= 0; 0 if not given
    """

potentials: tuple[str, ...]

def recorded_pair(name: str, l: Expression, limit: Optional[Expression], mount: Optional[SensorMount]) -> Potential: ...

def recorded_reference(states: list[Expression]) -> Reference: ...

def recorded_robot(name: str, rates: list[Expression], states: list[str], inputs: list[str], position: list[str], heading: list[str], u_min: Any, u_max: Any) -> Model: ...

def recorded_single(name: str, l: Expression, limit: Optional[Expression]) -> Potential: ...

references: tuple[str, ...]

def relative_velocity(*, v_0: npt.ArrayLike = ...) -> Potential:
    """The potential "relative_velocity" of scenarios.

    v_0: velocity that costs 1 [m/s], > 0; 1 if not given
    """

def replay(folder: str | os.PathLike[str], solver: Optional[str], set: list[str]) -> str: ...

robots: tuple[str, ...]

def run(scenario: Scenario, out: str | os.PathLike[str], seed: Optional[int], solver: Optional[str], progress: Any) -> Flown: ...

def sensor_cone(*, alpha: npt.ArrayLike = ..., kappa_G: npt.ArrayLike = ..., kappa_A: npt.ArrayLike = ..., form: npt.ArrayLike = ...) -> Potential:
    """The potential "sensor_cone" of scenarios.

    alpha: beam angle [rad], in (0, pi/2); 0.5 if not given
    kappa_G: slope outside the cone; 0 leaves no gradient to return by, (33) [1/m^2], >= 0; 0.01 if not given
    kappa_A: sharpness of the step [1/m^2], > 0; 2 if not given
    form: the border is at x sin alpha, (27), or x tan alpha, one of sine, tangent; sine if not given
    """

sight_size: int

def speed(*, max: npt.ArrayLike = ..., min: npt.ArrayLike = ...) -> Limit:
    """The limit "speed" of scenarios.

    max: greatest horizontal speed [m/s], > 0; 1 if not given
    min: least, below max [m/s], >= 0; 0 if not given
    """

def steps(*, times: npt.ArrayLike, p: npt.ArrayLike) -> Reference:
    """The reference "steps" of scenarios.

    times: when; the first pose also holds before [s], a list, rising; must be given
    p: where, for each time [m], a list; must be given
    heading: for each time; left out: free [rad], a list; may be left out
    """

def too_far(*, d_max: npt.ArrayLike = ..., kappa: npt.ArrayLike = ...) -> Potential:
    """The potential "too_far" of scenarios.

    d_max: greatest distance [m], > 0; 2 if not given
    kappa: sharpness of the bend at d_max [1/m], > 0; 10 if not given
    """

def too_near(*, d_min: npt.ArrayLike = ..., kappa: npt.ArrayLike = ...) -> Potential:
    """The potential "too_near" of scenarios.

    d_min: least distance [m], > 0; 1 if not given
    kappa: sharpness of the bend at d_min [1/m], > 0; 10 if not given
    """

def unicycle(*, b_psi: npt.ArrayLike = ..., a_f: npt.ArrayLike = ..., b_f: npt.ArrayLike = ...) -> Model:
    """The robot "unicycle" of scenarios.

    b_psi: yaw rate per command [rad/s], finite; 1.5 if not given
    a_f: forward drag [1/s], finite; -2.5 if not given
    b_f: forward acceleration per command; b_f / -a_f is the top speed [m/s^2], finite; 2.5 if not given
    """

def velocity_multirotor(*, tau_f: npt.ArrayLike = ..., tau_s: npt.ArrayLike = ..., tau_z: npt.ArrayLike = ..., tau_psi: npt.ArrayLike = ..., v_max: npt.ArrayLike = ..., climb_max: npt.ArrayLike = ..., yaw_max: npt.ArrayLike = ..., frame: npt.ArrayLike = ...) -> Model:
    """The robot "velocity_multirotor" of scenarios.

    preset: the start for all others, one of px4 ar_drone

    tau_f: lag of the forward velocity [s], 0.001 to 1000; 0.5 if not given
    tau_s: lag of the sideward velocity [s], 0.001 to 1000; 0.5 if not given
    tau_z: lag of the vertical velocity; 0: v_z is no state [s], 0 or 0.001 to 1000; 0.35 if not given
    tau_psi: lag of the yaw rate; 0: r is no state [s], 0 or 0.001 to 1000; 0.2 if not given
    v_max: limit of u_f and u_s [m/s], > 0; 3 if not given
    climb_max: limit of u_z [m/s], > 0; 1 if not given
    yaw_max: limit of u_psi [rad/s], > 0; 0.78 if not given
    frame: where its velocity stays while it yaws: with the heading, or level, in G, one of heading, level; heading if not given
    """

def waypoints(*, times: npt.ArrayLike, p: npt.ArrayLike) -> Reference:
    """The reference "waypoints" of scenarios.

    times: when; the first pose also holds before [s], a list, rising; must be given
    p: where, for each time [m], a list; must be given
    heading: for each time; left out: free [rad], a list; may be left out
    v: for each time; left out: straight lines [m/s], a list; may be left out
    """

def write_campaign_page(scenario: Scenario, file: str | os.PathLike[str], seed: int) -> os.PathLike[str]: ...

def write_report(folder: str | os.PathLike[str]) -> None: ...
