"""Meshes and results for other packages, and as pictures in notebooks: pyvista, xarray, HTML."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._arrays import Array, IntArray, Sealed
from softfish._errors import InputError, MissingError
from softfish._optional import optional

if TYPE_CHECKING:
    from softfish._mesh import Mesh
    from softfish._solver import Solver

#: Types of cells of VTK by the number of nodes: tetrahedra and hexahedra of both orders, whose nodes are in its order.
_CELL_TYPES = {4: 10, 8: 12, 10: 24, 20: 25}
#: Triangles of a picture, above which it would take seconds.
_MOST_TRIANGLES = 40_000
#: Where a picture is seen from: to the right, up and towards the eye, in x, y and z.
_VIEW = np.array([[0.866, 0.0, -0.5], [-0.18, 0.933, -0.312], [0.466, 0.36, 0.808]])


def grid_of(mesh: Mesh, displacement: Array | None) -> Any:
    """The mesh at rest as a `pyvista.UnstructuredGrid`, with its regions and a displacement as data."""
    elements = mesh.elements
    grid = optional("pyvista").UnstructuredGrid({_CELL_TYPES[elements.shape[1]]: elements}, mesh.nodes)
    grid.cell_data["region"] = mesh.regions
    if displacement is not None:
        grid.point_data["displacement"] = displacement
    return grid


def _corners(mesh: Mesh, displacement: Array | None) -> tuple[Array, IntArray]:
    """The skin as it is seen: triangles × 3 × 3 from behind to front, and their numbers."""
    places = mesh.nodes if displacement is None else mesh.nodes + displacement
    seen = places[mesh.skin] @ _VIEW.T
    order = np.argsort(seen[:, :, 2].mean(axis=1))
    return seen[order], order


def picture(mesh: Mesh, displacement: Array | None = None) -> bytes | None:
    """The skin as a PNG, coloured by the size of a displacement; none without matplotlib, or of more triangles than are drawn at once."""
    try:
        figures, collections = optional("matplotlib.figure"), optional("matplotlib.collections")
    except MissingError:
        return None
    if len(mesh.skin) > _MOST_TRIANGLES:
        return None
    seen, order = _corners(mesh, displacement)
    normals = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
    facing = np.abs(normals[:, 2]) / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    sizes = np.zeros(len(seen)) if displacement is None else np.linalg.norm(displacement, axis=1)[mesh.skin[order]].mean(axis=1)
    colours = optional("matplotlib").colormaps["viridis"](sizes / max(float(sizes.max(initial=0.0)), 1e-300) if sizes.any() else sizes + 0.35)
    colours[:, :3] *= (0.45 + 0.55 * facing)[:, None]
    figure = figures.Figure(figsize=(4.0, 2.6), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.add_collection(collections.PolyCollection(1e3 * seen[:, :, :2], facecolors=colours, edgecolors=colours, linewidths=0.2))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return file.getvalue()


def page(text: str, mesh: Mesh, displacement: Array | None = None) -> str:
    """A text and a picture in HTML."""
    drawn = picture(mesh, displacement)
    image = "" if drawn is None else f'<img src="data:image/png;base64,{base64.b64encode(drawn).decode()}" alt="the skin"/>'
    largest = "" if displacement is None or drawn is None else f"<p>colour: 0 to {np.linalg.norm(displacement, axis=1).max(initial=0.0):.3g} m</p>"
    return f"<pre>{html.escape(text)}</pre>{image}{largest}"


class Result(Sealed):
    """Displacements of one shape of a body or of several, which other packages take.

    Attributes:
        displacement: nodes × 3, or shapes × nodes × 3, m.
    """

    _solver: Solver
    displacement: Array

    def __init__(self, *_: object, **__: object) -> None:
        """Refused: solvers make results."""
        kind = type(self).__name__
        raise InputError(f"a result of the kind {kind} is made by hand", "it is what a solve found", "call a method of a Solver")

    def to_pyvista(self) -> Any:
        """As a `pyvista.UnstructuredGrid` of the mesh at rest with the displacement (m) as point data, which `warp_by_vector` moves; of several
        shapes a `pyvista.MultiBlock` of them."""
        mesh = self._solver.mesh
        if self.displacement.ndim == 2:
            return grid_of(mesh, self.displacement)
        blocks = optional("pyvista").MultiBlock()
        for number, shape in enumerate(self.displacement):
            blocks.append(grid_of(mesh, shape), f"{number}")
        return blocks

    def to_xarray(self) -> Any:
        """As an `xarray.Dataset`: displacement, place at rest, and the other attributes by node, axis, chamber and shape, with units; the
        displacements of the case's points as variables of their own."""
        solver, lead = self._solver, self._lead()
        variables = {"displacement": ((*lead, "node", "axis"), self.displacement, {"units": "m"}), **self._variables()}
        for name in solver.points:
            variables[f"marker.{name}"] = ((*lead, "axis"), solver.observe(f"marker.{name}", self.displacement), {"units": "m"})
        coordinates = {"axis": list("xyz"), "chamber": solver.chambers, "place": (("node", "axis"), solver.mesh.nodes, {"units": "m"})}
        return optional("xarray").Dataset(variables, {**coordinates, **self._coordinates()}, {"description": repr(self)})

    def _lead(self) -> tuple[str, ...]:
        """The dimension of several shapes."""
        return ()

    def _variables(self) -> dict[str, Any]:
        """Further variables: dimensions, values and units."""
        return {}

    def _coordinates(self) -> dict[str, Any]:
        """Coordinates of the shapes."""
        return {}

    def _repr_html_(self) -> str:
        last = self.displacement if self.displacement.ndim == 2 else self.displacement[-1] if len(self.displacement) else None
        return page(repr(self), self._solver.mesh, last)
