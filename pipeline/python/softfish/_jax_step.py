"""One step of a reduced model as a function of JAX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from softfish._arguments import checked
from softfish._errors import InputError
from softfish._jax_host import Derivative, Host, differentiable, jax, jnp, real
from softfish._step import Step

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

_SECOND = "a second derivative of a step is asked for"


class JaxStep:
    """See `ReducedModel.jax_step`."""

    def __init__(self, model: ReducedModel, dt: float, settings: Mapping[str, Any]) -> None:
        self.model = model
        self.dt = dt
        self.settings = dict(settings)
        self._begin()

    def _begin(self) -> None:
        self._host = Host()
        self._call = self._differentiable()

    def __getstate__(self) -> dict[str, Any]:
        return {"model": self.model, "dt": self.dt, "settings": self.settings}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    def check(self) -> None:
        """Raises the exception of a step that failed under `jax.jit`."""
        self._host.check()

    @checked()
    def __call__(self, coordinates: Any, velocity: Any, pressures: Any) -> tuple[Any, Any]:
        """Coordinates and velocity after the step."""
        self.check()
        count, chambers = self.model.coordinates, self.model._solver.chamber_count
        pairs = zip(("coordinates", "velocity", "pressures"), (coordinates, velocity, pressures), strict=True)
        arrays = [real(name, value) for name, value in pairs]
        for name, array, size in zip(("coordinates", "velocity", "pressures"), arrays, (count, count, chambers), strict=True):
            if array.shape != (size,):
                raise InputError(f"`{name}` has the shape {array.shape}", f"({size},) is required", "jax.vmap makes batches")
        q, v = self._call(*arrays)
        return q, v

    def _differentiable(self) -> Any:
        step, host = Step(self.model, self.dt, self.settings), self._host

        def value(arrays: Sequence[Any], shapes: tuple[Any, ...]) -> Any:
            return host.call(step.after, shapes, arrays)

        def along(arrays: Sequence[Any], shapes: tuple[Any, ...]) -> Any:
            return host.call(lambda values: step.along(values[:5], values[5:]), shapes, arrays)

        def adjoint(arrays: Sequence[Any], shapes: tuple[Any, ...]) -> Any:
            return host.call(lambda values: step.adjoint(values[:5], values[5:]), shapes, arrays)

        def shapes(arrays: Sequence[Any]) -> tuple[Any, ...]:
            shape = jax.ShapeDtypeStruct(arrays[0].shape, jnp.result_type(*arrays))
            return shape, shape

        return differentiable(value, Derivative(along, adjoint, _SECOND), shapes)

    def __repr__(self) -> str:
        return f"JaxStep({self.dt:g} s of {self.model!r})"
