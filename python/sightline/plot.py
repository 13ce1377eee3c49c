"""Figures of a log by matplotlib, a few lines each; `ax` is where it is drawn, and comes back.

    from sightline import plot
    plot.paths(log)
"""

import itertools

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
