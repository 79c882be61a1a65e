"""One step of a reduced model as a function of PyTorch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from softfish._arrays import Array
from softfish._errors import DerivativeError, InputError
from softfish._optional import optional
from softfish._step import Step
from softfish._torch import constant, is_recorded, numbers, outside_graphs, refuse_half, refuse_transforms, wider
from softfish._torch_graph import in_graph, register

if TYPE_CHECKING:
    from softfish._reduced import ReducedModel

torch: Any = optional("torch")


_NAMES = ("coordinates", "velocity", "pressures")
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
        self._begin()

    def _begin(self) -> None:
        self.second = DerivativeError("a second derivative of a step is asked for", _WHY, _ACT)
        self._key = register(self)
        count = self.model.coordinates
        self._lengths = (count, count, self.model._solver.chamber_count)

    def __getstate__(self) -> dict[str, Any]:
        return {"model": self.model, "dt": self.dt, "settings": self.settings}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._begin()

    def __call__(self, coordinates: Any, velocity: Any, pressures: Any) -> tuple[Any, Any]:
        """Coordinates and velocity after the step; a first axis of any argument is a batch."""
        values = (coordinates, velocity, pressures)
        if not is_recorded():
            q, v = self._take(values)
            return q, v
        full, batch = self._full(values)
        q, v = in_graph(full, self._key)
        return (q[0], v[0]) if batch is None else (q, v)

    # where a graph breaks, PyTorch would record what a step does with arrays
    @outside_graphs
    def _take(self, values: Sequence[Any]) -> tuple[Any, Any]:
        full, batch = self._full(values)
        refuse_transforms("a step of a reduced model")
        q, v = _Step.apply((Step(self.model, self.dt, self.settings), self._like(full)), *full)
        return (q[0], v[0]) if batch is None else (q, v)

    def _full(self, values: Sequence[Any]) -> tuple[list[Any], int | None]:
        """The arguments of all cases, and their number where there is a batch."""
        tensors = [value if isinstance(value, torch.Tensor) else constant(name, value) for name, value in zip(_NAMES, values, strict=True)]
        batch = self._batch(tensors)
        # what is the same in all cases is expanded, so that its gradient is their sum
        return [tensor.expand(1 if batch is None else batch, tensor.shape[-1]) for tensor in tensors], batch

    def _like(self, tensors: Sequence[Any]) -> Any:
        return torch.empty(0, dtype=wider(tensors), device=tensors[0].device)

    def _outputs(self, values: list[Any]) -> list[Any]:
        """Of an operation of a graph: see `Graphed`."""
        return [self._like(values).new_empty(values[0].shape) for _ in range(2)]

    def _values(self, values: list[Any]) -> list[Any]:
        step, like = Step(self.model, self.dt, self.settings), self._like(values)
        cases = zip(*(numbers(value) for value in values), strict=True)
        return list(stacked([step.after(case) for case in cases], (like, like)))

    def _gradients(self, values: list[Any], outputs: list[Any], cotangents: list[Any]) -> list[Any]:
        step = Step(self.model, self.dt, self.settings)
        known = zip(*(numbers(value) for value in (*values, *outputs)), strict=True)
        slopes = zip(*(numbers(part) for part in cotangents), strict=True)
        return list(stacked([step.adjoint(case, part) for case, part in zip(known, slopes, strict=True)], values))

    def _batch(self, tensors: Sequence[Any]) -> int | None:
        """The number of cases, of arguments of the right precision and shape."""
        lengths = self._lengths
        batch: int | None = None
        for n, name in enumerate(_NAMES):
            refuse_half(name, tensors[n])
            shape = tuple(tensors[n].shape)
            if shape[-1:] != (lengths[n],) or len(shape) > 2 or 0 in shape[:-1]:
                raise InputError(f"`{name}` has the shape {shape}", f"it is ({lengths[n]},), or a batch of that", "check its axes")
            if len(shape) == 2 and batch is not None and batch != shape[0]:
                raise InputError(f"batches have the sizes {batch} and {shape[0]}", "a call has one batch", "give equal sizes")
            batch = shape[0] if len(shape) == 2 else batch
        return batch
