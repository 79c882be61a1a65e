"""Closed surfaces as people have them: arrays, and objects of trimesh and pyvista."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

from softfish import _core
from softfish._arrays import Array, IntArray, integers, reals
from softfish._errors import InputError
from softfish._records import MeshedSurfaces

#: How tetrahedra are made.
Method: TypeAlias = Literal["columns", "general", "auto"]


def triangles(name: str, surface: Any) -> tuple[Array, IntArray]:
    """Points (points × 3, m) and faces (faces × 3) of a pair of arrays, a `trimesh.Trimesh` or a `pyvista.PolyData`."""
    if hasattr(surface, "vertices") and hasattr(surface, "faces"):
        points, faces = surface.vertices, surface.faces
    elif hasattr(surface, "points") and hasattr(surface, "regular_faces"):
        points, faces = surface.points, surface.triangulate().regular_faces
    elif isinstance(surface, (tuple, list)) and len(surface) == 2:
        points, faces = surface
    else:
        why = "it is a pair of arrays (points, faces), a trimesh.Trimesh or a pyvista.PolyData"
        raise InputError(f"`{name}` is {type(surface).__name__}", why, "give one of these")
    places, corners = reals(f"{name} points", np.asarray(points)), integers(f"{name} faces", np.asarray(faces))
    for what, array in ((f"{name} points", places), (f"{name} faces", corners)):
        if array.ndim != 2 or array.shape[1] != 3 or not len(array):
            raise InputError(f"`{what}` has the shape {array.shape}", "it has three columns", "check its axes")
    return places, corners


#: Envelope (m), shortest edges (m) and elements through a wall, each as it is asked for or not.
Detail: TypeAlias = tuple[float | None, float | None, int | None]


def meshed(
    body: Any, parts: tuple[Sequence[Any], Sequence[Any]], edge: float, how: tuple[Method, Detail]
) -> MeshedSurfaces:
    """The tetrahedra that a body, its inserts and its cavities enclose."""
    inserts, cavities = parts

    def given(name: str, surface: Any) -> tuple[Array, list[int]]:
        points, faces = triangles(name, surface)
        return np.ascontiguousarray(points).ravel(), faces.ravel().tolist()

    return _core.mesh_surfaces(
        (
            given("body", body),
            [given(f"inserts[{n}]", one) for n, one in enumerate(inserts)],
            [given(f"cavities[{n}]", one) for n, one in enumerate(cavities)],
        ),
        edge,
        how,
    )
