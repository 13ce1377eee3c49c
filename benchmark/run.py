#!/usr/bin/env python3
"""The benchmark "keep in view": every task with every controller, one table. docs/benchmark.md."""

import argparse
import json
import pathlib
import sys

import campaigns


def rows_of(result):
    """JSON with one line for each cell."""
    tasks = ",\n".join(
        f"  {json.dumps(task)}: {{\n" + ",\n".join(f"   {json.dumps(name)}: {json.dumps(cell)}" for name, cell in cells.items())
        + "}" for task, cells in result["tasks"].items())
    rest = {key: of for key, of in result.items() if key != "tasks"}
    return json.dumps(rest)[:-1] + ",\n \"tasks\": {\n" + tasks + "}}\n"


def percent(of):
    return "-" if of is None else f"{100 * of[0]:.1f} ({100 * of[1]:.1f} to {100 * of[2]:.1f})"


def scores(campaign):
    """Shares with their 95 % bounds: of recovered runs, of time in view (median of the runs)."""
    recovered = campaign["outcomes"]["recovered"]
    in_view = campaign["medians"]["fraction_in_view"]
    return {"recovered": [recovered["share"], recovered["low"], recovered["high"]],
            "in_view": None if in_view is None else [in_view["median"], in_view["low"], in_view["high"]],
            "outcomes": {name: of["runs"] for name, of in campaign["outcomes"].items()},
            "digest": campaign["digest"]}


def table(result, key):
    lines = ["| task | " + " | ".join(result["controllers"]) + " |", "|---" * (1 + len(result["controllers"])) + "|"]
    for task, cells in result["tasks"].items():
        row = [percent(cells[name].get(key)) for name in result["controllers"]]
        known = [cells[name][key][0] for name in result["controllers"] if cells[name].get(key)]
        for i, name in enumerate(result["controllers"]):
            if cells[name].get(key) and cells[name][key][0] == max(known):
                row[i] = f"**{row[i]}**"
        lines.append(f"| {task} | " + " | ".join(row) + " |")
    return "\n".join(lines)


def wins(result):
    """Sentences: where another controller is better than sightline beyond both bounds."""
    found = []
    for task, cells in result["tasks"].items():
        own = cells.get("sightline")
        for name, cell in cells.items():
            if own is None or name.startswith("sightline"):
                continue
            for key, what in (("recovered", "recovered runs"), ("in_view", "time in view")):
                if cell.get(key) and own.get(key) and cell[key][1] > own[key][2]:
                    found.append(f"{task}: {name} has more {what} than sightline, {percent(cell[key])} % instead of "
                                 f"{percent(own[key])} %.")
    return found


def markdown(result):
    refused = {}
    for task, cells in result["tasks"].items():
        for name, cell in cells.items():
            if "refused" in cell:
                refused.setdefault(f"{name}, {cell['refused']}", []).append(task)
    parts = [
        f"{result['runs']} runs for each task and controller, seed {result['seed']}, sightline {result['version']}, "
        f"{result['machine']}. In brackets: 95 % bounds.",
        "Recovered runs [%]:", table(result, "recovered"), "Time in view [%], median of the runs:",
        table(result, "in_view"), "Where a baseline wins:",
        "\n".join(f"- {sentence}" for sentence in wins(result)) or "- nowhere beyond the bounds"]
    if refused:
        parts += ["Not flown:", "\n".join(f"- {why}: {', '.join(of)}" for why, of in refused.items())]
    return "\n\n".join(parts) + "\n"


def main():
    known = campaigns.controllers()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tasks", nargs="+", default=campaigns.tasks(), choices=campaigns.tasks())
    parser.add_argument("--controllers", nargs="+", default=list(known), choices=[*known, "process"])
    parser.add_argument("--process", metavar="COMMAND", help="program of the controller `process`")
    parser.add_argument("--duration", type=float, help="of each run [s], instead of the tasks'")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--program", default="build/release/bin/sightline_keep_in_view")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    options = parser.parse_args()
    if ("process" in options.controllers) != bool(options.process):
        parser.error("--controllers process and --process COMMAND belong together")

    run = campaigns.program(options.program, options.process)
    result = {"runs": options.runs, "seed": options.seed, "controllers": options.controllers, "tasks": {}}
    for task in options.tasks:
        cells = result["tasks"][task] = {}
        for name in options.controllers:
            folder = options.output / name / task
            try:
                controller = known.get(name, {"solver": {"name": "process"}})
                file = campaigns.write_scenario(run, task, name, controller, folder)
                campaign = campaigns.fly(run, file, folder, options.runs, options.seed, options.duration,
                                         options.threads)
            except campaigns.Refused as refusal:
                cells[name] = {"refused": str(refusal)}
            else:
                cells[name] = scores(campaign)
                machine = campaign["machines"][0]
                result |= {"version": campaign["version"], "compiler": campaign["compiler"],
                           "machine": f"{machine['processor']}, {machine['cores']} cores"}
            print(f"{task} {name}: {cells[name].get('refused') or percent(cells[name]['recovered'])}", file=sys.stderr)
    (options.output / "table.json").write_text(rows_of(result))
    (options.output / "table.md").write_text(markdown(result))
    print(options.output / "table.md")


if __name__ == "__main__":
    main()
