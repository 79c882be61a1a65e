"""One step of a reduced model as a function of JAX."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from softfish._arrays import Array
from softfish._errors import InputError
from softfish._jax_host import Host, differentiable_once, jax, jnp, real, reverse_mode

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

_SECOND = "a second derivative of a step is asked for"
_REMEDY = "use jax.grad, jax.vjp or jax.jacrev"


class JaxStep:
    """See `ReducedModel.jax_step`."""

    def __init__(self, model: ReducedModel, dt: float, settings: Mapping[str, Any]) -> None:
        self.model = model
        self.dt = dt
        self.settings = dict(settings)
        self._begin()

    def _begin(self) -> None:
        self._host = Host()
        self._call = self._reverse()

    def __getstate__(self) -> dict[str, Any]:
        return {"model": self.model, "dt": self.dt, "settings": self.settings}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    def check(self) -> None:
        """Raises the exception of a step that failed under `jax.jit`."""
        self._host.check()

    def __call__(self, coordinates: Any, velocity: Any, pressures: Any) -> tuple[Any, Any]:
        """Coordinates and velocity after the step."""
        self.check()
        count, chambers = self.model.coordinates, self.model._solver.chamber_count
        pairs = zip(("coordinates", "velocity", "pressures"), (coordinates, velocity, pressures), strict=True)
        arrays = [real(name, value) for name, value in pairs]
        for name, array, size in zip(("coordinates", "velocity", "pressures"), arrays, (count, count, chambers), strict=True):
            if array.shape != (size,):
                raise InputError(f"`{name}` has the shape {array.shape}", f"({size},) is required", "jax.vmap makes batches")
        after: tuple[Any, Any] = reverse_mode(self._call, arrays, _REMEDY)
        return after

    def _reverse(self) -> Any:
        from softfish._reduced import ReducedState

        model = self.model

        def step(values: list[Array]) -> tuple[Array, Array]:
            after = model.step(ReducedState(*values[:2]), values[2], self.dt, **self.settings)
            return after.coordinates, after.velocity

        def adjoint(values: list[Array]) -> tuple[Array, Array, Array]:
            states = (ReducedState(*values[:2]), ReducedState(*values[3:5]))
            gradient = model.step_gradient(states, ReducedState(*values[5:]), values[2], self.dt, **self.settings)
            return gradient.state.coordinates, gradient.state.velocity, gradient.pressures

        def value(*arrays: Any) -> Any:
            shape = jax.ShapeDtypeStruct(arrays[0].shape, jnp.result_type(*arrays))
            return self._host.call(step, (shape, shape), arrays)

        def backward(*arrays: Any) -> Any:
            shapes = tuple(jax.ShapeDtypeStruct(array.shape, array.dtype) for array in arrays[:3])
            return self._host.call(adjoint, shapes, arrays)

        def forward(*arrays: Any) -> Any:
            after = value_once(*arrays)
            return after, (*arrays, *after)

        value_once, backward_once = differentiable_once(value, _SECOND), differentiable_once(backward, _SECOND)
        call = jax.custom_vjp(value)
        call.defvjp(forward, lambda arrays, cotangents: backward_once(*arrays, *cotangents))
        return call

    def __repr__(self) -> str:
        return f"JaxStep({self.dt:g} s of {self.model!r})"
