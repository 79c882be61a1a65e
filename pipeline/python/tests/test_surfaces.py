"""Bodies from closed surfaces that are arrays."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import softfish as sf

Surface = tuple[np.ndarray, np.ndarray]


def block(low: float, high: float) -> Surface:
    """A cube in twelve faces, normals outwards."""
    points = np.array([[low if n >> k & 1 == 0 else high for k in range(3)] for n in range(8)])
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return points, np.array([t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])


def volume(mesh: sf.Mesh, region: int) -> float:
    corners = mesh.nodes[mesh.elements[mesh.regions == region][:, :4]]
    return float(np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6)


def test_a_body_with_an_insert_and_a_cavity_is_meshed_with_its_regions_and_its_chamber() -> None:
    body, insert, cavity = block(0.0, 0.03), block(0.003, 0.009), block(0.014, 0.026)
    mesh = sf.Mesh.from_surfaces(body, 5e-3, inserts=[insert], cavities=[cavity], names={0: "silicone", 1: "sheet"})
    assert volume(mesh, 1) == pytest.approx(0.006**3, rel=1e-6)
    assert volume(mesh, 0) == pytest.approx(0.03**3 - 0.006**3 - 0.012**3, rel=1e-3)
    materials = {"silicone": sf.Material(1e5, 0.48), "sheet": sf.Material(1e7, 0.4)}
    solver = sf.Solver.of_mesh(mesh, materials, mesh.nodes[:, 0] < 1e-9)
    assert len(solver.chambers) == 1


def test_objects_of_other_packages_are_taken_and_dirt_is_reported() -> None:
    points, faces = block(0.0, 0.02)
    faces = faces.copy()
    faces[3] = faces[3][::-1]
    mesh = sf.Mesh.from_surfaces(SimpleNamespace(vertices=points, faces=faces), 5e-3, method="general")
    assert volume(mesh, 0) == pytest.approx(0.02**3, rel=1e-3)
    assert mesh.repairs and "turned" in mesh.repairs[0]


def test_a_plate_has_as_many_elements_through_it_as_are_asked_for() -> None:
    points, faces = block(0.0, 0.02)
    plate = points * np.array([1.0, 1.0, 0.1]), faces
    meshes = [sf.Mesh.from_surfaces(plate, 5e-3, layers=layers) for layers in (1, 2)]
    inner = [np.count_nonzero(np.abs(mesh.nodes[np.unique(mesh.elements[:, :4]), 2] - 1e-3) < 8e-4) for mesh in meshes]
    assert inner[1] > 3 * inner[0] + 50
    for wrong in ({"layers": 0}, {"envelope": -1e-4}, {"smallest": 0.0}, {"layers": 2, "method": "columns"}):
        with pytest.raises(sf.Error):
            sf.Mesh.from_surfaces(plate, 5e-3, **wrong)


@pytest.mark.parametrize(
    ("body", "words"),
    [("body.stl", "pair of arrays"), ((np.zeros((4, 2)), np.zeros((4, 3), int)), "three columns"), ((np.zeros((4, 3)), [[0, 1, 9]]), "corner")],
)
def test_what_is_no_surface_is_refused(body: Any, words: str) -> None:
    with pytest.raises(sf.Error, match=words):
        sf.Mesh.from_surfaces(body, 5e-3)
