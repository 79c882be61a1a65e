"""Solvers as functions of PyTorch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._errors import InputError
from softfish._function import Function
from softfish._optional import optional

if TYPE_CHECKING:
    from softfish._solver import Solver

torch: Any = optional("torch")


def _array(value: Any) -> Any:
    return value.detach().to("cpu", torch.float64).numpy()


class _Solve(torch.autograd.Function):  # type: ignore[misc]
    """One solve per case of a batch; the results, with what their adjoints need, are kept for the backward pass."""

    @staticmethod
    def forward(ctx: Any, function: Function, batch: int | None, *values: Any) -> Any:
        arrays = [_array(value) for value in values]
        ctx.function, ctx.batch = function, batch
        ctx.own = [len(parameter.shape) == value.dim() for parameter, value in zip(function.parameters, values, strict=True)]
        ctx.like = values[0].detach()
        ctx.save_for_backward(*values)
        ctx.results = [
            function.solve([array if own else array[n] for array, own in zip(arrays, ctx.own, strict=True)])
            for n in range(1 if batch is None else batch)
        ]
        outputs = [function.value(result) for result in ctx.results]
        whole = outputs[0] if batch is None else np.stack(outputs)
        # What is read-only in numpy is copied: PyTorch has no such tensors.
        return torch.as_tensor(np.array(whole), dtype=values[0].dtype, device=values[0].device)

    @staticmethod
    def jvp(ctx: Any, _function: None, _batch: None, *tangents: Any) -> Any:
        arrays = [None if tangent is None else _array(tangent) for tangent in tangents]
        outputs = []
        for n, result in enumerate(ctx.results):
            pairs = zip(arrays, ctx.own, strict=True)
            along = [None if array is None else array if own else array[n] for array, own in pairs]
            outputs.append(ctx.function.jvp(result, along))
        whole = outputs[0] if ctx.batch is None else np.stack(outputs)
        return torch.as_tensor(np.array(whole), dtype=ctx.like.dtype, device=ctx.like.device)

    @staticmethod
    def backward(ctx: Any, cotangent: Any) -> Any:
        return None, None, *_Adjoint.apply(ctx, cotangent, *ctx.saved_tensors)


class _Adjoint(torch.autograd.Function):  # type: ignore[misc]
    """The adjoint solves of a batch. They are no function that can be differentiated, and say so."""

    @staticmethod
    def forward(_: Any, solved: Any, cotangent: Any, *values: Any) -> Any:
        slopes = _array(cotangent)
        single = solved.batch is None
        parts = [solved.function.vjp(result, slopes if single else slopes[n]) for n, result in enumerate(solved.results)]
        gradients = []
        for k, (own, value) in enumerate(zip(solved.own, values, strict=True)):
            each = [part[k] for part in parts]
            whole = np.sum(each, axis=0) if own else np.stack(each)
            gradients.append(torch.as_tensor(np.array(whole), dtype=value.dtype, device=value.device))
        return tuple(gradients)

    @staticmethod
    def backward(_: Any, *cotangents: Any) -> Any:
        why = "a solver has first derivatives alone"
        raise InputError("a second derivative of a solve is asked for", why, "leave create_graph out, or use differences")


class TorchFunction:
    """`output` of a solver as a function of PyTorch tensors, in the order of `wrt`.

    `output`: `displacement` (nodes × 3) or a point of the case, as `marker.tip` (3); of a motion, where `steps` is given,
    with the steps as first axis. `wrt`: `E.region`, `nu.region`, `density.region` (scalars), `E`, `nu`, `density` (one per
    region), `element_E` (one per element, Pa), `pressure.chamber` (a scalar; one per step of a motion), `pressure`, and
    `force` (nodes × 3, N). Any argument may have a first axis for a batch of cases; plain numbers are taken as constants.

    The backward pass is one adjoint solve per case on the factor of its forward solve. Single precision is cast: solves
    are always in double. A second derivative is refused. Forward mode uses sensitivities.
    """

    def __init__(self, solver: Solver, output: str, wrt: Sequence[str], **settings: Any) -> None:
        self.function = Function(solver, output, wrt, **settings)

    def __call__(self, *values: Any) -> Any:
        """The output at `values`, one for each of `wrt`."""
        parameters = self.function.parameters
        if len(values) != len(parameters):
            names = ", ".join(parameter.name for parameter in parameters)
            raise InputError(f"{len(values)} arguments are given", f"the function has {names}", "give one for each")
        given = [value for value in values if isinstance(value, torch.Tensor)]
        like = {"dtype": given[0].dtype, "device": given[0].device} if given else {"dtype": torch.float64}
        tensors = [value if isinstance(value, torch.Tensor) else torch.as_tensor(value, **like) for value in values]
        batch = self._batch(tensors)
        return _Solve.apply(self.function, batch, *tensors)

    def _batch(self, tensors: Sequence[Any]) -> int | None:
        sizes = set()
        for parameter, tensor in zip(self.function.parameters, tensors, strict=True):
            shape = tuple(tensor.shape)
            if not tensor.dtype.is_floating_point:
                raise InputError(f"`{parameter.name}` holds {tensor.dtype}", "real numbers are required", "convert it")
            if shape == parameter.shape:
                continue
            if shape[1:] != parameter.shape:
                why = f"it is {parameter.shape}, or a batch of that"
                raise InputError(f"`{parameter.name}` has the shape {shape}", why, "check its axes")
            sizes.add(shape[0])
        if len(sizes) > 1 or 0 in sizes:
            raise InputError(f"batches have the sizes {sorted(sizes)}", "a call has one batch", "give equal sizes above 0")
        return sizes.pop() if sizes else None
