"""Solves on the host as functions of JAX: callbacks where values are not known yet, and refusals of derivatives that a solve does not have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from softfish._arrays import Array
from softfish._errors import DerivativeError, Error, InputError
from softfish._optional import optional

jax: Any = optional("jax")
jnp: Any = optional("jax.numpy")


def real(name: str, value: Any) -> Any:
    """An array in the precision that it has: single or double; whole numbers and lists in JAX's own."""
    array = jnp.asarray(value)
    if not jnp.issubdtype(array.dtype, jnp.floating) and not jnp.issubdtype(array.dtype, jnp.integer):
        raise InputError(f"`{name}` holds {array.dtype}", "real numbers are required", "convert it")
    if jnp.issubdtype(array.dtype, jnp.floating) and array.dtype.itemsize < 4:
        raise InputError(f"`{name}` holds {array.dtype}", "half precision has three digits", "convert it to float64")
    return array if jnp.issubdtype(array.dtype, jnp.floating) else array.astype(float)


def reverse_mode(call: Any, arrays: Sequence[Any], remedy: str) -> Any:
    """A call of a `jax.custom_vjp`, whose own error in a transform of forward mode becomes a `DerivativeError`."""
    try:
        return call(*arrays)
    except TypeError as error:
        if "forward-mode" not in str(error):
            raise
        why = "JAX gives a function reverse or forward mode; this one has reverse mode, and no second derivatives"
        raise DerivativeError("forward mode of a solve is asked for", why, remedy) from error


def differentiable_once(compute: Any, what: str) -> Any:
    """`compute` as a function that refuses to be differentiated."""

    def rule(*_: Any) -> Any:
        raise DerivativeError(what, "a solver has first derivatives alone", "use differences of first derivatives")

    call = jax.custom_jvp(compute)
    call.defjvp(rule)
    return call


class Host:
    """Calls of numpy, with the exception of the last one that failed under `jax.jit`."""

    def __init__(self) -> None:
        self._failure: Error | None = None

    def check(self) -> None:
        """Raises the exception of a solve that failed under `jax.jit`."""
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

    def call(self, compute: Any, shapes: Any, arrays: Sequence[Any]) -> Any:
        """`compute` of double-precision arrays on the host: at once where the values are known, else by a callback."""
        leaves, tree = jax.tree.flatten(shapes)

        def cast(outputs: Any) -> Any:
            flat = [np.asarray(out, dtype=of.dtype) for out, of in zip(jax.tree.leaves(outputs), leaves, strict=True)]
            return jax.tree.unflatten(tree, flat)

        def doubles(values: Sequence[Any]) -> list[Array]:
            return [np.array(value, dtype=np.float64) for value in values]

        if not any(isinstance(array, jax.core.Tracer) for array in arrays):
            return jax.tree.map(jnp.asarray, cast(compute(doubles(arrays))))

        def callback(*values: Any) -> Any:
            try:
                return cast(compute(doubles(values)))
            except Error as failure:
                # An exception in a callback would end the runtime's own thread.
                self._failure = failure
                return jax.tree.unflatten(tree, [np.full(of.shape, np.nan, of.dtype) for of in leaves])

        return jax.pure_callback(callback, shapes, *arrays, vmap_method="sequential")
