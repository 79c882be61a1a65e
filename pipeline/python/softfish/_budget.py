"""Limits of a solve: Newton iterations, cut-backs of a load step, and seconds."""

from __future__ import annotations

from softfish._arrays import whole, within


def limits(max_iterations: int | None, max_cutbacks: int | None, timeout: float | None) -> tuple[int | None, int | None, float | None]:
    """Them, checked; none where there is none."""
    return (
        None if max_iterations is None else whole("max_iterations", max_iterations, 1, 10**9),
        None if max_cutbacks is None else whole("max_cutbacks", max_cutbacks, 0, 10_000),
        None if timeout is None else within("timeout", timeout, 1e-3, 1e7),
    )
