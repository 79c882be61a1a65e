"""Arguments as arrays: shape, type and finiteness checked once, at the border."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from softfish._errors import InputError

Array: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
#: A number, or one number for each name.
ByName: TypeAlias = "float | npt.ArrayLike | Mapping[str, Any]"


def reals(name: str, value: Any, shape: tuple[int, ...] | None = None) -> Array:
    """`value` as contiguous double precision of `shape`; refused where a number is not finite."""
    try:
        array = np.ascontiguousarray(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"`{name}` is no array of numbers", str(error), "pass numbers") from error
    if array.dtype.kind not in "fiu":
        raise InputError(f"`{name}` holds {array.dtype}", "real numbers are required", "convert it to float64")
    array = np.ascontiguousarray(array, dtype=np.float64)
    if np.ndim(value) == 0:
        array = array.reshape(())
    if shape is not None and array.shape != shape:
        raise InputError(f"`{name}` has the shape {array.shape}", f"{shape} is required", "check its axes")
    if not np.all(np.isfinite(array)):
        raise InputError(f"`{name}` holds a number that is not finite", "every number must be finite", "check its source")
    return array


def integers(name: str, value: Any) -> IntArray:
    """`value` as contiguous whole numbers."""
    array = np.ascontiguousarray(value)
    if array.dtype.kind not in "iu":
        raise InputError(f"`{name}` holds {array.dtype}", "whole numbers are required", "convert it to int64")
    return np.ascontiguousarray(array, dtype=np.int64)


def number(name: str, value: Any) -> float:
    """`value` as one finite number."""
    return float(reals(name, value, ()))


def within(name: str, value: Any, low: float, high: float) -> float:
    """`value` as one number from `low` to `high`."""
    given = number(name, value)
    if not low <= given <= high:
        raise InputError(f"`{name}` is {given:g}", f"it lies between {low:g} and {high:g}", "give a number in this range")
    return given


def whole(name: str, value: Any, low: int, high: int) -> int:
    """`value` as one whole number from `low` to `high`."""
    array = np.asarray(value)
    if array.dtype.kind not in "iu" or array.ndim:
        raise InputError(f"`{name}` is {value!r}", "it counts", "give a whole number")
    return int(within(name, int(array), low, high))


def frozen(array: Array) -> Array:
    """The same array, read-only: a solver reads it again."""
    array.setflags(write=False)
    return array


def named(what: str, names: list[str], base: Array, given: ByName | None) -> Array:
    """One number for each of `names`: `base`, with what is `given` in its place.

    A plain number is allowed where there is one name, and a list in the order of the names.
    """
    values = base.copy()
    if given is None:
        return values
    if isinstance(given, Mapping):
        for name, value in given.items():
            if name not in names:
                known = ", ".join(names) or "none"
                raise InputError(f"there is no {what} `{name}`", f"known are {known}", "correct the name")
            values[names.index(name)] = number(f"{what} {name}", value)
        return values
    array = reals(what, given)
    if array.ndim == 0 and len(names) == 1:
        values[0] = array
        return values
    if array.shape != (len(names),):
        why = f"there are {len(names)}: {', '.join(names) or 'none'}"
        raise InputError(f"{what} has the shape {array.shape}", why, "give one number for each, or a dictionary by name")
    return array.copy()
