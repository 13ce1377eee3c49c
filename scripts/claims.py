#!/usr/bin/env python3
"""Flies again what README claims, scripts/claims.toml, and writes docs/claims.md:  scripts/claims.py [--check] [WORD ...]

With words, only claims whose row has one of them; the others keep their lines. --check flies nothing: it ends with 1 where
README's table of results, the claims and the page do not have the same rows.
"""

import datetime
import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile
import tomllib

tree = pathlib.Path(__file__).resolve().parents[1]
page = tree / "docs/claims.md"
head = "| claim | README | found | kind | command |\n|---|---|---|---|---|\n"


def readme_rows():
    """First cells of README's table of results, with their values."""
    text = (tree / "README.md").read_text()
    table = text[text.index("| result | value | command |"):].split("\n\n")[0].splitlines()[2:]
    return {cells[1].strip(): cells[2].strip() for cells in (line.split("|") for line in table)}


def page_lines():
    """Lines of the page's table, by their rows."""
    if not page.exists():
        return {}
    return {line.split("|")[1].strip(): line for line in page.read_text().splitlines() if re.match(r"\| (?!claim \|)[^-]", line)}


def found_by(claim):
    """The figures that the claim's command prints, as text."""
    if "measured" in claim:
        return claim["measured"]
    if "needs" in claim and not (tree / claim["needs"]).exists():
        return "data not there"
    path = f"{tree}/build/release/bin:{os.environ['PATH']}"
    with tempfile.TemporaryDirectory() as out:
        run = subprocess.run(["bash", "-eo", "pipefail", "-c", claim["command"]], cwd=tree, text=True, check=False,
                             env=os.environ | {"PATH": path, "out": out}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if run.returncode != 0:
        raise SystemExit(f"claims.py: {claim['row']}: exit {run.returncode}, expected 0:\n{run.stdout[-2000:]}")
    figures = []
    for name, pattern in claim["figures"].items():
        found = re.findall(pattern, run.stdout)
        if not found:
            raise SystemExit(f"claims.py: {claim['row']}: no {name}, expected {pattern} in:\n{run.stdout[-2000:]}")
        figures.append(f"{name}: {'; '.join(' '.join(one.split()) for one in found)}")
    return ", ".join(figures)


def main():
    words = [word for word in sys.argv[1:] if word != "--check"]
    claims = tomllib.loads((tree / "scripts/claims.toml").read_text())["claim"]
    values, lines = readme_rows(), page_lines()
    rows = [claim["row"] for claim in claims]
    if list(values) != rows:
        raise SystemExit(f"claims.py: README claims {list(values)}, expected the rows of scripts/claims.toml, {rows}")
    if "--check" in sys.argv[1:]:
        if list(lines) != rows:
            raise SystemExit(f"claims.py: docs/claims.md has {list(lines)}, expected the same rows: scripts/claims.py writes it")
        return
    version = re.search(r"project\(sightline VERSION (\S+)", (tree / "CMakeLists.txt").read_text()).group(1)
    commit = subprocess.run(["git", "-C", tree, "rev-parse", "--short=8", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()
    processor = next((line.split(": ")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), platform.machine())
    for claim in claims:
        if words and not any(word in claim["row"] for word in words):
            continue
        print(claim["row"], file=sys.stderr)
        command = f"`{claim['command'].replace('|', chr(92) + '|')}`" if "command" in claim else ""
        here = f", {version} {commit}, {datetime.date.today()}, {processor}, {os.cpu_count()} cores" if command else ""
        lines[claim["row"]] = f"| {claim['row']} | {values[claim['row']]} | {found_by(claim)} | {claim['kind']}{here} | {command} |"
    page.write_text("# Claims\n\nWhat README claims, flown again by `scripts/claims.py`, with version and commit, day and machine; `scripts/archive.py`\n"
                    "packs it with its sources. Seeds are of the scenarios and tests. *Simulated*: planning model or simulated vehicles,\n"
                    "*firmware* flies simulated bodies, *recorded* is data of real robots, *timed* depends on the machine.\n\n"
                    + head + "\n".join(lines[row] for row in rows if row in lines) + "\n")


if __name__ == "__main__":
    main()
