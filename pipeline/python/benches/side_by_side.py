"""The same two bodies of 8-node hexahedra in softfish, torch-fem and scikit-fem: tip to ten digits, its derivative by Young's modulus, seconds of one core.

A cantilever and Cook's membrane (plane strain) of one neo-Hookean material, ψ = μ/2 (|F|² − 3) − μ ln J + λ/2 (ln J)², under dead nodal forces that
bend them far. Nodes, elements, forces, clamps and quadrature (2 × 2 × 2) are the same arrays. `just bench-python` runs it.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before what reads them

import meshio
import numpy as np
import numpy.typing as npt
import scipy.sparse.linalg
import skfem
import torch
import torchfem
from skfem.io.meshio import from_meshio
from torchfem.materials import Hyperelastic3D

import softfish as sf

Array = npt.NDArray[np.float64]
E, NU = 2e5, 0.4
REPEATS = 2
STEPS = 5  # equal load steps, which all three take
torch.set_default_dtype(torch.float64)
torch.set_num_threads(1)


@dataclass
class Problem:
    """A body under dead forces.

    Attributes:
        clamped: nodes × 3.
        forces: nodes × 3, N.
        tip: The node and the axis of the displacement that is compared.
    """

    mesh: sf.Mesh
    clamped: npt.NDArray[np.bool_]
    forces: Array
    tip: tuple[int, int]

    @classmethod
    def of(cls, nodes: Array, box: sf.Mesh, traction: list[float], is_plane: bool) -> Problem:
        """Clamped at the first nodes along x, with a traction (Pa) at the last."""
        mesh = sf.Mesh(nodes, box.elements)
        clamped = np.repeat(np.isclose(nodes[:, :1], 0.0), 3, axis=1)
        clamped[:, 2] |= is_plane
        end = box.nodes[:, 0].max()
        faces = [face for element in box.elements for face in [element[[1, 2, 6, 5]]] if np.allclose(box.nodes[face, 0], end)]
        forces = sf.Solver.of_mesh(mesh, sf.Material(E, NU), clamped).traction(np.array(faces), traction)
        return cls(mesh, clamped, np.where(clamped, 0.0, forces), (int(np.argmax(nodes @ [1.0, 1e-3, 1e-6])), 1))


def cantilever() -> Problem:
    """100 × 10 × 10 mm, bent by half its length."""
    box = sf.Mesh.box((0.1, 0.01, 0.01), (24, 2, 2), "hexahedra")
    return Problem.of(box.nodes, box, [0.0, 120.0, 0.0], False)


def membrane() -> Problem:
    """Cook's membrane: 48 mm wide, from 44 mm to 16 mm high, sheared upwards at its end."""
    box = sf.Mesh.box((0.048, 1.0, 0.002), (16, 16, 1), "hexahedra")
    x, y = box.nodes[:, 0] / 0.048, box.nodes[:, 1]
    nodes = box.nodes.copy()
    nodes[:, 1] = 0.044 * x + y * (0.044 - 0.028 * x)
    return Problem.of(nodes, box, [0.0, 1e4, 0.0], True)


#: The tip (m), its derivative by E (m/Pa), and the seconds of the solve and of the derivative.
Outcome = tuple[float, float, float, float]


def by_softfish(problem: Problem) -> Outcome:
    began = time.perf_counter()
    solver = sf.Solver.of_mesh(problem.mesh, sf.Material(E, NU), problem.clamped, threads=1)
    rest = solver.equilibrium(forces=problem.forces, load_steps=STEPS, tolerance=1e-12)
    solved = time.perf_counter()
    slope = np.zeros_like(rest.displacement)
    slope[problem.tip] = 1.0
    gradient = rest.adjoint(slope).youngs_modulus[0]
    return rest.displacement[problem.tip], gradient, solved - began, time.perf_counter() - solved


def by_torch_fem(problem: Problem) -> Outcome:
    def energy(F: torch.Tensor, parameters: torch.Tensor) -> torch.Tensor:
        modulus = parameters[0]
        mu, lame = modulus / (2.0 * (1.0 + NU)), modulus * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
        C = F.transpose(-1, -2) @ F
        log_J = 0.5 * torch.logdet(C)
        return 0.5 * mu * (torch.trace(C) - 3.0) - mu * log_J + 0.5 * lame * log_J**2

    began = time.perf_counter()
    modulus = torch.tensor([E], requires_grad=True)
    model = torchfem.Solid(torch.tensor(problem.mesh.nodes), torch.tensor(problem.mesh.elements), Hyperelastic3D(energy, modulus))
    model.constraints = torch.tensor(problem.clamped)
    model.forces = torch.tensor(problem.forces)
    displacement, *_ = model.solve(torch.linspace(0.0, 1.0, STEPS + 1), rtol=1e-9, atol=1e-12, max_iter=30, differentiable_parameters=modulus)
    solved = time.perf_counter()
    tip = displacement[problem.tip]
    (gradient,) = torch.autograd.grad(tip, modulus)
    return tip.item(), gradient.item(), solved - began, time.perf_counter() - solved


def by_scikit_fem(problem: Problem) -> Outcome:
    mu, lame = E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))

    def kinematics(u: Array) -> dict[str, skfem.DiscreteField]:
        """What the forms need of a displacement, once for all pairs of shape functions: F, F⁻ᵀ and ln J."""
        F = basis.interpolate(u).grad + np.eye(3)[:, :, None, None]
        per_point = np.moveaxis(F, (0, 1), (-2, -1))
        inverse = np.ascontiguousarray(np.moveaxis(np.linalg.inv(per_point), (-2, -1), (1, 0)))  # its transpose
        parts = {"F": F, "G": inverse, "log_J": np.log(np.linalg.det(per_point))}
        return {name: skfem.DiscreteField(part) for name, part in parts.items()}

    @skfem.LinearForm
    def residual(v, w):  # type: ignore[no-untyped-def]
        F, G, log_J = w["F"].value, w["G"].value, w["log_J"].value
        return np.einsum("ij...,ij...", mu * (F - G) + lame * log_J * G, v.grad)

    @skfem.BilinearForm
    def tangent(u, v, w):  # type: ignore[no-untyped-def]
        G, log_J = w["G"].value, w["log_J"].value
        H = np.einsum("ik...,kl...->il...", np.einsum("ij...,kj...->ik...", G, u.grad), G)
        return np.einsum("ij...,ij...", mu * u.grad + (mu - lame * log_J) * H + lame * np.einsum("ij...,ij...", G, u.grad) * G, v.grad)

    began = time.perf_counter()
    mesh = from_meshio(meshio.Mesh(problem.mesh.nodes, [("hexahedron", problem.mesh.elements)]))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=3)
    dofs = basis.nodal_dofs.T  # nodes × 3
    free, forces, u = dofs[~problem.clamped], np.zeros(basis.N), np.zeros(basis.N)
    for part in np.linspace(0.0, 1.0, STEPS + 1)[1:]:
        forces[dofs] = part * problem.forces
        for _ in range(30):
            unbalanced = (forces - residual.assemble(basis, **kinematics(u)))[free]
            if np.linalg.norm(unbalanced) < 1e-10 * np.linalg.norm(forces):
                break
            K = tangent.assemble(basis, **kinematics(u))[free][:, free].tocsc()
            u[free] += scipy.sparse.linalg.spsolve(K, unbalanced, "MMD_AT_PLUS_A")
    solved = time.perf_counter()
    slope = np.zeros(basis.N)
    slope[dofs[problem.tip]] = 1.0
    K = tangent.assemble(basis, **kinematics(u))[free][:, free].tocsc()
    # internal forces are proportional to E
    gradient = -scipy.sparse.linalg.spsolve(K, slope[free], "MMD_AT_PLUS_A") @ forces[free] / E
    return u[dofs[problem.tip]], gradient, solved - began, time.perf_counter() - solved


PACKAGES: dict[str, Callable[[Problem], Outcome]] = {"softfish": by_softfish, "torch-fem": by_torch_fem, "scikit-fem": by_scikit_fem}


def main() -> None:
    for name, problem in {"cantilever": cantilever(), "Cook's membrane": membrane()}.items():
        print(f"{name}: {len(problem.mesh.elements)} hexahedra, {int((~problem.clamped).sum())} dofs, {STEPS} load steps, best of {REPEATS}")
        print(f"  {'':12}{'tip, m':>16}{'∂tip/∂E, m/Pa':>20}{'solve, s':>10}{'gradient, s':>13}")
        tips = []
        for package, solve in PACKAGES.items():
            outcomes = [solve(problem) for _ in range(REPEATS)]
            tip, gradient = outcomes[0][:2]
            solving, deriving = (min(outcome[n] for outcome in outcomes) for n in (2, 3))
            print(f"  {package:12}{tip:16.10f}{gradient:20.10e}{solving:10.3f}{deriving:13.4f}", flush=True)
            tips.append((tip, gradient))
        spread = np.ptp(np.array(tips), axis=0) / np.abs(np.array(tips[0]))
        print(f"  largest difference: {spread[0]:.1e} of the tip, {spread[1]:.1e} of the derivative")
        assert spread[0] < 1e-8 and spread[1] < 1e-7, "the packages disagree"


if __name__ == "__main__":
    main()
