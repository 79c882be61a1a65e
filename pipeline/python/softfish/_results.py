"""Results: equilibria, motions and paths of one body, with their gradients, sensitivities and modes."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from softfish import _core, _records
from softfish._arguments import checked, checked_constructor
from softfish._arrays import Array, ByName, IntArray, copied, frozen, named, number, reals
from softfish._errors import DerivativeError, InputError
from softfish._export import Result

if TYPE_CHECKING:
    from softfish._solver import Solver

NONE: Array = np.zeros(0)


@checked_constructor
@dataclass(frozen=True)
class Inputs:
    """Everything that a solve depends on beside pressures, in full. Its arrays are read-only: `dataclasses.replace` makes others.

    Attributes:
        youngs_modulus: By region, Pa; of one that relaxes its long-term modulus, to which a case with `modulus_time` converts its own.
        poissons_ratio: By region, no unit.
        density: By region, kg/m³.
        factors: By element: its modulus over that of its region, no unit; empty: 1.
        forces: nodes × 3, N.
        gravity: x, y and z, m/s².
        level: The level at which pressures are taken from the case, where they are not given; no unit.
    """

    youngs_modulus: Array
    poissons_ratio: Array
    density: Array
    factors: Array
    forces: Array
    gravity: Array
    level: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            kept = number("level", value) if field.name == "level" else copied(reals(field.name, value))
            object.__setattr__(self, field.name, kept)

    def __reduce__(self) -> tuple[Any, ...]:
        return Inputs, tuple(getattr(self, field.name) for field in fields(self))

    def _core(self) -> _records.Inputs:
        return {
            "youngs_modulus": self.youngs_modulus,
            "poissons_ratio": self.poissons_ratio,
            "density": self.density,
            "factors": self.factors,
            "forces": self.forces.reshape(-1),
            "gravity": self.gravity,
        }


@dataclass(frozen=True)
class Gradient:
    """The derivatives of one number L by everything that a solve depends on; units are those of a number without one.

    Attributes:
        youngs_modulus: ∂L/∂E by region, 1/Pa.
        poissons_ratio: ∂L/∂ν by region, no unit.
        density: ∂L/∂ρ by region, per kg/m³.
        elements: ∂L/∂E by element, 1/Pa; empty of a motion where a region relaxes.
        pressures: ∂L/∂p: chambers, or steps × chambers of a motion, 1/Pa.
        forces: ∂L/∂f: nodes × 3, 1/N.
        mass_damping: ∂L/∂α of a motion, s.
        stiffness_damping: ∂L/∂β of a motion, 1/s.
        initial_displacement: By the initial displacement of a motion: nodes × 3, 1/m.
        initial_velocity: By the initial velocity of a motion: nodes × 3, s/m.
    """

    youngs_modulus: Array
    poissons_ratio: Array
    density: Array
    elements: Array
    pressures: Array
    forces: Array
    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    initial_displacement: Array | None = None
    initial_velocity: Array | None = None


class Equilibrium(Result):
    """A body at rest under its loads.

    Attributes:
        pressures: One per chamber of the mesh, Pa; read-only.
        displacement: nodes × 3, m; read-only.
        level: The level of the case: the part of all loads but gravity, no unit. 1 without a case.
        iterations: Newton iterations over all load steps.
        factorisations: Factorisations over all load steps.
        residual: Norm of the unbalanced force over that of the elastic force, no unit.
        snap_through: Load factors (no unit) at which tangents on the way were not positive definite; `path()` says whether equilibria are unstable.
    """

    pressures: Array
    displacement: Array
    level: float
    iterations: int
    factorisations: int
    residual: float
    snap_through: list[float]
    _inputs: Inputs

    @classmethod
    def _make(cls, solver: Solver, inputs: Inputs, found: _records.FoundEquilibrium) -> Equilibrium:
        self = cls.__new__(cls)
        self._solver = solver
        self._inputs = inputs
        self.pressures = frozen(found["pressures"])
        self.displacement = frozen(found["displacement"].reshape(-1, 3))
        self.level = inputs.level
        self.iterations = found["iterations"]
        self.factorisations = found["factorisations"]
        self.residual = found["residual"]
        self.snap_through = found["snap_through"]
        return self

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        frozen(self.pressures)
        frozen(self.displacement)

    def _at(self) -> tuple[Array, list[float]]:
        return self.displacement.reshape(-1), self.pressures.tolist()

    def _variables(self) -> dict[str, Any]:
        return {"pressure": (("chamber",), self.pressures, {"units": "Pa"}), "level": ((), self.level)}

    @checked()
    def output(self, name: str) -> Array:
        """The displacement (nodes × 3), or that of a point of the case: `marker.tip`, `node.tip` (3)."""
        return self._solver.observe(name, self.displacement)

    @checked()
    def adjoint(self, dloss_du: npt.ArrayLike) -> Gradient:
        """The gradient of a loss from its derivative by the displacement (nodes × 3), by one solve with the factor."""
        solver = self._solver
        slope = reals("dloss_du", dloss_du, self.displacement.shape)
        found = solver._core.equilibrium_gradient(self._inputs._core(), self._at(), slope.reshape(-1))
        return solver._gradient(self._inputs, found, self.pressures.shape)

    @checked()
    def sensitivity(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        pressure: ByName | None = None,
        element_E: npt.ArrayLike | None = None,
        forces: npt.ArrayLike | None = None,
    ) -> Array:
        """The derivative of the displacement (nodes × 3) along a direction: so much of each parameter, by one solve."""
        solver = self._solver
        zeros = np.zeros(len(solver.regions))
        no_pressure = np.zeros(len(self.pressures))
        factors, full = NONE, NONE
        if E is not None and (element_E is not None or self._inputs.factors.size):
            why = "moduli of elements take the place of those of the regions"
            raise InputError("`E` has no effect on this equilibrium", why, "give `element_E` alone")
        if element_E is not None:
            factors = reals("element_E", element_E, solver.element_regions.shape)
            factors = factors / self._inputs.youngs_modulus[solver.element_regions]
        if forces is not None:
            full = reals("forces", forces, self.displacement.shape).reshape(-1)
        direction: _records.Direction = {
            "youngs_modulus": named("region", solver.regions, zeros, E, "E").tolist(),
            "poissons_ratio": named("region", solver.regions, zeros, nu, "nu").tolist(),
            "density": named("region", solver.regions, zeros, density, "density").tolist(),
            "factors": factors,
            "pressures": solver._by_chamber(no_pressure, pressure, "pressure").tolist(),
            "forces": full,
        }
        changed = solver._core.equilibrium_sensitivity(self._inputs._core(), self._at(), direction)
        return changed.reshape(-1, 3)

    @checked()
    def modes(self, count: int = 6, *, timeout: float | None = None) -> tuple[Array, Array]:
        """The lowest natural frequencies (Hz) about it, and their shapes (count × nodes × 3) of unit modal mass. `timeout`: seconds of the call;
        raises `BudgetError` at it."""
        frequencies, shapes = self._solver._core.modes(self._inputs._core(), self._at(), (count, timeout))
        return np.array(frequencies), shapes.reshape(len(frequencies), -1, 3)

    @checked()
    def chamber(self, chamber: int | str) -> tuple[float, float]:
        """Volume (m³; of a half model, of the half) and gauge pressure (Pa) of a chamber."""
        index = self._solver._chamber(chamber)
        return self._solver._core.chamber_state(self._inputs._core(), self._at(), index)

    def elastic_energy(self) -> float:
        """J; of a half model, of the half."""
        return self._solver._core.elastic_energy(self._inputs._core(), self.displacement.reshape(-1))

    def __repr__(self) -> str:
        most = float(np.abs(self.displacement).max(initial=0.0))
        return (
            f"Equilibrium({len(self.displacement)} nodes, level {self.level:g}, moved {most:.3e} m at most, "
            f"{self.iterations} iterations, residual {self.residual:.1e})"
        )


class Motion(Result):
    """A recorded motion.

    Attributes:
        times: Time of each step's end, s; read-only.
        displacement: steps × nodes × 3, m; read-only.
        velocity: steps × nodes × 3, m/s; read-only.
        pressures: steps × chambers, Pa; read-only.
        start: The equilibrium in which it began, where the case says so; its gradient is part of the motion's.
    """

    times: Array
    displacement: Array
    velocity: Array
    pressures: Array
    start: Equilibrium | None
    _inputs: Inputs
    _problem: Problem
    _trajectory: _core.Trajectory | None

    @classmethod
    def _make(cls, solver: Solver, inputs: Inputs, problem: Problem, found: _records.FoundMotion) -> Motion:
        self, steps = cls.__new__(cls), len(found["times"])
        self._solver = solver
        self._inputs = inputs
        self._problem = problem
        self._trajectory = found.get("trajectory")
        self.start = problem.start
        self.times = frozen(found["times"])
        self.displacement = frozen(found["displacement"].reshape(steps, -1, 3))
        self.velocity = frozen(found["velocity"].reshape(steps, -1, 3))
        self.pressures = frozen(found.get("pressures", np.zeros((steps, 0))).reshape(steps, -1))
        return self

    def _recorded(self) -> _core.Trajectory:
        """The states as the gradient needs them; made again for a copy, and where steps were adaptive."""
        if self._trajectory is None:
            of = self._problem
            times = (of.initial, self.pressures.reshape(-1), self.times.tolist())
            self._trajectory = self._solver._core.record_at(self._inputs._core(), times, of.settings)
        return self._trajectory

    def _lead(self) -> tuple[str, ...]:
        return ("time",)

    def _variables(self) -> dict[str, Any]:
        velocity = (("time", "node", "axis"), self.velocity, {"units": "m/s"})
        return {"velocity": velocity, "pressure": (("time", "chamber"), self.pressures, {"units": "Pa"})}

    def _coordinates(self) -> dict[str, Any]:
        return {"time": (("time",), self.times, {"units": "s"})}

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_trajectory": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for array in (self.times, self.displacement, self.velocity, self.pressures):
            frozen(array)

    @checked()
    def output(self, name: str) -> Array:
        """The displacement (steps × nodes × 3), or that of a point of the case: `marker.tip`, `node.tip` (steps × 3)."""
        return self._solver.observe(name, self.displacement)

    @checked()
    def adjoint(self, dloss_du: npt.ArrayLike, dloss_dv: npt.ArrayLike | None = None) -> Gradient:
        """The gradient of a loss from its derivatives by displacement and velocity (steps × nodes × 3); of adaptive steps at the times that they
        took, which other parameters would change."""
        solver = self._solver
        by_u = reals("dloss_du", dloss_du, self.displacement.shape).reshape(-1)
        by_v = NONE if dloss_dv is None else reals("dloss_dv", dloss_dv, self.velocity.shape).reshape(-1)
        found = solver._core.trajectory_gradient(self._inputs._core(), self._recorded(), (by_u, by_v))
        gradient = solver._gradient(self._inputs, found, self.pressures.shape)
        if self.start is None or gradient.initial_displacement is None:
            return gradient
        # the start depends on all but the pressures of the steps
        began = self.start.adjoint(gradient.initial_displacement)
        names = ["youngs_modulus", "poissons_ratio", "density", "forces"]
        # of a motion that relaxes there is none by element
        names += ["elements"] if gradient.elements.size else []
        return replace(gradient, **{name: getattr(gradient, name) + getattr(began, name) for name in names})

    @checked()
    def sensitivity(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        pressure_gain: ByName | None = None,
    ) -> Array:
        """The derivative of the displacement (steps × nodes × 3) along a direction: so much of each parameter, and of a
        factor of each chamber's whole pressure history."""
        solver = self._solver
        if self.start is not None:
            why = "the equilibrium in which it began depends on the same parameters"
            raise DerivativeError("this motion has no forward sensitivities", why, "use adjoint, or give initial to simulate")
        zeros = np.zeros(len(solver.regions))
        gains = solver._by_chamber(np.zeros(solver.chamber_count), pressure_gain, "pressure_gain")
        pairs = (("E", E), ("nu", nu), ("density", density))
        parts = [named("region", solver.regions, zeros, given, name).tolist() for name, given in pairs]
        direction = (parts[0], parts[1], parts[2], gains.tolist())
        found = solver._core.trajectory_sensitivity(self._inputs._core(), self._recorded(), direction)
        return found.reshape(self.displacement.shape)

    def __repr__(self) -> str:
        steps, nodes, _ = self.displacement.shape
        return f"Motion({steps} steps to {self.times[-1]:.4g} s, {nodes} nodes, {self.pressures.shape[1]} chambers)"


@dataclass(frozen=True)
class Problem:
    """What a motion began with and how it was integrated.

    Attributes:
        initial: Displacement and velocity, 3 entries per node.
    """

    initial: tuple[Array, Array]
    settings: _records.DynamicSettings
    start: Equilibrium | None


@dataclass(frozen=True)
class CriticalPoint:
    """A point of a path at which stability is lost or won.

    Attributes:
        kind: `limit_point` or `bifurcation`.
        level: Its level, no unit.
        displacement: nodes × 3, m.
        mode: Its critical mode, nodes × 3, no unit.
    """

    kind: Literal["limit_point", "bifurcation"]
    level: float
    displacement: Array
    mode: Array


class Path(Result):
    """A path of equilibria from rest to the last level of a case, through limit points and bifurcations.

    Attributes:
        levels: Level of each point, no unit.
        displacement: points × nodes × 3, m.
        negative_eigenvalues: Number of those of the tangent of each point; 0 where it is stable.
        eigenvalues: The eigenvalue of each point's tangent that is nearest to zero, N/m.
        iterations: Newton iterations of each point.
        critical: The critical points on the way.
    """

    levels: Array
    displacement: Array
    negative_eigenvalues: IntArray
    eigenvalues: Array
    iterations: IntArray
    critical: list[CriticalPoint]
    _inputs: Inputs

    @classmethod
    def _make(cls, solver: Solver, inputs: Inputs, found: _records.FoundPath) -> Path:
        self, points = cls.__new__(cls), len(found["levels"])
        self._solver = solver
        self._inputs = inputs
        self.levels = frozen(found["levels"])
        self.displacement = frozen(found["displacement"].reshape(points, -1, 3))
        self.negative_eigenvalues = frozen(found["negative_eigenvalues"])
        self.eigenvalues = frozen(found["eigenvalues"])
        self.iterations = frozen(found["iterations"])
        self.critical = [
            CriticalPoint("limit_point" if is_limit else "bifurcation", level, at.reshape(-1, 3), mode.reshape(-1, 3))
            for is_limit, level, at, mode in found["critical"]
        ]
        return self

    @checked()
    def output(self, name: str) -> Array:
        """The displacement (points × nodes × 3), or that of a point of the case: `marker.tip`, `node.tip` (points × 3)."""
        return self._solver.observe(name, self.displacement)

    def _lead(self) -> tuple[str, ...]:
        return ("point",)

    def _variables(self) -> dict[str, Any]:
        eigenvalues = (("point",), self.eigenvalues, {"units": "N/m"})
        return {"eigenvalue": eigenvalues, "negative_eigenvalues": (("point",), self.negative_eigenvalues)}

    def _coordinates(self) -> dict[str, Any]:
        return {"level": (("point",), self.levels)}

    def __repr__(self) -> str:
        last = f"to level {self.levels[-1]:g}" if len(self.levels) else "without points"
        return f"Path({len(self.levels)} points {last}, {len(self.critical)} critical, {self.displacement.shape[1]} nodes)"
