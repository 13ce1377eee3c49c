#!/usr/bin/env python3
"""Archives what makes the figures of README and documents:  scripts/archive.py OUTPUT.tar.gz

The archive has the tree of the last commit, with scenarios, tests, docs/claims.md and the benchmark's table, and FIGURES.json: version
and commit, of each claim its command, figures and result, the seed of each scenario, and the SHA-256 of each file.
The same commit gives the same bytes. A tree with other changes is refused.
"""

import gzip
import hashlib
import io
import json
import pathlib
import re
import subprocess
import sys
import tarfile
import tomllib

tree = pathlib.Path(__file__).resolve().parents[1]


def git(*words):
    return subprocess.run(["git", "-C", tree, *words], check=True, capture_output=True).stdout


def committed():
    """Files of the last commit by their paths: bytes and whether they are programs. Links are left out."""
    files = {}
    with tarfile.open(fileobj=io.BytesIO(git("archive", "--format=tar", "HEAD"))) as archive:
        for one in archive:
            if one.isfile():
                files[one.name] = archive.extractfile(one).read(), one.mode & 0o100 != 0
    return files


def figures(files):
    """The contents of FIGURES.json."""
    text = {name: files[name][0].decode() for name in ("CMakeLists.txt", "docs/claims.md", "scripts/claims.toml")}
    found = {}
    for line in text["docs/claims.md"].splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)]
        if len(cells) > 4:
            found[cells[1]] = {"found": cells[3], "kind": cells[4]}
    claims = tomllib.loads(text["scripts/claims.toml"])["claim"]
    missing = [claim["row"] for claim in claims if claim["row"] not in found]
    if missing:
        raise SystemExit(f"archive.py: docs/claims.md lacks {missing}, expected each row of scripts/claims.toml: scripts/claims.py writes it")
    seeds = {name: tomllib.loads(data.decode()).get("simulation", {}).get("seed", "default")
             for name, (data, _) in files.items() if name.startswith("scenarios/") and name.endswith(".toml")}
    return {"version": re.search(r"project\(sightline VERSION (\S+)", text["CMakeLists.txt"]).group(1),
            "commit": git("rev-parse", "HEAD").decode().strip(),
            "claims": [{**claim, **found[claim["row"]]} for claim in claims],
            "seeds": dict(sorted(seeds.items())),
            "sha256": {name: hashlib.sha256(data).hexdigest() for name, (data, _) in sorted(files.items())}}


def write(output, files, folder, time):
    with open(output, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, (data, runs) in sorted(files.items()):
            one = tarfile.TarInfo(f"{folder}/{name}")
            one.size, one.mtime, one.mode = len(data), time, 0o755 if runs else 0o644
            archive.addfile(one, io.BytesIO(data))


def main():
    if len(sys.argv) != 2 or not sys.argv[1].endswith(".tar.gz"):
        raise SystemExit("archive.py: OUTPUT.tar.gz is missing, expected the name of the archive")
    if changed := git("status", "--porcelain", "--untracked-files=no").decode().split("\n")[0]:
        raise SystemExit(f"archive.py: {changed[3:]} is changed, expected a tree without changes: commit them first")
    files = committed()
    about = figures(files)
    files["FIGURES.json"] = (json.dumps(about, indent=1) + "\n").encode(), False
    write(sys.argv[1], files, f"sightline-{about['version']}-figures", int(git("log", "-1", "--format=%ct")))
    print(f"{sys.argv[1]}: {len(files)} files, {len(about['claims'])} claims, commit {about['commit'][:8]}")


if __name__ == "__main__":
    try:
        main()
    except (OSError, KeyError, subprocess.CalledProcessError) as error:
        raise SystemExit(f"archive.py: {error}, expected a clone of the repository with docs/claims.md, and a folder to write to")
