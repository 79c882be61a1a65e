"""A solver as a function of some of its parameters, with derivatives in both directions: what PyTorch and JAX wrap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._arrays import Array, reals
from softfish._errors import InputError

if TYPE_CHECKING:
    from softfish._solver import Equilibrium, Gradient, Motion, Solver

_FIELDS = {"E": "youngs_modulus", "nu": "poissons_ratio", "density": "density"}


class Parameter:
    """One argument of the function: `E.silicone`, `nu`, `element_E`, `pressure.air`, `force`."""

    def __init__(self, name: str, solver: Solver, steps: int | None) -> None:
        self.name = name
        kind, _, key = name.partition(".")
        self.kind = "element_E" if name == "E.elements" else kind
        self.index: int | None = None
        chambers, regions = solver.chambers, solver.regions
        if self.kind == "element_E":
            self.shape: tuple[int, ...] = solver.element_regions.shape
        elif self.kind == "force" and not key:
            self.shape = solver.mesh.nodes.shape
        elif self.kind == "pressure":
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


class Function:
    """`output` of equilibria, or of motions where `steps` is given, as a function of the parameters `wrt`."""

    def __init__(
        self,
        solver: Solver,
        output: str,
        wrt: Sequence[str],
        *,
        steps: int | None = None,
        tolerance: float | None = None,
        **settings: Any,
    ) -> None:
        self.solver = solver
        self.output = output
        self.steps = steps
        if isinstance(wrt, str) or not wrt:
            raise InputError(f"wrt is {wrt!r}", "it is a list of names", "name at least one parameter")
        self.parameters = [Parameter(name, solver, steps) for name in wrt]
        kinds = [parameter.kind for parameter in self.parameters]
        if "element_E" in kinds and "E" in kinds:
            why = "moduli of elements take the place of those of the regions"
            raise InputError("element_E and E are both parameters", why, "name one of them")
        fine = 1e-12 if steps is None else 1e-11
        # Derivatives are those of the exact solution: what a loose tolerance leaves would be noise in differences.
        self._settings = {**settings, "tolerance": fine if tolerance is None else tolerance}
        points = 1 if output == "displacement" else 0
        nodes = solver.mesh.nodes.shape
        if not points:
            solver._weights(output)
        time = () if steps is None else (steps,)
        self.shape = time + (nodes if points else (3,))

    def solve(self, values: Sequence[Array]) -> Equilibrium | Motion:
        """The result at the values of all parameters."""
        given: dict[str, Any] = {}
        base = self.solver.base
        pressure: Array | None = None
        for parameter, value in zip(self.parameters, values, strict=True):
            number = reals(parameter.name, value, parameter.shape)
            kind, index = parameter.kind, parameter.index
            if kind in _FIELDS:
                whole = given.setdefault(kind, getattr(base, _FIELDS[kind]).copy())
                whole[slice(None) if index is None else index] = number
            elif kind == "pressure":
                pressure = self._pressures() if pressure is None else pressure
                pressure[..., slice(None) if index is None else index] = number
            else:
                given["forces" if kind == "force" else kind] = number
        if self.steps is None:
            return self.solver.equilibrium(pressure=pressure, **given, **self._settings)
        return self.solver.simulate(self.steps, pressure=pressure, **given, **self._settings)

    def _pressures(self) -> Array:
        solver = self.solver
        if self.steps is None:
            return solver._core.case_pressures([], float(self._settings.get("level", 1.0)))
        step = solver._dynamic_settings(self._settings.get("step"), None, None, None, (1e-6, 0))["step"]
        return solver._history(self.steps, step, None)

    def value(self, result: Equilibrium | Motion) -> Array:
        """The output of a result."""
        return result.output(self.output)

    def vjp(self, result: Equilibrium | Motion, cotangent: Array) -> list[Array]:
        """Σ cotangent · ∂output/∂θ for each parameter θ, by one adjoint solve."""
        from softfish._solver import Equilibrium

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
        from softfish._solver import Equilibrium

        solver = self.solver
        along: dict[str, Any] = {}
        for parameter, tangent in zip(self.parameters, tangents, strict=True):
            if tangent is None:
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
                raise InputError(what, why, "use reverse mode")
        changed = result.sensitivity(**along) if isinstance(result, Equilibrium) else result.sensitivity(**along)
        return solver.observe(self.output, changed)
