#!/usr/bin/env python3
"""Rules of the sources that no compiler checks:  scripts/lint.py [--self-test]

Prints `file:line: rule: sentence` for each fault; exit 1 if there is one.
"""

import re
import sys
from collections import defaultdict
from pathlib import Path

tree = Path(__file__).resolve().parents[1]
product = ("include", "src", "worlds", "bridges", "cli", "python", "examples", "bench")
everything = product + ("tests",)

# Rooms of src/sightline from the lowest; a file includes its own room or a lower one.
floors = ("base", "formula", "model", "potential", "ocp", "solver safety estimate", "world", "run", "readers", "scenario",
          "judge", "record", "report", "campaign analysis import", "server")
height = {room: i for i, floor in enumerate(floors) for room in floor.split()}
# The public headers, include/sightline/NAME.hpp, and their rooms; those of programs are in none.
public = {name: rooms.split() for rooms, names in (
    ("base", "base config"), ("formula", "formula"), ("model", "model robots"), ("potential", "potential potentials"),
    ("ocp", "team events"), ("solver", "solver solvers kernels"), ("safety", "barrier supervisor"), ("estimate", "estimator"),
    ("world", "vehicle sensors world worlds"), ("run", "loop"), ("readers", "mcap"), ("scenario", "scenario registry"), ("judge", "judge"),
    ("record", "log"), ("report", "report"), ("campaign analysis", "analysis"), ("", "sightline command_line mujoco"))
    for name in names.split()}


def rooms_of(header):
    """Rooms of a header of the library, sightline/NAME.hpp or sightline/ROOM/FILE.hpp."""
    parts = header.removesuffix(".hpp").split("/")
    return public.get(parts[1]) if len(parts) == 2 else [parts[1]]

# Functions of <cmath> that round, and gave the same bits on x86-64 and AArch64 in all arguments
# that scripts/arm64.sh tries.
same_bits = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "pow", "log1p"}
rounds = re.compile(r"(?:std)?::(a?(?:sin|cos|tan)h?|atan2|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|erfc?|"
                    r"[lt]gamma|lerp|beta|legendre|riemann_zeta|(?:cyl|sph)_\w+)\s*\(")
makes_thread = re.compile(r"std::j?thread\b(?!::)|std::async\b|\bpthread_create\b|\bthrd_create\b|\bclone3?\s*\(")
takes_callback = re.compile(r"(?:dds_lset_\w+|dds_set_(?:log|trace)_sink|sqlite3_\w*(?:hook|handler|function|exec)\w*|\batexit|"
                            r"\bqsort|\W::signal)\s*\(([^;]*)|(?:mju_user_\w+|mjcb_\w+|sa_handler|sa_sigaction)\s*=\s*([^;=]*)")
throws_nothing = re.compile(r"c_callback<|SIG_IGN|SIG_DFL|nullptr\s*\)|NULL\s*\)")
dds_header = re.compile(r"(dds|ddsc|ddscxx|fastdds|fastrtps|fastcdr|rclcpp|rcl|rmw)/")


class Source:
    """A C++ file of the tree: its includes, and its code without comments (and without strings, on request)."""

    def __init__(self, name, text):
        self.name, self.text = name, text
        self.includes = [(text[:m.start()].count("\n") + 1, m[1])
                         for m in re.finditer(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]", text, re.M)]
        blank = lambda m: re.sub(r"[^\n]", " ", m[0])
        self.code = re.sub(r"//[^\n]*|/\*[\s\S]*?\*/", blank, text)
        self.bare = re.sub(r"\"(?:\\.|[^\"\\\n])*\"|//[^\n]*|/\*[\s\S]*?\*/", blank, text)

    def under(self, *folders):
        return any(self.name.startswith(folder + "/") for folder in folders)

    def rooms(self):
        parts = self.name.split("/", 1)
        return rooms_of(parts[1]) or [] if parts[0] in ("src", "include") and parts[1].startswith("sightline/") else []

    def at(self, match):
        return self.text[:match.start()].count("\n") + 1


def layer(source):
    """A file of the library includes its own room or a lower one, by its path from the root of the includes; a public header
    includes public headers alone."""
    if not source.under("src/sightline", "include/sightline"):
        return
    for line, name in source.includes:
        beside = (tree / source.name).parent / name
        if any(name.startswith(folder + "/") for folder in everything) or name.startswith("../") or beside.exists():
            yield line, f"includes {name}, expected sightline/FILE.hpp or sightline/ROOM/FILE.hpp"
        if not name.startswith("sightline/"):
            continue
        others, own = rooms_of(name), source.rooms()
        if others is None or any(other not in height for other in others):
            yield line, f"includes {name}, which is in no room"
        elif source.under("include") and name.count("/") > 1:
            yield line, f"includes {name}, expected a public header"
        elif own and not set(own) & set(others) and min(map(height.get, own)) <= max(map(height.get, others), default=-1):
            yield line, f"includes {name}, expected a room below {own[0]}"


def component(source):
    """Components know the library, and only programs and their own tests know a component."""
    owners = (("DDS", dds_header, ("bridges", "tests/dds")),
              ("the bridge", re.compile(r"bridges/(?!dds/fleet/)"), ("bridges", "tests/dds", "cli/main.cpp")),
              ("fleets", re.compile(r"bridges/dds/fleet/"), ("bridges", "tests", "cli")),
              ("pybind11", re.compile(r"pybind11/|python/"), ("python",)),
              ("MuJoCo", re.compile(r"mujoco/"), ("worlds/mujoco",)),
              ("the world of MuJoCo", re.compile(r"sightline/mujoco\.hpp|worlds/"), ("worlds", "tests/mujoco", "bench", "cli/main.cpp")))
    for line, name in source.includes:
        for what, header, users in owners:
            if header.match(name) and not source.under(*users) and source.name not in users:
                yield line, f"includes {name}, expected {what} in {', '.join(users)} alone"
        if source.under("python") and re.match(r"cli/|bridges/", name):
            yield line, f"includes {name}, expected nothing of programs in the module"


def bits(source):
    """The library calls no function whose bits are the machine's own."""
    if source.under("src", "cli", "worlds"):
        for call in rounds.finditer(source.bare):
            if call[1] not in same_bits:
                yield source.at(call), f"calls {call[1]} of the C library, expected one of ours (elementary functions and norm of sightline/base.hpp)"


def thread(source):
    """Threads are made by ServiceThread of sightline/base.hpp, which catches what ends a thread."""
    if source.under(*product) and source.name != "include/sightline/base.hpp":
        for made in makes_thread.finditer(source.code):
            yield source.at(made), f"makes a thread by {made[0]}, expected ServiceThread"


def callback(source):
    """Libraries of C receive functions that throw nothing, by base/c_callback.hpp."""
    if source.under(*product):
        for given in takes_callback.finditer(source.code):
            if not throws_nothing.search(given[1] or given[2] or ""):
                yield source.at(given), "gives a function to a library of C, expected c_callback<...>"


def json(source):
    """JSON is written by base/json_text.hpp: dump() of nlohmann throws for a text that is not UTF-8."""
    if source.under(*product) and source.name != "src/sightline/base/json_text.hpp":
        for dump in re.finditer(r"\.dump\(", source.code):
            yield source.at(dump), "writes JSON by dump(), expected json_text()"


def classes_of(source):
    """Classes at the outermost level, with their namespaces; those of unnamed namespaces left out."""
    spaces = []
    for number, line in enumerate(source.text.split("\n"), 1):
        if opened := re.fullmatch(r"(?:inline )?namespace ?([\w:]*) ?\{", line):
            spaces.append(opened[1])
        elif line.startswith("}  // ") and "namespace" in line and spaces:
            spaces.pop()
        elif (defined := re.match(r"(?:struct|class) (\w+)(?!\w|<|;|::)", line)) and "" not in spaces:
            yield "::".join([*spaces, defined[1]]), number


def one_class(sources):
    """A name stands for one class: the linker takes one of two for both, and does not report it."""
    places = defaultdict(dict)
    for source in sources:
        if source.under("src", "worlds", "bridges", "cli", "python"):
            for name, line in classes_of(source):
                places[name][source.name] = line
    for name, files in places.items():
        for file, line in list(files.items())[1:]:
            yield file, line, f"defines {name}, which {next(iter(files))} defines too"


rules = {"layer": layer, "component": component, "bits": bits, "thread": thread, "callback": callback, "json": json}


def faults(sources):
    for source in sources:
        for name, rule in rules.items():
            for line, sentence in rule(source):
                yield f"{source.name}:{line}: {name}: {sentence}"
    for file, line, sentence in one_class(sources):
        yield f"{file}:{line}: one-class: {sentence}"


def self_test():
    """Each rule finds what it forbids and nothing else."""
    bad = {
        "layer": [("src/sightline/base/a.hpp", '#include "sightline/record/log.hpp"'),
                  ("src/sightline/base/a.hpp", '#include "sightline/log.hpp"'),
                  ("include/sightline/team.hpp", '#include "sightline/ocp/weights.hpp"'),
                  ("src/sightline/safety/a.hpp", '#include "sightline/solver.hpp"'),
                  ("src/sightline/world/a.hpp", '#include "sightline/attic/old.hpp"'),
                  ("src/sightline/safety/a.hpp", '#include "projection.hpp"'),
                  ("src/sightline/solver/a.hpp", '#include "newton/workspace.hpp"'),
                  ("src/sightline/world/a.hpp", '#include "tests/support/tree.hpp"')],
        "component": [("src/sightline/run/a.cpp", "#include <dds/dds.h>"), ("cli/run.cpp", "#include <sightline/mujoco.hpp>"),
                      ("tests/run/a.cpp", '#include "python/module.hpp"'), ("cli/a.cpp", "#include <mujoco/mujoco.h>")],
        "bits": [("src/sightline/run/a.cpp", "a = std::hypot(x, y);"), ("src/sightline/run/a.cpp", "b = ::tanh (x);"),
                 ("src/sightline/run/a.cpp", 'say("a://b", std::hypot(x, y));')],
        "thread": [("cli/a.cpp", "std::thread other([] {});"), ("cli/a.cpp", "std::vector<std::jthread> all;"),
                   ("cli/a.cpp", "auto f = std::async(work);"), ("cli/a.cpp", "pthread_create(&t, nullptr, run, nullptr);")],
        "callback": [("cli/a.cpp", "dds_lset_data_available(listener.get(), on_data);"), ("cli/a.cpp", "mju_user_error = on_error;"),
                     ("cli/a.cpp", "action.sa_handler = on_interrupt;")],
        "json": [("cli/a.cpp", "text = json.dump();")],
        "one-class": [("cli/a.hpp", "namespace sightline {\nstruct A {\n};\n}  // namespace sightline")],
    }
    good = [("src/sightline/solver/a.hpp", '#include "sightline/team.hpp"\n#include <vector>\n#include "sightline/solver/b.hpp"'),
            ("bridges/dds/a.cpp", "#include <dds/dds.h>"), ("cli/main.cpp", "#include <sightline/mujoco.hpp>"),
            ("src/sightline/run/a.cpp", "x = std::sin(x) + sightline::norm(x, y) + std::sqrt(x);  // std::hypot(x)"),
            ("cli/a.cpp", 'std::thread::hardware_concurrency(); std::this_thread::yield(); say("a");  // std::thread'),
            ("cli/a.cpp", "mju_user_error = c_callback<on_error>; ::signal(SIGPIPE, SIG_IGN);"),
            ("cli/a.cpp", "dds_lset_data_available(listener.get(), c_callback<on_data>);")]
    missed = 0
    for rule, cases in bad.items():
        for name, text in cases:
            sources = [Source(name, text)] + ([Source("cli/b.hpp", text)] if rule == "one-class" else [])
            if not any(f": {rule}: " in fault for fault in faults(sources)):
                missed += 1
                print(f"lint.py: rule {rule} does not find: {text}")
    for name, text in good:
        for fault in faults([Source(name, text)]):
            missed += 1
            print(f"lint.py: nothing is wrong with: {fault}")
    return missed


def main():
    if sys.argv[1:] == ["--self-test"]:
        return 1 if self_test() else 0
    if sys.argv[1:]:
        print(f"lint.py: argument = {sys.argv[1]}, expected --self-test or none", file=sys.stderr)
        return 2
    files = sorted(path for folder in everything for path in (tree / folder).rglob("*")
                   if path.suffix in (".hpp", ".cpp") and "node_modules" not in path.parts)
    sources = [Source(str(path.relative_to(tree)), path.read_text()) for path in files]
    if len(sources) < 500:
        print(f"lint.py: {len(sources)} files below {tree}, expected at least 500", file=sys.stderr)
        return 1
    found = list(faults(sources))
    print("\n".join(found) if found else f"lint.py: {len(sources)} files, {len(rules) + 1} rules, nothing found")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
