"""What type checkers know of the module is what the module has."""

import ast
import importlib.util
from pathlib import Path

import sightline
from sightline import _sightline

tree = Path(__file__).resolve().parents[2]


def stubs():
    spec = importlib.util.spec_from_file_location("stubs", tree / "python/packaging/stubs.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_stubs_are_those_of_the_module():
    assert stubs().file.read_text() == stubs().written(), "python/packaging/stubs.py writes them anew"


def test_each_public_name_is_in_them_and_has_a_type():
    parsed = ast.parse(stubs().file.read_text())
    named = {node.name for node in parsed.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    named |= {node.target.id for node in parsed.body if isinstance(node, ast.AnnAssign)}
    assert {name for name in vars(_sightline) if not name.startswith("__")} <= named
    solver = next(node for node in parsed.body if getattr(node, "name", "") == "Solver")
    step = next(node for node in solver.body if getattr(node, "name", "") == "step")
    assert [a.arg for a in step.args.args] == ["self", "time", "states"] and ast.unparse(step.returns) == "npt.NDArray[np.float64]"
    keep_out = next(node for node in parsed.body if getattr(node, "name", "") == "keep_out")
    assert [a.arg for a in keep_out.args.kwonlyargs] == ["d_min", "kappa_H", "kappa_G", "kappa_A"]


def test_the_package_says_that_it_is_typed():
    assert (Path(sightline.__file__).parent / "py.typed").is_file()
