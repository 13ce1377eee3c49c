"""What the tests of the Python module share: the tree, the command line, short scenarios."""

import os
import subprocess
from pathlib import Path

import pytest

tree = Path(__file__).resolve().parents[2]
binary = os.environ.get("SIGHTLINE_BINARY", str(tree / "build/release/bin/sightline"))


@pytest.fixture
def scenarios():
    return tree / "scenarios"


@pytest.fixture
def sightline():
    """Runs the command line."""

    def run(*arguments, code=0):
        done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == code, done.stderr
        return done.stdout

    return run
