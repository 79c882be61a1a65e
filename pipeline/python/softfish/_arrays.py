"""Arguments: shape, type, range and finiteness checked once, at the border, with the argument named as the caller named it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from softfish._errors import InputError

Array: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
T = TypeVar("T", bound=np.generic)
#: A number, or one number for each name.
ByName: TypeAlias = "float | npt.ArrayLike | Mapping[str, Any]"


def array_of(name: str, value: Any) -> npt.NDArray[Any]:
    """`value` as a contiguous array of whatever it holds; a plain number as one of length 1."""
    if np.ma.is_masked(value):
        raise InputError(f"`{name}` has masked entries", "what they hold would be used", "fill them, or leave them out")
    try:
        return np.ascontiguousarray(value)
    except (TypeError, ValueError, RuntimeError) as error:
        raise InputError(f"`{name}` is no array of numbers", str(error), "pass numbers") from error


def reals(name: str, value: Any, shape: tuple[int, ...] | None = None) -> Array:
    """`value` as contiguous double precision of `shape`; refused where a number is not finite."""
    array = array_of(name, value)
    if array.dtype.kind not in "fiu":
        raise InputError(f"`{name}` holds {array.dtype}", "real numbers are required", "convert it to float64")
    if array.dtype == np.float16:
        raise InputError(f"`{name}` holds {array.dtype}", "half precision has three digits", "convert it to float64")
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
    array = array_of(name, value)
    if array.dtype.kind not in "iu":
        raise InputError(f"`{name}` holds {array.dtype}", "whole numbers are required", "convert it to int64")
    if array.dtype == np.uint64 and array.size and int(array.max()) > np.iinfo(np.int64).max:
        raise InputError(f"`{name}` holds {array.max()}", "numbers lie below 2^63", "number anew")
    return np.ascontiguousarray(array, dtype=np.int64)


def number(name: str, value: Any) -> float:
    """`value` as one finite number."""
    return float(reals(name, value, ()))


def not_negative(name: str, value: Any) -> float:
    """`value` as one number that is not below 0."""
    given = number(name, value)
    if given < 0.0:
        raise InputError(f"`{name}` is {given:g}", "it is not below 0", "give 0 or a positive number")
    return given


def fraction(name: str, value: Any) -> float:
    """`value` as a tolerance in sizes of the body."""
    given = number(name, value)
    if not 0.0 < given <= 1e-2:
        raise InputError(f"`{name}` is {given:g}", "it is a part of the body's size, above 0 and at most 0.01", "give a number in this range")
    return given


def within(name: str, value: Any, low: float, high: float) -> float:
    """`value` as one number from `low` to `high`."""
    given = number(name, value)
    if not low <= given <= high:
        raise InputError(f"`{name}` is {given:g}", f"it lies between {low:g} and {high:g}", "give a number in this range")
    return given


def positive(name: str, value: Any) -> float:
    """`value` as one number above 0."""
    given = number(name, value)
    if given <= 0.0:
        raise InputError(f"`{name}` is {given:g}", "it lies above 0", "give a positive number")
    return given


def whole(name: str, value: Any, low: int, high: int) -> int:
    """`value` as one whole number from `low` to `high`."""
    counts = isinstance(value, int | np.integer) or (isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype.kind in "iu")
    if not counts or isinstance(value, bool):
        raise InputError(f"`{name}` is {value!r}", "it counts", "give a whole number")
    given = int(value)
    if not low <= given <= high:
        raise InputError(f"`{name}` is {given}", f"it lies between {low} and {high}", "give a number in this range")
    return given


def flag(name: str, value: Any) -> bool:
    """`value` as a truth value."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise InputError(f"`{name}` is {value!r}", "it is True or False", "give a truth value")


def text(name: str, value: Any) -> str:
    """`value` as a text that is not empty."""
    if isinstance(value, str) and value:
        return value
    raise InputError(f"`{name}` is {value!r}", "it is a name", "give a text")


def table(name: str, value: Any, keys: Sequence[str] = ()) -> Mapping[str, Any]:
    """`value` as a dictionary that has the `keys`."""
    if not isinstance(value, Mapping):
        raise InputError(f"`{name}` is a {type(value).__name__}", "it is a dictionary", "pass one")
    absent = [key for key in keys if key not in value]
    if absent:
        raise InputError(f"`{name}` lacks {', '.join(absent)}", f"it has {', '.join(map(str, value)) or 'nothing'}", "add what is absent")
    return value


def word(name: str, value: Any, known: Sequence[str]) -> str:
    """`value` as one of the `known` words."""
    if isinstance(value, str) and value in known:
        return value
    raise InputError(f"`{name}` is {value!r}", f"known are {', '.join(known)}", "name one of them")


def repeated(names: Sequence[str]) -> str | None:
    """The first of the names that stands there twice; a mesh may have tens of thousands."""
    seen: set[str] = set()
    return next((name for name in names if name in seen or seen.add(name)), None)  # type: ignore[func-returns-value]


def instance(name: str, value: Any, kind: type | tuple[type, ...], action: str) -> None:
    """Refuses a `value` that is not of a `kind`."""
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        why = f"it is a {' or a '.join(one.__name__ for one in kinds)}"
        raise InputError(f"`{name}` is a {type(value).__name__}", why, action)


def file(name: str, value: Any) -> str:
    """`value` as the name of a file or folder."""
    try:
        given = os.fspath(value)
    except TypeError:
        given = None
    if not isinstance(given, str) or not given or "\0" in given:
        raise InputError(f"`{name}` is {value!r}", "it names a file or a folder", "give a text or a pathlib.Path")
    return given


def frozen(array: npt.NDArray[T]) -> npt.NDArray[T]:
    """The same array, read-only: a solver reads it again, or a change of it would have no effect."""
    array.setflags(write=False)
    return array


class Sealed:
    """Something with attributes that are set once: the derivatives of a result are those of the shape that was found, not of another one that is
    put in its place, and an attribute that nothing reads would have no effect."""

    def __setattr__(self, name: str, value: Any) -> None:
        is_known = any(name in vars(one).get("__annotations__", {}) for one in type(self).__mro__)
        if not name.startswith("_") and (name in self.__dict__ or not is_known):
            kind = type(self).__name__
            why = f"a {kind} keeps what it was made of" if is_known or hasattr(type(self), name) else f"a {kind} has no attribute `{name}`"
            raise InputError(f"`{name}` of a {kind} is set", why, f"make another {kind}, or give it as an argument")
        object.__setattr__(self, name, value)


def copied(array: npt.NDArray[Any]) -> Any:
    """A read-only copy, which nobody else can write to."""
    own = np.array(array)
    own.setflags(write=False)
    return own


def named(what: str, names: list[str], base: Array, given: ByName | None, argument: str | None = None) -> Array:
    """One number for each of `names`: `base`, with what is `given` in its place.

    A plain number is allowed where there is one name, and a list in the order of the names.
    """
    said = argument or what
    values = base.copy()
    if given is None:
        return values
    if isinstance(given, Mapping):
        for name, value in given.items():
            if name not in names:
                known = ", ".join(names) or "none"
                raise InputError(f"there is no {what} `{name}`", f"known are {known}", "correct the name")
            values[names.index(name)] = number(f"{said}[{name!r}]", value)
        return values
    array = reals(said, given)
    if array.ndim == 0 and len(names) == 1:
        values[0] = array
        return values
    if array.shape != (len(names),):
        why = f"there are {len(names)} of the kind {what}: {', '.join(names) or 'none'}"
        raise InputError(f"`{said}` has the shape {array.shape}", why, "give one number for each, or a dictionary by name")
    return array.copy()
