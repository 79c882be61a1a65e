"""The structural problem of the Mosaic benchmark [pasteurlabs2026]: `apply` and `vector_jacobian_product`.

Inputs and outputs are those of its structural solvers: `rho` (a density per element), `hex_mesh` (`points`, `faces`, `n_points`,
`n_faces`, padded), `boundary_conditions` (`dirichlet` and `neumann` with `mask` and `values`), and `E_max`, `nu`, `xmin`, `p_exp`
of the SIMP law E(ρ) = E_max [x + (1 − x) ρᵖ]. The output is the compliance C = fᵀu of linear elasticity on trilinear
hexahedra, in units of the caller. K is symmetric and f does not depend on ρ, so that ∂C/∂E = −uᵀ (∂K/∂E) u: the adjoint
solve finds λ = u with the factor of the forward solve.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from softfish._arrays import Array, IntArray, integers, number, reals, table, whole
from softfish._errors import InputError
from softfish._mesh import Mesh
from softfish._results import Equilibrium
from softfish._solver import Material, Solver

#: The six faces of a hexahedron.
_FACES = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [0, 3, 7, 4]])
#: Solvers that are kept: one for each mesh with its supports.
_KEPT = 4


@dataclass
class _Problem:
    """A mesh with its supports and loads, and the last result on it."""

    solver: Solver
    forces: Array
    last: tuple[bytes, Equilibrium] | None = None


_problems: OrderedDict[tuple[bytes, ...], _Problem] = OrderedDict()


def apply(inputs: Mapping[str, Any]) -> dict[str, Any]:
    """The compliance."""
    problem, moduli, _ = _given(inputs)
    found = _solve(problem, moduli)
    return {"compliance": np.float64(np.sum(problem.forces * found.displacement))}


def vector_jacobian_product(
    inputs: Mapping[str, Any], vjp_inputs: set[str], vjp_outputs: set[str], cotangent_vector: Mapping[str, Any]
) -> dict[str, Any]:
    """cotangent · ∂compliance/∂ρ."""
    asked = (_names("vjp_inputs", vjp_inputs), _names("vjp_outputs", vjp_outputs))
    if not asked[0] <= {"rho"} or not asked[1] <= {"compliance"}:
        why = "the compliance is differentiable by rho"
        raise InputError(f"asked for {sorted(asked[1])} by {sorted(asked[0])}", why, "ask for compliance by rho")
    if not vjp_inputs:
        return {}
    problem, moduli, slope = _given(inputs)
    by_density = np.zeros(np.shape(inputs["rho"]))
    if "compliance" in vjp_outputs:
        gradient = _solve(problem, moduli).adjoint(problem.forces)
        weight = number("cotangent_vector", table("cotangent_vector", cotangent_vector, ["compliance"])["compliance"])
        by_density[: slope.size] = weight * gradient.elements * slope
    return {"rho": by_density}


def abstract_eval(abstract_inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Shape and type of the output, which do not depend on the inputs."""
    table("abstract_inputs", abstract_inputs)
    return {"compliance": {"shape": (), "dtype": "float64"}}


def _given(inputs: Mapping[str, Any]) -> tuple[_Problem, Array, Array]:
    """The problem, the modulus of each element, and its derivative by the density."""
    points, cells, density = _arrays(table("inputs", inputs, ["rho", "hex_mesh", "boundary_conditions"]))
    bc = table("boundary_conditions", inputs["boundary_conditions"], ["dirichlet", "neumann"])
    for kind, keys in (("dirichlet", ["mask"]), ("neumann", ["mask", "values"])):
        table(kind, bc[kind], keys)
    nodes = len(points)
    stiffest, ratio = number("E_max", inputs.get("E_max", 70_000.0)), number("nu", inputs.get("nu", 0.3))
    least, exponent = number("xmin", inputs.get("xmin", 1e-3)), number("p_exp", inputs.get("p_exp", 3.0))
    inside = np.clip(density, 0.0, 1.0)
    moduli = stiffest * (least + (1.0 - least) * inside**exponent)
    slope = stiffest * (1.0 - least) * exponent * inside ** (exponent - 1.0) * (density == inside)
    held = _mask(bc["dirichlet"], nodes)
    if bc["dirichlet"].get("values") is not None and np.any(np.asarray(bc["dirichlet"]["values"]) != 0.0):
        raise InputError("a support is moved", "supports are held at zero displacement", "give loads instead")
    pulled = _mask(bc["neumann"], nodes)
    tractions = np.atleast_2d(reals("neumann values", bc["neumann"]["values"]))
    key = tuple(part.tobytes() for part in (points, cells, held, pulled, tractions, np.array([stiffest, ratio])))
    if key not in _problems:
        solver = Solver.of_mesh(Mesh(points, cells), Material(stiffest, ratio, law="linear"), held > 0)
        _problems[key] = _Problem(solver, _forces(solver, cells, pulled, tractions))
        while len(_problems) > _KEPT:
            _problems.popitem(last=False)
    _problems.move_to_end(key)
    return _problems[key], moduli, slope


def _arrays(inputs: Mapping[str, Any]) -> tuple[Array, IntArray, Array]:
    """Points, elements and densities, without what they are padded with."""
    mesh = table("hex_mesh", inputs["hex_mesh"], ["points", "faces", "n_points", "n_faces"])
    nodes, elements = (_count(name, mesh[name]) for name in ("n_points", "n_faces"))
    points = reals("points", mesh["points"])[:nodes]
    cells = integers("faces", mesh["faces"])[:elements]
    density = reals("rho", inputs["rho"])[:elements]
    if density.shape != (elements,) or points.shape != (nodes, 3) or cells.shape != (elements, 8):
        shapes = f"{density.shape}, {points.shape} and {cells.shape}"
        why = f"there are {elements} elements of 8 nodes, and {nodes} points of 3 numbers"
        raise InputError(f"`rho`, `points` and `faces` have the shapes {shapes}", why, "check their axes")
    return points, cells, density


def _count(name: str, value: Any) -> int:
    counts = integers(name, value)
    if counts.size != 1:
        raise InputError(f"`{name}` has the shape {counts.shape}", "it is one number", "pass one")
    return whole(name, counts.ravel()[0], 1, 1 << 30)


def _names(name: str, value: Any) -> set[str]:
    if isinstance(value, set | frozenset | list | tuple) and all(isinstance(one, str) for one in value):
        return set(value)
    raise InputError(f"`{name}` is {value!r}", "it is a set of names", "pass one")


def _mask(condition: Mapping[str, Any], nodes: int) -> IntArray:
    mask = integers("mask", condition["mask"])[:nodes]
    return np.concatenate([mask, np.zeros(nodes - len(mask), dtype=np.int64)])


def _forces(solver: Solver, cells: IntArray, mask: IntArray, tractions: Array) -> Array:
    """Consistent nodal forces of the tractions on the outer faces whose four nodes carry a group's number."""
    forces = np.zeros((int(mask.size), 3))
    faces = cells[:, _FACES].reshape(-1, 4)
    _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    outer = faces[first[counts == 1]]
    for group, traction in enumerate(tractions, start=1):
        chosen = outer[np.all(mask[outer] == group, axis=1)]
        if len(chosen):
            forces += solver.traction(chosen, traction)
    return forces


def _solve(problem: _Problem, moduli: Array) -> Equilibrium:
    key = moduli.tobytes()
    if problem.last is None or problem.last[0] != key:
        # One load step: the problem is linear.
        found = problem.solver.equilibrium(element_E=moduli, forces=problem.forces, load_steps=1)
        problem.last = (key, found)
    return problem.last[1]
