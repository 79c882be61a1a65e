"""Mosaic's structural problem: compliance against scikit-fem, gradient against central differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import softfish as sf
from softfish import mosaic


def cantilever(nx: int, ny: int = 2, nz: int | None = None, corner: bool = False, seed: int | None = None) -> dict[str, Any]:
    """A cantilever of 2 × 1 × 1 under a force of 1, on its whole end or on one element of it, and its densities."""
    cells = (nx, ny, nz or max(1, nx // 2))
    mesh = sf.Mesh.box((2.0, 1.0, 1.0), cells, "hexahedra")
    nodes, elements = mesh.nodes, mesh.elements
    pulled = nodes[:, 0] > 2.0 - 1e-9
    traction = [0.0, 0.0, -1.0]
    if corner:
        pulled &= (nodes[:, 1] < 1.0 / cells[1] + 1e-9) & (nodes[:, 2] < 1.0 / cells[2] + 1e-9)
        traction = [0.0, 0.0, float(cells[1] * cells[2])]
    density = np.full(len(elements), 0.5)
    if seed is not None:
        density = np.clip(0.5 + 0.3 * np.random.default_rng(seed).standard_normal(len(elements)), 0.05, 0.95)
    return {
        "rho": density,
        "hex_mesh": {"points": nodes, "faces": elements, "n_points": len(nodes), "n_faces": len(elements)},
        "boundary_conditions": {
            "dirichlet": {"mask": (nodes[:, 0] < 1e-9).astype(np.int32), "values": None},
            "neumann": {"mask": pulled.astype(np.int32), "values": [traction]},
        },
    }


def by_scikit_fem(inputs: dict[str, Any]) -> float:
    """The same compliance by scikit-fem, on the nodes and elements of the input."""
    fem = pytest.importorskip("skfem")
    from skfem.helpers import ddot, sym_grad, trace
    from skfem.models.elasticity import lame_parameters

    points, cells = inputs["hex_mesh"]["points"], inputs["hex_mesh"]["faces"]
    # scikit-fem's corners: 000, 001, 010, 100, 011, 101, 110, 111
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
    order = [int(np.flatnonzero((corners == c).all(axis=1))[0]) for c in fem.MeshHex().p.T.astype(int)]
    mesh = fem.MeshHex(np.ascontiguousarray(points.T), np.ascontiguousarray(cells[:, order].T))
    basis = fem.Basis(mesh, fem.ElementVector(fem.ElementHex1()), intorder=3)
    moduli = 70_000.0 * (1e-3 + (1.0 - 1e-3) * inputs["rho"] ** 3)
    by_point = basis.with_element(fem.ElementHex0()).interpolate(moduli)
    lam, mu = lame_parameters(1.0, 0.3)

    @fem.BilinearForm
    def stiffness(u, v, w):
        return w["E"] * (2.0 * mu * ddot(sym_grad(u), sym_grad(v)) + lam * trace(sym_grad(u)) * trace(sym_grad(v)))

    mask = inputs["boundary_conditions"]["neumann"]["mask"]
    end = mesh.facets_satisfying(lambda x: np.isclose(x[0], 2.0))
    pulled = end[np.all(mask[mesh.facets[:, end]] == 1, axis=0)]
    traction = inputs["boundary_conditions"]["neumann"]["values"][0]
    load = fem.LinearForm(lambda v, w: sum(t * v[axis] for axis, t in enumerate(traction)))
    f = load.assemble(fem.FacetBasis(mesh, fem.ElementVector(fem.ElementHex1()), facets=pulled, intorder=3))
    K = stiffness.assemble(basis, E=by_point)
    u = fem.solve(*fem.condense(K, f, D=basis.get_dofs(lambda x: np.isclose(x[0], 0.0))))
    return float(f @ u)


@pytest.mark.parametrize("given", [
    {"nx": 8, "nz": 4},
    {"nx": 8, "nz": 4, "seed": 0, "corner": True},
    {"nx": 16, "seed": 1},
    {"nx": 16, "ny": 8, "seed": 2},
])
def test_the_compliance_is_that_of_scikit_fem(given: dict[str, Any]) -> None:
    inputs = cantilever(**given)
    assert mosaic.apply(inputs)["compliance"] == pytest.approx(by_scikit_fem(inputs), rel=1e-6)


def test_the_gradient_is_that_of_central_differences() -> None:
    inputs = cantilever(8, nz=4, corner=True, seed=0)
    by = mosaic.vector_jacobian_product(inputs, {"rho"}, {"compliance"}, {"compliance": 1.0})["rho"]
    differences = np.zeros_like(by)
    for element in range(len(by)):
        at = []
        for sign in (1.0, -1.0):
            near = inputs["rho"].copy()
            near[element] += sign * 1e-4
            at.append(mosaic.apply({**inputs, "rho": near})["compliance"])
        differences[element] = (at[0] - at[1]) / 2e-4
    cosine = by @ differences / np.linalg.norm(by) / np.linalg.norm(differences)
    assert cosine > 1.0 - 1e-8 and np.allclose(by, differences, rtol=1e-4, atol=1e-6 * np.abs(by).max())


def test_what_is_padded_has_no_gradient_and_no_effect() -> None:
    inputs = cantilever(8, nz=4, seed=0)
    plain = mosaic.apply(inputs)["compliance"]
    padded = {**inputs, "rho": np.concatenate([inputs["rho"], np.ones(7)])}
    assert mosaic.apply(padded)["compliance"] == plain
    by = mosaic.vector_jacobian_product(padded, {"rho"}, {"compliance"}, {"compliance": 2.0})["rho"]
    assert np.all(by[-7:] == 0.0) and np.all(by[:-7] < 0.0)
