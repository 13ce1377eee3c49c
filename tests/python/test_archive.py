"""The archive of all figures' sources, of a commit of its own so that the tree's changes do not matter."""

import hashlib
import json
import re
import shutil
import subprocess
import tarfile
from pathlib import Path

import pytest

tree = Path(__file__).resolve().parents[2]
parts = ("scripts", "scenarios", "docs/claims.md", "benchmark/table.md", "benchmark/table.json", "CMakeLists.txt", "CITATION.cff",
         "README.md")


def git(folder, *words):
    subprocess.run(["git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@b.c", *words], check=True, capture_output=True)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("copy")
    for part in parts:
        (folder / part).parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (tree / part).is_dir() else shutil.copy)(tree / part, folder / part)
    git(folder, "init")
    git(folder, "add", "--all")
    git(folder, "commit", "-m", "All parts")
    return folder


def archive(folder, output):
    return subprocess.run([folder / "scripts/archive.py", output], capture_output=True, text=True, check=False)


def test_the_archive_has_the_sources_of_each_claim(copy, tmp_path):
    done = archive(copy, tmp_path / "a.tar.gz")
    assert done.returncode == 0, done.stderr
    with tarfile.open(tmp_path / "a.tar.gz") as packed:
        files = {one.name.split("/", 1)[1]: packed.extractfile(one).read() for one in packed}
    about = json.loads(files.pop("FIGURES.json"))
    assert {name: hashlib.sha256(data).hexdigest() for name, data in files.items()} == about["sha256"]
    table = (tree / "README.md").read_text().split("| result | value | command |")[1].split("\n\n")[0].splitlines()[2:]
    assert [one["row"] for one in about["claims"]] == [line.split("|")[1].strip() for line in table]
    for claim in about["claims"]:
        assert claim["found"] and claim["kind"]
        for name in re.findall(r"(?<!\S)(?:scenarios|scripts)/\S+", claim.get("command", "")):
            assert name in files
    assert about["seeds"].keys() == {name for name in files if re.match(r"scenarios/.*\.toml", name)}
    assert {"docs/claims.md", "benchmark/table.md", "CITATION.cff"} <= files.keys()


def test_the_same_commit_gives_the_same_bytes(copy, tmp_path):
    second = tmp_path / "clone"
    subprocess.run(["git", "clone", "-q", copy, second], check=True)
    for folder, name in ((copy, "a.tar.gz"), (second, "b.tar.gz")):
        assert archive(folder, tmp_path / name).returncode == 0
    assert (tmp_path / "a.tar.gz").read_bytes() == (tmp_path / "b.tar.gz").read_bytes()


def test_changes_and_wrong_names_are_refused(copy, tmp_path):
    assert "expected the name of the archive" in archive(copy, tmp_path / "a.zip").stderr
    changed = tmp_path / "changed"
    subprocess.run(["git", "clone", "-q", copy, changed], check=True)
    (changed / "README.md").write_text("other")
    done = archive(changed, tmp_path / "c.tar.gz")
    assert done.returncode == 1 and "README.md is changed" in done.stderr
    assert not (tmp_path / "c.tar.gz").exists()
