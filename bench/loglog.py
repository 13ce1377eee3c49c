"""Draws times over the number of robots, both logarithmic:  bench/loglog.py FILE.svg TITLE CURVE...

A CURVE is LABEL|COLOUR|STYLE|FILE|COLUMN, of rows that begin with robots (STYLE of matplotlib), or with SCALE EXPONENT in
place of FILE|COLUMN the line SCALE robots^EXPONENT.
"""

import sys

import matplotlib
import numpy as np
from matplotlib.figure import Figure

name, title, *curves = sys.argv[1:]
matplotlib.rcParams["svg.hashsalt"] = name
figure = Figure(figsize=(7.6, 5.2), layout="constrained")
ax = figure.subplots()
robots = set()
for label, colour, style, *data in (curve.split("|") for curve in curves):
    if len(data) == 2:
        rows = np.loadtxt(data[0])
        robots |= set(rows[:, 0])
        ax.plot(rows[:, 0], rows[:, int(data[1]) - 1], style, color=colour, label=label or None)
        continue
    scale, exponent = map(float, data[0].split())
    x = np.array([min(robots), max(robots)])
    ax.plot(x, scale * x**exponent, style, color=colour, label=label)
ax.set(title=title, xlabel="robots", ylabel="median time of one update [us]", xscale="log", yscale="log")
ax.set_xticks(sorted(robots), [f"{n:g}" for n in sorted(robots)], minor=False)
ax.minorticks_off()
ax.grid()
ax.legend()
figure.savefig(name, metadata={"Date": None})
