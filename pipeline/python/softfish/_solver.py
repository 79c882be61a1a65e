"""Solvers: equilibria, motions and paths of one body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from softfish import _core, _records
from softfish._arguments import between, checked, checked_constructor, counted
from softfish._arrays import Array, ByName, IntArray, Sealed, array_of, flag, frozen, instance, integers, named, number, reals, repeated, word
from softfish._case import Case
from softfish._errors import ConvergenceError, InputError
from softfish._export import page
from softfish._mesh import Mesh
from softfish._progress import Progress, reporting
from softfish._results import NONE, Equilibrium, Gradient, Inputs, Motion, Path, Problem

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softfish._function import FunctionSettings
    from softfish._jax import JaxFunction
    from softfish._reduced import ReducedModel
    from softfish._torch import TorchFunction

Scheme = Literal["bdf2", "implicit_euler", "quasi_static"]
_SCHEMES: dict[str, Scheme] = {"Bdf2": "bdf2", "ImplicitEuler": "implicit_euler", "QuasiStatic": "quasi_static"}
#: Newton iterations, cut-backs of a load step, and seconds; none where there is no limit.
Limits: TypeAlias = tuple[int | None, int | None, float | None]


@checked_constructor
@dataclass(frozen=True)
class Material:
    """What a region is made of.

    Attributes:
        youngs_modulus: Pa.
        poissons_ratio: Below 0.5, no unit.
        density: kg/m³.
        law: `neo_hookean`, `yeoh`, `linear`, …: `softfish.MATERIALS`.
        mean_dilatation: Against volumetric locking.
    """

    youngs_modulus: float
    poissons_ratio: float
    density: float = 1000.0
    law: str = "neo_hookean"
    mean_dilatation: bool = False

    def __post_init__(self) -> None:
        for key in ("youngs_modulus", "poissons_ratio", "density"):
            object.__setattr__(self, key, number(key, getattr(self, key)))
        word("law", self.law, _core.MATERIALS)
        object.__setattr__(self, "mean_dilatation", flag("mean_dilatation", self.mean_dilatation))


class Solver(Sealed):
    """Solves one body. It keeps its factor, so that a solve near the last one, and every gradient, reuse it.

    Each solve takes its inputs in full: what is not given is that of the case. Results do not depend on the solves
    before, but for their tolerance. Each thread needs a solver of its own. A copy, by pickle or copy.deepcopy, is made anew.

    Attributes:
        mesh: The mesh at rest.
        regions: Names of the regions.
        chambers: Names of the chambers of the mesh.
        dofs: Number of degrees of freedom: three a node, without those that are clamped.
        chamber_count: Number of chambers of the mesh.
        element_regions: The region of each element, an index into `regions`.
    """

    mesh: Mesh
    regions: list[str]
    chambers: list[str]
    dofs: int
    chamber_count: int
    element_regions: IntArray

    @checked()
    def __init__(self, case: Case, *, threads: int | None = None) -> None:
        """Of a case. One solve uses all processors, unless `threads` of its own are given: solvers that solve at the same time on as many
        threads of Python are fastest with one each."""
        instance("case", case, Case, "make one: Case(...), or use Solver.of_mesh")
        self._made_of: tuple[Any, ...] = (case, threads)
        self._start(_core.Solver.of_case(case._core, case.mesh._core, threads), case.mesh)

    @classmethod
    @checked()
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
        nodes × 3 truth values; `threads` as for a case.

        Numbers of nodes are refused for a mesh that dropped nodes of the caller's arrays: see `Mesh.numbering`."""
        instance("mesh", mesh, Mesh, "make one: Mesh.read, Mesh.from_meshio")
        solver = cls.__new__(cls)
        solver._of_mesh(mesh, materials, _axes(clamped, mesh), (lumped_mass, threads))
        return solver

    def _of_mesh(
        self,
        mesh: Mesh,
        materials: Material | Mapping[str, Material],
        held: npt.NDArray[np.bool_],
        options: tuple[bool, int | None],
    ) -> None:
        regions = mesh.region_names
        if not isinstance(materials, Material | Mapping):
            why = "it is a Material, or a dictionary of them by region"
            raise InputError(f"`materials` is {materials!r}", why, "make one: Material(E, nu)")
        by_name = dict.fromkeys(regions, materials) if isinstance(materials, Material) else dict(materials)
        if set(by_name) != set(regions):
            why = f"the mesh has the regions {', '.join(regions)}"
            raise InputError(f"materials are given for {', '.join(map(str, by_name))}", why, "give one material for each region")
        wrong = next((name for name, one in by_name.items() if not isinstance(one, Material)), None)
        if wrong is not None:
            raise InputError(f"`materials[{wrong!r}]` is {by_name[wrong]!r}", "it is a Material", "make one: Material(E, nu)")
        of = [by_name[name] for name in regions]
        given: _records.Materials = {
            "law": [one.law for one in of],
            "youngs_modulus": [one.youngs_modulus for one in of],
            "poissons_ratio": [one.poissons_ratio for one in of],
            "density": [one.density for one in of],
            "mean_dilatation": [one.mean_dilatation for one in of],
            "lumped_mass": options[0],
        }
        self._made_of = (mesh, by_name, held, options)
        self._start(_core.Solver.of_mesh(mesh._core, given, (held, options[1])), mesh)

    def __getstate__(self) -> dict[str, Any]:
        return {"made_of": self._made_of}

    def __setstate__(self, state: dict[str, Any]) -> None:
        made_of = state["made_of"]
        if len(made_of) == 2:
            self.__init__(made_of[0], threads=made_of[1])  # type: ignore[misc]
        else:
            self._of_mesh(*made_of)

    def _start(self, core: _core.Solver, mesh: Mesh) -> None:
        self._core = core
        self.mesh = mesh
        self.regions = mesh.region_names
        self.dofs, self._nodes, self._elements, self.chamber_count = core.sizes()
        self.element_regions = frozen(core.element_regions())
        data = core.case_data()
        self._data: _records.CaseData | None = data
        properties = core.properties()
        shape = (self._nodes, 3)
        self._base = Inputs(
            youngs_modulus=np.array([of[1] for of in properties]),
            poissons_ratio=np.array([of[2] for of in properties]),
            density=np.array([of[3] for of in properties]),
            factors=NONE,
            forces=np.zeros(shape) if data is None else data["forces"].reshape(shape),
            gravity=np.zeros(3) if data is None else data["gravity"],
        )
        names = [f"chamber_{n}" for n in range(self.chamber_count)]
        for name, index in [] if data is None else data["chambers"]:
            names[index] = name
        twice = repeated(names)
        if twice is not None:
            raise InputError(f"two chambers are named `{twice}`", "one of them has no name of its own", "name it in the case")
        self.chambers = names
        points = [] if data is None else data["points"]
        self._points: dict[str, tuple[IntArray, Array]] = {name: (nodes, weights) for name, nodes, weights in points}

    @property
    def base(self) -> Inputs:
        """The inputs of the case, with its forces in full: at level 1."""
        return self._base

    @property
    def points(self) -> list[str]:
        """Names of the points of the case's output."""
        return list(self._points)

    @property
    def notes(self) -> list[str]:
        """What was noticed when the case was read."""
        return [] if self._data is None else self._data["notes"]

    @property
    def levels(self) -> list[float]:
        """The levels of the case (no unit), in the order in which `study simulate` solves them; none of a motion, or without a case."""
        return [] if self._data is None else list(self._data.get("levels", []))

    @checked()
    def inputs(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        element_E: npt.ArrayLike | None = None,
        forces: npt.ArrayLike | None = None,
        gravity: npt.ArrayLike | None = None,
        level: float | None = None,
    ) -> Inputs:
        """The inputs of a solve: those of the case, with what is given in their place.

        `E` (Pa), `nu` and `density` (kg/m³): a dictionary by region, a list, or a number where there is one region.
        `element_E`: one modulus per element, Pa, in the place of `E`. `forces`: nodes × 3, N, in the place of the case's at its `level`, which
        is the last one of the case where it is not given.
        """
        if E is not None and element_E is not None:
            why = "moduli of elements take the place of those of the regions"
            raise InputError("`E` and `element_E` are both given", why, "give one of them")
        part = self._level(level)
        moduli = named("region", self.regions, self._base.youngs_modulus, E, "E")
        factors = NONE
        if element_E is not None:
            given = reals("element_E", element_E, self.element_regions.shape)
            factors = given / moduli[self.element_regions]
        return Inputs(
            youngs_modulus=moduli,
            poissons_ratio=named("region", self.regions, self._base.poissons_ratio, nu, "nu"),
            density=named("region", self.regions, self._base.density, density, "density"),
            factors=factors,
            forces=part * self._base.forces if forces is None else reals("forces", forces, (self._nodes, 3)),
            gravity=self._base.gravity if gravity is None else reals("gravity", gravity, (3,)),
            level=part,
        )

    def _level(self, level: float | None) -> float:
        if level is not None and self._data is None:
            why = "it multiplies the loads of a case, and this body has none"
            raise InputError("`level` has no effect", why, "multiply `forces` and `pressure`")
        if level is not None:
            return level
        return self.levels[-1] if self.levels else 1.0

    def _given(self, inputs: Inputs | None, level: float | None, **others: Any) -> Inputs:
        """The inputs of a solve: those that are given in full, or the case's with others in their place."""
        if inputs is None:
            return self.inputs(level=level, **others)
        also = next((name for name, value in others.items() if value is not None), None)
        if also is not None:
            raise InputError(f"`{also}` and `inputs` are both given", "inputs are given in full", f"give {also} to Solver.inputs")
        if not isinstance(inputs, Inputs):
            raise InputError(f"`inputs` is {inputs!r}", "Solver.inputs makes them", "make them there")
        if inputs.forces.shape != (self._nodes, 3) or inputs.factors.size not in (0, self._elements):
            raise InputError("`inputs` are of another body", f"this one has {self._nodes} nodes", "make them with Solver.inputs")
        if level is None:
            return inputs
        part = self._level(level)
        own = self._are_own(inputs)
        return replace(inputs, level=part, forces=part * self._base.forces if own else inputs.forces)

    def _are_own(self, inputs: Inputs) -> bool:
        """Whether the forces are the case's at the level of the inputs."""
        return bool(np.array_equal(inputs.forces, inputs.level * self._base.forces))

    def _sets_all(self, pressure: ByName | None) -> bool:
        """Whether `pressure` leaves none to the case."""
        return not self.chambers or (pressure is not None and not (isinstance(pressure, Mapping) and set(self.chambers) - set(pressure)))

    def _way(self, level: float) -> list[float]:
        """The levels of the case before `level`, from which it is solved for as `study simulate` does."""
        levels = self.levels
        if levels and level == levels[-1]:
            return levels[:-1]
        beyond = (n for n, other in enumerate(levels) if other == level or (level > 0) == (other > level))
        first = levels.index(level) if level in levels else next(beyond, len(levels))
        return levels[:first]

    @checked()
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
        level: float | None = None,
        max_iterations: int | None = None,
        max_cutbacks: int | None = None,
        timeout: float | None = None,
    ) -> Equilibrium:
        """The equilibrium under all loads.

        `level`: the part of the case's pressures and forces; the last one of the case where it is not given, and 1 without a case. What is
        given by `pressure` (Pa, by chamber) or `forces` (nodes × 3, N) takes their place as it is. Under the loads of the case alone, the levels
        before are solved first, each from the one before, as `study simulate` does; of a case with a motion, the loads are those of time 0.
        `initial_guess`: a nearby displacement (nodes × 3, m). `tolerance`: of the last step, in sizes of the body. `load_steps`: from rest.
        `reuse_factor`: the factor of the last solve is tried first, with an initial guess.

        `max_iterations`: Newton iterations of a level (250). `max_cutbacks`: halvings of a load step (40). `timeout`: seconds of the call (none).
        Raises `ConvergenceError`, and `BudgetError` at one of these limits, with the last equilibrium and its level.
        """
        own = {"E": E, "nu": nu, "density": density, "element_E": element_E, "forces": forces, "gravity": gravity}
        given = self._given(inputs, level, **own)
        base = self._core.case_pressures([], given.level)
        if level is None and self._data is not None and "dynamic" in self._data:
            base = self._core.case_pressures([0.0], None)
        pressures = self._by_chamber(base, pressure, "pressure")
        guess = None if initial_guess is None else reals("initial_guess", initial_guess, (self._nodes, 3)).reshape(-1)
        if level is not None and not self._are_own(given) and self._sets_all(pressure):
            why = "all forces and pressures are given, and a given one is not multiplied by it"
            raise InputError("`level` has no effect", why, "leave it out, or give fewer loads")
        if guess is None and reuse_factor:
            raise InputError("`reuse_factor` has no effect", "it starts from a nearby shape", "give initial_guess as well")
        settings = self._static_settings((tolerance, load_steps, reuse_factor), (max_iterations, max_cutbacks, timeout))
        way: list[float] = []
        if guess is None and pressure is None and self._are_own(given):
            self._require_no_path()
            way = self._way(given.level)
        with self._last_equilibrium(given, way):
            found = self._core.equilibria(given._core(), (way, given.level, pressures.tolist()), (guess, settings))
        last = found[-1]
        last["iterations"] = sum(one["iterations"] for one in found)
        last["factorisations"] = sum(one["factorisations"] for one in found)
        return Equilibrium._make(self, given, last)

    @checked()
    def equilibria(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        element_E: npt.ArrayLike | None = None,
        gravity: npt.ArrayLike | None = None,
        tolerance: float | None = None,
        load_steps: int | None = None,
        max_iterations: int | None = None,
        max_cutbacks: int | None = None,
        timeout: float | None = None,
    ) -> list[Equilibrium]:
        """The equilibria of all levels of the case, each from the one before, as `study simulate` has them; the arguments are those of
        `equilibrium`."""
        levels = self.levels
        if not levels:
            raise InputError("the case has no levels", "it has no [static]", "use equilibrium, or simulate")
        self._require_no_path()
        given = self.inputs(E, nu, density, element_E=element_E, gravity=gravity)
        settings = self._static_settings((tolerance, load_steps, False), (max_iterations, max_cutbacks, timeout))
        pressures = self._core.case_pressures([], given.level).tolist()
        with self._last_equilibrium(given, levels[:-1]):
            found = self._core.equilibria(given._core(), (levels[:-1], given.level, pressures), (None, settings))
        return [Equilibrium._make(self, self._given(given, level), one) for level, one in zip(levels, found, strict=True)]

    @checked()
    def path(
        self,
        E: ByName | None = None,
        nu: ByName | None = None,
        density: ByName | None = None,
        *,
        element_E: npt.ArrayLike | None = None,
        gravity: npt.ArrayLike | None = None,
        max_iterations: int | None = None,
        timeout: float | None = None,
    ) -> Path:
        """The path of equilibria of a case with `arc_length`, as `study simulate` follows it. `max_iterations`: of each point."""
        given = self.inputs(E, nu, density, element_E=element_E, gravity=gravity)
        iterations, _, seconds = self._limits((max_iterations, None, timeout))
        return Path._make(self, given, self._core.path(given._core(), (iterations, seconds)))

    def _require_no_path(self) -> None:
        if self._data is not None and self._data.get("follows_path", False):
            why = "the case follows a path (arc_length), which may leave this branch at a critical point"
            raise InputError("the equilibrium of a level is not that of the path", why, "use path, or give an initial_guess from it")

    @contextmanager
    def _last_equilibrium(self, inputs: Inputs, way: list[float]) -> Iterator[None]:
        """Makes an equilibrium of the last state that the exception of a solve holds."""
        try:
            yield
        except ConvergenceError as error:
            last, asked = error.__dict__.pop("_last", None), error.__dict__.pop("_asked", inputs.level)
            if last is not None and error.level is not None:
                whole_level = error.level in way or asked == 0.0
                part = 1.0 if whole_level else error.level / asked
                forces = error.level * self._base.forces if self._are_own(inputs) else part * inputs.forces
                own = replace(inputs, level=error.level, forces=forces, gravity=part * inputs.gravity)
                error.equilibrium = Equilibrium._make(self, own, last)
            displacement = error.__dict__.pop("_displacement", None)
            if displacement is not None and displacement.size:
                error.displacement = displacement.reshape(-1, 3)
            raise

    @checked()
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
        max_iterations: int | None = None,
        timeout: float | None = None,
    ) -> Motion:
        """A motion of `steps` steps of `step` seconds; what is not given is the case's, its adaptive steps and its start included.

        `pressure` (Pa): steps × chambers, or by chamber a number or one per step. `initial`: displacement and velocity
        (nodes × 3 each, m and m/s), or an equilibrium; where the case starts in its equilibrium, that is the one under its pressures at time 0.
        `progress`: called with the steps done and all steps, or `True` for a bar.
        `memory`: bytes of states that the gradient may keep; beyond it they are computed again. `max_iterations`: Newton iterations of a step.
        `timeout`: seconds of the call. Raises `ConvergenceError` with `time` and `displacement` of the last state.
        """
        own = {"E": E, "nu": nu, "density": density, "element_E": element_E, "forces": forces, "gravity": gravity}
        given = self._given(inputs, None, **own)
        budget = (max_iterations, None, timeout)
        settings = self._dynamic_settings(step, scheme, (mass_damping, stiffness_damping), (tolerance, memory, budget))
        if settings["scheme"] == "quasi_static":
            self._require_no_inertia({"mass_damping": mass_damping, "stiffness_damping": stiffness_damping}, initial)
        adaptive = self._adaptive(steps, step)
        if adaptive is None and settings["step"] <= 0.0:
            raise InputError("`step` is not given", "the case has no [dynamic] with a step", "give it in seconds")
        count = 0 if adaptive is not None else self._steps(steps, settings["step"])
        begun = self._start_of(given, initial, budget)
        problem = Problem(self._initial_state(initial if begun is None else begun), settings, begun)
        with reporting(progress, count) as report, self._last_equilibrium(given, []):
            if adaptive is not None:
                asked = (problem.initial, self._constants(pressure), adaptive)
                found = self._core.integrate_adaptive(given._core(), asked, (settings, report))
            else:
                pressures = self._history(count, settings["step"], pressure)
                found = self._core.record(given._core(), (problem.initial, pressures.reshape(-1), count), (settings, report))
                found["pressures"] = pressures
        return Motion._make(self, given, problem, found)

    def _require_no_inertia(self, damping: Mapping[str, float | None], initial: Any) -> None:
        """Refuses what a motion without inertia leaves out."""
        velocity = NONE if isinstance(initial, Equilibrium) else self._initial_state(initial)[1]
        also = [name for name, value in damping.items() if value] + (["initial[1]"] if np.any(velocity) else [])
        if also:
            why = "a quasi-static motion has no inertia: its states are equilibria"
            raise InputError(f"`{also[0]}` has no effect", why, "leave it out, or take the scheme bdf2")

    def _initial_state(self, initial: tuple[npt.ArrayLike, npt.ArrayLike] | Equilibrium | None) -> tuple[Array, Array]:
        shape = (self._nodes, 3)
        if initial is None:
            return np.zeros(3 * self._nodes), np.zeros(3 * self._nodes)
        if isinstance(initial, Equilibrium):
            return reals("initial", initial.displacement, shape).reshape(-1), np.zeros(3 * self._nodes)
        if not isinstance(initial, tuple | list) or len(initial) != 2:
            why = "it is a pair of displacement and velocity, or an equilibrium"
            raise InputError(f"`initial` is a {type(initial).__name__}", why, "correct it")
        displacement, velocity = (reals(f"initial[{n}]", part, shape).reshape(-1) for n, part in enumerate(initial))
        held = ~self._core.free()
        for n, part in enumerate((displacement, velocity)):
            # a state that was computed elsewhere may hold what is left of rounding
            if np.abs(part[held]).max(initial=0.0) > 1e-9 * np.abs(part).max(initial=0.0):
                why = "a clamped node stays where it is"
                raise InputError(f"`initial[{n}]` moves a node that is clamped", why, "set it to 0 there")
        return displacement, velocity

    def _start_of(self, inputs: Inputs, initial: object, budget: Limits) -> Equilibrium | None:
        """The equilibrium in which a motion of the case begins, where it does and nothing else is given."""
        dynamic = None if self._data is None else self._data.get("dynamic")
        if initial is not None or dynamic is None or dynamic["starts_at_rest"]:
            return None
        settings = self._static_settings((None, None, False), budget)
        with self._last_equilibrium(inputs, []):
            return Equilibrium._make(self, inputs, self._core.start_equilibrium(inputs._core(), settings))

    def _adaptive(self, steps: int | None, step: float | None) -> tuple[float, float, float, float] | None:
        """Duration, tolerance (m), shortest and longest step (s) of a case with adaptive steps."""
        dynamic = None if self._data is None else self._data.get("dynamic")
        if step is not None or dynamic is None or dynamic["adaptive"] is None:
            return None
        if steps is not None:
            raise InputError("`steps` has no effect", "the case has adaptive steps", "give `step` as well, or leave it out")
        tolerance, shortest, longest = dynamic["adaptive"]
        return dynamic["duration"], tolerance, shortest, longest

    def _constants(self, pressure: npt.ArrayLike | Mapping[str, Any] | None) -> list[float | None]:
        """The pressures that are given of an adaptive motion, one a chamber."""
        constants: list[float | None] = [None] * self.chamber_count
        if pressure is not None and not isinstance(pressure, Mapping):
            raise InputError("`pressure` is given by steps", "the steps of an adaptive motion are not known", "give a number by chamber")
        self._require_one_name(pressure or {})
        for name, value in (pressure or {}).items():
            constants[self._chamber(name)] = number(f"pressure[{name!r}]", value)
        return constants

    @checked()
    def adjoint(self, at: Equilibrium | Motion, dloss_du: npt.ArrayLike) -> Gradient:
        """The gradient of a loss of a result, from its derivative by the displacement (as its shape)."""
        instance("at", at, (Equilibrium, Motion), "give what equilibrium or simulate returned")
        return at.adjoint(dloss_du)

    @checked()
    def sensitivity(self, at: Equilibrium | Motion, **direction: Any) -> Array:
        """The derivative of a result's displacement along a direction of its parameters: see `Equilibrium.sensitivity`."""
        instance("at", at, (Equilibrium, Motion), "give what equilibrium or simulate returned")
        return at.sensitivity(**direction)

    @checked()
    def modes(self, count: int = 6, at: Equilibrium | None = None, *, timeout: float | None = None) -> tuple[Array, Array]:
        """Natural frequencies (Hz) and shapes (count × nodes × 3) about an equilibrium; without one, about that of the
        case. `timeout`: seconds of the modes."""
        if at is not None:
            instance("at", at, Equilibrium, "give what equilibrium returned")
        return (self.equilibrium() if at is None else at).modes(count, timeout=timeout)

    @checked()
    def traction(self, faces: npt.ArrayLike, traction: npt.ArrayLike) -> Array:
        """Nodal forces (nodes × 3, N) of a traction (Pa) over faces × 3, 4 or 6 nodes."""
        nodes = integers("faces", faces)
        if nodes.ndim != 2 or nodes.shape[1] not in (3, 4, 6):
            raise InputError(f"`faces` has the shape {nodes.shape}", "it is faces × 3, 4 or 6", "check its axes")
        _require_own_numbers("faces", self.mesh)
        vector = reals("traction", traction, (3,))
        along = (float(vector[0]), float(vector[1]), float(vector[2]))
        return self._core.traction_forces(nodes.reshape(-1), int(nodes.shape[1]), along).reshape(-1, 3)

    @checked()
    def torch(self, output: str, wrt: Sequence[str], *, steps: int | None = None, **settings: Unpack[FunctionSettings]) -> TorchFunction:
        """The output as a differentiable function of PyTorch, see `softfish.TorchFunction`."""
        from softfish._torch import TorchFunction

        return TorchFunction(self, output, wrt, steps=steps, **settings)

    @checked()
    def jax(
        self,
        output: str,
        wrt: Sequence[str],
        *,
        kept: int = 64,
        steps: int | None = None,
        **settings: Unpack[FunctionSettings],
    ) -> JaxFunction:
        """The output as a differentiable function of JAX, see `softfish.JaxFunction`."""
        from softfish._jax import JaxFunction

        return JaxFunction(self, output, wrt, kept=kept, steps=steps, **settings)

    @checked(coordinates=counted(1, 1000), tolerance=between(1e-12, 1.0), equilibria=counted(1, 1000))
    def reduce(
        self,
        snapshots: npt.ArrayLike | None = None,
        coordinates: int | None = None,
        *,
        tolerance: float | None = None,
        over: Mapping[str, tuple[float, float]] | None = None,
        pressure: Mapping[str, tuple[float, float]] | None = None,
        equilibria: int | None = None,
    ) -> ReducedModel:
        """The body in a few modes.

        Of `snapshots` (snapshots × nodes × 3, m) that it took: at most `coordinates` (20) of them, `tolerance` (1e-3) that of the cubature. Or trained
        as `study reduce` does: `over` ranges of constants, `{"E.silicone": (1e5, 3e5), "nu.silicone": (0.45, 0.49)}`, and of each chamber's
        `pressure`, `{"air": (0.0, 3e4)}`; at most `equilibria` (60) of the whole body teach it, until points drawn from the ranges differ by at
        most `tolerance` (5e-3) of the largest displacement."""
        from softfish._reduced import ReducedModel
        from softfish._training import trained

        if (snapshots is None) == (pressure is None):
            why = "a model is made of snapshots, or trained over ranges of pressures"
            raise InputError("`reduce` needs either `snapshots` or `pressure`", why, "give one of them")
        if snapshots is not None:
            if over is not None or equilibria is not None:
                why = "snapshots are shapes of one body"
                raise InputError("`over` and `equilibria` belong to a training", why, "leave them out, or give `pressure` in place of `snapshots`")
            return ReducedModel.of(self, snapshots, 20 if coordinates is None else coordinates, 1e-3 if tolerance is None else tolerance)
        if coordinates is not None:
            raise InputError("`coordinates` belong to `snapshots`", "a training takes as many as its tolerance needs", "leave it out")
        limits = (5e-3 if tolerance is None else tolerance, 60 if equilibria is None else equilibria)
        return trained(self, over or {}, pressure or {}, limits)

    def _limits(self, given: Limits) -> Limits:
        """Iterations, cut-backs and seconds: what is given, else the case's."""
        of_case: Limits = (None, None, None) if self._data is None else self._data.get("budget", (None, None, None))
        iterations, cutbacks, seconds = given
        return (
            of_case[0] if iterations is None else iterations,
            of_case[1] if cutbacks is None else cutbacks,
            of_case[2] if seconds is None else seconds,
        )

    def _static_settings(self, given: tuple[float | None, int | None, bool], budget: Limits) -> _records.StaticSettings:
        data: Mapping[str, Any] = {} if self._data is None else self._data
        tolerance, load_steps, reuse_factor = given
        iterations, cutbacks, seconds = self._limits(budget)
        return {
            "tolerance": data.get("tolerance", 1e-8) if tolerance is None else tolerance,
            "load_steps": data.get("load_steps", 3) if load_steps is None else load_steps,
            "reuse_factor": reuse_factor,
            "max_iterations": iterations,
            "max_cutbacks": cutbacks,
            "timeout": seconds,
        }

    def _dynamic_settings(
        self,
        step: float | None,
        scheme: Scheme | None,
        damping: tuple[float | None, float | None],
        limits_of: tuple[float, int, Limits],
    ) -> _records.DynamicSettings:
        """The settings of a motion; its step is 0 where none is given."""
        set_by_case: Mapping[str, Any] = {} if self._data is None else self._data.get("dynamic", {})
        length = set_by_case.get("step") if step is None else step
        alpha, beta = (set_by_case.get(name, 0.0) for name in ("mass_damping", "stiffness_damping"))
        tolerance, memory, budget = limits_of
        iterations, _, seconds = self._limits(budget)
        adaptive = set_by_case.get("adaptive")
        shortest = adaptive[1] if adaptive else 0.0
        return {
            "step": float(shortest if length is None else length),
            "scheme": _SCHEMES.get(set_by_case.get("scheme", ""), "bdf2") if scheme is None else scheme,
            "mass_damping": float(alpha if damping[0] is None else damping[0]),
            "stiffness_damping": float(beta if damping[1] is None else damping[1]),
            "tolerance": tolerance,
            "memory": memory,
            "max_iterations": iterations,
            "timeout": seconds,
        }

    def _steps(self, steps: int | None, step: float) -> int:
        dynamic = None if self._data is None else self._data.get("dynamic")
        if steps is None and dynamic is not None:
            steps = round(dynamic["duration"] / step)
        if steps is None:
            raise InputError("`steps` is not given", "the case has no [dynamic] with a duration", "give their number")
        return steps

    def _history(self, steps: int, step: float, given: npt.ArrayLike | Mapping[str, Any] | None) -> Array:
        shape = (steps, self.chamber_count)
        times = step * np.arange(1, steps + 1)
        history = self._core.case_pressures(times.tolist(), None).reshape(shape)
        if given is None:
            return history
        if not isinstance(given, Mapping):
            return reals("pressure", given, shape).copy()
        self._require_one_name(given)
        for name, values in given.items():
            column = reals(f"pressure[{name!r}]", values)
            if column.shape not in ((), (steps,)):
                raise InputError(f"`pressure[{name!r}]` has the shape {column.shape}", f"there are {steps} steps", "give one each")
            history[:, self._chamber(name)] = column
        return history

    def _require_one_name(self, given: Mapping[Any, Any]) -> None:
        """Refuses a chamber that is given by its name and by its number."""
        numbers = [self._chamber(name) for name in given]
        if len(set(numbers)) < len(numbers):
            raise InputError("`pressure` has a chamber twice", f"its keys are {', '.join(map(repr, given))}", "give each once")

    def _chamber(self, chamber: int | str) -> int:
        if isinstance(chamber, str) and chamber in self.chambers:
            return self.chambers.index(chamber)
        if isinstance(chamber, int | np.integer) and not isinstance(chamber, bool) and 0 <= chamber < self.chamber_count:
            return int(chamber)
        known = ", ".join(self.chambers) or "none"
        raise InputError(f"there is no chamber {chamber!r}", f"known are {known}", "correct it")

    def _by_chamber(self, base: Array, given: ByName | None, argument: str) -> Array:
        return named("chamber", self.chambers, base, given, argument)

    @checked()
    def observe(self, name: str, displacement: Array) -> Array:
        """An output of a displacement (… × nodes × 3) or of its derivative: `displacement`, or a point of the case."""
        instance("name", name, str, "name `displacement`, or a point of the case")
        values = reals("displacement", displacement)
        if values.shape[-2:] != (self._nodes, 3):
            why = f"it is … × {self._nodes} × 3"
            raise InputError(f"`displacement` has the shape {values.shape}", why, "check its axes")
        if name == "displacement":
            return values
        nodes, weights = self._weights(name)
        return np.asarray(np.einsum("...ni,n->...i", values[..., nodes, :], weights))

    def _weights(self, name: str) -> tuple[IntArray, Array]:
        instance("output", name, str, "name `displacement`, or a point of the case")
        kind, _, point = name.rpartition(".")
        if point not in self._points or kind not in ("", "marker", "node"):
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
        by_displacement, by_velocity = found.get("initial_displacement"), found.get("initial_velocity")
        return Gradient(
            youngs_modulus=by_region,
            poissons_ratio=found["poissons_ratio"],
            density=found["density"],
            elements=by_factor / moduli if by_factor.size else by_factor,
            pressures=found["pressures"].reshape(pressures),
            forces=found["forces"].reshape(shape),
            mass_damping=found.get("mass_damping", 0.0),
            stiffness_damping=found.get("stiffness_damping", 0.0),
            initial_displacement=None if by_displacement is None else by_displacement.reshape(shape),
            initial_velocity=None if by_velocity is None else by_velocity.reshape(shape),
        )

    def __repr__(self) -> str:
        sizes = f"{self._nodes} nodes, {self._elements} elements, {self.dofs} dofs"
        return f"Solver({sizes}, regions {self.regions}, chambers {self.chambers}, points {self.points})"

    def _repr_html_(self) -> str:
        return page(repr(self), self.mesh)


def _require_own_numbers(name: str, mesh: Mesh) -> None:
    """Refuses numbers of nodes where they are not those of the caller's arrays."""
    if mesh._moved():
        why = "the mesh dropped nodes that no element uses, so that its numbers are not those of the arrays that it was made of"
        raise InputError(f"`{name}` holds node numbers", why, "give truth values by place, or drop unused nodes before")


def _axes(clamped: npt.ArrayLike, mesh: Mesh) -> npt.NDArray[np.bool_]:
    array = array_of("clamped", clamped)
    nodes = len(mesh.nodes)
    axes = np.zeros((nodes, 3), dtype=np.bool_)
    if array.size == 0:
        return axes.reshape(-1)
    if array.dtype.kind == "b" and array.shape in ((nodes,), (nodes, 3)):
        axes[:] = array.reshape(nodes, -1)
    elif array.dtype.kind in "iu" and array.ndim == 1 and array.min() >= 0 and array.max() < nodes:
        _require_own_numbers("clamped", mesh)
        axes[array] = True
    else:
        why = f"it holds node numbers below {nodes}, or truth values of the shape ({nodes},) or ({nodes}, 3)"
        raise InputError(f"`clamped` holds {array.dtype} of the shape {array.shape}", why, "correct it")
    return axes.reshape(-1)
