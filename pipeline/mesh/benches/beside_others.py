"""Bodies with chambers meshed by softfish, gmsh, tetgen and fTetWild at one edge length: elements, angles, seconds, and the tip under pressure.

The tip is that of `study simulate` on each mesh in quadratic elements. `just bench-meshers` runs it.
"""

from __future__ import annotations

import contextlib
import csv
import resource
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import gmsh
import meshio
import numpy as np
import numpy.typing as npt
import pytetwild
import pyvista
import tetgen

Array = npt.NDArray[np.float64]
#: Points (m) and triangles, normals outwards.
Surface = tuple[Array, npt.NDArray[np.int64]]
#: Nodes (m) and tetrahedra of four corners.
Tetrahedra = tuple[Array, npt.NDArray[np.int64]]

STUDY = Path(sys.argv[1])
PRESSURE, MODULUS, RATIO = 2e3, 1e5, 0.45
#: Angle between triangles from which gmsh takes their edge for one of the body, rad.
CREASE = 0.7
#: Length of gmsh's edges over ours: it has one element through a wall of that length, where ours are sized by the wall; the shorter ones say how
#: far the longer ones are from their limit.
GMSH_EDGES = [0.4, 0.33]
#: Edges that take from some fifteen to some five hundred thousand elements, m.
GROWTH_EDGES = [4e-3, 1.8e-3, 1e-3, 0.72e-3]


@dataclass
class Body:
    """A skin around a chamber.

    Attributes:
        within: A point in the chamber, m.
        edge: Target length of the meshes' edges, m.
    """

    name: str
    skin: Surface
    chamber: Surface
    within: list[float]
    edge: float


def sheet(place: Callable[[Array, Array], Array], rows: int, columns: int) -> Surface:
    """A closed surface over poles and rings: place(polar, turn) for polar angles 0 to π and turns 0 to 2π."""
    polar = np.linspace(0.0, np.pi, rows + 1)[1:-1]
    turn = np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False)
    rings = place(*np.meshgrid(polar, turn, indexing="ij")).reshape(-1, 3)
    poles = place(np.array([0.0, np.pi]), np.zeros(2))
    number = np.arange(len(rings)).reshape(rows - 1, columns)
    after = np.roll(number, -1, axis=1)
    quads = [number[:-1], number[1:], after[1:], after[:-1]]
    halves = [np.stack([quads[0], quads[1], quads[2]], -1), np.stack([quads[0], quads[2], quads[3]], -1)]
    first, last = np.full(columns, len(rings)), np.full(columns, len(rings) + 1)
    caps = [np.stack([first, number[0], after[0]], -1), np.stack([last, after[-1], number[-1]], -1)]
    return np.vstack([rings, poles]), np.vstack([part.reshape(-1, 3) for part in halves + caps])


def ellipsoid(axes: list[float], tilt: float = 0.0) -> Surface:
    """Half axes in m, the first tilted about z (rad)."""
    c, s = np.cos(tilt), np.sin(tilt)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def place(polar: Array, turn: Array) -> Array:
        sphere = np.stack([np.cos(polar), np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn)], -1)
        return np.asarray((sphere * axes) @ turned.T)

    return sheet(place, 40, 48)


def bellows(offset: float) -> Surface:
    """A bellows 60 mm long with four folds, its surface moved inwards by an offset (m)."""

    def place(polar: Array, turn: Array) -> Array:
        x = (0.03 - offset) * np.cos(polar)
        radius = (0.011 - offset + 0.003 * np.cos(4.0 * 2.0 * np.pi * x / 0.06)) * np.sqrt(np.sin(polar))
        return np.stack([x, radius * np.cos(turn), radius * np.sin(turn)], -1)

    return sheet(place, 96, 40)


BODIES = [
    Body("slanted chamber", ellipsoid([0.03, 0.012, 0.012]), ellipsoid([0.02, 0.006, 0.007], 0.15), [0.0, 0.0, 0.0], 3e-3),
    Body("bellows", bellows(0.0), bellows(0.002), [0.0, 0.0, 0.0], 3e-3),
]


def written(surfaces: list[Surface], path: Path) -> Path:
    """Surfaces in one binary STL file, in mm."""
    triangles = np.concatenate([1e3 * points[faces] for points, faces in surfaces]).astype("<f4")
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["corners"] = triangles
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + rows.tobytes())
    return path


def turned(surface: Surface) -> Surface:
    """Normals the other way."""
    return surface[0], surface[1][:, ::-1]


def joined(body: Body) -> Surface:
    """Skin and chamber as one surface, normals out of the solid."""
    points = np.vstack([body.skin[0], body.chamber[0]])
    return points, np.vstack([body.skin[1], turned(body.chamber)[1] + len(body.skin[0])])


def by_softfish(body: Body, folder: Path) -> Path:
    """A mesh file of quadratic tetrahedra."""
    file, out = written([body.skin, turned(body.chamber)], folder / "body.stl"), folder / "softfish.msh"
    edge = f"{1e3 * body.edge}mm"
    subprocess.run([STUDY, "mesh", file, "--method", "general", "--edge", edge, "--out", out], check=True, capture_output=True)
    return out


def by_gmsh(body: Body, folder: Path, edge: float = GMSH_EDGES[0]) -> Path:
    """The same of gmsh's, on its own parametrisation of the triangles, with edges of so much of the body's."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for name, surface in [("skin", body.skin), ("chamber", body.chamber)]:
        gmsh.merge(str(written([surface], folder / f"{name}.stl")))
    gmsh.model.mesh.removeDuplicateNodes()
    gmsh.model.mesh.classifySurfaces(CREASE, True, True, np.pi)
    gmsh.model.mesh.createGeometry()
    surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
    length = {tag: np.subtract(*np.split(np.array(gmsh.model.getBoundingBox(2, tag)), 2)[::-1])[0] for tag in surfaces}
    longest = max(length.values())
    skin = [tag for tag in surfaces if length[tag] > 0.97 * longest]
    loops = [gmsh.model.geo.addSurfaceLoop(part) for part in (skin, [tag for tag in surfaces if tag not in skin])]
    gmsh.model.geo.addVolume(loops)
    gmsh.model.geo.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1e3 * edge * body.edge)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.5e3 * edge * body.edge)
    gmsh.option.setNumber("Mesh.Optimize", 1)
    gmsh.model.mesh.generate(3)
    # of curved elements of the triangles' parametrisation some are inverted
    gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="body")
    gmsh.write(str(folder / "gmsh.msh"))
    gmsh.finalize()
    return folder / "gmsh.msh"


def by_fine_gmsh(body: Body, folder: Path) -> Path:
    """The same with the shorter edges."""
    return by_gmsh(body, folder, GMSH_EDGES[1])


def by_tetgen(body: Body, folder: Path) -> Path:
    """Of four nodes; quadratic in `study simulate`, edges straight."""
    points, faces = joined(body)
    mesher = tetgen.TetGen(pyvista.PolyData(points, np.insert(faces, 0, 3, axis=1)))
    mesher.add_hole(body.within)
    mesher.tetrahedralize(order=1, mindihedral=10, minratio=1.5, maxvolume=body.edge**3 / 8.5, fixedvolume=True)
    nodes, tets = mesher.node, mesher.elem
    return tetrahedra_file((np.asarray(nodes), np.asarray(tets)), folder / "tetgen.vtu")


def by_ftetwild(body: Body, folder: Path) -> Path:
    """As tetgen's."""
    points, faces = joined(body)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    with contextlib.chdir(folder):  # where it writes a surface of its own
        nodes, tets = pytetwild.tetrahedralize(points, faces.astype(np.int32), edge_length_fac=body.edge / diagonal)[:2]
    return tetrahedra_file((nodes, tets), folder / "ftetwild.vtu")


def tetrahedra_file(mesh: Tetrahedra, path: Path) -> Path:
    """Corners in mm, volumes positive."""
    nodes, tets = mesh
    a, b, c, d = (nodes[tets[:, k]] for k in range(4))
    inverted = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0.0
    tets = np.where(inverted[:, None], tets[:, [0, 2, 1, 3]], tets)
    meshio.Mesh(1e3 * nodes, [("tetra", tets)]).write(path)
    return path


def dihedral_angles(path: Path) -> Array:
    """Of each tetrahedron, by its corners, degrees: tetrahedra × 6."""
    mesh = meshio.read(path)
    tets = np.vstack([block.data[:, :4] for block in mesh.cells if block.type in ("tetra", "tetra10")])
    corners = mesh.points[tets]
    normals = []
    for face in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]):
        a, b, c = (corners[:, k] for k in face)
        normal = np.cross(b - a, c - a)
        normals.append(normal / np.linalg.norm(normal, axis=1, keepdims=True))
    pairs = [(i, j) for i in range(4) for j in range(i)]
    cosines = np.stack([-np.einsum("ij,ij->i", normals[i], normals[j]) for i, j in pairs], -1)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0))))


def tip(body: Body, mesh: Path) -> float:
    """How far the free end moves under pressure, m."""
    low, high = body.skin[0].min(axis=0), body.skin[0].max(axis=0)
    held = np.array([low[0] + 0.15 * (high[0] - low[0]), *(high[1:] + 1e-3)])
    case = mesh.with_name(f"{mesh.stem}.toml")
    case.write_text(f"""
[mesh]
file = "{mesh.name}"
unit = "{"m" if mesh.stem == "softfish" else "mm"}"
order = "quadratic"
[[region]]
{'name = "body"' if mesh.stem == "gmsh" else ""}
material = "neo_hookean"
youngs_modulus = {MODULUS}
poissons_ratio = {RATIO}
density = 1000.0
[[clamp]]
box = {{ low = {(low - 1e-3).tolist()}, high = {held.tolist()} }}
[[chamber]]
name = "air"
inside = {body.within}
pressure = {PRESSURE}
[static]
levels = [0.5, 1.0]
[output]
vtu_every = 0
marker = [{{ name = "tip", at = [{high[0]}, 0.0, 0.0] }}]
""")
    subprocess.run([STUDY, "simulate", case, "--quiet"], check=True, capture_output=True)
    with (mesh.parent / f"{mesh.stem}.out" / f"{mesh.stem}.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    return float(np.linalg.norm([float(value) for key, value in last.items() if key.startswith("tip_u")]))


def processor_seconds() -> float:
    """Of this process and those that it waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


def print_growth() -> None:
    """Seconds and memory of ours over a decade and a half of elements."""
    body = BODIES[0]
    print(f"\n{'edge mm':>8}{'elements':>10}{'CPU s':>8}{'µs an element':>15}{'MB':>7}")
    for edge in GROWTH_EDGES:
        with tempfile.TemporaryDirectory() as scratch:
            began = processor_seconds()
            mesh = by_softfish(replace(body, edge=edge), Path(scratch))
            seconds, elements = processor_seconds() - began, len(dihedral_angles(mesh))
        # the largest of all children until now: edges grow shorter
        memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
        print(f"{1e3 * edge:>8.2f}{elements:>10}{seconds:>8.1f}{1e6 * seconds / elements:>15.0f}{memory:>7.0f}", flush=True)


def main() -> None:
    """Prints a row for each body and mesher."""
    print_growth()
    print(f"{'body':<18}{'mesher':<10}{'elements':>9}{'least °':>9}{'0.1 % °':>9}{'CPU s':>8}{'tip mm':>9}{'of ours':>9}")
    for body in BODIES:
        with tempfile.TemporaryDirectory() as scratch:
            ours = 0.0
            for mesher in (by_softfish, by_gmsh, by_fine_gmsh, by_tetgen, by_ftetwild):
                name, began = mesher.__name__.removeprefix("by_"), processor_seconds()
                try:
                    mesh = mesher(body, Path(scratch))
                    seconds, angles = processor_seconds() - began, dihedral_angles(mesh).min(axis=1)
                    moved = tip(body, mesh)
                except (Exception, subprocess.CalledProcessError) as why:  # another's mesher may refuse in any way
                    print(f"{body.name:<18}{name:<10}  {getattr(why, 'stderr', why)}")
                    continue
                ours = ours or moved
                least, usual = angles.min(), np.quantile(angles, 1e-3)
                row = f"{len(angles):>9}{least:>9.2f}{usual:>9.2f}{seconds:>8.1f}{1e3 * moved:>9.4f}{moved / ours:>9.4f}"
                print(f"{body.name:<18}{name:<10}{row}", flush=True)


main()
