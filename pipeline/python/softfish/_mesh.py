"""Meshes: from arrays, files, surfaces and meshio."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from softfish import _core
from softfish._arrays import Array, IntArray, integers, reals
from softfish._errors import InputError

Unit = Literal["m", "mm"]


def _is_millimetres(unit: str) -> bool:
    if unit not in ("m", "mm"):
        raise InputError(f"the unit is `{unit}`", "lengths are in m or mm", "name one of them")
    return unit == "mm"


class Mesh:
    """A body at rest: nodes (m), tetrahedra of 4 or 10 nodes or hexahedra of 8, regions and chambers.

    Mid-edge nodes are those of the edges 01, 12, 02, 03, 13, 23; hexahedra have the order of VTK. Chambers are the closed
    cavities of tetrahedra, in rising order of their centroids along x, then y, then z.
    """

    def __init__(
        self,
        nodes: npt.ArrayLike,
        elements: npt.ArrayLike,
        regions: npt.ArrayLike | None = None,
        *,
        names: Mapping[int, str] | None = None,
        half: bool = False,
    ) -> None:
        """From arrays: `nodes` (nodes × 3, m), `elements` (elements × 4, 8 or 10), the tag of each element's region and
        `names` of tags. `half`: the mesh is the half z ≥ 0 of a body that is symmetric about z = 0."""
        points = reals("nodes", nodes)
        cells = integers("elements", elements)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"`nodes` has the shape {points.shape}", "it is nodes × 3", "check its axes")
        if cells.ndim != 2 or cells.shape[1] not in (4, 8, 10) or len(cells) == 0:
            why = "it is elements × 4 or 10 (tetrahedra) or × 8 (hexahedra)"
            raise InputError(f"`elements` has the shape {cells.shape}", why, "check its axes")
        tags = np.zeros(len(cells), dtype=np.int64) if regions is None else integers("regions", regions)
        if tags.shape != (len(cells),):
            raise InputError(f"`regions` has the shape {tags.shape}", f"there are {len(cells)} elements", "give one each")
        given = {int(tag): str(name) for tag, name in (names or {}).items()}
        pair = (cells.ravel(), int(cells.shape[1]))
        self._core = _core.Mesh.from_arrays(points.ravel(), pair, (tags.tolist(), given), half)

    @classmethod
    def _of(cls, core: _core.Mesh) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._core = core
        return mesh

    @classmethod
    def read(
        cls, path: str | os.PathLike[str], unit: Unit = "m", *, order: Literal[1, 2] | None = None, half: bool = False
    ) -> Mesh:
        """From a file: `.msh` (4.1), `.vtu`, `.mesh`, `.ele` with its `.node` beside it."""
        return cls._of(_core.Mesh.read(os.fspath(path), _is_millimetres(unit), order, half))

    @classmethod
    def from_stl(
        cls,
        body: str | os.PathLike[str],
        edge: float,
        unit: Unit = "mm",
        *,
        spine: str | os.PathLike[str] | None = None,
        half: bool = False,
    ) -> Mesh:
        """From the closed surface of a body, and that of a plane sheet in it, with edges of the length `edge` (m)."""
        if not 1e-5 <= edge <= 1.0:
            raise InputError(f"edge is {edge}", "it lies between 1e-5 and 1 m", "give it in metres")
        sheet = None if spine is None else os.fspath(spine)
        return cls._of(_core.Mesh.from_surfaces(os.fspath(body), sheet, edge, (_is_millimetres(unit), half)))

    @classmethod
    def from_meshio(cls, mesh: Any, *, unit: Unit = "m", tags: str | None = None, half: bool = False) -> Mesh:
        """From a `meshio.Mesh`: its tetrahedra (or its hexahedra), with the cell data `tags` as regions."""
        kinds = ("tetra10", "tetra", "hexahedron")
        kind = next((kind for kind in kinds if any(block.type == kind for block in mesh.cells)), None)
        if kind is None:
            found = ", ".join(sorted({block.type for block in mesh.cells}))
            raise InputError("the mesh has no solid elements", f"it has {found}", f"give one of {', '.join(kinds)}")
        blocks = [n for n, block in enumerate(mesh.cells) if block.type == kind]
        elements = np.concatenate([mesh.cells[n].data for n in blocks])
        if kind == "tetra10":
            # meshio has the order of VTK, which is that of this package
            elements = np.ascontiguousarray(elements)
        regions = None if tags is None else np.concatenate([mesh.cell_data[tags][n] for n in blocks])
        scale = 1e-3 if _is_millimetres(unit) else 1.0
        return cls(scale * np.asarray(mesh.points, dtype=np.float64), elements.astype(np.int64), regions, half=half)

    @classmethod
    def box(
        cls,
        size: tuple[float, float, float],
        cells: tuple[int, int, int],
        kind: Literal["linear", "quadratic", "hexahedra"] = "quadratic",
    ) -> Mesh:
        """A box [0, size] (m) of grid cells, each cut into six tetrahedra, or hexahedra."""
        if not all(0 < side <= 10 for side in size) or not all(0 < count <= 4096 for count in cells):
            raise InputError(f"the box has sides {size} m and cells {cells}", "both are above 0", "correct them")
        made = _core.box_mesh((float(size[0]), float(size[1]), float(size[2])), cells, kind)
        return cls(made["nodes"].reshape(-1, 3), made["elements"].reshape(-1, made["each"]))

    @property
    def nodes(self) -> Array:
        """nodes × 3, m."""
        return self._core.nodes().reshape(-1, 3)

    @property
    def elements(self) -> IntArray:
        """elements × 4, 8 or 10: node numbers."""
        elements, each = self._core.elements()
        return elements.reshape(-1, each)

    @property
    def regions(self) -> IntArray:
        """The region of each element, an index into `region_names`."""
        return self._core.regions()

    @property
    def region_names(self) -> list[str]:
        """The name of each region; `region_` and its tag where the file has none."""
        return self._core.region_names()

    @property
    def chambers(self) -> list[tuple[float, tuple[float, float, float]]]:
        """Volume (m³) and centroid (m) of each chamber."""
        return [(volume, (at[0], at[1], at[2])) for volume, at in self._core.chambers()]

    @property
    def skin(self) -> IntArray:
        """triangles × 3: node numbers of the outer skin's corners, of tetrahedra."""
        return self._core.skin().reshape(-1, 3)

    @property
    def notes(self) -> list[str]:
        """What was repaired or noticed when it was read."""
        return self._core.notes()

    def to_meshio(self, displacement: npt.ArrayLike | None = None) -> Any:
        """As a `meshio.Mesh`, with a displacement as point data where one is given."""
        from softfish._optional import optional

        elements = self.elements
        kind = {4: "tetra", 8: "hexahedron", 10: "tetra10"}[elements.shape[1]]
        data = {} if displacement is None else {"displacement": reals("displacement", displacement, self.nodes.shape)}
        return optional("meshio").Mesh(self.nodes, [(kind, elements)], data, {"region": [self.regions]})

    def __repr__(self) -> str:
        nodes, elements = len(self.nodes), self.elements
        return f"Mesh({nodes} nodes, {len(elements)} elements of {elements.shape[1]}, regions {self.region_names})"
