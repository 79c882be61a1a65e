"""Solves in compiled graphs of PyTorch: an operation that a graph holds without looking into it, with its adjoint.

`torch.compile(fullgraph=True)` and `torch.export` record tensors without numbers, which no solve can read. The operation `softfish::value` gives
them the shapes of its outputs, and solves when the graph runs. It finds its function by a key, so that an exported graph runs in the process that
made it.
"""

from __future__ import annotations

from itertools import count
from typing import Any, Protocol
from weakref import WeakValueDictionary

from softfish._errors import DerivativeError, InputError
from softfish._optional import optional

torch: Any = optional("torch")
#: Operations of one's own are there from PyTorch 2.4 on.
HAS_OPERATIONS = hasattr(torch.library, "custom_op")

_VALUE, _ADJOINT = "softfish::value", "softfish::adjoint"
_keys = count()
_functions: WeakValueDictionary[str, Graphed] = WeakValueDictionary()


class Graphed(Protocol):
    """A function that an operation calls."""

    #: What a second derivative of it is called.
    second: DerivativeError

    def _outputs(self, values: list[Any], /) -> list[Any]:
        """Tensors of the shapes and types of the outputs, without numbers."""
        ...

    def _values(self, values: list[Any], /) -> list[Any]:
        """The outputs."""
        ...

    def _gradients(self, values: list[Any], outputs: list[Any], cotangents: list[Any], /) -> list[Any]:
        """Σ cotangent · ∂output/∂value of each value."""
        ...


def register(function: Graphed) -> str:
    """A key by which the operations find a function, as long as it is there."""
    key = f"function {next(_keys)}"
    _functions[key] = function
    return key


def _function(key: str) -> Graphed:
    function = _functions.get(key)
    if function is None:
        why = "it was made in another process, or is gone"
        raise InputError("a graph calls a solve that is not there", why, "make function and graph again in this process")
    return function


def in_graph(values: list[Any], key: str) -> list[Any]:
    """The outputs of the function of a key, as an operation of the graph that is recorded."""
    return list(torch.ops.softfish.value(values, key))


def _refuse_forward_mode() -> None:
    """An operation of one's own has no forward mode: its tangents would be zero."""
    if torch.autograd.forward_ad._current_level >= 0:
        why = "a graph has derivatives in reverse mode"
        raise DerivativeError("forward mode of a solve in a graph is asked for", why, "call the function outside of it, with forward_ad")


def _value(values: list[Any], key: str) -> list[Any]:
    _refuse_forward_mode()
    return _function(key)._values(list(values))


def _outputs(values: list[Any], key: str) -> list[Any]:
    _refuse_forward_mode()
    return _function(key)._outputs(list(values))


def _adjoint(values: list[Any], outputs: list[Any], cotangents: list[Any], key: str) -> list[Any]:
    return _function(key)._gradients(list(values), list(outputs), list(cotangents))


def _gradients(values: list[Any], _outputs: list[Any], _cotangents: list[Any], _key: str) -> list[Any]:
    return [torch.empty_like(value) for value in values]


def _keep(ctx: Any, inputs: tuple[Any, ...], output: list[Any]) -> None:
    values, ctx.key = inputs
    ctx.count = len(values)
    ctx.save_for_backward(*values, *output)


def _backward(ctx: Any, cotangents: list[Any]) -> tuple[Any, ...]:
    saved = list(ctx.saved_tensors)
    values, outputs = saved[: ctx.count], saved[ctx.count :]
    # an output that the loss leaves out has no cotangent
    full = [torch.zeros_like(out) if part is None else part.contiguous() for part, out in zip(cotangents, outputs, strict=True)]
    return torch.ops.softfish.adjoint(values, outputs, full, ctx.key), None


def _keep_key(ctx: Any, inputs: tuple[Any, ...], output: list[Any]) -> None:
    ctx.key = inputs[-1]


def _no_second(ctx: Any, *_: Any) -> Any:
    raise _function(ctx.key).second


def _define() -> None:
    lists = "Tensor[] values"
    value = torch.library.custom_op(_VALUE, _value, mutates_args=(), schema=f"({lists}, str key) -> Tensor[]")
    value.register_fake(_outputs)
    value.register_autograd(_backward, setup_context=_keep)
    schema = f"({lists}, Tensor[] outputs, Tensor[] cotangents, str key) -> Tensor[]"
    adjoint = torch.library.custom_op(_ADJOINT, _adjoint, mutates_args=(), schema=schema)
    adjoint.register_fake(_gradients)
    adjoint.register_autograd(_no_second, setup_context=_keep_key)


if HAS_OPERATIONS:
    _define()
