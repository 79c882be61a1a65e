"""Bodies of the tests: small ones, so that a solve takes milliseconds."""

from __future__ import annotations

import os
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import softfish as sf

#: The folder `pipeline/python` of this project; the tests of an installed wheel run away from it.
SOURCE = Path(os.environ.get("SOFTFISH_SOURCE", Path(__file__).parents[1]))
EXAMPLES = SOURCE.parent / "simulate" / "examples"


@pytest.fixture(scope="session")
def finger() -> sf.Solver:
    """Half of a finger of two regions with a chamber and a marker at its tip."""
    return sf.Case(EXAMPLES / "finger.toml").solver()


def hollow() -> sf.Mesh:
    """A block of tetrahedra around an empty cell in its middle."""
    box = sf.Mesh.box((0.05, 0.03, 0.03), (5, 3, 3), "linear")
    middle = box.nodes[box.elements].mean(axis=1)
    inside = np.all(np.abs(middle - [0.025, 0.015, 0.015]) < [0.015, 0.005, 0.005], axis=1)
    return sf.Mesh(box.nodes, box.elements[~inside])


@pytest.fixture
def block() -> sf.Solver:
    """A hollow block of one region, clamped at x = 0, that sags and can be inflated."""
    case = {
        "gravity": [0.0, 0.0, -9.81],
        "region": [{"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}],
        "clamp": [{"plane": {"x": 0.0}}],
        "chamber": [{"name": "air", "number": 0, "pressure": 5e3}],
        "dynamic": {"duration": 0.02, "step": 0.002, "stiffness_damping": 1e-3},
        "output": {"marker": [{"name": "tip", "at": [0.05, 0.015, 0.03]}]},
    }
    return sf.Case(case, mesh=hollow()).solver()


@pytest.fixture
def brick() -> sf.Solver:
    """Hexahedra of two regions, clamped at x = 0."""
    box = sf.Mesh.box((0.04, 0.01, 0.01), (8, 2, 2), "hexahedra")
    upper = box.nodes[box.elements].mean(axis=1)[:, 2] > 0.005
    mesh = sf.Mesh(box.nodes, box.elements, upper.astype(int))
    materials = {"region_0": sf.Material(2e5, 0.4), "region_1": sf.Material(1e6, 0.3)}
    return sf.Solver.of_mesh(mesh, materials, mesh.nodes[:, 0] == 0.0)


def program() -> str | None:
    """The command line of this checkout, where it was built."""
    built = SOURCE.parents[1] / "target" / "release" / "study"
    return os.environ.get("STUDY") or (str(built) if built.exists() else shutil.which("study"))


@contextmanager
def interrupted(after: float) -> Iterator[None]:
    """Presses Ctrl-C so many seconds later; the exception ends what runs within five seconds."""
    timer = threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT))
    began = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        yield
    timer.join()
    assert time.monotonic() - began < after + 5.0
