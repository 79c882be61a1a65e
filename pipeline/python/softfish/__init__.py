"""Differentiable finite elements for soft bodies with pressurised chambers.

A `Case` (a file of TOML, or a dictionary) or a `Mesh` with `Material`s becomes a `Solver`:

    import softfish as sf

    body = sf.Case("finger.toml").solver()
    rest = body.equilibrium(pressure={"left": 8e3})
    rest.displacement                                   # nodes × 3, m
    tip = body.torch("marker.tip", wrt=["E.soft", "pressure.left"])

All quantities are in SI units. Every refusal is an `Error` that says what is wrong, why, and what to do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from softfish._case import Case
from softfish._core import MATERIALS
from softfish._errors import (
    BusyError,
    CaseError,
    ConvergenceError,
    Error,
    InputError,
    MeshError,
    MissingError,
    NotStableError,
)
from softfish._fit import Fit, FittedLaw, fit
from softfish._instruments import Camera, Tracks, calibrate, track
from softfish._mesh import Mesh
from softfish._project import Project, Record
from softfish._reduced import ReducedGradient, ReducedModel, ReducedState
from softfish._solver import Equilibrium, Gradient, Inputs, Material, Motion, Solver

if TYPE_CHECKING:
    from softfish._jax import JaxFunction
    from softfish._torch import TorchFunction

__all__ = [
    "MATERIALS",
    "BusyError",
    "Camera",
    "Case",
    "CaseError",
    "ConvergenceError",
    "Equilibrium",
    "Error",
    "Fit",
    "FittedLaw",
    "Gradient",
    "InputError",
    "Inputs",
    "JaxFunction",
    "Material",
    "Mesh",
    "MeshError",
    "MissingError",
    "Motion",
    "NotStableError",
    "Project",
    "Record",
    "ReducedGradient",
    "ReducedModel",
    "ReducedState",
    "Solver",
    "TorchFunction",
    "Tracks",
    "calibrate",
    "fit",
    "track",
]


def __getattr__(name: str) -> Any:
    """The functions of PyTorch and JAX, which are loaded where they are used."""
    if name == "TorchFunction":
        from softfish._torch import TorchFunction

        return TorchFunction
    if name == "JaxFunction":
        from softfish._jax import JaxFunction

        return JaxFunction
    raise AttributeError(f"module `softfish` has no attribute `{name}`")
