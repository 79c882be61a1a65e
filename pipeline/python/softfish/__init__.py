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

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from softfish._case import Case
from softfish._core import MATERIALS, __version__
from softfish._errors import (
    ArgumentError,
    BudgetError,
    BusyError,
    CaseError,
    ConvergenceError,
    DerivativeError,
    Error,
    InputError,
    InternalError,
    MeshError,
    MissingAttributeError,
    MissingError,
    NotStableError,
)
from softfish._fit import Fit, FittedLaw, fit
from softfish._instruments import Camera, Tracks, calibrate, track
from softfish._mesh import Mesh
from softfish._project import Project, Record
from softfish._reduced import ReducedGradient, ReducedModel, ReducedState, ReducedStaticGradient
from softfish._results import CriticalPoint, Equilibrium, Gradient, Inputs, Motion, Path
from softfish._solver import Material, Solver
from softfish._twin import Twin, TwinState

if TYPE_CHECKING:
    from softfish._jax import JaxFunction
    from softfish._torch import TorchFunction

__all__ = [
    "MATERIALS",
    "ArgumentError",
    "BudgetError",
    "BusyError",
    "Camera",
    "Case",
    "CaseError",
    "ConvergenceError",
    "CriticalPoint",
    "DerivativeError",
    "Equilibrium",
    "Error",
    "Fit",
    "FittedLaw",
    "Gradient",
    "InputError",
    "Inputs",
    "InternalError",
    "Material",
    "Mesh",
    "MeshError",
    "MissingError",
    "Motion",
    "NotStableError",
    "Path",
    "Project",
    "Record",
    "ReducedGradient",
    "ReducedModel",
    "ReducedState",
    "ReducedStaticGradient",
    "Solver",
    "Tracks",
    "Twin",
    "TwinState",
    "calibrate",
    "fit",
    "track",
]
#: Those that need a package which is used where it is installed.
_OPTIONAL = {"JaxFunction": "jax", "TorchFunction": "torch"}
__all__ += [name for name, package in _OPTIONAL.items() if find_spec(package) is not None]


def __getattr__(name: str) -> Any:
    """The functions of PyTorch and JAX, which are loaded where they are used."""
    try:
        if name == "TorchFunction":
            from softfish._torch import TorchFunction

            return TorchFunction
        if name == "JaxFunction":
            from softfish._jax import JaxFunction

            return JaxFunction
    except MissingError as error:
        raise MissingAttributeError(error.what, error.why, error.action) from error
    raise AttributeError(f"module `softfish` has no attribute `{name}`")


def __dir__() -> list[str]:
    """What the package offers."""
    return sorted([*__all__, "__doc__", "__version__"])
