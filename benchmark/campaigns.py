"""Scenarios of the benchmark, a task with a controller each, and their campaigns."""

import json
import os
import pathlib
import subprocess
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
CONTROLLERS = HERE / "controllers.json"
# Potentials of one purpose, sightline's and the paper's.
VIEWS, NEAR, FAR = ("bearing", "sensor_cone"), ("too_near", "keep_out"), ("too_far", "cohesion")
OWN, PAPER = 0, 1


class Refused(Exception):
    """A scenario that the program does not fly."""


def tasks():
    return sorted(file.stem for file in (HERE / "tasks").glob("*.toml"))


def controllers():
    """Settings by name; `as` takes those of another controller for all that it does not state."""
    listed = json.loads(CONTROLLERS.read_text())
    return {name: listed.get(of.get("as"), {}) | of for name, of in listed.items()}


def program(path, process):
    return [str(path)] + (["--process", process] if process else [])


def toml(value):
    """A value as TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(of)}" for key, of in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def with_files(value, folder, source):
    """The value with its `file` names relative to another folder."""
    if not isinstance(value, dict):
        return value
    return {
        key: os.path.relpath(source / of, folder) if key == "file" else with_files(of, folder, source)
        for key, of in value.items()
    }


def couplings(given, weights, folder):
    """The couplings of a task for a controller: its own kinds, with its weights, of the same limits."""
    listed = []
    for couple in given:
        (kind, keys), = couple["potential"].items()
        form = PAPER if "sensor_cone" in weights else OWN
        purpose = next((of for of in (VIEWS, NEAR, FAR) if kind in of), None)
        if kind == "relative_velocity" and form == PAPER:
            continue
        if purpose is None:
            potential = {kind: with_files(keys, folder, HERE / "tasks")}
            weight = weights.get(kind, couple.get("weight", 1.0))
        else:
            wanted, limit = purpose[form], {VIEWS: "alpha", NEAR: "d_min", FAR: "d_max"}[purpose]
            potential = {wanted: keys if kind == wanted else {limit: keys[limit]}}
            weight = weights[wanted]
        listed.append(couple | {"potential": potential, "weight": weight})
    pairs = {tuple(couple["between"]) for couple in given if next(iter(couple["potential"])) in VIEWS}
    moving = {tuple(couple["between"]) for couple in listed if "relative_velocity" in couple["potential"]}
    if "relative_velocity" in weights:
        for pair in sorted(pairs - moving):
            listed.append({"potential": {"relative_velocity": {"v_0": 1.0}}, "between": list(pair),
                           "felt_by": [pair[0]], "weight": weights["relative_velocity"]})
    # The judge takes the first view of a pair: those that judge alone have the weight 0.
    listed.sort(key=lambda couple: couple["weight"] > 0)
    return listed, sorted(pair[0] for pair in pairs)


def write_scenario(run, task, name, controller, folder):
    """Writes TASK.toml of a controller into the folder."""
    source = HERE / "tasks" / f"{task}.toml"
    printed = subprocess.run(run + ["check", "--print", str(source)], capture_output=True, text=True)
    if printed.returncode != 0:
        raise Refused(printed.stderr.strip())
    given = tomllib.loads(printed.stdout)["couple"]
    own = controllers()["sightline"]
    listed, observers = couplings(given, controller.get("couplings", own["couplings"]), folder)
    lines = [f"based_on = {json.dumps(os.path.relpath(source, folder))}", "couple = [",
             *(f"  {toml(couple)}," for couple in listed), "]", f"solver = {toml(controller['solver'])}", ""]
    for observer in observers:
        lines += [f"[agent.{observer}]", f"R = {toml([controller.get('R', own['R'])] * 4)}",
                  f"Q = {toml(controller.get('Q', [0.0] * 7))}", ""]
    certified = controller.get("certify_view", {})
    if certified:
        if task not in certified:
            raise Refused("no bound of the target's motion is stated")
        pairs = [couple["between"] for couple in listed if next(iter(couple["potential"])) in VIEWS]
        for observer, target in pairs:
            lines += ["[[certify_view]]", f'observer = "{observer}"', f'target = "{target}"',
                      *(f"{key} = {toml(value)}" for key, value in certified[task].items()), ""]
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{task}.toml"
    file.write_text("\n".join([f"# The task {task} with the controller {name}.", *lines]))
    return file


def fly(run, file, folder, runs, seed=1, duration=None, threads=1):
    """Flies a campaign; its campaign.json."""
    command = run + ["campaign", str(file), "--runs", str(runs), "--seed", str(seed), "--threads", str(threads),
                     "-o", str(folder)]
    if duration is not None:
        command += ["--set", f"campaign.duration={duration}", "--set", f"campaign.view_within={duration}"]
    flown = subprocess.run(command, capture_output=True, text=True)
    if flown.returncode not in (0, 1) or not (folder / "campaign.json").exists():
        raise Refused(flown.stderr.strip())
    return json.loads((folder / "campaign.json").read_text())
