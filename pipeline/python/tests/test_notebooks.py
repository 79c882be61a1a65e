"""The notebooks run from the first cell to the last, and are tracked without outputs."""

from __future__ import annotations

import importlib.util
import os
import resource
from pathlib import Path

import pytest
from conftest import SOURCE

NOTEBOOKS = sorted((SOURCE / "notebooks").glob("*.ipynb"))
OF_TORCH = ("controller", "moduli")
RECORDINGS = [SOURCE.parents[1] / "data/raw/beam_ds10", SOURCE.parents[2] / "shared/real/beam_ds10"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    if path.stem in OF_TORCH and importlib.util.find_spec("torch") is None:
        pytest.skip("PyTorch is not installed")
    if path.stem == "identify" and not any((folder / "gravity_a.csv").exists() for folder in RECORDINGS):
        pytest.skip("the recordings of the bar are not here")
    monkeypatch.setenv("SOFTFISH_SOURCE", os.fspath(SOURCE))
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = nbformat.read(path, as_version=4)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": os.fspath(tmp_path)}}).execute()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # two minutes of a core
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 120.0


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_tracked_without_outputs(path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    cells = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    assert cells and all(not cell.outputs and cell.execution_count is None for cell in cells)
