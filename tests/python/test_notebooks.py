"""The notebooks run from the first cell to the last."""

import shutil
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

tree = Path(__file__).resolve().parents[2]
notebooks = sorted((tree / "docs/notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("file", notebooks, ids=lambda file: file.stem)
def test_it_runs_and_shows_something(file, tmp_path):
    folder = tmp_path / "docs/notebooks"
    shutil.copytree(file.parent, folder, ignore=shutil.ignore_patterns("out"))
    (tmp_path / "scenarios").symlink_to(tree / "scenarios")
    notebook = nbformat.read(folder / file.name, as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.outputs for cell in notebook.cells if cell.cell_type == "code"), "kept without outputs"
    done = NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": folder}}).execute()
    pictures = [out for cell in done.cells if cell.cell_type == "code" for out in cell.outputs if "image/png" in out.get("data", {})]
    assert len(pictures) >= 2


def test_there_are_three():
    assert [file.stem for file in notebooks] == ["campaign", "own_sensor", "paper"]
