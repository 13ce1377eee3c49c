#!/usr/bin/env python3
"""Tunes controllers of the benchmark: random settings, an equal budget for each, the best of them into controllers.json.

A candidate multiplies each number of a controller's solver and couplings by its own factor, log-uniform within
1/--factor to --factor; the first candidate is the setting before any tuning. Its measure is the mean over the tasks of recovered
share and median time in view. The seed of the runs is not that of the table, so the table's runs are held out.
"""

import argparse
import json
import math
import pathlib
import random
import sys
import tempfile

import campaigns


TUNED = ("solver", "couplings")


def changed(controller, draw):
    """The controller with each tuned number times a drawn factor."""
    def of(table):
        return {key: float(f"{value * draw():.4g}") if isinstance(value, float) else value
                for key, value in table.items()}
    return controller | {key: of(controller[key]) for key in TUNED if key in controller}


def measure(run, name, controller, options, folder):
    total = 0.0
    for task in options.tasks:
        place = folder / task
        file = campaigns.write_scenario(run, task, name, controller, place)
        campaign = campaigns.fly(run, file, place, options.runs, options.seed, options.duration)
        in_view = campaign["medians"]["fraction_in_view"]
        total += 0.5 * campaign["outcomes"]["recovered"]["share"] + 0.5 * (in_view["median"] if in_view else 0.0)
    return total / len(options.tasks)


def command(name, options):
    settings = " ".join(f"--{key} {getattr(options, key)}" for key in ("candidates", "runs", "duration", "seed", "factor"))
    return f"benchmark/tune.py --controllers {name} --tasks {' '.join(options.tasks)} {settings}"


def main():
    listed = json.loads(campaigns.CONTROLLERS.read_text())
    tunable = [name for name, of in listed.items() if "as" not in of]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--controllers", nargs="+", default=tunable, choices=tunable)
    parser.add_argument("--tasks", nargs="+", default=["paper_7_1", "paper_7_2", "adversary"], choices=campaigns.tasks())
    parser.add_argument("--candidates", type=int, default=12)
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--duration", type=float, default=10.0, help="of each run [s]")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--factor", type=float, default=2.0)
    parser.add_argument("--program", default="build/release/bin/sightline_keep_in_view")
    options = parser.parse_args()
    run = campaigns.program(options.program, None)
    for name in options.controllers:
        draw = random.Random(f"{options.seed} {name}")
        start = listed[name] | listed[name].get("tuned", {}).get("from", {})
        best, most, first = start, -math.inf, None
        for candidate in range(options.candidates):
            value = None
            while value is None:  # draws again where a number leaves its range
                tried = changed(start, lambda: options.factor ** draw.uniform(-1, 1)) if candidate else start
                with tempfile.TemporaryDirectory() as folder:
                    try:
                        value = measure(run, name, tried, options, pathlib.Path(folder))
                    except campaigns.Refused as refusal:
                        if candidate == 0:
                            sys.exit(f"{name}: {refusal}")
            first = value if first is None else first
            if value > most:
                best, most = tried, value
        listed = json.loads(campaigns.CONTROLLERS.read_text())
        listed[name] = best | {"tuned": {
            "command": command(name, options), "before": round(first, 4), "after": round(most, 4),
            "from": {key: start[key] for key in TUNED if key in start}}}
        print(f"{name}: {first:.4f} to {most:.4f}", file=sys.stderr)
        campaigns.CONTROLLERS.write_text(json.dumps(listed, indent=2) + "\n")


if __name__ == "__main__":
    main()
