"""Solves on the host as functions of JAX: callbacks where values are not known yet, and refusals of derivatives that a solve does not have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

from softfish._arrays import Array
from softfish._errors import DerivativeError, Error, InputError
from softfish._optional import optional

#: Arrays, to arrays of these shapes.
Call: TypeAlias = Callable[[Sequence[Any], tuple[Any, ...]], Sequence[Any]]

jax: Any = optional("jax")
jnp: Any = optional("jax.numpy")
ad: Any = optional("jax.interpreters.ad")
batching: Any = optional("jax.interpreters.batching")
mlir: Any = optional("jax.interpreters.mlir")
optional("jax.extend.core")


def real(name: str, value: Any) -> Any:
    """An array in the precision that it has: single or double; whole numbers and lists in JAX's own."""
    try:
        array = jnp.asarray(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"`{name}` is no array of numbers", str(error), "pass numbers") from error
    if not jnp.issubdtype(array.dtype, jnp.floating) and not jnp.issubdtype(array.dtype, jnp.integer):
        raise InputError(f"`{name}` holds {array.dtype}", "real numbers are required", "convert it")
    if jnp.issubdtype(array.dtype, jnp.floating) and array.dtype.itemsize < 4:
        raise InputError(f"`{name}` holds {array.dtype}", "half precision has three digits", "convert it to float64")
    return array if jnp.issubdtype(array.dtype, jnp.floating) else array.astype(float)


class Derivative:
    """A derivative on the host: `along` gives the outputs along tangents, `adjoint` the gradient of cotangents, both of lists of arrays that
    begin with arguments and outputs. Both modes of JAX have it, and transforms of them; `what` is said where it is differentiated itself.

    A `jax.custom_vjp` has reverse mode alone and a `jax.custom_jvp` of a callback forward mode alone, and what they lack is an untyped error under
    `jax.jit`; `jax.custom_derivatives.linear_call` has both but no batches. A primitive has all.
    """

    def __init__(self, along: Call, adjoint: Call, what: str) -> None:
        self.along, self.adjoint, self.what = along, adjoint, what

    def __call__(self, known: Sequence[Any], tangents: Sequence[Any]) -> tuple[Any, ...]:
        """The outputs along the tangents of the arguments; `known` are arguments and outputs."""
        shapes = tuple(_shape(array) for array in known[len(tangents) :])
        return tuple(_LINEAR.bind(*known, *tangents, of=self, count=len(known), shapes=shapes, is_adjoint=False))


def _compute(*given: Any, of: Derivative, shapes: tuple[Any, ...], is_adjoint: bool, **_: Any) -> list[Any]:
    return list((of.adjoint if is_adjoint else of.along)(given, shapes))


def _shape(array: Any) -> Any:
    of = array.aval if ad.is_undefined_primal(array) else array
    return jax.ShapeDtypeStruct(of.shape, of.dtype)


def _transpose(cotangents: Sequence[Any], *given: Any, count: int, is_adjoint: bool, **settings: Any) -> list[Any]:
    arrays, linear = given[:count], given[count:]
    full = [ad.instantiate_zeros(cotangent) for cotangent in cotangents]
    settings["shapes"] = tuple(_shape(array) for array in linear)
    gradient = _LINEAR.bind(*arrays, *full, count=count, is_adjoint=not is_adjoint, **settings)
    asked = [out if ad.is_undefined_primal(array) else None for array, out in zip(linear, gradient, strict=True)]
    return [None] * count + asked


def _along(given: Sequence[Any], tangents: Sequence[Any], *, of: Derivative, count: int, **settings: Any) -> Any:
    """Linear in the tangents; by the arguments it is a second derivative."""
    if any(not isinstance(tangent, ad.Zero) for tangent in tangents[:count]):
        raise DerivativeError(of.what, "a solver has first derivatives alone", "use differences of first derivatives")
    linear = [ad.instantiate_zeros(tangent) for tangent in tangents[count:]]
    settings |= {"of": of, "count": count}
    return _LINEAR.bind(*given, **settings), _LINEAR.bind(*given[:count], *linear, **settings)


def _one_after_the_other(given: Sequence[Any], axes: Sequence[Any], **settings: Any) -> tuple[list[Any], list[int]]:
    """A batch, case by case: solves share a factor."""
    is_batch = [axis is not None for axis in axes]
    moved = [jnp.moveaxis(array, axis, 0) for array, axis in zip(given, axes, strict=True) if axis is not None]

    def case(parts: Sequence[Any]) -> list[Any]:
        rest = iter(parts)
        return list(_LINEAR.bind(*(next(rest) if batch else array for array, batch in zip(given, is_batch, strict=True)), **settings))

    outputs = jax.lax.map(case, moved)
    return outputs, [0] * len(outputs)


def _primitive() -> Any:
    linear = jax.extend.core.Primitive("softfish_derivative")
    linear.multiple_results = True
    linear.def_impl(_compute)
    linear.def_abstract_eval(lambda *_, shapes, **__: [jax.core.ShapedArray(of.shape, of.dtype) for of in shapes])
    mlir.register_lowering(linear, mlir.lower_fun(_compute, multiple_results=True))
    batching.primitive_batchers[linear] = _one_after_the_other
    ad.primitive_jvps[linear] = _along
    ad.primitive_transposes[linear] = _transpose
    return linear


_LINEAR = _primitive()


def differentiable(value: Call, derivative: Derivative, shapes: Callable[[Sequence[Any]], tuple[Any, ...]]) -> Any:
    """A function of arrays with a derivative; `shapes` are those of its outputs, by its arguments."""

    def compute(*arrays: Any) -> tuple[Any, ...]:
        return tuple(value(arrays, shapes(arrays)))

    def rule(arrays: Sequence[Any], tangents: Sequence[Any]) -> Any:
        outputs = call(*arrays)
        return outputs, derivative((*arrays, *outputs), tangents)

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
