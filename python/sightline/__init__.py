"""sightline: real-time nonlinear model predictive control of robot teams that keep each other in view.

    import sightline as sl

Words are those of scenarios and of C++; parameters are keyword arguments, numbers are numpy arrays, and what is refused is a
ValueError with the library's sentence. docs/python.md has the whole.
"""

import contextlib as _contextlib
import html as _html
import json as _json

from . import _sightline
from ._sightline import *  # noqa: F401,F403
from ._sightline import Log, Scenario, __version__, compiler  # noqa: F401
from .plot import figures  # noqa: F401
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
        """Makes report.html, one file with all figures. Its path."""
        _sightline.write_report(self.folder)
        return self.folder / "report.html"

    def __repr__(self):
        return f"<flight {self.folder}, {'ok' if self.ok else '; '.join(self.faults)}>"

    def _repr_html_(self):
        rows = [("folder", self.folder), ("solver", self.summary.get("solver")), ("updates", self.summary.get("updates")),
                ("cost", self.summary.get("cost")), ("least distance [m]", self.summary.get("min_distance"))]
        return _html_table(rows + [("fault", fault) for fault in self.faults])


def _html_table(rows):
    cells = "".join(f"<tr><td>{_html.escape(str(k))}</td><td>{_html.escape(str(v))}</td></tr>" for k, v in rows)
    return f"<table>{cells}</table>"


def _scenario(given):
    return given if isinstance(given, Scenario) else Scenario.read(given)


def _bar(total, unit):
    """A function of what is done: a bar in a terminal, in place of the one before; in a notebook one that its cell shows."""
    import sys

    def words(done):
        return f"[{'#' * int(30 * min(1.0, done / total)):30}] {done:g} of {total:g} {unit}"

    if "ipykernel" in sys.modules:
        from IPython.display import display

        shown = display(words(0), display_id=True)
        return lambda done: shown.update(words(done))
    return lambda done: print(f"\r{words(done)} ", end="", file=sys.stderr, flush=True)


def run(scenario, seed=None, out=None, solver=None, progress=None):  # type: ignore[no-redef]
    """Flies a scenario in simulated time, to the same bits as `sightline run`.

    scenario: a Scenario, or the name of its file; seed, solver: in place of the scenario's
    out: folder for run.mcap, timing.csv and summary.json; out/NAME if not given
    progress: a function that is called with the simulated time [s] a few times a second; True: a bar

    Other threads run meanwhile. Ctrl-C ends the flight at the next period, with a log up to there.
    """
    scenario = _scenario(scenario)
    progress = _bar(scenario.duration, "s") if progress is True else progress
    flown = _sightline.run(scenario, "" if out is None else out, seed, solver, progress)
    return Flight(flown.folder, _json.loads(flown.summary), flown.faults)


def check(scenario):  # type: ignore[no-redef]
    """What `sightline check` says of a scenario. Raises ValueError where it cannot be flown."""
    return _sightline.check(_scenario(scenario))


def explain(scenario):  # type: ignore[no-redef]
    """Which limits of a scenario can hold together and what each is worth, as `sightline explain`."""
    return _sightline.explain(_scenario(scenario))


def replay(folder, solver=None, set=()):  # type: ignore[no-redef]
    """Feeds the measurements of a run through its loop again, and compares each command bit for bit.

    folder: of a run; solver, set: another solver, or other values of its scenario. A dict as `sightline replay --json` has it.
    """
    return _json.loads(_sightline.replay(folder, solver, list(set)))


def localize(recording, out=None, landmarks="all", robots="all", anchor="", start="known", identities=True, noise="", set=(),
             identify_noise=False, seed=1, pixels=""):
    """Localizes a recorded team or camera rig, as `sightline localize`. The summary, a dict.

    recording, out: folder of the recording, or PREFIX or bag of a rig; folder of the results, out/RECORDING/localize if not given
    landmarks, robots: robots that see them, "all", "none" or names with commas; anchor: robot with a known pose
    noise, set: file with [localize], KEY=VALUE of it; other options as those of the command
    A rig takes these two and pixels alone. Its random walks are fitted unless noise is given or set has one.
    """
    return _json.loads(_sightline.localize_recording(recording, "" if out is None else out, landmarks, robots, anchor, start,
                                                     identities, noise, list(set), identify_noise, seed, pixels))


class Campaign:
    """The runs of a campaign: its table campaign.sqlite, a row a run."""

    def __init__(self, scenario, file):
        self.scenario = scenario
        self.file = file
        self.runs = self._table()

    def _table(self):
        import sqlite3

        import numpy as np

        with _contextlib.closing(sqlite3.connect(f"file:{self.file}?mode=ro", uri=True)) as database:
            self.about = dict(database.execute("SELECT key, value FROM campaign"))
            asked = database.execute('SELECT * FROM runs ORDER BY "index"')
            names = [column[0] for column in asked.description]
            rows = asked.fetchall()
        columns = {}
        for i, name in enumerate(names):
            values = [row[i] for row in rows]
            words = any(isinstance(value, str) for value in values)
            missing = "" if words else np.nan
            columns[name] = np.array([missing if value is None else value for value in values])
        return columns

    @property
    def outcomes(self):
        """How many runs had each outcome."""
        words = list(self.runs["outcome"])
        return {str(word): words.count(word) for word in dict.fromkeys(words)}

    def frame(self):
        """The runs as a pandas DataFrame, by their index."""
        import pandas

        return pandas.DataFrame(self.runs).set_index("index")

    def lines(self):
        """What `sightline campaign` prints of it: (what, value) each."""
        return _sightline.campaign_lines(self.scenario.name, self.file)

    def report(self):
        """Makes campaign.html, one file with all figures. Its path."""
        return _sightline.write_campaign_page(self.scenario, self.file, int(self.about["seed"]))

    def __len__(self):
        return len(self.runs["index"])

    def __repr__(self):
        return f"<campaign {self.file}, {len(self)} runs>"

    def _repr_html_(self):
        return _html_table(self.lines())


def campaign(scenario, runs=100, seed=None, out=None, threads=0, progress=None):
    """Flies many runs of a scenario with [campaign], each with its own draws; the table has the rows of `sightline campaign`.

    scenario: a Scenario, or the name of its file; runs, seed: as the command's; threads: 0 is one a core
    out: folder for campaign.sqlite, which goes on where it was; out/NAME/campaign if not given
    progress: a function that is called with the number of runs a few times a second; True: a bar

    Other threads run meanwhile. Ctrl-C ends it after the present runs, with a table that opens and goes on.
    """
    scenario = _scenario(scenario)
    progress = _bar(runs, "runs") if progress is True else progress
    return Campaign(scenario, _sightline.fly_campaign(scenario, "" if out is None else out, runs, seed, threads, progress))


def _log_frame(log):
    """The log as a pandas DataFrame: a row a period, columns (body, what), by the time [s]."""
    import pandas

    columns = {}
    for name, body in log.bodies.items():
        for i, axis in enumerate("xyz"):
            columns[name, f"p_{axis}"] = body.p[:, i]
        for i, axis in enumerate("xyz"):
            columns[name, f"v_{axis}"] = body.v[:, i]
        columns[name, "heading"] = body.heading
        for i, label in enumerate(body.inputs):
            columns[name, label] = body.u[:, i]
    columns["team", "cost"] = log.cost
    columns["team", "residual"] = log.residual
    columns["team", "status"] = log.status
    return pandas.DataFrame(columns, index=pandas.Index(log.time, name="t"))


setattr(Log, "frame", _log_frame)  # the stub has it as a method, to which nothing is assigned
