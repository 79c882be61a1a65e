"""Solvers as functions of JAX."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._arguments import checked
from softfish._arrays import Array
from softfish._errors import ArgumentError, InputError
from softfish._function import Function, FunctionSettings
from softfish._jax_host import Derivative, Host, differentiable, jax, jnp, real

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softfish._results import Equilibrium, Motion
    from softfish._solver import Solver

_SECOND = "a second derivative of a solve is asked for"


class JaxFunction:
    """`output` of a solver as a function of JAX arrays, in the order of `wrt`; both as those of `softfish.TorchFunction`.

    Both modes are there, and go with `jax.jit`, `jax.vmap`, `jax.lax.scan` and `jax.checkpoint`: reverse mode by adjoint solves, forward mode by
    sensitivities. Solves are host callbacks, made one after the other under `jax.vmap`. The last `kept` results stay on the host, so that a
    derivative finds the result of its solve. A second derivative, and forward mode of a motion by what it has no sensitivities of, are refused by a
    `DerivativeError`. The settings are those of `Solver.equilibrium`, or of `Solver.simulate`.

    A solve that fails raises its own exception; under `jax.jit`, where nothing can be raised, its output is NaN, and the
    exception is raised by the next call, or by `check()`.
    """

    @checked()
    def __init__(
        self,
        solver: Solver,
        output: str,
        wrt: Sequence[str],
        *,
        kept: int = 64,
        steps: int | None = None,
        **settings: Unpack[FunctionSettings],
    ) -> None:
        self.function = Function(solver, output, wrt, steps, settings)
        self._kept = kept
        self._begin()

    def _begin(self) -> None:
        self._results: OrderedDict[tuple[bytes, ...], Equilibrium | Motion] = OrderedDict()
        self._host = Host()
        self._call = self._differentiable()

    def __getstate__(self) -> dict[str, Any]:
        return {"function": self.function, "_kept": self._kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    def __call__(self, *values: Any, **unknown: Any) -> Any:
        """The output at `values`, one for each of `wrt`."""
        parameters = self.function.parameters
        names = ", ".join(parameter.name for parameter in parameters)
        if unknown:
            why = f"the arguments have no names; they are, in this order, {names}"
            raise ArgumentError(f"`{next(iter(unknown))}` is given by name", why, "give the values alone")
        if len(values) != len(parameters):
            raise InputError(f"{len(values)} arguments are given", f"the function has {names}", "give one for each")
        self.check()
        arrays = [real(parameter.name, value) for parameter, value in zip(parameters, values, strict=True)]
        for parameter, array in zip(parameters, arrays, strict=True):
            if array.shape != parameter.shape:
                why = f"{parameter.shape} is required; jax.vmap makes batches"
                raise InputError(f"`{parameter.name}` has the shape {array.shape}", why, "check its axes")
        return self._call(*arrays)[0]

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

    def _differentiable(self) -> Any:
        function, host, count = self.function, self._host, len(self.function.parameters)

        def value(arrays: Sequence[Any], shapes: tuple[Any, ...]) -> Any:
            return host.call(lambda values: (function.value(self._result(values)),), shapes, arrays)

        def along(arrays: Sequence[Any], shapes: tuple[Any, ...]) -> Any:
            return host.call(lambda values: (function.jvp(self._result(values[:count]), values[count + 1 :]),), shapes, arrays)

        def adjoint(arrays: Sequence[Any], shapes: tuple[Any, ...]) -> Any:
            return host.call(lambda values: tuple(function.vjp(self._result(values[:count]), values[count + 1])), shapes, arrays)

        def shapes(arrays: Sequence[Any]) -> tuple[Any, ...]:
            return (jax.ShapeDtypeStruct(function.shape, jnp.result_type(*arrays)),)

        return differentiable(value, Derivative(along, adjoint, _SECOND), shapes)

    def __repr__(self) -> str:
        of = self.function
        return f"JaxFunction({of.output} by {', '.join(one.name for one in of.parameters)}: {of.shape})"
