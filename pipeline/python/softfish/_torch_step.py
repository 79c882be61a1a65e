"""One step of a reduced model as a function of PyTorch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._arrays import Array
from softfish._errors import DerivativeError, InputError
from softfish._optional import optional
from softfish._step import Step
from softfish._torch import numbers, outside_graphs, refuse_half, refuse_transforms

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

torch: Any = optional("torch")


_WHY = "a step has first derivatives alone"
_ACT = "leave create_graph out, or take the penalty by differences of the step"


def stacked(parts: Sequence[Sequence[Array]], like: Sequence[Any]) -> tuple[Any, ...]:
    """The parts of each case as tensors, each of the precision and on the device of another."""
    each = zip(zip(*parts, strict=True), like, strict=True)
    return tuple(torch.as_tensor(np.stack(part), dtype=of.dtype, device=of.device) for part, of in each)


class _Step(torch.autograd.Function):  # type: ignore[misc]
    """Implicit Euler of each case of a batch, and the adjoint of its equations."""

    @staticmethod
    def forward(ctx: Any, given: tuple[Step, Any], *values: Any) -> Any:
        step, like = given
        before = list(zip(*(numbers(value) for value in values), strict=True))
        after = [step.after(case) for case in before]
        ctx.kept = (step, [(*case, *state) for case, state in zip(before, after, strict=True)])
        ctx.like = like
        ctx.save_for_backward(*values)
        return stacked(after, (like, like))

    @staticmethod
    def jvp(ctx: Any, _given: None, *tangents: Any) -> Any:
        step, known = ctx.kept
        arrays = [None if tangent is None else numbers(tangent) for tangent in tangents]
        along = [[None if array is None else array[n] for array in arrays] for n in range(len(known))]
        return stacked([step.along(case, part) for case, part in zip(known, along, strict=True)], (ctx.like, ctx.like))

    @staticmethod
    def backward(ctx: Any, by_q: Any, by_v: Any) -> Any:
        refuse_transforms("the derivative of a step")
        return None, *_StepAdjoint.apply(ctx.kept, by_q, by_v, *ctx.saved_tensors)


class _StepAdjoint(torch.autograd.Function):  # type: ignore[misc]
    """The adjoint of a step. It is no function that can be differentiated, and says so."""

    @staticmethod
    def forward(_ctx: Any, kept: tuple[Step, Any], by_q: Any, by_v: Any, *values: Any) -> Any:
        step, known = kept
        cotangents = zip(numbers(by_q), numbers(by_v), strict=True)
        return stacked([step.adjoint(case, part) for case, part in zip(known, cotangents, strict=True)], values)

    @staticmethod
    def jvp(_ctx: Any, *_tangents: Any) -> Any:
        raise DerivativeError("forward mode of a gradient of a step is asked for", _WHY, _ACT)

    @staticmethod
    def backward(_ctx: Any, *_cotangents: Any) -> Any:
        raise DerivativeError("a second derivative of a step is asked for", _WHY, _ACT)


class TorchStep:
    """See `ReducedModel.torch_step`."""

    def __init__(self, model: ReducedModel, dt: float, settings: Mapping[str, Any]) -> None:
        self.model = model
        self.dt = dt
        self.settings = dict(settings)

    @outside_graphs
    def __call__(self, coordinates: Any, velocity: Any, pressures: Any) -> tuple[Any, Any]:
        """Coordinates and velocity after the step; a first axis of any argument is a batch."""
        refuse_transforms("a step of a reduced model")
        values = (coordinates, velocity, pressures)
        tensors = [value if isinstance(value, torch.Tensor) else torch.as_tensor(value, dtype=torch.float64) for value in values]
        batch = self._batch(tensors)
        single = all(tensor.dtype == torch.float32 for tensor in tensors)
        like = torch.empty(0, dtype=torch.float32 if single else torch.float64, device=tensors[0].device)
        # what is the same in all cases is expanded, so that its gradient is their sum
        full = [tensor.expand(1 if batch is None else batch, tensor.shape[-1]) for tensor in tensors]
        q, v = _Step.apply((Step(self.model, self.dt, self.settings), like), *full)
        return (q[0], v[0]) if batch is None else (q, v)

    def _batch(self, tensors: Sequence[Any]) -> int | None:
        """The number of cases, of arguments of the right precision and shape."""
        count, chambers = self.model.coordinates, self.model._solver.chamber_count
        sizes = set()
        for name, tensor, size in zip(("coordinates", "velocity", "pressures"), tensors, (count, count, chambers), strict=True):
            refuse_half(name, tensor)
            if tuple(tensor.shape[-1:]) != (size,) or tensor.dim() > 2:
                raise InputError(f"`{name}` has the shape {tuple(tensor.shape)}", f"it is ({size},), or a batch of that", "check its axes")
            sizes |= set(tensor.shape[:-1])
        if len(sizes) > 1 or 0 in sizes:
            raise InputError(f"batches have the sizes {sorted(sizes)}", "a call has one batch", "give equal sizes above 0")
        return sizes.pop() if sizes else None
