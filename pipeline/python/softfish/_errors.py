"""Exceptions: each says what is wrong, why, and what to do."""

from __future__ import annotations


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


class MeshError(InputError):
    """A mesh or its file is refused."""


class CaseError(InputError):
    """A case is refused: an unknown key, a number out of range, a place where nothing lies."""


class ConvergenceError(Error, RuntimeError):
    """No equilibrium, or no time step, is found."""


class NotStableError(Error, RuntimeError):
    """An equilibrium at which the tangent is not positive definite: it has no gradient."""


class BusyError(Error, RuntimeError):
    """Another thread is in a solve of the same solver."""


class MissingError(Error, ImportError):
    """An optional package is not installed."""
