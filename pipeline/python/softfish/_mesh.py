"""Meshes: from arrays, files, surfaces and meshio."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from softfish import _core
from softfish._arguments import checked, one_of
from softfish._arrays import Array, IntArray, Sealed, file, frozen, integers, reals, repeated, whole, within
from softfish._errors import InputError
from softfish._export import grid_of, page
from softfish._surfaces import Method, meshed

Unit = Literal["m", "mm", "cm", "inch"]
#: One of it, m.
_METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}

#: Solids of meshio, and what is said of those that are not simulated.
_SOLIDS = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20}
_FLAT = ("vertex", "line", "triangle", "quad", "polygon", "VTK_LAGRANGE_CURVE", "VTK_LAGRANGE_TRIANGLE", "VTK_LAGRANGE_QUAD")
#: Cell data that hold the region of a cell, by priority: those of `Mesh.read`.
_TAGS = ("region", "regions", "gmsh:physical", "cellentityids", "medit:ref", "tetgen:ref", "cell_tags", "material", "gmsh:geometrical")


class Mesh(Sealed):
    """A body at rest: nodes (m), tetrahedra of 4 or 10 nodes or hexahedra of 8 or 20, regions and chambers. Its arrays are read-only: another
    body is another mesh.

    Mid-edge nodes are those of the edges 01, 12, 02, 03, 13, 23; hexahedra have the order of VTK. Chambers are the closed
    cavities of tetrahedra, in rising order of their centroids along x, then y, then z.

    Every mesh is checked: inverted, flat and repeated elements, nodes that lie at the same place and faces of more than two elements are
    refused. Nodes that no element uses are dropped; `numbering` then says where each node is.

    Attributes:
        repairs: What `from_surfaces` changed of the surfaces, a sentence each.
    """

    repairs: tuple[str, ...] = ()

    @checked()
    def __init__(
        self,
        nodes: npt.ArrayLike,
        elements: npt.ArrayLike,
        regions: npt.ArrayLike | None = None,
        *,
        names: Mapping[int, str] | None = None,
        half: bool = False,
    ) -> None:
        """From arrays: `nodes` (nodes × 3, m), `elements` (elements × 4, 8, 10 or 20), the tag of each element's region and
        `names` of tags. `half`: the mesh is the half z ≥ 0 of a body that is symmetric about z = 0."""
        self._make(nodes, elements, regions, (names, half), None)

    def _make(
        self,
        nodes: npt.ArrayLike,
        elements: npt.ArrayLike,
        regions: npt.ArrayLike | None,
        options: tuple[Mapping[int, str] | None, bool],
        surfaces: tuple[IntArray, list[int], dict[int, str]] | None,
    ) -> None:
        names, half = options
        points = reals("nodes", nodes)
        cells = integers("elements", elements)
        if points.ndim != 2 or points.shape[1] != 3:
            raise InputError(f"`nodes` has the shape {points.shape}", "it is nodes × 3", "check its axes")
        if cells.ndim != 2 or cells.shape[1] not in (4, 8, 10, 20) or len(cells) == 0:
            why = "it is elements × 4 or 10 (tetrahedra) or × 8 or 20 (hexahedra)"
            raise InputError(f"`elements` has the shape {cells.shape}", why, "check its axes")
        tags = np.zeros(len(cells), dtype=np.int64) if regions is None else integers("regions", regions)
        if tags.shape != (len(cells),):
            raise InputError(f"`regions` has the shape {tags.shape}", f"there are {len(cells)} elements", "give one each")
        arrays = (points.ravel(), cells.ravel(), int(cells.shape[1]))
        self._core = _core.Mesh.from_arrays(arrays, (tags.tolist(), _names(names, tags)), (half, surfaces))

    @classmethod
    def _of(cls, core: _core.Mesh) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._core = core
        return mesh

    @classmethod
    @checked()
    def read(
        cls, path: str | os.PathLike[str], unit: Unit = "m", *, order: Literal[1, 2] | None = None, half: bool = False
    ) -> Mesh:
        """From a file: `.msh` (4.1 or 2.2), `.vtu`, `.vtk`, `.mesh`, `.ele` with its `.node` beside it.

        `unit`: of the numbers in the file. `order` 1 or 2: of the elements; left out: as the file has them. `half`: as for arrays."""
        return cls._of(_core.Mesh.read(os.fspath(path), (unit, order), half))

    @classmethod
    @checked(body=file)
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
        files = (os.fspath(body), None if spine is None else os.fspath(spine))
        return cls._of(_core.Mesh.from_surfaces(files, edge, (unit, half)))

    @classmethod
    @checked(method=one_of("columns", "general", "auto"))
    def from_surfaces(
        cls,
        body: Any,
        edge: float,
        *,
        inserts: Sequence[Any] = (),
        cavities: Sequence[Any] = (),
        names: Mapping[int, str] | None = None,
        method: Method = "auto",
        envelope: float | None = None,
        smallest: float | None = None,
        layers: int | None = None,
    ) -> Mesh:
        """Quadratic tetrahedra in a body, with edges of the length `edge` (m): region 0, `inserts` that displace it regions 1, 2, …, `cavities`
        empty. A surface is a pair (points × 3 in m, faces × 3), a `trimesh.Trimesh` or a `pyvista.PolyData`; gaps, holes and faces that look the
        wrong way are repaired, see `repairs`. `method`: in columns, the general one, or columns where they divide the body. `envelope`: largest
        distance from the surfaces (m; 2 % of an edge where it is left out); `smallest`: shortest edges (m; a sixteenth); `layers`: elements
        through a wall (1 to 8; one, five times as wide as the wall is thick). With these three `auto` is the general method."""
        for name, length in (("envelope", envelope), ("smallest", smallest)):
            if length is not None:
                within(name, length, 1e-6, 1.0)
        count = None if layers is None else whole("layers", layers, 1, 8)
        made = meshed(body, (inserts, cavities), edge, (method, (envelope, smallest, count)))
        mesh = cls(made["nodes"].reshape(-1, 3), made["elements"].reshape(-1, 10), made["regions"], names=names)
        mesh.repairs = tuple(made["repairs"])
        return mesh

    @classmethod
    @checked()
    def from_meshio(cls, mesh: Any, *, unit: Unit = "m", tags: str | None = None, half: bool = False) -> Mesh:
        """From a `meshio.Mesh`: all its tetrahedra of one order, or all its hexahedra. Other solids, and two kinds, are refused.

        `tags`: the cell data with the tag of each element's region; left out: the first that is there of those that `Mesh.read` knows.
        Physical names (`field_data`) become the names of regions and surfaces. Nodes that no element uses are dropped: see `numbering`."""
        kind = _solid_kind(mesh)
        blocks = [n for n, block in enumerate(mesh.cells) if block.type == kind]
        elements = np.concatenate([np.asarray(mesh.cells[n].data) for n in blocks]).astype(np.int64)
        data = _tags_of(mesh, tags)
        regions = None if data is None else np.concatenate([np.asarray(data[n]) for n in blocks])
        if regions is not None and np.array_equal(regions, np.asarray(regions).astype(np.int64)):
            # some formats of meshio hold tags as real numbers
            regions = regions.astype(np.int64)
        made = cls.__new__(cls)
        names = _physical_names(mesh, 3, set() if regions is None else set(np.unique(regions).tolist()))
        points = _METRES[unit] * reals("points", mesh.points)
        made._make(points, elements, regions, (names, half), _surfaces(mesh, data, kind))
        return made

    @classmethod
    @checked(kind=one_of("linear", "quadratic", "hexahedra", "quadratic_hexahedra"))
    def box(
        cls,
        size: tuple[float, float, float],
        cells: tuple[int, int, int],
        kind: Literal["linear", "quadratic", "hexahedra", "quadratic_hexahedra"] = "quadratic",
    ) -> Mesh:
        """A box [0, size] (m) of grid cells, each cut into six tetrahedra, or hexahedra."""
        sides = reals("size", size, (3,)).tolist()
        if integers("cells", cells).shape != (3,):
            raise InputError(f"`cells` is {cells!r}", "it is the number along x, y and z", "give three whole numbers")
        counts = [whole("cells", count, 1, 1 << 20) for count in cells]
        for side in sides:
            within("size", side, 1e-9, 10.0)
        made = _core.box_mesh((sides[0], sides[1], sides[2]), (counts[0], counts[1], counts[2]), kind)
        return cls(made["nodes"].reshape(-1, 3), made["elements"].reshape(-1, made["each"]))

    @property
    def nodes(self) -> Array:
        """nodes × 3, m."""
        return frozen(self._core.nodes().reshape(-1, 3))

    @property
    def elements(self) -> IntArray:
        """elements × 4, 8, 10 or 20: node numbers."""
        elements, each = self._core.elements()
        return frozen(elements.reshape(-1, each))

    @property
    def regions(self) -> IntArray:
        """The region of each element, an index into `region_names` and `tags`."""
        return frozen(self._core.regions())

    @property
    def region_names(self) -> list[str]:
        """The name of each region; `region_` and its tag where the file has none."""
        return self._core.region_names()

    @property
    def tags(self) -> list[int]:
        """The tag of each region, as in the file or the arrays; rising."""
        return [tag for tag, _ in self._core.region_tags()]

    @property
    def numbering(self) -> IntArray:
        """For each node of the arrays or of the file that the mesh was made of its number here, −1 where no element uses it."""
        given = self._core.numbering()
        return frozen(given if len(given) else np.arange(len(self.nodes), dtype=np.int64))

    @property
    def surfaces(self) -> dict[str, IntArray]:
        """The surfaces that the file names or numbers, by name or tag: triangles × 3 node numbers, of hexahedra sides × 4."""
        return {name or str(tag): frozen(corners.reshape(-1, self._corners())) for tag, name, corners in self._core.surfaces()}

    @property
    def half(self) -> bool:
        """Whether it is the half z ≥ 0 of a body that is symmetric about z = 0."""
        return self._core.half()

    @property
    def chambers(self) -> list[tuple[float, tuple[float, float, float]]]:
        """Volume (m³) and centroid (m) of each chamber."""
        return [(volume, (at[0], at[1], at[2])) for volume, at in self._core.chambers()]

    @property
    def skin(self) -> IntArray:
        """triangles × 3: node numbers of the outer skin's corners; sides of hexahedra are cut into two."""
        return frozen(self._core.skin().reshape(-1, 3))

    @property
    def notes(self) -> list[str]:
        """What was repaired or noticed when it was read."""
        return self._core.notes()

    def to_meshio(self, displacement: npt.ArrayLike | None = None) -> Any:
        """As a `meshio.Mesh`, with a displacement (nodes × 3, m) as point data where one is given: the tag of each element as cell data
        `region`, names of regions and surfaces as `field_data`, surfaces as triangles or quadrilaterals."""
        from softfish._optional import optional

        elements = self.elements
        kind = {4: "tetra", 8: "hexahedron", 10: "tetra10", 20: "hexahedron20"}[elements.shape[1]]
        data = {} if displacement is None else {"displacement": reals("displacement", displacement, self.nodes.shape)}
        pairs = self._core.region_tags()
        region = np.array([tag for tag, _ in pairs], dtype=np.int64)[self.regions]
        fields = {name: np.array([tag, 3]) for name, (tag, is_named) in zip(self.region_names, pairs, strict=True) if is_named}
        cells, values = [(kind, elements)], [region]
        for tag, name, corners in self._core.surfaces():
            faces = corners.reshape(-1, self._corners())
            cells.append(("triangle" if faces.shape[1] == 3 else "quad", faces))
            values.append(np.full(len(faces), tag, dtype=np.int64))
            if name is not None:
                fields[name] = np.array([tag, 2])
        return optional("meshio").Mesh(self.nodes, cells, data, {"region": values}, field_data=fields)

    def to_pyvista(self, displacement: npt.ArrayLike | None = None) -> Any:
        """As a `pyvista.UnstructuredGrid` at rest: the region of each element as cell data, a displacement (nodes × 3, m) as point data."""
        return grid_of(self, None if displacement is None else reals("displacement", displacement, self.nodes.shape))

    def _repr_html_(self) -> str:
        return page(repr(self), self)

    def _corners(self) -> int:
        """Corners of a face of its surfaces."""
        return 3 if self.elements.shape[1] in (4, 10) else 4

    def _moved(self) -> bool:
        """Whether nodes of the caller's arrays were dropped, so that numbers of nodes are no longer those of the caller."""
        given = self._core.numbering()
        return len(given) > 0 and bool(np.any(given < 0))

    def __getstate__(self) -> dict[str, Any]:
        solid = self._core.solid_state()
        if solid is not None:
            return {"solid": solid, "half": self.half, "numbering": self._core.numbering(), "notes": self.notes}
        pairs = self._core.region_tags()
        names = {tag: name for name, (tag, is_named) in zip(self.region_names, pairs, strict=True) if is_named}
        found = self._core.surfaces()
        corners = [corners for _, _, corners in found]
        surfaces = (
            np.concatenate([np.zeros(0, dtype=np.int64), *corners]),
            [tag for tag, _, corners in found for _ in range(len(corners) // self._corners())],
            {tag: name for tag, name, _ in found if name is not None},
        )
        tags = np.array([tag for tag, _ in pairs], dtype=np.int64)[self.regions]
        arrays = {"nodes": self.nodes, "elements": self.elements, "tags": tags, "numbering": self._core.numbering()}
        return {**arrays, "names": names, "half": self.half, "surfaces": surfaces, "notes": self.notes}

    def __setstate__(self, state: dict[str, Any]) -> None:
        if "solid" in state:
            nodes, elements, parts = state["solid"]
            core = _core.Mesh.of_solid_state(nodes, elements, parts, state["half"])
            self._core = core.noted(state["numbering"], state["notes"])
            return
        self._make(state["nodes"], state["elements"], state["tags"], (state["names"], state["half"]), state["surfaces"])
        self._core = self._core.noted(state["numbering"], state["notes"])

    def __repr__(self) -> str:
        nodes, elements = len(self.nodes), self.elements
        kind = {4: "tetrahedra", 8: "hexahedra", 10: "tetrahedra", 20: "hexahedra"}[elements.shape[1]]
        chambers = len(self.chambers)
        size = " × ".join(f"{1e3 * side:.4g}" for side in np.ptp(self.nodes, axis=0))
        return (
            f"Mesh({nodes} nodes, {len(elements)} {kind} of {elements.shape[1]}, {size} mm{', half' if self.half else ''}, "
            f"regions {self.region_names}, {chambers} chamber{'' if chambers == 1 else 's'})"
        )


def _names(given: Mapping[int, str] | None, tags: IntArray) -> dict[int, str]:
    """The names of tags: each of an element's tag, and each once."""
    names: dict[int, str] = {}
    present = set(np.unique(tags).tolist())
    if given is not None and not isinstance(given, Mapping):
        raise InputError(f"`names` is {given!r}", "it is a dictionary from tags to names", "correct it")
    for tag, name in (given or {}).items():
        key = whole("names", tag, -(1 << 62), 1 << 62)
        if not isinstance(name, str) or not name:
            raise InputError(f"`names` has {name!r} for the tag {key}", "a name is a text", "correct it")
        if key not in present:
            why = f"elements have the tags {', '.join(map(str, sorted(present)[:20]))}"
            raise InputError(f"`names` has the tag {key}", why, "leave it out, or correct the tag")
        names[key] = name
    all_names = [names.get(tag, f"region_{tag}") for tag in sorted(present)]
    twice = repeated(all_names)
    if twice is not None:
        raise InputError(f"`names` has `{twice}` for two tags", "materials are given by name", "give them one tag, or two names")
    return names


def _solid_kind(mesh: Any) -> str:
    """The one kind of solids of a mesh of meshio."""
    if not all(hasattr(mesh, part) for part in ("points", "cells", "cell_data")):
        raise InputError(f"`mesh` is a {type(mesh).__name__}", "it is a meshio.Mesh", "give what meshio.read returned")
    present = sorted({block.type for block in mesh.cells if len(block.data)})
    solids = [kind for kind in present if not kind.startswith(_FLAT)]
    found = ", ".join(present) or "no cells"
    known = ", ".join(_SOLIDS)
    if not solids:
        raise InputError("the mesh has no solid elements", f"it has {found}", f"give one of {known}")
    if len(solids) > 1 or solids[0] not in _SOLIDS:
        why = f"a body is meshed with one of {known}; none of its parts may be left out"
        raise InputError(f"the mesh has {', '.join(solids)}", why, "mesh the whole body with one kind of elements")
    return str(solids[0])


def _tags_of(mesh: Any, name: str | None) -> list[Any] | None:
    """The cell data with tags, block by block."""
    present = dict(mesh.cell_data)
    if name is not None:
        if name not in present:
            raise InputError(f"there are no cell data `{name}`", f"there are {', '.join(present) or 'none'}", "correct `tags`")
        return list(present[name])
    by_lower = {key.lower(): key for key in present}
    known = next((by_lower[key] for key in _TAGS if key in by_lower), None)
    return None if known is None else list(present[known])


def _physical_names(mesh: Any, dimension: int, tags: set[int]) -> dict[int, str]:
    pairs = {name: np.asarray(of).ravel() for name, of in dict(mesh.field_data or {}).items()}
    of_dimension = {int(of[0]): name for name, of in pairs.items() if len(of) == 2 and int(of[1]) == dimension}
    return {tag: name for tag, name in of_dimension.items() if tag in tags}


def _surfaces(mesh: Any, data: list[Any] | None, kind: str) -> tuple[IntArray, list[int], dict[int, str]] | None:
    """The faces of surfaces with their tags: triangles of tetrahedra, quadrilaterals of hexahedra."""
    if data is None:
        return None
    count, faces = (3, ("triangle", "triangle6")) if kind.startswith("tetra") else (4, ("quad", "quad8", "quad9"))
    blocks = [n for n, block in enumerate(mesh.cells) if block.type in faces and len(block.data)]
    if not blocks:
        return None
    corners = np.concatenate([np.asarray(mesh.cells[n].data)[:, :count].astype(np.int64).ravel() for n in blocks])
    tags = np.concatenate([np.asarray(data[n]) for n in blocks]).astype(np.int64).tolist()
    return corners, tags, _physical_names(mesh, 2, set(tags))
