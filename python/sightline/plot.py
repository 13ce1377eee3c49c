"""Figures of a log by matplotlib, a few lines each; `ax` is where it is drawn, and comes back. Those of a report as SVG.

    from sightline import plot
    plot.paths(log)
"""

import html
import itertools
import json
import re
from pathlib import Path

import numpy as np


def _axes(ax):
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def paths(log, ax=None):
    """Where the bodies went, from above; a dot where each began."""
    ax = _axes(ax)
    for name, body in log.bodies.items():
        (line,) = ax.plot(body.p[:, 0], body.p[:, 1], label=name)
        ax.plot(*body.p[:1, :2].T, "o", color=line.get_color())
    ax.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title=log.name)
    ax.legend()
    return ax


def distance(log, between=None, ax=None):
    """How far two bodies were from each other over time; of each pair where `between` names none."""
    ax = _axes(ax)
    pairs = [between] if between is not None else itertools.combinations(log.bodies, 2)
    for a, b in pairs:
        ax.plot(log.time, np.linalg.norm(log[a].p - log[b].p, axis=1), label=f"{a}, {b}")
    ax.set(xlabel="t [s]", ylabel="distance [m]", ylim=(0, None))
    ax.legend()
    return ax


def inputs(log, robot, ax=None):
    """The applied inputs of a robot over time."""
    ax = _axes(ax)
    for name, values in zip(log[robot].inputs, log[robot].u.T):
        ax.plot(log.time, values, label=name)
    ax.set(xlabel="t [s]", ylabel="input", title=robot)
    ax.legend()
    return ax


def success(campaign, x, y, ax=None):
    """Where the runs of a campaign were recovered and where not, over two of its columns."""
    ax = _axes(ax)
    runs = campaign.runs
    for outcome in campaign.outcomes:
        of_it = runs["outcome"] == outcome
        ax.plot(runs[x][of_it], runs[y][of_it], "o" if outcome == "recovered" else "x", label=outcome)
    ax.set(xlabel=x, ylabel=y)
    ax.legend()
    return ax


_marks = {"line": {}, "dashed": {"linestyle": "--"}, "thin": {"linewidth": 0.8}, "points": {"linestyle": "", "marker": "."}}


def _text(words):
    return words.replace("$", r"\$")  # no formula


def _panel(ax, panel):
    for curve in panel["curves"]:
        x, y = (np.array(curve[axis], dtype=float) for axis in "xy")  # a gap is NaN
        look = {"color": curve["colour"], "label": _text(curve["label"]) or None}
        if curve["mark"] == "arrows":
            ax.quiver(x[::2], y[::2], np.diff(x)[::2], np.diff(y)[::2], angles="xy", scale_units="xy", scale=1, width=0.003, **look)
        elif curve["mark"] == "bars":
            ax.stairs(y[:-1], x, fill=True, alpha=0.55, **look)
        else:
            ax.plot(x, y, **_marks[curve["mark"]], **look)
    for note in panel["notes"]:
        ax.annotate(_text(note["text"]), (note["x"], note["y"]), fontsize="small")
    for moment in panel["moments"]:
        ax.axvline(moment["x"], color="grey", linestyle=":")
        ax.annotate(_text(moment["text"]), (moment["x"], 1), xycoords=("data", "axes fraction"), va="top", fontsize="small")
    ax.set(**{f"{axis}scale": "log" for axis, log in zip("xy", panel["log"]) if log})
    if panel["equal"]:
        ax.set_aspect("equal", "datalim")
    if panel["names"]:
        ax.set_yticks(range(len(panel["names"])), map(_text, panel["names"]))
    ax.set(xlabel=_text(panel["x"]), ylabel=_text(panel["y"]), title=_text(panel["title"]), xlim=panel["xRange"], ylim=panel["yRange"])
    ax.tick_params(labelbottom=bool(panel["x"]))
    ax.grid(alpha=0.4)
    longest = max(len(curve["label"]) for curve in panel["curves"])
    if longest > 0:
        ax.legend(fontsize="small", loc="upper right", ncols=max(1, 80 // (longest + 8)))


def figures(folder):
    """Writes the figures of a run's report.html as SVG into its folder `figures`; their files."""
    from matplotlib.figure import Figure

    folder = Path(folder)
    (folder / "figures").mkdir(exist_ok=True)
    page = (folder / "report.html").read_text(encoding="utf-8")
    files = []
    for title, content in re.findall(r'<h2>([^\n]*)</h2>\n<figure [^\n]*\n(.*?)\n<figcaption>', page, re.S):
        name = re.sub(r"\W+", "_", html.unescape(title)).strip("_")
        files.append(folder / "figures" / f"{len(files):02}_{name}.svg")
        if content.startswith("<svg"):
            svg = content.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1).replace("var(--paper)", "#fff")
            files[-1].write_text(svg, encoding="utf-8")
            continue
        panels = json.loads(content.partition(">")[2].rpartition("<")[0])["panels"]
        heights = [panel["height"] / 110 + 0.4 for panel in panels]  # [in]
        figure = Figure(figsize=(7, sum(heights) + 0.4), layout="constrained")
        for ax, panel in zip(figure.subplots(len(panels), squeeze=False, height_ratios=heights).flat, panels):
            _panel(ax, panel)
        figure.savefig(files[-1], metadata={"Date": None})
    return files
