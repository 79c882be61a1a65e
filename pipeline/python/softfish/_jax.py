"""Solvers as functions of JAX."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from softfish._arrays import Array, whole, word
from softfish._errors import InputError
from softfish._function import Function, FunctionSettings
from softfish._jax_host import Host, differentiable_once, jax, jnp, real, reverse_mode

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softfish._solver import Equilibrium, Motion, Solver

_SECOND = "a second derivative of a solve is asked for"


class JaxFunction:
    """`output` of a solver as a function of JAX arrays, in the order of `wrt`; both as those of `softfish.TorchFunction`.

    `mode` is `reverse` (`jax.custom_vjp`) or `forward` (`jax.custom_jvp`): JAX has one or the other. Solves are host
    callbacks, made one after the other under `jax.vmap` (`vmap_method="sequential"`). The last `kept` results stay on the
    host, so that a backward pass finds the result of its forward solve. A derivative that it does not have, as a second one or `jax.jvp` in
    reverse mode, is refused by a `DerivativeError`. The settings are those of `Solver.equilibrium`, or of `Solver.simulate`.

    A solve that fails raises its own exception; under `jax.jit`, where nothing can be raised, its output is NaN, and the
    exception is raised by the next call, or by `check()`.
    """

    def __init__(
        self,
        solver: Solver,
        output: str,
        wrt: Sequence[str],
        *,
        mode: Literal["reverse", "forward"] = "reverse",
        kept: int = 64,
        steps: int | None = None,
        **settings: Unpack[FunctionSettings],
    ) -> None:
        self.function = Function(solver, output, wrt, steps, settings)
        self._kept = whole("kept", kept, 1, 1_000_000)
        self._mode = word("mode", mode, ("reverse", "forward"))
        self._begin()

    def _begin(self) -> None:
        self._results: OrderedDict[tuple[bytes, ...], Equilibrium | Motion] = OrderedDict()
        self._host = Host()
        self._call = self._reverse() if self._mode == "reverse" else self._forward()

    def __getstate__(self) -> dict[str, Any]:
        return {"function": self.function, "_kept": self._kept, "_mode": self._mode}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    def __call__(self, *values: Any) -> Any:
        """The output at `values`, one for each of `wrt`."""
        parameters = self.function.parameters
        if len(values) != len(parameters):
            names = ", ".join(parameter.name for parameter in parameters)
            raise InputError(f"{len(values)} arguments are given", f"the function has {names}", "give one for each")
        self.check()
        arrays = [real(parameter.name, value) for parameter, value in zip(parameters, values, strict=True)]
        for parameter, array in zip(parameters, arrays, strict=True):
            if array.shape != parameter.shape:
                why = f"{parameter.shape} is required; jax.vmap makes batches"
                raise InputError(f"`{parameter.name}` has the shape {array.shape}", why, "check its axes")
        return reverse_mode(self._call, arrays, 'make the function with mode="forward"')

    def check(self) -> None:
        """Raises the exception of a solve that failed under `jax.jit`."""
        self._host.check()

    def _result(self, values: Sequence[Array]) -> Equilibrium | Motion:
        """The result at `values`, the kept one where there is one."""
        key = tuple(value.tobytes() for value in values)
        if key not in self._results:
            self._results[key] = self.function.solve(values)
        self._results.move_to_end(key)
        while len(self._results) > self._kept:
            self._results.popitem(last=False)
        return self._results[key]

    def _shape(self, arrays: Sequence[Any]) -> Any:
        return jax.ShapeDtypeStruct(self.function.shape, jnp.result_type(*arrays))

    def _value(self, *arrays: Any) -> Any:
        return self._host.call(lambda values: self.function.value(self._result(values)), self._shape(arrays), arrays)

    def _reverse(self) -> Any:
        count = len(self.function.parameters)

        def adjoint(values: list[Array]) -> list[Array]:
            return self.function.vjp(self._result(values[:count]), values[count])

        def backward(*given: Any) -> Any:
            shapes = tuple(jax.ShapeDtypeStruct(array.shape, array.dtype) for array in given[:count])
            return self._host.call(adjoint, shapes, given)

        value, once = differentiable_once(self._value, _SECOND), differentiable_once(backward, _SECOND)
        call = jax.custom_vjp(self._value)
        call.defvjp(lambda *arrays: (value(*arrays), arrays), lambda arrays, cotangent: tuple(once(*arrays, cotangent)))
        return call

    def _forward(self) -> Any:
        count = len(self.function.parameters)

        def along(values: list[Array]) -> Array:
            return self.function.jvp(self._result(values[:count]), values[count:])

        def changed(*given: Any) -> Any:
            return self._host.call(along, self._shape(given[:count]), given)

        once = differentiable_once(changed, _SECOND)

        def rule(arrays: Any, tangents: Any) -> Any:
            full = [
                jnp.zeros_like(array) if isinstance(tangent, jax.custom_derivatives.SymbolicZero) else tangent
                for array, tangent in zip(arrays, tangents, strict=True)
            ]
            return call(*arrays), once(*arrays, *full)

        call = jax.custom_jvp(self._value)
        call.defjvp(rule)
        return call

    def __repr__(self) -> str:
        of = self.function
        return f"JaxFunction({of.output} by {', '.join(one.name for one in of.parameters)}: {of.shape}, {self._mode})"
