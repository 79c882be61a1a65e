"""Reduced models that are trained over ranges of constants and pressures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from softfish._arrays import reals
from softfish._errors import InputError
from softfish._reduced import ReducedModel

if TYPE_CHECKING:
    from softfish._solver import Solver

#: Low and high.
Range = tuple[float, float]


def trained(solver: Solver, over: Mapping[str, Range], pressure: Mapping[str, Range], limits: tuple[float, int]) -> ReducedModel:
    """Of a body that nothing but pressures moves; `limits`: tolerance, and equilibria at most."""
    acting = solver.inputs()
    if np.any(acting.gravity) or np.any(acting.forces):
        why = "a reduced model is moved by the pressures of its chambers alone"
        raise InputError("gravity or forces act on the body", why, "train a solver without them")
    if solver._core.moves_clamps():
        raise InputError("a clamp of the case is displaced", "a reduced model holds its clamps at rest", "train a solver whose clamps stay")
    constants = [(kind, region, (name, *_bounds(name, over[name]))) for name in over for kind, region in [_constant(solver, name)]]
    unknown = [name for name in pressure if name not in solver.chambers]
    if unknown:
        raise InputError(f"there is no chamber `{unknown[0]}`", f"known are {', '.join(solver.chambers) or 'none'}", "correct the name")
    ranges = {name: _bounds(name, pressure.get(name, (0.0, 0.0))) for name in solver.chambers}
    tolerance, equilibria = limits
    statics = solver._static_settings((None, None, False), (None, None, None))["tolerance"]
    core, _, _ = solver._core.train((constants, [(name, *bounds) for name, bounds in ranges.items()]), (tolerance, equilibria, statics))
    return ReducedModel(solver, core, {**{name: _bounds(name, over[name]) for name in over}, **ranges})


def _constant(solver: Solver, name: str) -> tuple[str, int]:
    """`E` or `nu`, and the number of the region."""
    kind, _, region = name.partition(".")
    known = [f"{one}.{other}" for one in ("E", "nu") for other in solver.regions]
    if kind not in ("E", "nu") or region not in solver.regions:
        raise InputError(f"`over` names `{name}`", f"known are {', '.join(known)}", "correct the name")
    return kind, list(solver.regions).index(region)


def _bounds(name: str, bounds: Range) -> Range:
    low_high = reals(f"the range of {name}", bounds)
    if low_high.shape != (2,) or low_high[0] > low_high[1]:
        raise InputError(f"the range of `{name}` is {bounds!r}", "it is a pair (low, high)", "give the lower one first")
    return float(low_high[0]), float(low_high[1])
