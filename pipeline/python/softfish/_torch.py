"""Solvers as functions of PyTorch."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

from softfish._arguments import checked
from softfish._arrays import reals
from softfish._errors import ArgumentError, DerivativeError, InputError
from softfish._function import Function, FunctionSettings
from softfish._optional import optional
from softfish._torch_graph import HAS_OPERATIONS, in_graph, register

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from softfish._solver import Solver

P = ParamSpec("P")
R = TypeVar("R")
torch: Any = optional("torch")
get_proxy_mode: Any = optional("torch.fx.experimental.proxy_tensor").get_proxy_mode

_REMEDY = "leave create_graph out; take torch.autograd.forward_ad for a directional derivative, and differences for second ones"
#: Calls within graphs whose results are kept for their adjoints.
_KEPT = 16
_ACT = "use torch.autograd; a batch is a first axis of the arguments; jacobian and hessian take vectorize=False"


def outside_graphs(call: Callable[P, R]) -> Callable[P, R]:
    """A call that PyTorch does not record."""
    uncompiled: Callable[P, R] = torch.compiler.disable(call)
    return uncompiled


def is_recorded() -> bool:
    """Whether a graph is recorded that can hold operations of one's own."""
    return HAS_OPERATIONS and bool(torch.compiler.is_compiling())


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


def constant(name: str, value: Any) -> Any:
    """Numbers as a tensor in double precision."""
    if is_recorded():
        return torch.as_tensor(value, dtype=torch.float64)
    return torch.as_tensor(np.array(reals(name, value)))


def wider(tensors: Sequence[Any]) -> Any:
    """The precision of an output: single where all arguments have it."""
    return torch.float32 if all([tensor.dtype == torch.float32 for tensor in tensors]) else torch.float64


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

    def solve(self, values: Sequence[Any]) -> Any:
        """The outputs of all cases."""
        arrays = [numbers(value) for value in values]
        function = self.function
        self.own = [len(parameter.shape) == value.dim() for parameter, value in zip(function.parameters, values, strict=True)]
        self.results = [
            function.solve([array if own else array[n] for array, own in zip(arrays, self.own, strict=True)])
            for n in range(self.cases())
        ]
        return self.whole([function.value(result) for result in self.results])

    def adjoint(self, cotangent: Any, values: Sequence[Any]) -> tuple[Any, ...]:
        """The gradient by each of the values."""
        slopes, single = numbers(cotangent), self.batch is None
        parts = [self.function.vjp(result, slopes if single else slopes[n]) for n, result in enumerate(self.results)]
        gradients = []
        for k, (own, value) in enumerate(zip(self.own, values, strict=True)):
            each = [part[k] for part in parts]
            gradients.append(self.tensor(np.sum(each, axis=0) if own else np.stack(each), value))
        return tuple(gradients)

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
        ctx.call = call
        ctx.save_for_backward(*values)
        return call.solve(values)

    @staticmethod
    def jvp(ctx: Any, _call: None, *tangents: Any) -> Any:
        return ctx.call.along(tangents)

    @staticmethod
    def backward(ctx: Any, cotangent: Any) -> Any:
        refuse_transforms("the derivative of a solve")
        return None, *_Adjoint.apply(ctx.call, cotangent, *ctx.saved_tensors)


def _second() -> DerivativeError:
    return DerivativeError("a second derivative of a solve is asked for", "a solver has first derivatives alone", _REMEDY)


class _Adjoint(torch.autograd.Function):  # type: ignore[misc]
    """The adjoint solves of a batch: linear in the cotangent. By the parameters they are second derivatives, which there are none of."""

    @staticmethod
    def forward(ctx: Any, call: _Call, cotangent: Any, *values: Any) -> Any:
        ctx.call = call
        return call.adjoint(cotangent, values)

    @staticmethod
    def jvp(_ctx: Any, *_tangents: Any) -> Any:
        raise DerivativeError("forward mode of a gradient of a solve is asked for", "a solver has first derivatives alone", _REMEDY)

    @staticmethod
    def backward(ctx: Any, *cotangents: Any) -> Any:
        refuse_transforms("the derivative of an adjoint")
        if any(ctx.needs_input_grad[2:]):
            raise _second()
        return None, ctx.call.along(cotangents), *(None for _ in cotangents)


class TorchFunction:
    """`output` of a solver as a function of PyTorch tensors, in the order of `wrt`.

    `output`: `displacement` (nodes × 3) or a point of the case, as `marker.tip` (3); of a motion, where `steps` is given,
    with the steps as first axis. `wrt`: `E.region`, `nu.region`, `density.region` (scalars), `E`, `nu`, `density` (one per
    region), `element_E` (one per element, Pa), `pressure.chamber` (a scalar; one per step of a motion), `pressure`, and
    `force` (nodes × 3, N). Any argument may have a first axis for a batch of cases; plain numbers are taken as constants.
    The settings are those of `Solver.equilibrium`, or of `Solver.simulate`.

    The backward pass is one adjoint solve per case on the factor of its forward solve. Tensors are of single or double precision, the output
    of the wider one: solves are always in double. Forward mode (`torch.autograd.forward_ad`) uses sensitivities. `torch.compile` and
    `torch.export` hold a call as one operation (from PyTorch 2.4 on; before, `torch.compile` leaves it as it is). A second derivative, a transform
    of `torch.func`, and what else records operations (`torch.jit.trace`, `make_fx`) are refused by a `DerivativeError`.
    """

    @checked()
    def __init__(
        self, solver: Solver, output: str, wrt: Sequence[str], *, steps: int | None = None, **settings: Unpack[FunctionSettings]
    ) -> None:
        self.function = Function(solver, output, wrt, steps, settings)
        self._begin()

    def _begin(self) -> None:
        self.second = _second()
        self._key = register(self)
        #: Calls within graphs, whose adjoints look for their results here.
        self._calls: OrderedDict[tuple[bytes, ...], _Call] = OrderedDict()

    def __getstate__(self) -> dict[str, Any]:
        return {"function": self.function}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    def __call__(self, *values: Any, **unknown: Any) -> Any:
        """The output at `values`, one for each of `wrt`."""
        if unknown:
            why = f"the arguments have no names; they are, in this order, {self._names()}"
            raise ArgumentError(f"`{next(iter(unknown))}` is given by name", why, "give the values alone")
        if not is_recorded():
            return self._solve(values)
        tensors = self._tensors(values)
        self._batch(tensors)
        return in_graph(tensors, self._key)[0]

    # where a graph breaks, PyTorch would record what a solve does with arrays
    @outside_graphs
    def _solve(self, values: Sequence[Any]) -> Any:
        tensors = self._tensors(values)
        refuse_transforms("a solve")
        return _Solve.apply(self._of_call(tensors), *tensors)

    def _names(self) -> str:
        return ", ".join([parameter.name for parameter in self.function.parameters])

    def _tensors(self, values: Sequence[Any]) -> list[Any]:
        """Tensors as they are; anything else as constants in double precision."""
        parameters = self.function.parameters
        if len(values) != len(parameters):
            raise InputError(f"{len(values)} arguments are given", f"the function has {self._names()}", "give one for each")
        tensors = []
        for n, value in enumerate(values):
            if isinstance(value, torch.Tensor):
                refuse_half(parameters[n].name, value)
                tensors.append(value)
            else:
                tensors.append(constant(parameters[n].name, value))
        return tensors

    def _of_call(self, tensors: Sequence[Any]) -> _Call:
        return _Call(self.function, self._batch(tensors), (wider(tensors), tensors[0].device))

    def _outputs(self, values: list[Any]) -> list[Any]:
        """Of an operation of a graph: see `Graphed`."""
        batch = self._batch(values)
        shape = self.function.shape if batch is None else (batch, *self.function.shape)
        return [torch.empty(shape, dtype=wider(values), device=values[0].device)]

    def _values(self, values: list[Any]) -> list[Any]:
        key = tuple(numbers(value).tobytes() for value in values)
        call = self._calls[key] = self._of_call(values)
        while len(self._calls) > _KEPT:
            self._calls.popitem(last=False)
        return [call.solve(values)]

    def _gradients(self, values: list[Any], _: list[Any], cotangents: list[Any]) -> list[Any]:
        key = tuple(numbers(value).tobytes() for value in values)
        if key not in self._calls:
            self._values(values)
        return list(self._calls[key].adjoint(cotangents[0], values))

    def _batch(self, tensors: Sequence[Any]) -> int | None:
        """The number of cases, of arguments of the right shapes."""
        batch: int | None = None
        for n, parameter in enumerate(self.function.parameters):
            shape = tuple(tensors[n].shape)
            if shape == parameter.shape:
                continue
            if shape[1:] != parameter.shape or not shape or shape[0] == 0:
                why = f"it is {parameter.shape}, or a batch of that"
                raise InputError(f"`{parameter.name}` has the shape {shape}", why, "check its axes")
            if batch is not None and batch != shape[0]:
                raise InputError(f"batches have the sizes {batch} and {shape[0]}", "a call has one batch", "give equal sizes")
            batch = shape[0]
        return batch

    def __repr__(self) -> str:
        return f"TorchFunction({self.function.output} by {self._names()}: {self.function.shape})"
