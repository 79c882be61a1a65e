"""Solvers as functions of PyTorch."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._errors import DerivativeError, InputError
from softfish._function import Function, FunctionSettings
from softfish._optional import optional

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softfish._solver import Solver

torch: Any = optional("torch")
get_proxy_mode: Any = optional("torch.fx.experimental.proxy_tensor").get_proxy_mode

_REMEDY = "leave create_graph out; take torch.autograd.forward_ad for a directional derivative, and differences for second ones"
_ACT = "use torch.autograd; a batch is a first axis of the arguments; jacobian and hessian take vectorize=False"


def outside_graphs(call: Any) -> Any:
    """A call that `torch.compile` leaves as it is; the error of `fullgraph=True` then says why, where PyTorch takes a reason."""
    reason = "a solve runs outside of compiled graphs: leave fullgraph out"
    takes_reason = "reason" in inspect.signature(torch.compiler.disable).parameters
    return torch.compiler.disable(call, **({"reason": reason} if takes_reason else {}))


def numbers(value: Any) -> Any:
    """A tensor as an array in double precision; refused where a transform holds it, so that it has no numbers yet."""
    try:
        return value.detach().to("cpu", torch.float64).numpy()
    except RuntimeError as error:
        why = f"a solve needs numbers: {str(error).splitlines()[0]}"
        raise DerivativeError("a solve is called within a transform of tensors", why, _ACT) from error


def refuse_transforms(what: str) -> None:
    """Refuses what torch.func and vmap would make of a solve: their tensors have no numbers that a solver could read."""
    if torch._C._functorch.peek_interpreter_stack() is not None:
        why = "a solve has first derivatives by torch.autograd and torch.autograd.forward_ad"
        raise DerivativeError(f"{what} is called within a transform of torch.func or vmap", why, _ACT)
    # what records operations would keep this one result as a constant, and a derivative of zero
    if torch.jit.is_tracing() or get_proxy_mode() is not None:
        why = "a solve is no operation of PyTorch that could be recorded"
        raise DerivativeError(f"{what} is called within torch.jit.trace, make_fx or torch.func.linearize", why, _ACT)


def refuse_half(name: str, tensor: Any) -> None:
    """Refuses tensors that hold no real numbers of single or double precision."""
    if tensor.dtype not in (torch.float32, torch.float64):
        why = "single or double precision is required; solves are in double"
        raise InputError(f"`{name}` holds {tensor.dtype}", why, "convert it to float64")


class _Call:
    """One call of a function: its batch, and the results with what their adjoints need."""

    def __init__(self, function: Function, batch: int | None, like: tuple[Any, Any]) -> None:
        self.function = function
        self.batch = batch
        #: Precision and device of the output.
        self.like = like
        self.own: list[bool] = []
        self.results: list[Any] = []

    def tensor(self, array: Any, like: Any = None) -> Any:
        """A tensor of the output, or like another; what is read-only in numpy is copied, as PyTorch has no such tensors."""
        dtype, device = self.like if like is None else (like.dtype, like.device)
        return torch.as_tensor(np.array(array), dtype=dtype, device=device)

    def cases(self) -> int:
        return 1 if self.batch is None else self.batch

    def whole(self, outputs: list[Any]) -> Any:
        return self.tensor(outputs[0] if self.batch is None else np.stack(outputs))

    def along(self, tangents: Sequence[Any]) -> Any:
        """Σ ∂output/∂θ · tangent of each case."""
        arrays = [None if tangent is None else numbers(tangent) for tangent in tangents]
        outputs = []
        for n, result in enumerate(self.results):
            pairs = zip(arrays, self.own, strict=True)
            parts = [None if array is None else array if own else array[n] for array, own in pairs]
            outputs.append(self.function.jvp(result, parts))
        return self.whole(outputs)


class _Solve(torch.autograd.Function):  # type: ignore[misc]
    """One solve per case of a batch; the results, with what their adjoints need, are kept for the backward pass."""

    @staticmethod
    def forward(ctx: Any, call: _Call, *values: Any) -> Any:
        arrays = [numbers(value) for value in values]
        function = call.function
        call.own = [len(parameter.shape) == value.dim() for parameter, value in zip(function.parameters, values, strict=True)]
        call.results = [
            function.solve([array if own else array[n] for array, own in zip(arrays, call.own, strict=True)])
            for n in range(call.cases())
        ]
        ctx.call = call
        ctx.save_for_backward(*values)
        return call.whole([function.value(result) for result in call.results])

    @staticmethod
    def jvp(ctx: Any, _call: None, *tangents: Any) -> Any:
        return ctx.call.along(tangents)

    @staticmethod
    def backward(ctx: Any, cotangent: Any) -> Any:
        refuse_transforms("the derivative of a solve")
        return None, *_Adjoint.apply(ctx.call, cotangent, *ctx.saved_tensors)


class _Adjoint(torch.autograd.Function):  # type: ignore[misc]
    """The adjoint solves of a batch: linear in the cotangent. By the parameters they are second derivatives, which there are none of."""

    @staticmethod
    def forward(ctx: Any, call: _Call, cotangent: Any, *values: Any) -> Any:
        slopes = numbers(cotangent)
        single = call.batch is None
        ctx.call = call
        parts = [call.function.vjp(result, slopes if single else slopes[n]) for n, result in enumerate(call.results)]
        gradients = []
        for k, (own, value) in enumerate(zip(call.own, values, strict=True)):
            each = [part[k] for part in parts]
            gradients.append(call.tensor(np.sum(each, axis=0) if own else np.stack(each), value))
        return tuple(gradients)

    @staticmethod
    def jvp(_ctx: Any, *_tangents: Any) -> Any:
        raise DerivativeError("forward mode of a gradient of a solve is asked for", "a solver has first derivatives alone", _REMEDY)

    @staticmethod
    def backward(ctx: Any, *cotangents: Any) -> Any:
        refuse_transforms("the derivative of an adjoint")
        if any(ctx.needs_input_grad[2:]):
            raise DerivativeError("a second derivative of a solve is asked for", "a solver has first derivatives alone", _REMEDY)
        return None, ctx.call.along(cotangents), *(None for _ in cotangents)


class TorchFunction:
    """`output` of a solver as a function of PyTorch tensors, in the order of `wrt`.

    `output`: `displacement` (nodes × 3) or a point of the case, as `marker.tip` (3); of a motion, where `steps` is given,
    with the steps as first axis. `wrt`: `E.region`, `nu.region`, `density.region` (scalars), `E`, `nu`, `density` (one per
    region), `element_E` (one per element, Pa), `pressure.chamber` (a scalar; one per step of a motion), `pressure`, and
    `force` (nodes × 3, N). Any argument may have a first axis for a batch of cases; plain numbers are taken as constants.
    The settings are those of `Solver.equilibrium`, or of `Solver.simulate`.

    The backward pass is one adjoint solve per case on the factor of its forward solve. Tensors are of single or double precision, the output
    of the wider one: solves are always in double. Forward mode (`torch.autograd.forward_ad`) uses sensitivities. A second derivative, a
    transform of `torch.func`, and what records operations (`torch.jit.trace`, `make_fx`) are refused by a `DerivativeError`; `torch.compile` leaves the function as it is,
    and with `fullgraph=True` is refused by PyTorch's own error.
    """

    def __init__(
        self, solver: Solver, output: str, wrt: Sequence[str], *, steps: int | None = None, **settings: Unpack[FunctionSettings]
    ) -> None:
        self.function = Function(solver, output, wrt, steps, settings)

    @outside_graphs
    def __call__(self, *values: Any) -> Any:
        """The output at `values`, one for each of `wrt`."""
        refuse_transforms("a solve")
        parameters = self.function.parameters
        if len(values) != len(parameters):
            names = ", ".join(parameter.name for parameter in parameters)
            raise InputError(f"{len(values)} arguments are given", f"the function has {names}", "give one for each")
        given = [value for value in values if isinstance(value, torch.Tensor)]
        for parameter, value in zip(parameters, values, strict=True):
            if isinstance(value, torch.Tensor):
                refuse_half(parameter.name, value)
        dtype = torch.float32 if given and all(value.dtype == torch.float32 for value in given) else torch.float64
        device = given[0].device if given else torch.device("cpu")
        tensors = [self._tensor(parameter.name, value) for parameter, value in zip(parameters, values, strict=True)]
        return _Solve.apply(_Call(self.function, self._batch(tensors), (dtype, device)), *tensors)

    @staticmethod
    def _tensor(name: str, value: Any) -> Any:
        """A tensor as it is; anything else as a constant in double precision."""
        from softfish._arrays import reals

        return value if isinstance(value, torch.Tensor) else torch.as_tensor(np.array(reals(name, value)))

    def _batch(self, tensors: Sequence[Any]) -> int | None:
        sizes = set()
        for parameter, tensor in zip(self.function.parameters, tensors, strict=True):
            shape = tuple(tensor.shape)
            if shape == parameter.shape:
                continue
            if shape[1:] != parameter.shape:
                why = f"it is {parameter.shape}, or a batch of that"
                raise InputError(f"`{parameter.name}` has the shape {shape}", why, "check its axes")
            sizes.add(shape[0])
        if len(sizes) > 1 or 0 in sizes:
            raise InputError(f"batches have the sizes {sorted(sizes)}", "a call has one batch", "give equal sizes above 0")
        return sizes.pop() if sizes else None

    def __repr__(self) -> str:
        of = self.function
        return f"TorchFunction({of.output} by {', '.join(one.name for one in of.parameters)}: {of.shape})"
