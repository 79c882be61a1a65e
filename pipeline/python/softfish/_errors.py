"""Exceptions: each says what is wrong, why, and what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from softfish._arrays import Array
    from softfish._results import Equilibrium


class Error(Exception):
    """What is wrong (`what`), why (`why`), and what to do (`action`)."""

    def __init__(self, what: str, why: str = "", action: str = "") -> None:
        super().__init__(what, why, action)
        self.what = what
        self.why = why
        self.action = action

    def __str__(self) -> str:
        lines = [self.what]
        if self.why:
            lines.append(f"  why: {self.why}")
        if self.action:
            lines.append(f"  do:  {self.action}")
        return "\n".join(lines)


class InputError(Error, ValueError):
    """An argument is refused: its shape, its type, a number out of range."""


class ArgumentError(InputError, TypeError):
    """A call has an argument too many, or one too few."""


class MeshError(InputError):
    """A mesh or its file is refused."""


class CaseError(InputError):
    """A case is refused: an unknown key, a number out of range, a place where nothing lies."""


class ConvergenceError(Error, RuntimeError):
    """No equilibrium, or no time step, is found.

    Attributes:
        equilibrium: The last equilibrium on the way, where there is one.
        level: Its level: the part of all loads but gravity that it carries, no unit.
        time: Of a motion, the time of the last state, s.
        displacement: Of a motion, the last displacement: nodes × 3, m.
    """

    equilibrium: Equilibrium | None = None
    level: float | None = None
    time: float | None = None
    displacement: Array | None = None


class BudgetError(ConvergenceError):
    """A solve reached its `max_iterations` or its `timeout`; the last equilibrium and its level are kept."""


class NotStableError(Error, RuntimeError):
    """An equilibrium at which the tangent is not positive definite: it has no gradient."""


class DerivativeError(InputError, NotImplementedError):
    """A derivative that a solve does not have: a second one, or one that a transformation asks for."""


class BusyError(Error, RuntimeError):
    """Another thread is in a solve of the same solver."""


class InternalError(Error, RuntimeError):
    """A defect of the compiled part."""


class MissingError(Error, ImportError):
    """An optional package is not installed."""


class MissingAttributeError(Error, AttributeError):
    """An attribute of the package that needs an optional package which is not installed."""
