"""One layer that checks arguments: what a name may hold is said once, for every signature that has it.

`checked` replaces each argument whose name is known by what its check returns, so that a function sees plain numbers, words and truth values. What
depends on a body, such as the shape of forces, is checked where the body is.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from difflib import get_close_matches
from typing import Any, ParamSpec, TypeAlias, TypeVar

from softfish._arrays import file, flag, fraction, not_negative, positive, text, whole, within, word
from softfish._errors import ArgumentError

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
#: Name and value of an argument, to its value as it is used.
Check: TypeAlias = Callable[[str, Any], Any]


def counted(low: int, high: int) -> Check:
    """Whole numbers from `low` to `high`."""
    return lambda name, value: whole(name, value, low, high)


def between(low: float, high: float) -> Check:
    """Numbers from `low` to `high`."""
    return lambda name, value: within(name, value, low, high)


def one_of(*words: str) -> Check:
    """One of some words."""
    return lambda name, value: word(name, value, words)


#: What an argument of this name may hold, wherever it stands.
CHECKS: dict[str, Check] = {
    "columns": counted(3, 100),
    "count": counted(1, 1_000_000),
    "dots": flag,
    "dt": positive,
    "edge": between(1e-5, 1.0),
    "every": counted(1, 1000),
    "film": file,
    "find": counted(1, 1000),
    "first": counted(0, 1 << 40),
    "fisheye": flag,
    "half": flag,
    "hidden": between(0.0, 3600.0),
    "item": text,
    "kept": counted(1, 1_000_000),
    "last": counted(0, 1 << 40),
    "level": between(-1e3, 1e3),
    "library": one_of("polars", "pandas"),
    "load_steps": counted(1, 10_000),
    "lumped_mass": flag,
    "mass_damping": not_negative,
    "max_cutbacks": counted(0, 10_000),
    "max_iterations": counted(1, 10**9),
    "memory": counted(0, 1 << 62),
    "order": counted(1, 2),
    "out": file,
    "overlay": flag,
    "page": file,
    "path": file,
    "profile": one_of("paper", "quick", "population"),
    "quiet": flag,
    "radius": between(4.0, 1000.0),
    "reuse_factor": flag,
    "root": file,
    "rows": counted(3, 100),
    "scheme": one_of("bdf2", "implicit_euler", "quasi_static"),
    "specimen": text,
    "spine": file,
    "square": between(1e-3, 1.0),
    "stage": text,
    "stale": flag,
    "step": positive,
    "steps": counted(1, 10_000_000),
    "stiffness_damping": not_negative,
    "threads": counted(1, 1024),
    "timeout": between(1e-3, 1e7),
    "tolerance": fraction,
    "unit": one_of("m", "mm", "cm", "inch"),
}


def checked(**others: Check) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A function whose arguments are checked by their names; `others` are checks that hold for it alone."""

    def decorate(call: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(call)
        known = {**CHECKS, **others}
        checks = [(one.name, known[one.name], one.default is None) for one in signature.parameters.values() if one.name in known]

        @functools.wraps(call)
        def run(*args: P.args, **given: P.kwargs) -> R:
            try:
                bound = signature.bind(*args, **given)
            except TypeError as error:
                raise _unfit(call, signature, (error, given)) from error
            arguments = bound.arguments
            for name, check, may_be_none in checks:
                if name in arguments and not (may_be_none and arguments[name] is None):
                    arguments[name] = check(name, arguments[name])
            return call(*bound.args, **bound.kwargs)

        return run

    return decorate


def checked_constructor(kind: type[T]) -> type[T]:
    """A class whose constructor is checked in the same way."""
    setattr(kind, "__init__", checked()(kind.__init__))
    return kind


def _unfit(call: Callable[..., Any], signature: inspect.Signature, failed: tuple[TypeError, dict[str, Any]]) -> ArgumentError:
    """Arguments that are no arguments of a call."""
    error, given = failed
    names = [name for name in signature.parameters if name not in ("self", "cls")]
    near = [match for name in given if name not in names for match in get_close_matches(name, names, 1)]
    action = f"write `{near[0]}`" if near else "correct the call"
    return ArgumentError(f"`{call.__qualname__}` cannot be called so: {error}", f"its arguments are {', '.join(names) or 'none'}", action)
