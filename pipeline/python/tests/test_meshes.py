"""Meshes of every cell type go through the same checks; nothing of a body is dropped in silence."""

from __future__ import annotations

import copy
import pickle
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import softfish as sf
from conftest import EXAMPLES

KINDS = ("linear", "quadratic", "hexahedra", "quadratic_hexahedra")
SILICONE = sf.Material(2e5, 0.4, 1000.0)


def box(kind: str) -> sf.Mesh:
    return sf.Mesh.box((0.06, 0.01, 0.01), (6, 2, 2), kind)


def unmerged(mesh: sf.Mesh) -> sf.Mesh:
    """Two halves that meet at x = 0.06, with nodes of their own."""
    return sf.Mesh(np.vstack([mesh.nodes, mesh.nodes + [0.06, 0, 0]]), np.vstack([mesh.elements, mesh.elements + len(mesh.nodes)]))


def repeated(mesh: sf.Mesh) -> sf.Mesh:
    elements = mesh.elements.copy()
    elements[3, 1] = elements[3, 2]
    return sf.Mesh(mesh.nodes, elements)


def inverted(mesh: sf.Mesh) -> sf.Mesh:
    nodes, elements = mesh.nodes.copy(), mesh.elements
    inner = int(np.flatnonzero(np.all(np.isclose(nodes, [0.03, 0.005, 0.005]), axis=1))[0])
    nodes[inner] += [0.02, 0.0, 0.0]
    return sf.Mesh(nodes, elements)


def below(mesh: sf.Mesh) -> sf.Mesh:
    return sf.Mesh(mesh.nodes - [0, 0, 0.005], mesh.elements, half=True)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("make, word", [
    (lambda mesh: sf.Mesh(mesh.nodes, np.vstack([mesh.elements, mesh.elements[:8]])), "has the corners of element"),
    (unmerged, "lie at the same place"),
    (repeated, "twice"),
    (inverted, "inverted|flat"),
    (below, "half model"),
    (lambda mesh: sf.Mesh(mesh.nodes + [0, 0, 0.01], mesh.elements, half=True), "no face on z = 0"),
    (lambda mesh: sf.Mesh(1e3 * mesh.nodes, mesh.elements), "long when its numbers"),
    (lambda mesh: sf.Mesh(mesh.nodes * [1, 1, 1e-9], mesh.elements), "flat"),
    (lambda mesh: sf.Mesh(mesh.nodes, mesh.elements, np.arange(len(mesh.elements)) // 2 * 2, names={0: "a", 2: "a"}), "two tags"),
    (lambda mesh: sf.Mesh(mesh.nodes, mesh.elements, names={7: "a"}), "tag 7"),
    (lambda mesh: sf.Mesh(mesh.nodes, mesh.elements, names={0.5: "a"}), "names"),
    (lambda mesh: sf.Mesh(mesh.nodes, mesh.elements + 1), "names the node"),
    (lambda mesh: sf.Mesh(mesh.nodes, mesh.elements, half="yes"), "half"),
])
def test_the_same_is_refused_of_every_cell_type(kind: str, make: Callable[[sf.Mesh], object], word: str) -> None:
    with pytest.raises(sf.InputError, match=word) as caught:
        make(box(kind))
    assert caught.value.what and caught.value.why and caught.value.action


@pytest.mark.parametrize("kind", KINDS)
def test_a_region_number_never_wraps(kind: str) -> None:
    mesh = sf.Mesh.box((1.0, 1.0, 1.0), (11, 11, 11), kind)
    with pytest.raises(sf.MeshError, match="tags"):
        sf.Mesh(mesh.nodes, mesh.elements, np.arange(len(mesh.elements)))
    tags = 70_000 + np.arange(len(mesh.elements)) % 3
    many = sf.Mesh(mesh.nodes, mesh.elements, tags)
    assert many.tags == [70_000, 70_001, 70_002] and np.array_equal(np.array(many.tags)[many.regions], tags)


def test_a_tag_for_each_of_many_elements_is_refused_at_once() -> None:
    mesh = sf.Mesh.box((1.0, 1.0, 1.0), (42, 42, 42), "hexahedra")
    began = time.process_time()
    with pytest.raises(sf.MeshError, match="74088 tags"):
        sf.Mesh(mesh.nodes, mesh.elements, np.arange(len(mesh.elements)))
    # it was 95 s where each name was looked for among all before
    assert time.process_time() - began < 10.0


@pytest.mark.parametrize("kind", KINDS)
def test_a_half_model_stays_on_its_plane(kind: str) -> None:
    whole = box(kind)
    half = sf.Mesh(whole.nodes, whole.elements, half=True)
    body = sf.Solver.of_mesh(half, SILICONE, half.nodes[:, 0] == 0)
    found = body.equilibrium(forces=np.outer(half.nodes[:, 0] == half.nodes[:, 0].max(), [0.0, -1e-4, -1e-4]))
    plane = np.isclose(half.nodes[:, 2], 0)
    assert half.half and np.abs(found.displacement[plane, 2]).max() == 0.0 and np.abs(found.displacement[plane, 1]).max() > 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_nodes_that_no_element_uses_are_dropped_with_a_map_and_numbers_of_nodes_then_refused(kind: str) -> None:
    mesh = box(kind)
    nodes = np.vstack([[[0.05, 0.05, 0.05]], mesh.nodes])
    found = sf.Mesh(nodes, mesh.elements + 1)
    assert found.numbering[0] == -1 and np.array_equal(found.numbering[1:], np.arange(len(mesh.nodes)))
    assert np.array_equal(found.nodes[found.numbering[1:]], nodes[1:]) and found.notes
    held = np.flatnonzero(nodes[:, 0] == 0)
    with pytest.raises(sf.InputError, match="`clamped` holds node numbers"):
        sf.Solver.of_mesh(found, SILICONE, held)
    mask = np.zeros(len(found.nodes), dtype=bool)
    mask[found.numbering[held]] = True
    assert np.array_equal(mask, found.nodes[:, 0] == 0)
    assert sf.Solver.of_mesh(found, SILICONE, mask).dofs == sf.Solver.of_mesh(mesh, SILICONE, np.flatnonzero(mesh.nodes[:, 0] == 0)).dofs
    assert np.array_equal(mesh.numbering, np.arange(len(mesh.nodes)))


@pytest.mark.parametrize("kind", KINDS)
def test_tags_and_names_survive_meshio_and_copies(kind: str) -> None:
    pytest.importorskip("meshio")
    mesh = box(kind)
    upper = mesh.nodes[mesh.elements].mean(axis=1)[:, 2] > 0.005
    named = sf.Mesh(mesh.nodes, mesh.elements, np.where(upper, 9, 4), names={9: "stiff"})
    assert named.region_names == ["region_4", "stiff"]
    for again in (sf.Mesh.from_meshio(named.to_meshio()), pickle.loads(pickle.dumps(named)), copy.deepcopy(named)):
        assert (again.region_names, again.tags) == (named.region_names, [4, 9])
        for part in ("nodes", "elements", "regions", "skin"):
            assert np.array_equal(getattr(again, part), getattr(named, part))


def test_names_of_gmsh_and_surfaces_come_through() -> None:
    meshio = pytest.importorskip("meshio")
    mesh = box("linear")
    side = mesh.skin[np.all(mesh.nodes[mesh.skin][:, :, 0] == 0.0, axis=1)]
    given = meshio.Mesh(
        mesh.nodes,
        [("tetra", mesh.elements), ("triangle", side)],
        cell_data={"gmsh:physical": [np.ones(len(mesh.elements), int), np.full(len(side), 5)]},
        field_data={"silicone": np.array([1, 3]), "holder": np.array([5, 2])},
    )
    found = sf.Mesh.from_meshio(given)
    assert found.region_names == ["silicone"] and len(found.surfaces["holder"]) == len(side)
    rubber = {"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}
    case = {"region": [rubber], "clamp": [{"surface": "holder"}], "static": {"levels": [1.0]}}
    for other in (found, sf.Mesh.from_meshio(found.to_meshio()), pickle.loads(pickle.dumps(found))):
        assert sf.Case(case, mesh=other).solver().dofs == 3 * int(np.sum(mesh.nodes[:, 0] > 0))


@pytest.mark.parametrize("kind, face", [("hexahedra", "quad"), ("quadratic_hexahedra", "quad8")])
def test_names_of_surfaces_of_hexahedra_come_through(kind: str, face: str) -> None:
    meshio = pytest.importorskip("meshio")
    mesh = box(kind)
    sides = mesh.elements[:, [0, 3, 2, 1] if kind == "hexahedra" else [0, 3, 2, 1, 11, 10, 9, 8]]
    nodes = np.vstack([[[0.05, 0.05, 0.05]], mesh.nodes])
    given = meshio.Mesh(
        nodes,
        [("hexahedron" if kind == "hexahedra" else "hexahedron20", mesh.elements + 1), (face, sides + 1)],
        cell_data={"gmsh:physical": [np.ones(len(mesh.elements), int), np.full(len(sides), 5)]},
        field_data={"silicone": np.array([1, 3]), "base": np.array([5, 2])},
    )
    found = sf.Mesh.from_meshio(given)
    for again in (found, sf.Mesh.from_meshio(found.to_meshio()), pickle.loads(pickle.dumps(found))):
        assert again.region_names == ["silicone"] and np.array_equal(again.surfaces["base"], sides[:, :4])


def test_a_mesh_of_two_kinds_is_refused() -> None:
    meshio = pytest.importorskip("meshio")
    one, other, second = box("hexahedra"), box("linear"), box("quadratic")
    apart = other.nodes + [0.06, 0, 0]
    mixed = [("hexahedron", one.elements), ("tetra", other.elements + len(one.nodes))]
    orders = [("tetra10", second.elements), ("tetra", second.elements[:1, :4])]
    wedge = [("tetra", other.elements), ("wedge", np.arange(6)[None])]
    for points, cells in ((np.vstack([one.nodes, apart]), mixed), (second.nodes, orders), (other.nodes, wedge)):
        with pytest.raises(sf.InputError, match="the mesh has"):
            sf.Mesh.from_meshio(meshio.Mesh(points, cells))
    with pytest.raises(sf.InputError, match="no cell data"):
        sf.Mesh.from_meshio(meshio.Mesh(other.nodes, [("tetra", other.elements)]), tags="nowhere")
    lines = meshio.Mesh(other.nodes, [("line", [[0, 1]]), ("tetra", other.elements), ("quad", [[0, 1, 2, 3]])])
    assert len(sf.Mesh.from_meshio(lines).elements) == len(other.elements)


@pytest.mark.parametrize("kind, cell, order", [("hexahedra", "hexahedron", 1), ("quadratic_hexahedra", "hexahedron20", 2)])
@pytest.mark.parametrize("ending", [".vtu", ".msh"])
def test_a_file_of_hexahedra_is_read_whole(ending: str, kind: str, cell: str, order: int, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    mesh = box(kind)
    meshio.Mesh(1e3 * mesh.nodes, [(cell, mesh.elements)]).write(tmp_path / f"box{ending}", **({"file_format": "gmsh22", "binary": False} if ending == ".msh" else {}))
    found = sf.Mesh.read(tmp_path / f"box{ending}", "mm")
    assert np.allclose(found.nodes, mesh.nodes) and np.array_equal(found.elements, mesh.elements)
    assert np.array_equal(sf.Mesh.read(tmp_path / f"box{ending}", "mm", order=order).elements, mesh.elements)
    with pytest.raises(sf.InputError, match=f"order is {3 - order}"):
        sf.Mesh.read(tmp_path / f"box{ending}", "mm", order=3 - order)


@pytest.mark.parametrize("kind, cell", [("hexahedra", "hexahedron"), ("quadratic_hexahedra", "hexahedron20")])
@pytest.mark.parametrize("ending", [".vtu", ".msh"])
def test_a_case_of_a_file_of_hexahedra_sags_like_its_mesh(ending: str, kind: str, cell: str, tmp_path: Path) -> None:
    """Corners become 20-node hexahedra; both files hold a box with straight edges, so that they sag alike."""
    meshio = pytest.importorskip("meshio")
    mesh = box(kind)
    form = {"file_format": "gmsh22", "binary": False} if ending == ".msh" else {}
    meshio.Mesh(1e3 * mesh.nodes, [(cell, mesh.elements)]).write(tmp_path / f"box{ending}", **form)
    text = (f'mesh = {{ file = "box{ending}", unit = "mm" }}\ngravity = [0.0, -9.81, 0.0]\nclamp = [{{ plane = {{ x = 0.0 }} }}]\nstatic = {{ levels = [1.0] }}\n'
            '[[region]]\nmaterial = "neo_hookean"\nyoungs_modulus = 2e5\npoissons_ratio = 0.4\ndensity = 1000.0\n')
    case = sf.Case.from_toml(text, tmp_path)
    assert case.mesh.elements.shape == (len(mesh.elements), 20)
    whole = box("quadratic_hexahedra")
    solver = sf.Solver.of_mesh(whole, SILICONE, whole.nodes[:, 0] == 0.0)
    sag = [np.abs(found.displacement).max(axis=0) for found in (case.solver().equilibrium(), solver.equilibrium(gravity=[0.0, -9.81, 0.0]))]
    assert sag[1][1] > 1e-4 and np.allclose(*sag, rtol=1e-6, atol=1e-9)
    region = {"material": "neo_hookean", "youngs_modulus": 2e5, "poissons_ratio": 0.4, "density": 1000.0}
    with pytest.raises(sf.InputError, match="given mesh of hexahedra"):
        sf.Case({"region": [region], "clamp": [{"plane": {"x": 0.0}}], "static": {"levels": [1.0]}}, mesh=mesh).solver()


def hollow_cube(kind: str, cells: int) -> sf.Mesh:
    """A cube of 30 mm around a cubic cavity of a third of its edge."""
    cube = sf.Mesh.box((0.03, 0.03, 0.03), (cells, cells, cells), kind)
    middle = cube.nodes[cube.elements[:, : 4 if "hexa" not in kind else 8]].mean(axis=1)
    return sf.Mesh(cube.nodes, cube.elements[np.any(np.abs(middle - 0.015) > 0.005, axis=1)])


def test_a_cavity_of_quadratic_hexahedra_is_a_chamber_and_swells_as_one_of_tetrahedra() -> None:
    def swelling(mesh: sf.Mesh) -> float:
        base = mesh.nodes[:, 2] == 0.0
        solver = sf.Solver.of_mesh(mesh, sf.Material(2e5, 0.45, 1000.0), base)
        found = solver.equilibrium(pressure=[2e4])
        return float(found.displacement[np.all(np.isclose(mesh.nodes, [0.015, 0.015, 0.03]), axis=1), 2][0])

    # the cavity's edges are singular: 6 and 1.7 % between the two with 6 and 12 cells along the cube
    meshes = [hollow_cube("quadratic_hexahedra", 12), hollow_cube("quadratic", 12)]
    for mesh in meshes:
        [(volume, centroid)] = mesh.chambers
        assert volume == pytest.approx(1e-6) and np.allclose(centroid, 0.015)
    hexahedra, tetrahedra = (swelling(mesh) for mesh in meshes)
    assert hexahedra == pytest.approx(tetrahedra, rel=0.03) and hexahedra > 1e-4
    assert hollow_cube("hexahedra", 3).chambers == [] and "take no pressure" in hollow_cube("hexahedra", 3).notes[0]


@pytest.mark.parametrize("make", [
    lambda: sf.Mesh.box((1.0, 1.0, 1.0), (1000, 1000, 1000)),
    lambda: sf.Mesh.box((1.0, 1.0, 1.0), (1.9, 1, 1)),
    lambda: sf.Mesh.box((1.0, 1.0), (1, 1, 1)),
    lambda: sf.Mesh.box((1.0, 1.0, np.nan), (1, 1, 1)),
    lambda: sf.Mesh.box((1.0, 1.0, 1.0), (1, 1, 1), "cubes"),
    lambda: sf.Mesh.read(EXAMPLES / "finger.msh", "mm", order=3),
    lambda: sf.Mesh.read(EXAMPLES / "finger.msh", "mm", order=1.5),
    lambda: sf.Mesh.read(EXAMPLES / "finger.msh", "foot"),
    lambda: sf.Mesh.from_stl("nowhere.stl", "thin"),
])
def test_arguments_of_meshes_are_checked(make: Callable[[], object]) -> None:
    with pytest.raises(sf.InputError) as caught:
        make()
    assert caught.value.what and caught.value.why and caught.value.action


def test_every_unit_of_a_case_is_one_of_a_file() -> None:
    metres = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}
    size = np.ptp(sf.Mesh.read(EXAMPLES / "finger.msh", "mm", half=True).nodes, axis=0)
    for unit in ("cm", "inch"):
        found = np.ptp(sf.Mesh.read(EXAMPLES / "finger.msh", unit, half=True).nodes, axis=0)
        assert np.allclose(found, size * metres[unit] / metres["mm"], rtol=1e-9)
