"""Solvers: equilibria and motions of one body, their gradients, sensitivities and modes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from softfish import _core, _records
from softfish._arrays import Array, ByName, IntArray, frozen, integers, named, number, reals, whole
from softfish._case import Case
from softfish._errors import InputError
from softfish._mesh import Mesh

if TYPE_CHECKING:
    from softfish._jax import JaxFunction
    from softfish._reduced import ReducedModel
    from softfish._torch import TorchFunction

Scheme = Literal["bdf2", "implicit_euler", "quasi_static"]
Progress = Callable[[int, int], object]
_NONE: Array = np.zeros(0)
_SCHEMES: dict[str, Scheme] = {"Bdf2": "bdf2", "ImplicitEuler": "implicit_euler", "QuasiStatic": "quasi_static"}


@dataclass(frozen=True)
class Inputs:
    """Everything that a solve depends on beside pressures, in full."""

    #: By region, Pa.
    youngs_modulus: Array
    #: By region.
    poissons_ratio: Array
    #: By region, kg/m³.
    density: Array
    #: By element: its modulus over that of its region; empty: 1.
    factors: Array
    #: nodes × 3, N.
    forces: Array
    #: m/s².
    gravity: Array

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
    """The derivatives of one number L by everything that a solve depends on."""

    #: ∂L/∂E by region, 1/Pa.
    youngs_modulus: Array
    #: ∂L/∂ν by region.
    poissons_ratio: Array
    #: ∂L/∂ρ by region, per kg/m³.
    density: Array
    #: ∂L/∂E by element, 1/Pa; empty where a region relaxes.
    elements: Array
    #: ∂L/∂p: chambers, or steps × chambers of a motion, 1/Pa.
    pressures: Array
    #: ∂L/∂f: nodes × 3, 1/N.
    forces: Array
    #: ∂L/∂α of a motion, s.
    mass_damping: float = 0.0
    #: ∂L/∂β of a motion, 1/s.
    stiffness_damping: float = 0.0
    #: By the initial displacement of a motion: nodes × 3, 1/m.
    initial_displacement: Array | None = None
    #: By the initial velocity of a motion: nodes × 3, s/m.
    initial_velocity: Array | None = None


class Equilibrium:
    """A body at rest under its loads."""

    def __init__(self, solver: Solver, inputs: Inputs, pressures: Array, found: _records.FoundEquilibrium) -> None:
        self._solver = solver
        self._inputs = inputs
        #: One per chamber of the mesh, Pa.
        self.pressures: Array = frozen(pressures)
        #: nodes × 3, m; read-only.
        self.displacement: Array = frozen(found["displacement"].reshape(-1, 3))
        #: Newton iterations over all load steps.
        self.iterations: int = found["iterations"]
        #: Factorisations over all load steps.
        self.factorisations: int = found["factorisations"]
        #: Norm of the unbalanced force over that of the elastic force.
        self.residual: float = found["residual"]
        #: Load factors at which the body snapped through.
        self.snap_through: list[float] = found["snap_through"]

    def _at(self) -> tuple[Array, list[float]]:
        return self.displacement.reshape(-1), self.pressures.tolist()

    def output(self, name: str) -> Array:
        """The displacement (nodes × 3), or that of a point of the case: `marker.tip`, `node.tip` (3)."""
        return self._solver.observe(name, self.displacement)

    def adjoint(self, dloss_du: npt.ArrayLike) -> Gradient:
        """The gradient of a loss from its derivative by the displacement (nodes × 3), by one solve with the factor."""
        solver = self._solver
        slope = reals("dloss_du", dloss_du, self.displacement.shape)
        found = solver._core.equilibrium_gradient(self._inputs._core(), self._at(), slope.reshape(-1))
        return solver._gradient(self._inputs, found, self.pressures.shape)

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
        factors, full = _NONE, _NONE
        if element_E is not None:
            factors = reals("element_E", element_E, solver.element_regions.shape)
            factors = factors / self._inputs.youngs_modulus[solver.element_regions]
        if forces is not None:
            full = reals("forces", forces, self.displacement.shape).reshape(-1)
        direction: _records.Direction = {
            "youngs_modulus": named("region", solver.regions, zeros, E).tolist(),
            "poissons_ratio": named("region", solver.regions, zeros, nu).tolist(),
            "density": named("region", solver.regions, zeros, density).tolist(),
            "factors": factors,
            "pressures": solver._by_chamber(no_pressure, pressure).tolist(),
            "forces": full,
        }
        changed = solver._core.equilibrium_sensitivity(self._inputs._core(), self._at(), direction)
        return changed.reshape(-1, 3)

    def modes(self, count: int = 6) -> tuple[Array, Array]:
        """The lowest natural frequencies (Hz) about it, and their shapes (count × nodes × 3) of unit modal mass."""
        frequencies, shapes = self._solver._core.modes(self._inputs._core(), self._at(), int(count))
        return np.array(frequencies), shapes.reshape(len(frequencies), -1, 3)

    def chamber(self, chamber: int | str) -> tuple[float, float]:
        """Volume (m³; of a half model, of the half) and gauge pressure (Pa) of a chamber."""
        index = self._solver._chamber(chamber)
        return self._solver._core.chamber_state(self._inputs._core(), self._at(), index)

    def elastic_energy(self) -> float:
        """J; of a half model, of the half."""
        return self._solver._core.elastic_energy(self._inputs._core(), self.displacement.reshape(-1))

    def __repr__(self) -> str:
        most = float(np.abs(self.displacement).max(initial=0.0))
        return f"Equilibrium({len(self.displacement)} nodes, moved {most:.3e} m at most, {self.iterations} iterations)"


class Motion:
    """A recorded motion."""

    def __init__(self, solver: Solver, inputs: Inputs, pressures: Array, found: _records.FoundMotion) -> None:
        steps = len(found["times"])
        self._solver = solver
        self._inputs = inputs
        self._trajectory = found["trajectory"]
        #: Time of each step's end, s.
        self.times: Array = frozen(found["times"])
        #: steps × nodes × 3, m; read-only.
        self.displacement: Array = frozen(found["displacement"].reshape(steps, -1, 3))
        #: steps × nodes × 3, m/s; read-only.
        self.velocity: Array = frozen(found["velocity"].reshape(steps, -1, 3))
        #: steps × chambers, Pa.
        self.pressures: Array = frozen(pressures)

    def output(self, name: str) -> Array:
        """The displacement (steps × nodes × 3), or that of a point of the case: `marker.tip`, `node.tip` (steps × 3)."""
        return self._solver.observe(name, self.displacement)

    def adjoint(self, dloss_du: npt.ArrayLike, dloss_dv: npt.ArrayLike | None = None) -> Gradient:
        """The gradient of a loss from its derivatives by displacement and velocity (steps × nodes × 3)."""
        solver = self._solver
        by_u = reals("dloss_du", dloss_du, self.displacement.shape).reshape(-1)
        by_v = _NONE if dloss_dv is None else reals("dloss_dv", dloss_dv, self.velocity.shape).reshape(-1)
        found = solver._core.trajectory_gradient(self._inputs._core(), self._trajectory, (by_u, by_v))
        return solver._gradient(self._inputs, found, self.pressures.shape)

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
        zeros = np.zeros(len(solver.regions))
        gains = solver._by_chamber(np.zeros(solver.chamber_count), pressure_gain)
        parts = [named("region", solver.regions, zeros, given).tolist() for given in (E, nu, density)]
        direction = (parts[0], parts[1], parts[2], gains.tolist())
        found = solver._core.trajectory_sensitivity(self._inputs._core(), self._trajectory, direction)
        return found.reshape(self.displacement.shape)

    def __repr__(self) -> str:
        steps, nodes, _ = self.displacement.shape
        return f"Motion({steps} steps to {self.times[-1]:.4g} s, {nodes} nodes)"


@dataclass(frozen=True)
class Material:
    """What a region is made of."""

    #: Pa.
    youngs_modulus: float
    #: Below 0.5.
    poissons_ratio: float
    #: kg/m³.
    density: float = 1000.0
    #: `neo_hookean`, `yeoh`, `linear`, …: `softfish.MATERIALS`.
    law: str = "neo_hookean"
    #: Against volumetric locking.
    mean_dilatation: bool = False


class Solver:
    """Solves one body. It keeps its factor, so that a solve near the last one, and every gradient, reuse it.

    Each solve takes its inputs in full: what is not given is that of the case. Results do not depend on the solves
    before, but for their tolerance. Each thread needs a solver of its own.
    """

    def __init__(self, case: Case, *, threads: int | None = None) -> None:
        """Of a case. One solve uses all processors, unless `threads` of its own are given: solvers that solve at the same time on as many
        threads of Python are fastest with one each."""
        self._start(_core.Solver.of_case(case._core, case.mesh._core, _threads(threads)), case.mesh)

    @classmethod
    def of_mesh(
        cls,
        mesh: Mesh,
        materials: Material | Mapping[str, Material],
        clamped: npt.ArrayLike,
        *,
        lumped_mass: bool = False,
        threads: int | None = None,
    ) -> Solver:
        """Of a mesh, the material of each region, and the `clamped` nodes: node numbers, one truth value per node, or
        nodes × 3 truth values; `threads` as for a case."""
        regions = mesh.region_names
        by_name = {name: materials for name in regions} if isinstance(materials, Material) else dict(materials)
        if set(by_name) != set(regions):
            why = f"the mesh has the regions {', '.join(regions)}"
            raise InputError(f"materials are given for {', '.join(by_name)}", why, "give one material for each region")
        of = [by_name[name] for name in regions]
        given: _records.Materials = {
            "law": [one.law for one in of],
            "youngs_modulus": [number("youngs_modulus", one.youngs_modulus) for one in of],
            "poissons_ratio": [number("poissons_ratio", one.poissons_ratio) for one in of],
            "density": [number("density", one.density) for one in of],
            "mean_dilatation": [bool(one.mean_dilatation) for one in of],
            "lumped_mass": bool(lumped_mass),
        }
        solver = cls.__new__(cls)
        held = _axes(clamped, len(mesh.nodes))
        solver._start(_core.Solver.of_mesh(mesh._core, given, (held, _threads(threads))), mesh)
        return solver

    def _start(self, core: _core.Solver, mesh: Mesh) -> None:
        self._core = core
        #: The mesh at rest.
        self.mesh = mesh
        #: Names of the regions.
        self.regions: list[str] = mesh.region_names
        self.dofs, self._nodes, self._elements, self.chamber_count = core.sizes()
        #: The region of each element.
        self.element_regions: IntArray = core.element_regions()
        data = core.case_data()
        self._data: _records.CaseData | None = data
        properties = core.properties()
        shape = (self._nodes, 3)
        self._base = Inputs(
            youngs_modulus=np.array([of[1] for of in properties]),
            poissons_ratio=np.array([of[2] for of in properties]),
            density=np.array([of[3] for of in properties]),
            factors=_NONE,
            forces=np.zeros(shape) if data is None else data["forces"].reshape(shape),
            gravity=np.zeros(3) if data is None else data["gravity"],
        )
        names = [f"chamber_{n}" for n in range(self.chamber_count)]
        for name, index in [] if data is None else data["chambers"]:
            names[index] = name
        #: Names of the chambers of the mesh.
        self.chambers: list[str] = names
        points = [] if data is None else data["points"]
        self._points: dict[str, tuple[IntArray, Array]] = {name: (nodes, weights) for name, nodes, weights in points}

    @property
    def base(self) -> Inputs:
        """The inputs of the case."""
        return self._base

    @property
    def points(self) -> list[str]:
        """Names of the points of the case's output."""
        return list(self._points)

    @property
    def notes(self) -> list[str]:
        """What was noticed when the case was read."""
        return [] if self._data is None else self._data["notes"]

    def inputs(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        element_E: npt.ArrayLike | None = None,
        forces: npt.ArrayLike | None = None,
        gravity: npt.ArrayLike | None = None,
    ) -> Inputs:
        """The inputs of a solve: those of the case, with what is given in their place.

        `E` (Pa), `nu` and `density` (kg/m³): a dictionary by region, a list, or a number where there is one region.
        `element_E`: one modulus per element, Pa. `forces`: nodes × 3, N, in the place of the case's.
        """
        moduli = named("region", self.regions, self._base.youngs_modulus, E)
        factors = _NONE
        if element_E is not None:
            given = reals("element_E", element_E, self.element_regions.shape)
            factors = given / moduli[self.element_regions]
        return Inputs(
            youngs_modulus=moduli,
            poissons_ratio=named("region", self.regions, self._base.poissons_ratio, nu),
            density=named("region", self.regions, self._base.density, density),
            factors=factors,
            forces=self._base.forces if forces is None else reals("forces", forces, (self._nodes, 3)).copy(),
            gravity=self._base.gravity if gravity is None else reals("gravity", gravity, (3,)).copy(),
        )

    def equilibrium(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        pressure: ByName | None = None,
        element_E: npt.ArrayLike | None = None,
        forces: npt.ArrayLike | None = None,
        gravity: npt.ArrayLike | None = None,
        inputs: Inputs | None = None,
        initial_guess: npt.ArrayLike | None = None,
        tolerance: float | None = None,
        load_steps: int | None = None,
        reuse_factor: bool = False,
        level: float = 1.0,
    ) -> Equilibrium:
        """The equilibrium under all loads.

        `pressure` (Pa): by chamber; what is not given is the case's at its `level`. `initial_guess`: a nearby
        displacement (nodes × 3). `tolerance`: of the last step, in sizes of the body. Raises `ConvergenceError`.
        """
        if inputs is None:
            inputs = self.inputs(E, nu, density, element_E=element_E, forces=forces, gravity=gravity)
        base = self._core.case_pressures([], number("level", level))
        pressures = self._by_chamber(base, pressure)
        guess = None
        if initial_guess is not None:
            guess = reals("initial_guess", initial_guess, (self._nodes, 3)).reshape(-1)
        settings = self._static_settings(tolerance, load_steps, reuse_factor)
        found = self._core.equilibrium(inputs._core(), pressures.tolist(), (guess, settings))
        return Equilibrium(self, inputs, pressures, found)

    def simulate(
        self,
        steps: int | None = None,
        step: float | None = None,
        *,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        pressure: npt.ArrayLike | Mapping[str, Any] | None = None,
        element_E: npt.ArrayLike | None = None,
        forces: npt.ArrayLike | None = None,
        gravity: npt.ArrayLike | None = None,
        inputs: Inputs | None = None,
        initial: tuple[npt.ArrayLike, npt.ArrayLike] | Equilibrium | None = None,
        scheme: Scheme | None = None,
        mass_damping: float | None = None,
        stiffness_damping: float | None = None,
        tolerance: float = 1e-6,
        memory: int = 1 << 31,
        progress: Progress | bool | None = None,
    ) -> Motion:
        """A motion of `steps` steps of `step` seconds; what is not given is the case's.

        `pressure` (Pa): steps × chambers, or by chamber a number or one per step. `initial`: displacement and velocity
        (nodes × 3 each), or an equilibrium. `progress`: called with the steps done and all steps, or `True` for tqdm.
        `memory`: bytes of states that the gradient may keep; beyond it they are computed again. Raises `ConvergenceError`.
        """
        if inputs is None:
            inputs = self.inputs(E, nu, density, element_E=element_E, forces=forces, gravity=gravity)
        given = self._dynamic_settings(step, scheme, mass_damping, stiffness_damping, (tolerance, memory))
        count = self._steps(steps, given["step"])
        pressures = self._history(count, given["step"], pressure)
        shape = (self._nodes, 3)
        if isinstance(initial, Equilibrium):
            initial = (initial.displacement, np.zeros(shape))
        first = (np.zeros(shape), np.zeros(shape)) if initial is None else initial
        start = (reals("initial displacement", first[0], shape).reshape(-1), reals("initial velocity", first[1], shape).reshape(-1))
        with _Progress(progress, count) as report:
            found = self._core.record(inputs._core(), (start, pressures.reshape(-1), count), (given, report))
        return Motion(self, inputs, pressures, found)

    def adjoint(self, at: Equilibrium | Motion, dloss_du: npt.ArrayLike) -> Gradient:
        """The gradient of a loss of a result, from its derivative by the displacement."""
        return at.adjoint(dloss_du)

    def sensitivity(self, at: Equilibrium | Motion, **direction: Any) -> Array:
        """The derivative of a result's displacement along a direction of its parameters."""
        return at.sensitivity(**direction)

    def modes(self, count: int = 6, at: Equilibrium | None = None) -> tuple[Array, Array]:
        """Natural frequencies (Hz) and shapes (count × nodes × 3) about an equilibrium; without one, about that of the
        case."""
        return (self.equilibrium() if at is None else at).modes(count)

    def traction(self, faces: npt.ArrayLike, traction: npt.ArrayLike) -> Array:
        """Nodal forces (nodes × 3, N) of a traction (Pa) over faces × 3, 4 or 6 nodes."""
        nodes = integers("faces", faces)
        if nodes.ndim != 2 or nodes.shape[1] not in (3, 4, 6):
            raise InputError(f"`faces` has the shape {nodes.shape}", "it is faces × 3, 4 or 6", "check its axes")
        vector = reals("traction", traction, (3,))
        along = (float(vector[0]), float(vector[1]), float(vector[2]))
        return self._core.traction_forces(nodes.reshape(-1), int(nodes.shape[1]), along).reshape(-1, 3)

    def torch(self, output: str, wrt: Sequence[str], **settings: Any) -> TorchFunction:
        """The output as a differentiable function of PyTorch, see `softfish.TorchFunction`."""
        from softfish._torch import TorchFunction

        return TorchFunction(self, output, wrt, **settings)

    def jax(self, output: str, wrt: Sequence[str], **settings: Any) -> JaxFunction:
        """The output as a differentiable function of JAX, see `softfish.JaxFunction`."""
        from softfish._jax import JaxFunction

        return JaxFunction(self, output, wrt, **settings)

    def reduce(self, snapshots: npt.ArrayLike, coordinates: int = 20, *, tolerance: float = 1e-3) -> ReducedModel:
        """The body in at most `coordinates` modes of displacements (snapshots × nodes × 3) that it took."""
        from softfish._reduced import ReducedModel

        return ReducedModel.of(self, snapshots, coordinates, tolerance)

    def _static_settings(self, tolerance: float | None, load_steps: int | None, reuse: bool) -> _records.StaticSettings:
        data = self._data
        fine = 1e-8 if data is None else data.get("tolerance", 1e-8)
        fine = fine if tolerance is None else number("tolerance", tolerance)
        steps = 3 if data is None else data.get("load_steps", 3)
        steps = steps if load_steps is None else int(load_steps)
        if not 1 <= steps <= 10_000:
            raise InputError(f"load_steps is {steps}", "it lies between 1 and 10000", "correct it")
        return {"tolerance": float(fine), "load_steps": int(steps), "reuse_factor": bool(reuse)}

    def _dynamic_settings(
        self,
        step: float | None,
        scheme: Scheme | None,
        mass_damping: float | None,
        stiffness_damping: float | None,
        limits: tuple[float, int],
    ) -> _records.DynamicSettings:
        set_by_case: Mapping[str, Any] = {} if self._data is None else self._data.get("dynamic", {})
        length = set_by_case.get("step") if step is None else number("step", step)
        if length is None:
            raise InputError("`step` is not given", "the case has no [dynamic] with a step", "give it in seconds")
        known = _SCHEMES.get(set_by_case.get("scheme", ""), "bdf2")
        alpha = set_by_case.get("mass_damping", 0.0) if mass_damping is None else number("mass_damping", mass_damping)
        beta = set_by_case.get("stiffness_damping", 0.0)
        beta = beta if stiffness_damping is None else number("stiffness_damping", stiffness_damping)
        return {
            "step": float(length),
            "scheme": known if scheme is None else scheme,
            "mass_damping": float(alpha),
            "stiffness_damping": float(beta),
            "tolerance": number("tolerance", limits[0]),
            "memory": int(limits[1]),
        }

    def _steps(self, steps: int | None, step: float) -> int:
        dynamic = None if self._data is None else self._data.get("dynamic")
        if steps is None and dynamic is not None:
            steps = round(dynamic["duration"] / step)
        if steps is None or not 1 <= int(steps) <= 10_000_000:
            raise InputError(f"steps is {steps}", "a motion has between 1 and 10 million steps", "give their number")
        return int(steps)

    def _history(self, steps: int, step: float, given: npt.ArrayLike | Mapping[str, Any] | None) -> Array:
        shape = (steps, self.chamber_count)
        times = step * np.arange(1, steps + 1)
        history = self._core.case_pressures(times.tolist(), None).reshape(shape)
        if given is None:
            return history
        if not isinstance(given, Mapping):
            return reals("pressure", given, shape).copy()
        for name, values in given.items():
            column = reals(f"pressure {name}", values)
            if column.shape not in ((), (steps,)):
                raise InputError(f"pressure {name} has the shape {column.shape}", f"there are {steps} steps", "give one each")
            history[:, self._chamber(name)] = column
        return history

    def _chamber(self, chamber: int | str) -> int:
        if isinstance(chamber, str) and chamber in self.chambers:
            return self.chambers.index(chamber)
        if isinstance(chamber, int) and 0 <= chamber < self.chamber_count:
            return chamber
        known = ", ".join(self.chambers) or "none"
        raise InputError(f"there is no chamber {chamber!r}", f"known are {known}", "correct it")

    def _by_chamber(self, base: Array, given: ByName | None) -> Array:
        return named("chamber", self.chambers, base, given)

    def observe(self, name: str, displacement: Array) -> Array:
        """An output of a displacement (… × nodes × 3) or of its derivative: `displacement`, or a point of the case."""
        if name == "displacement":
            return displacement
        nodes, weights = self._weights(name)
        return np.asarray(np.einsum("...ni,n->...i", displacement[..., nodes, :], weights))

    def _weights(self, name: str) -> tuple[IntArray, Array]:
        point = name.removeprefix("marker.").removeprefix("node.")
        if point not in self._points:
            known = ", ".join(["displacement", *(f"marker.{point}" for point in self._points)])
            raise InputError(f"there is no output `{name}`", f"known are {known}", "add it to [output] of the case")
        return self._points[point]

    def _slope(self, name: str, cotangent: Array, shape: tuple[int, ...]) -> Array:
        """The derivative by the displacement of Σ cotangent · output."""
        if name == "displacement":
            return np.ascontiguousarray(cotangent)
        nodes, weights = self._weights(name)
        slope = np.zeros(shape)
        # A point may name a node twice.
        parts = np.einsum("...i,n->...ni", cotangent, weights)
        for at, node in enumerate(nodes):
            slope[..., node, :] += parts[..., at, :]
        return slope

    def _gradient(self, inputs: Inputs, found: _records.FoundGradient, pressures: tuple[int, ...]) -> Gradient:
        shape = (self._nodes, 3)
        by_factor, moduli = found["factors"], inputs.youngs_modulus[self.element_regions]
        by_region = found["youngs_modulus"]
        if inputs.factors.size:
            # Moduli of elements are given themselves: those of the regions have no effect.
            by_region = np.zeros_like(by_region)
        initial = {key: found[key].reshape(shape) for key in ("initial_displacement", "initial_velocity") if key in found}
        return Gradient(
            youngs_modulus=by_region,
            poissons_ratio=found["poissons_ratio"],
            density=found["density"],
            elements=by_factor / moduli if by_factor.size else by_factor,
            pressures=found["pressures"].reshape(pressures),
            forces=found["forces"].reshape(shape),
            mass_damping=found.get("mass_damping", 0.0),
            stiffness_damping=found.get("stiffness_damping", 0.0),
            **initial,
        )

    def __repr__(self) -> str:
        return f"Solver({self.dofs} dofs, regions {self.regions}, chambers {self.chambers})"


def _threads(given: int | None) -> int | None:
    return None if given is None else whole("threads", given, 1, 1024)


def _axes(clamped: npt.ArrayLike, nodes: int) -> npt.NDArray[np.bool_]:
    array = np.asarray(clamped)
    axes = np.zeros((nodes, 3), dtype=np.bool_)
    if array.size == 0:
        return axes.reshape(-1)
    if array.dtype.kind == "b" and array.shape in ((nodes,), (nodes, 3)):
        axes[:] = array.reshape(nodes, -1)
    elif array.dtype.kind in "iu" and array.ndim == 1 and array.min() >= 0 and array.max() < nodes:
        axes[array] = True
    else:
        why = f"it holds node numbers below {nodes}, or truth values of the shape ({nodes},) or ({nodes}, 3)"
        raise InputError(f"`clamped` holds {array.dtype} of the shape {array.shape}", why, "correct it")
    return axes.reshape(-1)


class _Progress:
    """A progress callback, or tqdm's bar."""

    def __init__(self, progress: Progress | bool | None, steps: int) -> None:
        self._bar: Any = None
        self._call: Progress | None = progress if callable(progress) else None
        if progress is True:
            from softfish._optional import optional

            self._bar = optional("tqdm").tqdm(total=steps)
            self._call = lambda done, _: self._bar.update(done - self._bar.n)

    def __enter__(self) -> Progress | None:
        return self._call

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
