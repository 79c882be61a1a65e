"""Progress of a motion: a callback, or a bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from softfish._errors import InputError, MissingError
from softfish._optional import optional

Progress = Callable[[int, int], object]
#: Lines of a motion where there is no bar.
_LINES = 20


@contextmanager
def reporting(progress: Progress | bool | None, steps: int) -> Iterator[Progress | None]:
    """The callback that is told of steps done and all steps (0: not known): the caller's own, tqdm's bar, or lines without tqdm."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        yield from _bar(steps)
    elif callable(progress):
        yield progress
    else:
        raise InputError(f"`progress` is {progress!r}", "it is True, or a function of steps done and all steps", "correct it")


def _bar(steps: int) -> Iterator[Progress]:
    try:
        tqdm = optional("tqdm")
    except MissingError:
        every = max(1, -(-steps // _LINES)) if steps else _LINES
        yield lambda done, planned: done % every == 0 and print(f"step {done} of {planned or '?'}", file=sys.stderr)
        return
    bar: Any = tqdm.tqdm(total=steps or None)
    try:
        yield lambda done, _: bar.update(done - bar.n)
    finally:
        bar.close()
