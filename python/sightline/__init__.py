"""sightline: real-time nonlinear model predictive control of robot teams that keep each other in view.

    import sightline as sl

Words are those of scenarios and of C++; parameters are keyword arguments, numbers are numpy arrays, and what is refused is a
ValueError with the library's sentence. docs/python.md has the whole.
"""

import json as _json

from . import _sightline
from ._sightline import *  # noqa: F401,F403
from ._sightline import Log, Scenario, __version__, compiler  # noqa: F401
from .tracing import (  # noqa: F401
    Symbol,
    TraceError,
    atan2,
    cos,
    exp,
    log,
    logistic,
    maximum,
    minimum,
    potential,
    reference,
    robot,
    sin,
    softplus,
    sqrt,
)


class Flight:
    """What a run left: its files, and how it is judged."""

    def __init__(self, folder, summary, faults):
        self.folder = folder  # of run.mcap, timing.csv and summary.json
        self.summary = summary  # of summary.json; None is a number that was not finite
        self.faults = faults  # what makes the run a failure, a sentence each

    @property
    def log(self):
        """The Log, read again at each call."""
        return Log(self.folder)

    @property
    def ok(self):
        """Whether `sightline run` would end with exit code 0."""
        return not self.faults

    def report(self):
        """Makes report.html, one file with all figures, by gnuplot. Its path."""
        _sightline.write_report(self.folder)
        return self.folder / "report.html"

    def __repr__(self):
        return f"<flight {self.folder}, {'ok' if self.ok else '; '.join(self.faults)}>"

    def _repr_html_(self):
        import html

        rows = [("folder", self.folder), ("solver", self.summary.get("solver")), ("updates", self.summary.get("updates")),
                ("cost", self.summary.get("cost")), ("least distance [m]", self.summary.get("min_distance"))]
        rows += [("fault", fault) for fault in self.faults]
        cells = "".join(f"<tr><td>{html.escape(str(k))}</td><td>{html.escape(str(v))}</td></tr>" for k, v in rows)
        return f"<table>{cells}</table>"


def _scenario(given):
    return given if isinstance(given, Scenario) else Scenario.read(given)


def run(scenario, seed=None, out=None, solver=None, progress=None):
    """Flies a scenario in simulated time, to the same bits as `sightline run`.

    scenario: a Scenario, or the name of its file; seed, solver: in place of the scenario's
    out: folder for run.mcap, timing.csv and summary.json; out/NAME if not given
    progress: a function that is called with the simulated time [s] a few times a second

    Other threads run meanwhile. Ctrl-C ends the flight at the next period, with a log up to there.
    """
    flown = _sightline.run(_scenario(scenario), "" if out is None else out, seed, solver, progress)
    return Flight(flown.folder, _json.loads(flown.summary), flown.faults)


def check(scenario):
    """What `sightline check` says of a scenario. Raises ValueError where it cannot be flown."""
    return _sightline.check(_scenario(scenario))


def explain(scenario):
    """Which limits of a scenario can hold together and what each is worth, as `sightline explain`."""
    return _sightline.explain(_scenario(scenario))


def replay(folder, solver=None, set=()):
    """Feeds the measurements of a run through its loop again, and compares each command bit for bit.

    folder: of a run; solver, set: another solver, or other values of its scenario. A dict as `sightline replay --json` has it.
    """
    return _json.loads(_sightline.replay(folder, solver, list(set)))
