"""`pip install --no-index .` in a fresh venv, with the module of this build, so that nothing is compiled again."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

tree = Path(__file__).resolve().parents[2]
build = os.environ["SIGHTLINE_BUILD"]


def shell(*command, **given):
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, env=environment, **given)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_pip_installs_it_without_an_index(tmp_path):
    shell(sys.executable, "-m", "venv", "--system-site-packages", tmp_path / "venv")
    python = tmp_path / "venv" / "bin" / "python"
    shell(python, "-m", "pip", "install", "--no-index", "--config-settings", f"build-dir={build}", tree, cwd=tmp_path)
    told = shell(python, "-c", "import sightline as sl; print(sl.__file__); print(sl.keep_out(d_min=2.0))", cwd=tmp_path)
    assert str(tmp_path / "venv") in told and "<potential keep_out>" in told
    assert "sightline" in shell(python, "-m", "pip", "list", "--format", "freeze", cwd=tmp_path)


def test_a_wheel_has_the_same_bytes_each_time(tmp_path):
    sys.path.insert(0, str(tree / "python/packaging"))
    import sightline_build

    wheels = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        wheels.append(folder / sightline_build.build_wheel(folder, {"build-dir": build}))
    assert wheels[0].read_bytes() == wheels[1].read_bytes()
    names = zipfile.ZipFile(wheels[0]).namelist()
    assert "sightline/__init__.py" in names and any(name.endswith(".dist-info/RECORD") for name in names)
    with pytest.raises(SystemExit, match="expected a module for this python"):
        sightline_build.build_wheel(tmp_path, {"build-dir": tmp_path / "a"})
