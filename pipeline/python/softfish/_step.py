"""A step of a reduced model between arrays, with its derivatives in both directions: what PyTorch and JAX wrap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from softfish._arrays import Array
from softfish._reduced import ReducedGradient, ReducedModel, ReducedState


@dataclass(frozen=True)
class Step:
    """Coordinates, velocity and pressures before, to coordinates and velocity after `dt` seconds."""

    model: ReducedModel
    dt: float
    settings: Mapping[str, Any]

    def after(self, values: Sequence[Array]) -> tuple[Array, Array]:
        """Coordinates and velocity after the step."""
        state = self.model.step(ReducedState(values[0], values[1]), values[2], self.dt, **self.settings)
        return state.coordinates, state.velocity

    def adjoint(self, known: Sequence[Array], cotangents: Sequence[Array]) -> tuple[Array, Array, Array]:
        """The gradient of Σ cotangent · state after by coordinates, velocity and pressures; `known` are these, and the state after."""
        gradient = self._gradient(known, ReducedState(cotangents[0], cotangents[1]))
        return gradient.state.coordinates, gradient.state.velocity, gradient.pressures

    def along(self, known: Sequence[Array], tangents: Sequence[Array | None]) -> tuple[Array, Array]:
        """The change of the state after along tangents of coordinates, velocity and pressures, by an adjoint solve for each of its numbers: a
        model has a few dozen."""
        count = self.model.coordinates
        changed = np.zeros(2 * count)
        for n, unit in enumerate(np.eye(2 * count)):
            parts = self.adjoint(known, (unit[:count], unit[count:]))
            changed[n] = sum(float(part @ tangent) for part, tangent in zip(parts, tangents, strict=True) if tangent is not None)
        return changed[:count], changed[count:]

    def _gradient(self, known: Sequence[Array], loss: ReducedState) -> ReducedGradient:
        states = (ReducedState(known[0], known[1]), ReducedState(known[3], known[4]))
        return self.model.step_gradient(states, loss, known[2], self.dt, **self.settings)
