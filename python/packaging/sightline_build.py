"""Builds the wheel of the Python module by CMake (PEP 517), with no package but what is installed.

    pip install --no-index .

Processor: that of this machine, or SIGHTLINE_ARCH of the environment as CMake's. `--config-settings build-dir=FOLDER` takes the
module of a build that is there already.
"""

import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

_tree = Path(__file__).resolve().parents[2]
_apt = "on Debian: apt-get install cmake g++ pybind11-dev python3-dev, and what scripts/deps.sh demo installs"


def _version():
    found = re.search(r"project\(sightline VERSION (\S+)", (_tree / "CMakeLists.txt").read_text())
    return found.group(1)


def _metadata():
    return (
        "Metadata-Version: 2.1\nName: sightline\n"
        f"Version: {_version()}\n"
        "Summary: Real-time nonlinear model predictive control of coupled robots\n"
        "License: Apache-2.0\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
    )


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub('[-.]', '_', sysconfig.get_platform())}"


def _run(*command):
    try:
        subprocess.run([str(word) for word in command], check=True)
    except FileNotFoundError as error:
        raise SystemExit(f"sightline: {command[0]} is missing; {_apt}") from error
    except subprocess.CalledProcessError as error:
        raise SystemExit(f"sightline: {' '.join(map(str, command))} failed; {_apt}") from error


def _package(settings):
    """The folder of the built package."""
    given = (settings or {}).get("build-dir")
    if given:
        return Path(given).resolve() / "python" / "sightline"
    build = _tree / "build" / f"wheel-{_tag()}"
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    off = [f"-DSIGHTLINE_{part}=OFF" for part in ("BENCH", "CLI", "EXAMPLES", "INSTALL", "TESTS", "WERROR")]
    arch = os.environ.get("SIGHTLINE_ARCH", "native")
    _run("cmake", "-S", _tree, "-B", build, *generator, "-DCMAKE_BUILD_TYPE=Release", f"-DSIGHTLINE_ARCH={arch}",
         f"-DPython_EXECUTABLE={sys.executable}", "-DSIGHTLINE_PYTHON=ON", *off)
    _run("cmake", "--build", build, "--parallel", os.cpu_count() or 1, "--target", "sightline_python")
    return build / "python" / "sightline"


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    name = f"sightline-{_version()}.dist-info"
    folder = Path(metadata_directory) / name
    folder.mkdir()
    (folder / "METADATA").write_text(_metadata())
    (folder / "WHEEL").write_text(_wheel())
    return name


def _wheel():
    return f"Wheel-Version: 1.0\nGenerator: sightline\nRoot-Is-Purelib: false\nTag: {_tag()}\n"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    package = _package(config_settings)
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    if not (package / f"_sightline{suffix}").is_file():
        raise SystemExit(f"sightline: {package} has no _sightline{suffix}, expected a module for this python; {_apt}")
    files = {f"sightline/{file.name}": file.read_bytes() for file in sorted(package.iterdir())
             if file.suffix in (".py", ".pyi") or file.name == "py.typed" or file.name.endswith(suffix)}
    info = f"sightline-{_version()}.dist-info"
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = _wheel().encode()
    files[f"{info}/LICENSE"] = (_tree / "LICENSE").read_bytes()

    def line(name, content):
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        return f"{name},sha256={digest},{len(content)}\n"

    record = f"{info}/RECORD"
    files[record] = ("".join(line(n, c) for n, c in files.items()) + f"{record},,\n").encode()
    wheel = f"sightline-{_version()}-{_tag()}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            # Of one build, one wheel, byte for byte.
            entry = zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0))
            entry.external_attr = (0o755 if name.endswith(suffix) else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return wheel


def build_sdist(sdist_directory, config_settings=None):
    """All that git knows of the tree."""
    name = f"sightline-{_version()}"
    listed = subprocess.run(["git", "-C", str(_tree), "ls-files", "-z"], check=True, capture_output=True).stdout
    with tarfile.open(Path(sdist_directory) / f"{name}.tar.gz", "w:gz") as archive:
        for file in sorted(filter(None, listed.decode().split("\0"))):
            archive.add(_tree / file, f"{name}/{file}", recursive=False)
        information = Path(sdist_directory) / "PKG-INFO"
        information.write_text(_metadata())
        archive.add(information, f"{name}/PKG-INFO")
        information.unlink()
    return f"{name}.tar.gz"
