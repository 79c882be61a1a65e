"""Results in pyvista, xarray and notebooks, and the progress of a motion."""

from __future__ import annotations

import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest

import softfish as sf


@pytest.mark.parametrize("kind, name", [("linear", 10), ("quadratic", 24), ("hexahedra", 12), ("quadratic_hexahedra", 25)])
def test_pyvista_has_the_volume_and_the_displacement_of_a_mesh(kind: str, name: int) -> None:
    pytest.importorskip("pyvista")
    mesh = sf.Mesh.box((0.1, 0.02, 0.03), (3, 1, 2), kind)
    grid = mesh.to_pyvista(2.0 * mesh.nodes)
    assert set(grid.celltypes) == {name} and grid.volume == pytest.approx(6e-5)
    assert grid.warp_by_vector("displacement").volume == pytest.approx(27 * 6e-5)
    assert np.array_equal(grid.cell_data["region"], mesh.regions)
    with pytest.raises(sf.InputError, match="displacement"):
        mesh.to_pyvista(np.zeros((2, 3)))


def test_results_are_grids_of_pyvista(block: sf.Solver) -> None:
    pytest.importorskip("pyvista")
    rest, motion = block.equilibrium(), block.simulate(3)
    assert np.array_equal(rest.to_pyvista().point_data["displacement"], rest.displacement)
    blocks = motion.to_pyvista()
    assert len(blocks) == 3 and np.array_equal(blocks[2].point_data["displacement"], motion.displacement[2])


def test_results_are_datasets_of_xarray(block: sf.Solver) -> None:
    pytest.importorskip("xarray")
    rest, motion = block.equilibrium().to_xarray(), block.simulate(3)
    assert dict(rest.sizes) == {"node": 96, "axis": 3, "chamber": 1} and float(rest["pressure"].sel(chamber="air")) == 5e3
    moved = motion.to_xarray()
    assert moved["velocity"].dims == ("time", "node", "axis") and moved["velocity"].units == "m/s"
    last = moved["marker.tip"].sel(time=motion.times[-1], axis="z")
    assert float(last) == motion.output("marker.tip")[-1, 2]
    rubber = {"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}
    pushed = {"region": [rubber], "clamp": [{"plane": {"x": 0.0}}], "static": {"levels": [1.0], "arc_length": {}}}
    path = sf.Case({**pushed, "load": [{"plane": {"x": 0.05}, "traction": [0.0, 0.0, 50.0]}]}, mesh=block.mesh).solver().path()
    points = path.to_xarray()
    assert np.array_equal(points["level"], path.levels) and points["displacement"].shape == path.displacement.shape


class Tags(HTMLParser):
    """The tags of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)


def test_notebooks_show_a_picture(block: sf.Solver, brick: sf.Solver) -> None:
    pytest.importorskip("matplotlib")
    shown = [block.mesh, block, block.equilibrium(), block.simulate(2), brick.mesh, brick.equilibrium(gravity=[0.0, 0.0, -9.81])]
    for thing in shown:
        page = thing._repr_html_()
        assert "img" in Tags(page).tags and f"{type(thing).__name__}(" in page and len(page) < 300_000
    assert "colour: 0 to" in block.equilibrium()._repr_html_()


def test_without_matplotlib_notebooks_show_the_text() -> None:
    program = """
import sys
sys.modules["matplotlib"] = sys.modules["matplotlib.figure"] = None
import softfish as sf
mesh = sf.Mesh.box((1.0, 1.0, 1.0), (1, 1, 1))
print(mesh._repr_html_())
sys.modules["pyvista"] = None
try:
    mesh.to_pyvista()
except sf.MissingError as error:
    print(error.action)
"""
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert "<pre>Mesh(" in ran.stdout and "<img" not in ran.stdout and "pip install pyvista" in ran.stdout


def test_progress_is_a_bar_of_tqdm(block: sf.Solver, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    block.simulate(5, progress=True)
    assert "5/5" in capsys.readouterr().err


def test_progress_is_lines_without_tqdm(block: sf.Solver, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm", None)
    block.simulate(5, progress=True)
    assert capsys.readouterr().err.splitlines() == [f"step {n} of 5" for n in range(1, 6)]
