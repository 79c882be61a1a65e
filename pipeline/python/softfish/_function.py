"""A solver as a function of some of its parameters, with derivatives in both directions: what PyTorch and JAX wrap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

import numpy as np
import numpy.typing as npt

from softfish._arguments import CHECKS
from softfish._arrays import Array, ByName, instance, reals
from softfish._errors import DerivativeError, InputError

if TYPE_CHECKING:
    from softfish._results import Equilibrium, Gradient, Inputs, Motion
    from softfish._solver import Solver

_FIELDS = {"E": "youngs_modulus", "nu": "poissons_ratio", "density": "density"}


class FunctionSettings(TypedDict, total=False):
    """What a function passes on to `Solver.equilibrium`, or to `Solver.simulate` where it has `steps`."""

    E: ByName
    nu: ByName
    density: ByName
    element_E: npt.ArrayLike
    forces: npt.ArrayLike
    gravity: npt.ArrayLike
    inputs: Inputs
    pressure: ByName | Mapping[str, Any]
    tolerance: float
    max_iterations: int
    timeout: float
    #: Of equilibria.
    level: float
    load_steps: int
    initial_guess: npt.ArrayLike
    reuse_factor: bool
    max_cutbacks: int
    #: Of motions.
    step: float
    initial: tuple[npt.ArrayLike, npt.ArrayLike] | Equilibrium
    scheme: Literal["bdf2", "implicit_euler", "quasi_static"]
    mass_damping: float
    stiffness_damping: float
    memory: int


_BOTH = {"E", "nu", "density", "element_E", "forces", "gravity", "inputs", "pressure", "tolerance", "max_iterations", "timeout"}
_STATIC = _BOTH | {"level", "load_steps", "initial_guess", "reuse_factor", "max_cutbacks"}
_DYNAMIC = _BOTH | {"step", "initial", "scheme", "mass_damping", "stiffness_damping", "memory"}


def _unchanged(_: str, value: Any) -> Any:
    """Of a setting that depends on the body: it is checked with it."""
    return value


class Parameter:
    """One argument of the function: `E.silicone`, `nu`, `element_E`, `pressure.air`, `force`."""

    def __init__(self, name: str, solver: Solver, steps: int | None) -> None:
        if not isinstance(name, str):
            raise InputError(f"`wrt` holds {name!r}", "it is a list of names", "correct it")
        self.name = name
        kind, _, key = name.partition(".")
        self.index: int | None = None
        chambers, regions = solver.chambers, solver.regions
        # a region of this name keeps its modulus
        self.kind = "element_E" if name == "E.elements" and key not in regions else kind
        if self.kind == "element_E" and (not key or name == "E.elements"):
            self.shape: tuple[int, ...] = solver.element_regions.shape
        elif self.kind == "force" and not key:
            self.shape = solver.mesh.nodes.shape
        elif self.kind == "pressure" and chambers:
            self.index = self._index(key, chambers)
            time = () if steps is None else (steps,)
            self.shape = time + (() if self.index is not None else (len(chambers),))
        elif self.kind in _FIELDS:
            self.index = self._index(key, regions)
            self.shape = () if self.index is not None else (len(regions),)
        else:
            raise self._unknown(regions, chambers)

    def _index(self, key: str, names: list[str]) -> int | None:
        if not key:
            return None
        if key not in names:
            raise InputError(f"there is no `{self.name}`", f"known are {', '.join(names) or 'none'}", "correct the name")
        return names.index(key)

    def _unknown(self, regions: list[str], chambers: list[str]) -> InputError:
        known = [f"{kind}.{name}" for kind in _FIELDS for name in regions]
        known += [f"pressure.{name}" for name in chambers] + ["element_E", "force"]
        return InputError(f"there is no parameter `{self.name}`", f"known are {', '.join(known)}", "correct the name")

    def overlaps(self, other: Parameter) -> bool:
        """Whether both set the same number."""
        moduli = {"E", "element_E"}
        if self.kind != other.kind:
            return {self.kind, other.kind} == moduli
        return self.index is None or other.index is None or self.index == other.index


def _names(given: Any, chamber: str) -> bool:
    """Whether given pressures are those of all chambers, or name one."""
    return not isinstance(given, Mapping) or chamber in given


class Function:
    """`output` of equilibria, or of motions where `steps` is given, as a function of the parameters `wrt`."""

    def __init__(self, solver: Solver, output: str, wrt: Sequence[str], steps: int | None, settings: Mapping[str, Any]) -> None:
        from softfish._solver import Solver

        instance("solver", solver, Solver, "use Solver.torch or Solver.jax")
        instance("output", output, str, "name `displacement`, or a point of the case")
        self.solver = solver
        self.output = output
        self.steps = None if steps is None else CHECKS["steps"]("steps", steps)
        if not isinstance(wrt, list | tuple) or not wrt:
            raise InputError(f"`wrt` is {wrt!r}", "it is a list of names", "name at least one parameter")
        self.parameters = [Parameter(name, solver, self.steps) for name in wrt]
        for n, parameter in enumerate(self.parameters):
            for other in self.parameters[:n]:
                if parameter.overlaps(other):
                    why = "both set the same number, and a gradient by one of them would hold the other"
                    raise InputError(f"`{other.name}` and `{parameter.name}` are both in `wrt`", why, "name one of them")
        given = {name: CHECKS.get(name, _unchanged)(name, value) for name, value in settings.items() if value is not None}
        self._check_settings(given)
        fine = 1e-12 if steps is None else 1e-11
        # Derivatives are those of the exact solution: what a loose tolerance leaves would be noise in differences.
        self._settings = {**given, "tolerance": given.get("tolerance", fine)}
        if self.steps is not None and self._step() <= 0.0:
            raise InputError("`step` is not given", "the case has no [dynamic] with a step", "give it in seconds")
        self._check_values(given)
        is_whole = output == "displacement"
        if not is_whole:
            solver._weights(output)
        time = () if self.steps is None else (self.steps,)
        self.shape = time + (solver.mesh.nodes.shape if is_whole else (3,))

    def _check_settings(self, given: Mapping[str, Any]) -> None:
        known = _STATIC if self.steps is None else _DYNAMIC
        what = "an equilibrium" if self.steps is None else "a motion"
        for name in given:
            if name not in known:
                raise InputError(f"`{name}` is no setting of {what}", f"known are {', '.join(sorted(known))}", "leave it out")
        for parameter in self.parameters:
            fixed = self._fixed_by(parameter, given)
            if fixed is not None:
                why = "what the function is differentiated by cannot be fixed as well"
                raise InputError(f"`{fixed}` is given beside `{parameter.name}` of `wrt`", why, "give one of them")
        own = {name: given[name] for name in ("E", "nu", "density", "element_E", "forces", "gravity") if name in given}
        self._base = self.solver._given(given.get("inputs"), given.get("level"), **own)

    def _check_values(self, given: Mapping[str, Any]) -> None:
        """Refuses here what each call would refuse: shapes, names and ranges of settings, and those without effect."""
        solver = self.solver
        solver._core.check(self._base._core())
        if self.steps is not None:
            solver._adaptive(self.steps, given.get("step"))
            solver._history(self.steps, self._step(), given.get("pressure"))
            solver._initial_state(given.get("initial"))
            settings = solver._dynamic_settings(None, given.get("scheme"), (None, None), (1e-6, 0, (None, None, None)))
            if settings["scheme"] == "quasi_static":
                damping = {name: given.get(name) for name in ("mass_damping", "stiffness_damping")}
                solver._require_no_inertia(damping, given.get("initial"))
            return
        solver._by_chamber(np.zeros(solver.chamber_count), given.get("pressure"), "pressure")
        if given.get("initial_guess") is not None:
            reals("initial_guess", given["initial_guess"], solver.mesh.nodes.shape)
        elif given.get("reuse_factor"):
            raise InputError("`reuse_factor` has no effect", "it starts from a nearby shape", "give initial_guess as well")
        kinds = {parameter.kind for parameter in self.parameters}
        if "level" in given and ("forces" in given or "force" in kinds) and solver._sets_all(self._static_pressures([])):
            why = "all forces and pressures are given, and a given one is not multiplied by it"
            raise InputError("`level` has no effect", why, "leave it out, or give fewer loads")

    def _fixed_by(self, parameter: Parameter, given: Mapping[str, Any]) -> str | None:
        """The setting that would fix the number of a parameter."""
        kind, index = parameter.kind, parameter.index
        other = {"E": "element_E", "element_E": "E"}.get(kind)
        if other in given:
            return other
        if kind != "pressure" and "inputs" in given:
            return "inputs"
        name = "forces" if kind == "force" else kind
        names = self.solver.chambers if kind == "pressure" else self.solver.regions
        value = given.get(name)
        elsewhere = isinstance(value, Mapping) and index is not None and names[index] not in value
        return None if value is None or elsewhere else name

    def _step(self) -> float:
        chosen = self._settings.get("step")
        return self.solver._dynamic_settings(chosen, None, (None, None), (1e-6, 0, (None, None, None)))["step"]

    def solve(self, values: Sequence[Array]) -> Equilibrium | Motion:
        """The result at the values of all parameters."""
        settings = dict(self._settings)
        own: dict[str, Any] = {name: settings.pop(name) for name in ("E", "nu", "density", "element_E") if name in settings}
        for parameter, value in zip(self.parameters, values, strict=True):
            number = reals(parameter.name, value, parameter.shape)
            kind, index = parameter.kind, parameter.index
            if kind in _FIELDS:
                if not isinstance(own.get(kind), np.ndarray):
                    own[kind] = np.array(getattr(self._base, _FIELDS[kind]))
                own[kind][slice(None) if index is None else index] = number
            elif kind != "pressure":
                own["forces" if kind == "force" else kind] = number
        if any(parameter.kind == "pressure" for parameter in self.parameters):
            settings["pressure"] = self._static_pressures(values) if self.steps is None else self._pressure_history(values)
        if self.steps is None:
            return self.solver.equilibrium(**own, **settings)
        return self.solver.simulate(self.steps, **own, **settings)

    def _static_pressures(self, values: Sequence[Array]) -> dict[str, Any] | None:
        """The pressures that are given, by chamber; those of `wrt` are 0 where no `values` are."""
        solver, given = self.solver, self._settings.get("pressure")
        if given is None and all(parameter.kind != "pressure" for parameter in self.parameters):
            return None
        whole = solver._by_chamber(np.zeros(solver.chamber_count), given, "pressure")
        pressures = {name: value for name, value in zip(solver.chambers, whole, strict=True) if given is not None and _names(given, name)}
        for n, parameter in enumerate(self.parameters):
            if parameter.kind == "pressure":
                names = solver.chambers if parameter.index is None else [solver.chambers[parameter.index]]
                numbers = reals(parameter.name, values[n], parameter.shape) if values else np.zeros(len(names))
                pressures.update(zip(names, numbers.reshape(-1).tolist(), strict=True))
        return pressures

    def _pressure_history(self, values: Sequence[Array]) -> Array:
        """The pressures of all steps."""
        assert self.steps is not None
        pressure = self.solver._history(self.steps, self._step(), self._settings.get("pressure"))
        for parameter, value in zip(self.parameters, values, strict=True):
            if parameter.kind == "pressure":
                columns = slice(None) if parameter.index is None else parameter.index
                pressure[..., columns] = reals(parameter.name, value, parameter.shape)
        return pressure

    def value(self, result: Equilibrium | Motion) -> Array:
        """The output of a result."""
        return result.output(self.output)

    def vjp(self, result: Equilibrium | Motion, cotangent: Array) -> list[Array]:
        """Σ cotangent · ∂output/∂θ for each parameter θ, by one adjoint solve."""
        from softfish._results import Equilibrium

        slope = self.solver._slope(self.output, cotangent, result.displacement.shape)
        gradient = result.adjoint(slope) if isinstance(result, Equilibrium) else result.adjoint(slope)
        return [self._part(gradient, parameter) for parameter in self.parameters]

    def _part(self, gradient: Gradient, parameter: Parameter) -> Array:
        if parameter.kind == "element_E":
            return gradient.elements
        if parameter.kind == "force":
            return gradient.forces
        whole = gradient.pressures if parameter.kind == "pressure" else getattr(gradient, _FIELDS[parameter.kind])
        return np.asarray(whole if parameter.index is None else whole[..., parameter.index])

    def jvp(self, result: Equilibrium | Motion, tangents: Sequence[Array | None]) -> Array:
        """Σ ∂output/∂θ · tangent over all parameters, by forward sensitivities."""
        from softfish._results import Equilibrium

        solver = self.solver
        along: dict[str, Any] = {}
        for parameter, tangent in zip(self.parameters, tangents, strict=True):
            if tangent is None or not np.any(tangent):
                continue
            kind, index = parameter.kind, parameter.index
            if kind in _FIELDS:
                whole = along.setdefault(kind, np.zeros(len(solver.regions)))
                whole[slice(None) if index is None else index] += tangent
            elif kind == "pressure" and self.steps is None:
                whole = along.setdefault("pressure", np.zeros(solver.chamber_count))
                whole[slice(None) if index is None else index] += tangent
            elif self.steps is None:
                along["forces" if kind == "force" else kind] = tangent
            else:
                what = f"forward mode of a motion has no direction of `{parameter.name}`"
                why = "a motion's forward sensitivities are those of E, nu and density"
                raise DerivativeError(what, why, "use reverse mode")
        changed = result.sensitivity(**along) if isinstance(result, Equilibrium) else result.sensitivity(**along)
        return solver.observe(self.output, changed)
